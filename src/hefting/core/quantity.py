"""Quantity: a number with its unit, as a person writes it."""

import re
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
