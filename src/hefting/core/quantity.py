"""Numbers as people write and read them: with a unit, several in one text, and rounded
by their uncertainty.

A number known to half a width h of its 95 % interval is worth two significant digits of
h. One without an interval gets `MOST_DIGITS` digits, and none gets more.
"""

import re
from collections.abc import Sequence
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from hefting.core.errors import InputError
from hefting.core.spatial import Array

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


def numbers(text: str, count: int | None, option: str) -> list[float]:
    """`count` finite numbers between commas, or any number of them; else `InputError`
    names the option."""
    count = text.count(",") + 1 if count is None else count
    try:
        values = [float(part) for part in text.split(",")]
    except ValueError:
        values = []
    if len(values) != count or not all(abs(value) < float("inf") for value in values):
        what = f"{count} finite numbers separated by commas"
        what = "a finite number" if count == 1 else what
        raise InputError(f"'{text}' is not {what}", where=option)
    return values


def quantities(
    text: str, kinds: Sequence[Kind], option: str, example: str
) -> tuple[float, ...]:
    """Numbers with units separated by commas, in SI units; `InputError` for others."""
    parts = text.split(",")
    if len(parts) != len(kinds):
        what = f"'{text}' is not {len(kinds)} numbers with units"
        raise InputError(what, where=option, fix=f"as in {example}")
    try:
        return tuple(
            quantity(part, kind) for part, kind in zip(parts, kinds, strict=True)
        )
    except InputError as error:
        raise InputError(error.what, option, error.fix) from None


MOST_DIGITS = 6
"""Significant digits of the largest of several numbers that belong together: enough for
any sensor, too few for rounding errors of arithmetic to show."""
DIGITS_OF_HALF_WIDTH = 2
"""As uncertainties are commonly stated (GUM, JCGM 100:2008, 7.2.6)."""


def decimals(half_widths: ArrayLike, size: float, least_digits: int = 0) -> np.ndarray:
    """Decimal places to which numbers are rounded, as integers of the same shape,
    negative for tens. `half_widths` of their intervals are zero, infinite or NaN for
    none; `size` is that of the largest number, of which `least_digits` are kept
    whatever the intervals are."""
    half = np.asarray(half_widths, dtype=float)
    finest = MOST_DIGITS - 1 - _exponent(size) if size > 0.0 else MOST_DIGITS
    known = np.isfinite(half) & (half > 0.0)
    exponents = np.floor(np.log10(np.where(known, half, 1.0))).astype(int)
    worth = np.where(known, DIGITS_OF_HALF_WIDTH - 1 - exponents, finest)
    coarsest = least_digits - 1 - _exponent(size) if least_digits and size else -300
    return np.clip(worth, min(coarsest, finest), finest)


def rounded(values: ArrayLike, places: ArrayLike) -> Array:
    """Numbers rounded to decimal `places` each, without a negative zero."""
    each = np.broadcast_arrays(np.asarray(values, dtype=float), np.asarray(places))
    flat = [
        round(float(v), int(d)) + 0.0 if np.isfinite(v) else float(v)
        for v, d in zip(each[0].ravel(), each[1].ravel(), strict=True)
    ]
    return np.array(flat).reshape(each[0].shape)


def significant(value: float, digits: int = 2) -> str:
    """A number to so many digits, ``13000`` and not ``1.3e+04``."""
    return np.format_float_positional(value, digits, fractional=False, trim="-")


WRENCH_DIGITS = 3
"""Significant digits of the largest force, and of the largest torque."""


def wrench_text(wrench: ArrayLike) -> str:
    """A wrench (6,) as ``"(1, 2, 3) N, (0.1, 0.2, 0) N m"``: forces as finely as
    `WRENCH_DIGITS` of the largest of them, and torques likewise."""
    force, torque = (_together(three) for three in np.reshape(wrench, (2, 3)))
    return f"({force}) N, ({torque}) N m"


def _together(values: Array) -> str:
    size = float(np.abs(values).max())
    is_sized = np.isfinite(size) and size > 0.0
    places = WRENCH_DIGITS - 1 - _exponent(size) if is_sized else 0
    texts = (np.format_float_positional(v, trim="-") for v in rounded(values, places))
    return ", ".join(texts)


def _exponent(size: float) -> int:
    return int(np.floor(np.log10(size)))
