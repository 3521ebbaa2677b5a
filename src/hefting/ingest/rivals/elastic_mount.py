"""The sensor's mount yields to the load and turns the sensor against the logged frame,
by a compliance that is the same about all axes, times the torque about some point of
the mount.

To first order, and without the velocity of the turn, the specific force s of the sensor
is turned: by s x k (t + r x f) for a force f and a torque t.
"""

import numpy as np

from hefting.core.spatial import Array
from hefting.ingest.model import REGRESSOR_BY_FEATURE
from hefting.ingest.rivals.case import Case
from hefting.ingest.rivals.evidence import beside_body, fit_rows, with_bias
from hefting.ingest.rivals.explanation import Explanation, fit_as_given

CODE = "mount-elastic"
UNKNOWNS = 4
"""The compliance, and its product with the place of the point."""
PASSES = 2
"""Number of times that the load is predicted, with improved turns."""
SMALLEST_TURN = np.radians(1.0)
"""Smallest turn from the mean one that is reported: arms yield by some tenths of a
degree."""
LARGEST_TURN = np.radians(10.0)
"""Largest turn of a mount that could stay unnoticed; beyond, another object is
likelier."""


def explain(case: Case) -> Explanation | None:
    """The likeliest compliance, at the clock offset of the recording as given."""
    if not case.path.moves:
        return None
    fitted, offset = fit_as_given(case)
    motion = case.motion_late(offset)
    features = case.features(motion)
    maps = beside_body(np.eye(6 * UNKNOWNS).reshape(-1, 6, UNKNOWNS))
    for _ in range(PASSES):
        body = REGRESSOR_BY_FEATURE @ fitted.solution[fitted.best, :10]
        turns = _turns(features[0] @ body)
        moved = np.cross(features[0, :, None, :3], turns)
        columns = np.einsum("kux,xc->kcu", moved, body[:3])
        known = np.concatenate((features, columns.reshape(1, len(turns), -1)), axis=2)
        fitted = fit_rows(case, with_bias(case, known, maps, motion.known))
    turn = np.einsum("kux,u->kx", turns, fitted.solution[0, 10:][:UNKNOWNS])
    largest = float(np.linalg.norm(turn - turn.mean(axis=0), axis=1).max())
    if not SMALLEST_TURN < largest < LARGEST_TURN:
        return None
    what = (
        "the mount of the sensor seems to give way under the load, so that it is turned by "
        f"up to {np.degrees(largest):.2g}° from its mean direction in the logged frame"
    )
    fix = "mount it stiffer, or move slower with a lighter object"
    return Explanation(CODE, what, fix, fitted, UNKNOWNS, rarity=2.0)


def _turns(load: Array) -> Array:
    """(K, 4, 3) turns under loads (K, 6), per unit of the compliance and of its product
    with the place of the point."""
    force, torque = load[:, None, :3], load[:, None, 3:]
    return np.concatenate((torque, np.cross(np.eye(3), force)), axis=1)
