"""A cable or hose pulls at the sensor: a force that depends on where the sensor is.

The pull is that of an isotropic spring between a point of the world and a point of the
sensor frame, -k (p - p0). Its part along gravity cannot be told from the object's
weight, but for its change.
"""

import numpy as np

from hefting.core.spatial import Array, skew
from hefting.ingest.model import FEATURES, REGRESSOR_BY_FEATURE, tangents_of
from hefting.ingest.rivals.case import Case, Motion
from hefting.ingest.rivals.evidence import Fitted, Rows, fit_rows, with_bias
from hefting.ingest.rivals.explanation import Explanation

CODE = "cable-force"
UNKNOWNS = 12
"""Stiffness, pull across gravity, and the moments of both about the sensor."""
BODY_AND_PULLS = 22
"""Unknowns of the body and the spring, which come before those of the bias."""


def explain(case: Case) -> Explanation | None:
    """The likeliest spring, at no clock offset and at the one that was found."""
    if not case.path.moves or not case.recording.has("position"):
        return None
    times = case.time - case.likely_offsets[:, None]
    fitted = fit_rows(case, _rows(case, case.motion_at(times), times))
    force, torque = _largest_pull(fitted)
    pull = f"{force:.2g} N" if force > case.floor[0] else f"{torque:.2g} N m"
    what = (
        f"something pulls at the sensor by up to {pull}, depending on where it "
        "is, as a cable or a hose does"
    )
    fix = "fix it to the arm with slack, or off the arm, and record again"
    return Explanation(CODE, what, fix, fitted, UNKNOWNS, rarity=1.0)


def _rows(case: Case, motion: Motion, times: Array) -> Rows:
    """Rows of a body, a bias, and a spring."""
    position = case.recording["position"]
    shape = (*times.shape, 3)
    place = np.stack(
        [np.interp(times, position.time, x) for x in position.values.T], axis=2
    )
    place -= place.mean(axis=(0, 1))
    across = tangents_of(case.gravity)  # (2, 3)
    pulls = [np.broadcast_to(side, shape) for side in across] + [place]
    turned = [np.einsum("okij,okj->oki", motion.axes, pull) for pull in pulls]
    known = np.concatenate((motion.features(case.modelled_gravity), *turned), axis=2)
    return with_bias(case, known, _maps(len(pulls)), motion.known)


def _maps(pulls: int) -> Array:
    """Columns of the ten parameters; of the size of each pull; of its size times the
    place (3,) where it acts."""
    maps = np.zeros((FEATURES + 3 * pulls, 6, 10 + 4 * pulls))
    maps[:FEATURES, :, :10] = REGRESSOR_BY_FEATURE
    for i in range(pulls):
        for axis, unit in enumerate(np.eye(3)):
            row = FEATURES + 3 * i + axis
            maps[row, axis, 10 + 4 * i] = 1.0
            # r x e is -skew(e) r
            maps[row, 3:, 11 + 4 * i : 14 + 4 * i] = -skew(unit)
    return maps


def _largest_pull(fitted: Fitted) -> Array:
    """(2,) force [N], and torque [N m]."""
    best, rows = fitted.best, fitted.rows
    solution = fitted.solution[best, :BODY_AND_PULLS].copy()
    solution[:10] = 0.0
    pull = rows.predict(solution)[best].reshape(-1, 2, 3)
    return np.linalg.norm(pull, axis=2).max(axis=0)
