"""MassReading: the mass of the object by a scale, and its uncertainty.

It is information about the true mass, independent of the errors of the force-torque
sensor, such as a gain that all its channels share.
"""

import re
from dataclasses import dataclass
from decimal import Decimal
from typing import Self

from hefting.core.errors import InputError
from hefting.core.magnitudes import SMALLEST_MASS
from hefting.core.quantity import quantity

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
