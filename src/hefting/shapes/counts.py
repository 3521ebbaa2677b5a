"""How many points a solid is given."""

from typing import Any

from hefting.core.errors import InputError
from hefting.shapes.checks import point_count, positive
from hefting.shapes.sampling import MAX_POINTS
from hefting.shapes.solid import Solid

DEFAULT_POINTS = 56
"""Number of points when none is asked for (Nadeau et al. 2022, Sec. V)."""


def count_of_points(
    solid: Solid, points: int | None, points_per_cm3: float | None, where: Any
) -> int:
    """Number of points, as given, by density [1/cm³], or by default.

    Raises `InputError` where both are given, and for what is no number of points.
    """
    if points is not None and points_per_cm3 is not None:
        raise InputError(
            "points and points_per_cm3 are both given", fix="give one of them"
        )
    if points_per_cm3 is None:
        return point_count(DEFAULT_POINTS if points is None else points)
    exact = positive(points_per_cm3, "points_per_cm3") * solid.volume * 1e6
    if exact > MAX_POINTS:
        volume = f"{solid.volume * 1e6:.4g} cm³"
        what = f"{points_per_cm3:g} points/cm³ in {volume} are over {MAX_POINTS} points"
        raise InputError(what, where, "check the unit, or ask for fewer")
    return point_count(max(1, round(exact)))
