"""Numbers, with units or without, as they are typed."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

from hefting.core.errors import InputError

if TYPE_CHECKING:
    from hefting.core.quantity import Kind


def numbers(text: str, count: int, option: str) -> list[float]:
    """`count` finite numbers separated by commas; `InputError` names the option
    otherwise."""
    try:
        values = [float(part) for part in text.split(",")]
    except ValueError:
        values = []
    if len(values) != count or not all(abs(value) < float("inf") for value in values):
        raise InputError(
            f"'{text}' is not {count} finite numbers separated by commas", where=option
        )
    return values


def quantities(
    text: str, kinds: "Sequence[Kind]", option: str, example: str
) -> tuple[float, ...]:
    """Numbers with units separated by commas, in SI units; `InputError` names the
    option otherwise."""
    from hefting.core.quantity import quantity

    parts = text.split(",")
    if len(parts) != len(kinds):
        raise InputError(
            f"'{text}' is not {len(kinds)} numbers with units",
            where=option,
            fix=f"as in {example}",
        )
    try:
        return tuple(
            quantity(part, kind) for part, kind in zip(parts, kinds, strict=True)
        )
    except InputError as error:
        raise InputError(error.what, option, error.fix) from None
