"""Numbers as people write and read them: with a unit, several in one text, and rounded
by their uncertainty.

A number known to half a width h of its 95 % interval is worth two significant digits of
h. One without an interval gets `MOST_DIGITS` digits, and none gets more.
"""

import re
from collections.abc import Sequence
from dataclasses import dataclass
from decimal import Decimal
from typing import Any, Literal, Self

import numpy as np
from numpy.typing import ArrayLike

from hefting.core.errors import InputError
from hefting.core.magnitudes import SMALLEST_MASS
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


def turned_about(text: Any) -> Array:
    """Pose (4, 4) of a frame that is turned about one axis of another, by a text such as
    ``"z:45"``: axis and degrees. `InputError` for anything else."""
    axis, _, degrees = str(text).strip().partition(":")
    try:
        angle = np.radians(float(degrees))
    except ValueError:
        angle = np.nan
    if axis not in ("x", "y", "z") or not abs(angle) <= 2.0 * np.pi:
        raise InputError(
            f"'{str(text)[:40]}' is no turn", fix="give an axis and degrees, as in z:45"
        )
    from scipy.spatial.transform import Rotation

    pose = np.eye(4)
    pose[:3, :3] = Rotation.from_euler(axis, angle).as_matrix()
    return pose


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


EXAMPLE = "0.512kg±1g"
"""How a reading is written."""
LARGEST_MASS = 1e6
"""[kg] Largest reading: a thousand times what any robot holds, so that wrong units are
named rather than refused."""
LONGEST_TEXT = 100
"""Largest number of characters of a reading."""
SMALLEST_SHARE = 1e-9
"""Smallest standard deviation over the mass of any scale."""

_PLUS_MINUS = re.compile(r"±|\+/?-")
_NUMBER = re.compile(r"\s*([\d.]{1,40}(?:e[+-]?\d{1,2})?)\s*(\D{0,4}?)\s*")


@dataclass(frozen=True)
class MassReading:
    """Mass of an object as a scale shows it: of the object alone, without a gripper.

    Raises `InputError` unless both are positive and finite, and the deviation is below
    the mass.

    Examples
    --------
    >>> hefting.MassReading.of("512g+-1g")
    MassReading(mass=0.512, std=0.001, assumed=False)
    >>> found = hefting.identify("demo/log.csv", mass="0.670kg±1g")
    """

    mass: float
    """[kg]"""
    std: float
    """[kg] standard deviation. The accuracy that a scale's maker states, a limit of its
    errors, will do: the intervals then are wider than need be."""
    assumed: bool = False
    """Whether no deviation was given: the reading counts as right to its last digit."""

    def __post_init__(self):
        try:
            mass, std = float(self.mass), float(self.std)
        except (TypeError, ValueError):
            what = f"a scale's reading is two numbers [kg], not {self.mass}, {self.std}"
            raise InputError(what, fix=f"as in {EXAMPLE}, or (0.512, 0.001)") from None
        if not SMALLEST_MASS <= mass <= LARGEST_MASS:
            raise InputError(
                f"no scale shows {mass:g} kg", fix=f"a mass in kg, as in {EXAMPLE}"
            )
        if not std >= SMALLEST_SHARE * mass:
            what = f"no scale shows {mass:g} kg with an accuracy of {std:g} kg"
            raise InputError(what, fix=f"give its accuracy, as in {EXAMPLE}")
        if not std < mass:
            what = "its last digit" if self.assumed else "its deviation"
            raise InputError(
                f"a scale's reading of {mass:g} kg tells nothing if {what} is {std:g} kg",
                fix=f"give its accuracy, as in {EXAMPLE}",
            )
        object.__setattr__(self, "mass", mass)
        object.__setattr__(self, "std", std)

    @classmethod
    def of(
        cls, value: "MassReading | tuple[float, float] | str | None"
    ) -> "MassReading | None":
        """From a reading, a pair of mass and standard deviation [kg], or a text; None
        for None. Raises `InputError` for anything else."""
        if value is None or isinstance(value, MassReading):
            return value
        if isinstance(value, str):
            return cls.parse(value)
        try:
            mass, std = value
        except (TypeError, ValueError):
            what = f"a scale's reading is a mass and its deviation [kg], not {value}"
            fix = f"as in '{EXAMPLE}', or (0.512, 0.001)"
            raise InputError(what, fix=fix) from None
        return cls(mass, std)

    @classmethod
    def parse(cls, text: str) -> Self:
        """From a text like ``0.512kg±1g``, ``512g+-1g``, ``0.512+-0.001`` (kg) or
        ``0.512kg±0.2%``; kg, g, lb and oz. What is after ± is one standard deviation.
        Of ``0.512kg`` it is taken to be the last digit, 1 g.

        Raises `InputError` for anything else.
        """
        parts = [_NUMBER.fullmatch(part) for part in _PLUS_MINUS.split(text)]
        if len(text) > LONGEST_TEXT or len(parts) > 2 or None in parts:
            raise _no_reading(text)
        (number, unit), *spread = [(m[1], m[2]) for m in parts if m is not None]
        if not spread:
            mass = _kilograms(number, unit or "kg", text)
            digit = f"1e{Decimal(number).as_tuple().exponent}"
            return cls(mass, _kilograms(digit, unit or "kg", text), assumed=True)
        deviation, last = spread[0]
        unit = unit or last.replace("%", "") or "kg"
        mass = _kilograms(number, unit, text)
        if last != "%":
            return cls(mass, _kilograms(deviation, last or unit, text))
        return cls(mass, mass * 0.01 * _kilograms(deviation, "kg", text))

    def __str__(self) -> str:
        """A text that `parse` reads."""
        return f"{self.mass:.9g}kg±{1e3 * self.std:.6g}g"


def _kilograms(number: str, unit: str, text: str) -> float:
    """A number with a unit in kg; `InputError` of the whole `text` unless a mass."""
    try:
        return quantity(number + unit, "mass")
    except InputError:
        raise _no_reading(text) from None


def _no_reading(text: str) -> InputError:
    what = f"'{text[:60]}' is not a scale's reading"
    return InputError(what, fix=f"as in {EXAMPLE} or 512g+-1g: kg, g, lb or oz")
