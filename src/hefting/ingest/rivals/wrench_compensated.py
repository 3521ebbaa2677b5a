"""The controller subtracts the weight of a payload: of all of the object, of a part of
it, or of somewhat more.

Gravity then acts on another mass and first moment than acceleration does.
"""

from dataclasses import replace

import numpy as np

from hefting.core.spatial import Array
from hefting.ingest.model import REGRESSOR_BY_FEATURE
from hefting.ingest.rivals.case import Case, Motion
from hefting.ingest.rivals.evidence import Fitted, Rows, linear_step, with_bias
from hefting.ingest.rivals.explanation import Explanation, over_offsets

CODE = "wrench-compensated"
LARGEST_SHARE = 1.5
"""Largest share of the object's weight that a controller takes away: more is gravity the
wrong way round."""


def explain(case: Case) -> Explanation | None:
    """The share of the object's weight that is missing."""
    if not case.path.moves or case.path.kind == "orientation":
        return None
    fitted, _ = over_offsets(case, lambda motion: _rows(case, motion))
    solution = fitted.solution[fitted.best]
    mass, weighed = float(solution[0]), float(solution[10])
    if not mass:
        return None
    share = 1.0 - weighed / mass
    if not 0.0 <= share <= LARGEST_SHARE:
        return None
    std = _share_std(fitted)
    what = (
        f"some {100.0 * share:.0f} % of the object's weight seem to be missing in the "
        "wrench, as where the controller subtracts a payload"
    )
    fix = "set its payload to zero before recording"
    return Explanation(CODE, what, fix, fitted, 4, effect=abs(share) / max(std, 1e-9))


def _rows(case: Case, motion: Motion) -> Rows:
    gravity = -(motion.axes @ case.gravity)
    a = motion.a if not case.path.gravity_measured else motion.a - gravity
    known = np.concatenate((a, motion.rest, gravity), axis=2)
    return with_bias(case, known, _maps(), motion.known)


def _maps() -> Array:
    """Columns of the ten parameters by the acceleration, then of mass and first moment
    by gravity."""
    maps = np.zeros((15, 6, 14))
    maps[:12, :, :10] = REGRESSOR_BY_FEATURE
    maps[12:, :, 10:] = REGRESSOR_BY_FEATURE[:3, :, :4]
    return maps


def _share_std(fitted: Fitted) -> float:
    """Standard deviation of the share, beside the mass that acceleration acts on."""
    found = fitted.of_best()
    rows, mass = found.rows, float(found.solution[0, 0])
    # the wrench by the share, where the mass that gravity acts on is the rest of it
    column = -mass * (rows.known[0] @ rows.maps[:, :, 10])
    maps = rows.maps.copy()
    maps[:, :, 0] += maps[:, :, 10]
    tied = replace(found, rows=replace(rows, maps=np.delete(maps, 10, axis=2)))
    step = linear_step(tied, 0, column[:, :, None])
    return float(np.sqrt(step.covariance[0, 0]))
