"""Events: what happened between two stretches, by the bodies before and after."""

import numpy as np

from hefting.core.spatial import Array
from hefting.ingest.changes.stretches import EventKind

BARE_SHARE = 0.2
"""Share of the heavier body's mass up to which the lighter one is a bare gripper, or
nothing."""
SIGNIFICANT = 4.0
"""Number of standard deviations from which on two masses differ."""
SAME_MASS_SHARE = 0.05
"""Difference of two masses, as a share of the larger, up to which they are the same:
the errors of a sensor."""


def event_between(before: Array, after: Array, std_of_difference: float) -> EventKind:
    """Kind of a change from one body to another.

    Parameters
    ----------
    before, after : (10,) parameters, with a positive mass for what is heavy.
    std_of_difference : of the masses [kg].
    """
    heavier = max(float(before[0]), float(after[0]))
    if before[0] <= BARE_SHARE * heavier:
        return "picked-up"
    if after[0] <= BARE_SHARE * heavier:
        return "put-down"
    apart = abs(float(after[0] - before[0]))
    if apart > max(SIGNIFICANT * std_of_difference, SAME_MASS_SHARE * heavier):
        return "swapped"
    return "slipped"


def center_of_mass(body: Array, heaviest: float) -> Array | None:
    """(3,) [m]; None for a body (10,) whose mass is negligible beside the heaviest
    [kg]."""
    mass = float(body[0])
    if not mass > 0.02 * heaviest:
        return None
    return np.asarray(body[1:4] / mass)
