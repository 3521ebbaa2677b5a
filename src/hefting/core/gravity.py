"""Gravity: its direction and size where a recording was made, and how well these are
known.

On the Earth's surface gravity is from 9.764 to 9.834 m/s². A mass found from a force at
rest is wrong by as much, the other way: a share of the error of gravity. The size at a
latitude is that of the normal gravity of WGS 84 (NIMA TR8350.2, *Department of Defense
World Geodetic System 1984*, 2000): on the ellipsoid the closed form of Somigliana, eq.
(4-1), and above it the expansion in the altitude, eq. (4-3).
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any, Literal, Self

import numpy as np
from numpy.typing import ArrayLike

from hefting.core.errors import InputError, check_number
from hefting.core.spatial import STANDARD_GRAVITY, Array, check_gravity

EQUATORIAL_GRAVITY = 9.7803253359
"""[m/s²] Normal gravity at the equator; WGS 84."""
SOMIGLIANA = 0.00193185265241
"""Somigliana's constant k; WGS 84."""
SQUARED_ECCENTRICITY = 0.00669437999014
"""First eccentricity of the ellipsoid, squared; WGS 84."""
SEMI_MAJOR_AXIS = 6378137.0
"""[m] of the ellipsoid; WGS 84."""
FLATTENING = 1.0 / 298.257223563
"""Flattening of the ellipsoid; WGS 84."""
CENTRIFUGAL_RATIO = 0.00344978650684
"""Centrifugal acceleration at the equator over gravity, the m of WGS 84."""
WORLD_STD = 0.013
"""[m/s²] Root mean square difference of local gravity from 9.80665 at an unknown place:
0.017 weighted by population, in bands of 10° of latitude, 0.011 by installed industrial
robots, by country. Its 95 % range, 9.781 to 9.832, is that of normal gravity at sea
level between the equator and the poles."""
LATITUDE_STD = 0.0015
"""[m/s²] Standard deviation of local gravity at a known latitude whose altitude is not
given: people live within some 500 m of sea level, where 100 m make 0.0003."""
PLACE_STD = 0.0005
"""[m/s²] Standard deviation of local gravity at a known latitude and altitude: free-air
anomalies of land are 30 to 50 mGal, and half a degree of latitude makes 0.0004 at
most."""
ALTITUDES = (-500.0, 9000.0)
"""[m] Lowest and highest altitude that is accepted."""


@dataclass(frozen=True)
class Gravity:
    """Gravity in world axes, and its uncertainty. It can be given wherever three numbers can.

    Examples
    --------
    >>> gravity = hefting.Gravity.at(latitude=59.9, altitude=20.0)
    >>> round(-gravity.vector[2], 3)
    9.819
    >>> found = hefting.identify("demo/log.csv", gravity=gravity)
    """

    vector: tuple[float, float, float]
    """[m/s²]"""
    std: float = 0.0
    """[m/s²] standard deviation of its size; 0 where it is exact"""
    direction: Literal["known", "estimate"] = "known"
    """whether the direction is to be estimated, for a robot on a tilted base"""

    @classmethod
    def of(cls, value: Gravity | ArrayLike | Literal["estimate"]) -> Gravity:
        """From three numbers, which are exact, also as text, ``"0,0,-9.81"``; or from
        ``"estimate"``: anywhere on the Earth, in a direction that is to be found.
        Raises `InputError` for anything else."""
        if isinstance(value, Gravity):
            return value
        if isinstance(value, str):
            if value == "estimate":
                return ON_EARTH.in_unknown_direction
            value = _three_numbers(value)
        x, y, z = check_gravity(value).tolist()
        return cls((x, y, z))

    @classmethod
    def at(cls, latitude: float, altitude: float | None = None) -> Self:
        """Gravity at a latitude [°], north positive, and an altitude [m], by default
        unknown, near 0.

        Raises `InputError` for a place that is not on the Earth.
        """
        size = normal_gravity(latitude, 0.0 if altitude is None else altitude)
        return cls((0.0, 0.0, -size), LATITUDE_STD if altitude is None else PLACE_STD)

    @property
    def in_unknown_direction(self) -> Gravity:
        """The same gravity, whose direction is to be estimated."""
        return replace(self, direction="estimate")

    @property
    def relative_std(self) -> float:
        """Standard deviation of the size over the size."""
        return self.std / float(np.linalg.norm(self.vector))

    def __array__(self, dtype: Any = None, copy: bool | None = None) -> Array:
        """(3,) the vector [m/s²]."""
        return np.array(self.vector, dtype=dtype)


GravityLike = Gravity | ArrayLike | Literal["estimate"]
"""Gravity, three numbers [m/s²] that are exact, or ``"estimate"``."""


def _three_numbers(text: str) -> list[float]:
    try:
        return [float(number) for number in text.split(",")]
    except ValueError:
        fix = "use X,Y,Z [m/s²] or estimate"
        raise InputError(f"unknown gravity '{text[:40]}'", fix=fix) from None


def normal_gravity(latitude: float, altitude: float = 0.0) -> float:
    """Size [m/s²] of normal gravity at a latitude [°] and an altitude above the
    ellipsoid [m].

    Raises `InputError` for a latitude beyond 90°, an altitude outside `ALTITUDES`, and
    what is no number.
    """
    check_number("latitude", latitude, "degrees")
    check_number("altitude", altitude, "metres")
    if not abs(latitude) <= 90.0:
        what = f"a latitude of {latitude:g}° is not on the Earth"
        raise InputError(what, fix="give degrees from -90 (south) to 90")
    low, high = ALTITUDES
    if not low <= altitude <= high:
        what = f"an altitude of {altitude:g} m is not on the ground"
        raise InputError(what, fix=f"give metres from {low:g} to {high:g}")
    square = float(np.sin(np.radians(latitude)) ** 2)
    on_ellipsoid = (
        EQUATORIAL_GRAVITY
        * (1.0 + SOMIGLIANA * square)
        / (1.0 - SQUARED_ECCENTRICITY * square) ** 0.5
    )
    h = altitude / SEMI_MAJOR_AXIS
    slope = 2.0 * (1.0 + FLATTENING + CENTRIFUGAL_RATIO - 2.0 * FLATTENING * square)
    return on_ellipsoid * (1.0 - slope * h + 3.0 * h * h)


ON_EARTH = Gravity(STANDARD_GRAVITY, WORLD_STD)
"""Standard gravity of uncertain size, for an unknown place."""
