"""Which form three numbered angles have, as their numbers tell: a rotation vector, or
roll, pitch and yaw.

Either reads as a smooth motion by its own form. By the other one the body jumps wherever
the angles pass half a turn, and begin again at the other end.
"""

import numpy as np

from hefting.core.spatial import Array
from hefting.logs.orientations import quaternions

JUMP = 0.5
"""[rad] Turn from one row to the next that no recording of a slow arm has."""
SMOOTHER = 0.2
"""Largest turn by the right form over that by the other: both jump where messages are
lost."""


def form_of_angles(angles: Array) -> tuple[str, str]:
    """Form of the angles (N, 3) [rad] of one pose after the other, and why where it is
    not the usual one, a rotation vector."""
    known = angles[np.isfinite(angles).all(axis=1)]
    if len(known) < 2:
        return "rotation-vector", ""
    vector, rpy = (_largest_turn(known, form) for form in ("rotation-vector", "rpy"))
    if vector > JUMP and rpy < SMOOTHER * vector:
        return "rpy", "as a rotation vector it would jump"
    return "rotation-vector", ""


def _largest_turn(angles: Array, form: str) -> float:
    """[rad] Largest turn from one row to the next."""
    q = quaternions(angles, form)
    cosine = np.abs(np.einsum("ki,ki->k", q[1:], q[:-1]))
    return float(2.0 * np.arccos(np.clip(cosine, 0.0, 1.0)).max(initial=0.0))
