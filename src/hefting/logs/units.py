"""Units of logs, and their exact conversion to SI."""

import math
import re
from dataclasses import dataclass

import numpy as np

from hefting.core.errors import InputError, nearest
from hefting.core.spatial import STANDARD_GRAVITY, Array


@dataclass(frozen=True)
class Unit:
    """A unit of measure: SI = value * `multiplier` / `divisor`; powers of ten divide,
    so that 1 mm is 0.001 m."""

    name: str
    multiplier: float = 1.0
    divisor: float = 1.0

    def to_si(self, values: Array) -> Array:
        """`values` in SI units; the same array for an SI unit."""
        if self.multiplier == self.divisor == 1.0:
            return values
        # values that overflow are refused later, as not finite
        with np.errstate(over="ignore"):
            if self.multiplier != 1.0:
                return values * self.multiplier / self.divisor
            return values / self.divisor


def _units(**factors: float | tuple[float, float]) -> dict[str, Unit]:
    pairs = (
        (name.replace("_", " "), f if isinstance(f, tuple) else (f, 1.0))
        for name, f in factors.items()
    )
    return {name: Unit(name, *pair) for name, pair in pairs}


POUND = 4.4482216152605
"""Pound-force [N], exact by definition."""

GRAVITY = -STANDARD_GRAVITY[2]
"""Standard gravity [m/s²], exact by definition."""

DEGREE = (math.pi, 180.0)
"""Multiplier and divisor of a degree [rad]."""

UNITS: dict[str, dict[str, Unit]] = {
    "time": _units(s=1.0, ms=(1.0, 1e3), us=(1.0, 1e6), ns=(1.0, 1e9), min=60.0),
    "length": _units(m=1.0, mm=(1.0, 1e3), cm=(1.0, 1e2), um=(1.0, 1e6))
    | {"in": Unit("in", 0.0254)},
    "angle": _units(rad=1.0, deg=DEGREE),
    "force": _units(N=1.0, mN=(1.0, 1e3), kN=1e3, kgf=GRAVITY, lbf=POUND),
    "torque": _units(
        N_m=1.0,
        N_mm=(1.0, 1e3),
        N_cm=(1.0, 1e2),
        mN_m=(1.0, 1e3),
        kgf_m=GRAVITY,
        kgf_cm=(GRAVITY, 1e2),
        lbf_in=POUND * 0.0254,
        lbf_ft=POUND * 0.3048,
    ),
    "speed": {
        "m/s": Unit("m/s"),
        "mm/s": Unit("mm/s", 1.0, 1e3),
        "cm/s": Unit("cm/s", 1.0, 1e2),
    },
    "angular speed": {"rad/s": Unit("rad/s"), "deg/s": Unit("deg/s", *DEGREE)},
    "acceleration": {
        "m/s^2": Unit("m/s^2"),
        "mm/s^2": Unit("mm/s^2", 1.0, 1e3),
        "g": Unit("g", GRAVITY),
    },
    "current": _units(A=1.0, mA=(1.0, 1e3)),
    "angular acceleration": {
        "rad/s^2": Unit("rad/s^2"),
        "deg/s^2": Unit("deg/s^2", *DEGREE),
    },
}
"""Units by kind and name; the first of each kind is its SI unit."""

ALIASES = {
    alias: name
    for name, aliases in (
        ("s", "sec secs second seconds 秒"),
        ("ms", "msec msecs millis millisecond milliseconds"),
        ("us", "usec usecs micros microsecond microseconds"),
        ("ns", "nanos nsec nsecs nanosec nanosecs nanosecond nanoseconds"),
        ("m", "meter meters metre metres"),
        ("mm", "millimeter millimeters millimetre millimetres"),
        ("cm", "centimeter centimeters centimetre centimetres"),
        ("in", "inch inches"),
        ("rad", "rads radian radians"),
        ("deg", "degs degree degrees"),
        ("N", "newton newtons"),
        ("kgf", "kg"),
        ("lbf", "lb lbs"),
        ("N m", "newtonmeter newtonmeters newtonmetre newtonmetres"),
        (
            "N mm",
            "newtonmillimeter newtonmillimeters newtonmillimetre newtonmillimetres",
        ),
        ("kgf m", "kgm"),
        ("kgf cm", "kgcm"),
        ("lbf in", "lbin inlb inlbf lbsin inlbs"),
        ("lbf ft", "lbft ftlb ftlbf lbsft ftlbs"),
    )
    for alias in aliases.split()
}
"""Other words for units, in small letters; kg of a force means kgf."""

SECOND = UNITS["time"]["s"]
"""The SI unit of time."""


SCALED = re.compile(r"\s*(\d{1,9}(?:\.\d{1,9})?(?:e-?\d{1,2})?)\s*([^\d\s].*)")
"""A unit with a factor before it."""


def find_unit(name: object, kind: str, where: object) -> Unit:
    """The unit `name` of a kind of quantity (a key of `UNITS`).

    ``"N m"``, ``"N-m"`` and ``"N·m"`` are the same, as are ``"m/s2"`` and ``"m/s^2"``, and
    `ALIASES`. A factor may precede the unit: ``"0.0001 deg"``. `InputError`, naming
    `where`, lists the known units.
    """
    known = UNITS[kind]
    if not isinstance(name, str):
        raise InputError(
            f"the unit of {kind} is not text", where, f"use {', '.join(known)}"
        )
    if (scaled := SCALED.fullmatch(name)) and 0.0 < (factor := float(scaled[1])) < 1e9:
        unit = find_unit(scaled[2], kind, where)
        return Unit(name.strip(), factor * unit.multiplier, unit.divisor)
    plain = {_plain(each): unit for each, unit in known.items()}
    found = plain.get(_plain(name)) or known.get(ALIASES.get(_plain(name).lower(), ""))
    if found is None:
        what = f"unknown unit of {kind} '{name[:40]}'{nearest(name, known)}"
        raise InputError(what, where, f"use {', '.join(known)}")
    return found


def _plain(name: str) -> str:
    """A unit without spaces, hyphens, dots and carets, and with common signs replaced."""
    name = (
        name.replace("²", "2").replace("µ", "u").replace("μ", "u").replace("°", "deg")
    )
    return re.sub(r"[\s*·⋅・･^.-]", "", name)


def squeezed(unit: str) -> str:
    """A unit as a word of a name: ``nmm``."""
    return re.sub(r"[^a-z0-9]", "", unit.lower())
