"""Quantity: a number with its unit, as a person writes it, and several in one text."""

import re
from collections.abc import Sequence
from typing import Literal

from hefting.core.errors import InputError

Kind = Literal["length", "angle", "share", "percentage", "force", "torque", "mass"]
UNITS: dict[Kind, dict[str, float]] = {
    "length": {"m": 1.0, "cm": 1e-2, "mm": 1e-3, "um": 1e-6},
    "angle": {"rad": 1.0, "deg": 0.017453292519943295, "°": 0.017453292519943295},
    "share": {"%": 1e-2, "": 1.0},
    "percentage": {"%": 1e-2},
    "force": {"N": 1.0, "mN": 1e-3},
    "torque": {"Nm": 1.0, "N m": 1.0, "mNm": 1e-3},
    "mass": {"kg": 1.0, "g": 1e-3, "lb": 0.45359237, "oz": 0.028349523125},
}
"""In m, rad, of one, N, N m and kg."""


def quantity(text: str, kind: Kind) -> float:
    """A finite, not negative number in SI units from a text like ``2mm``, ``5deg`` or
    ``20%``.

    Raises `InputError` for anything else.
    """
    match = re.fullmatch(
        r"\s*(\d{1,30}\.?\d{0,30}|\.\d{1,30})(e[+-]?\d{1,2})?\s*(\D{0,4}?)\s*", text
    )
    units = UNITS[kind]
    if match is None or match[3] not in units:
        names = ", ".join(unit or "no unit" for unit in units)
        raise InputError(
            f"'{text}' is not a {kind}", fix=f"a number and a unit: {names}"
        )
    return float(match[1] + (match[2] or "")) * units[match[3]]


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
    text: str, kinds: Sequence[Kind], option: str, example: str
) -> tuple[float, ...]:
    """Numbers with units separated by commas, in SI units; `InputError` names the
    option otherwise."""
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
