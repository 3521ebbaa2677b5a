"""The sensor is elsewhere than the logged frame, with the same axes: the pose is that of
a flange behind it, or the torque is about a point of the tool.

A point r of the turning frame has the acceleration a + alpha x r + w x (w x r). The
wrench about it is that of a body held there; r is found by Gauss-Newton steps.
"""

import numpy as np

from hefting.core.spatial import Array, skew, vector_to_tensor
from hefting.ingest.model import REGRESSOR_BY_FEATURE
from hefting.ingest.rivals.case import Case, Motion
from hefting.ingest.rivals.evidence import Fitted, Rows, fit_rows, linear_step
from hefting.ingest.rivals.explanation import (
    Explanation,
    fit_as_given,
    newton_euler,
    offset_columns,
)

CODE = "lever-arm"
STEPS = 5
"""Gauss-Newton steps of the point and the clock offset."""
LARGEST_LEVER = 0.5
"""[m] Largest distance of a sensor from the logged frame: points beyond are found where
force and torque do not belong together."""
LARGEST_STEP = 0.3
"""[m] Largest change of the point along each axis in one of them."""


def explain(case: Case) -> Explanation | None:
    """The point, from the logged frame's origin."""
    if not case.path.moves or case.path.kind == "orientation":
        return None
    _, offset = fit_as_given(case)
    point, std, fitted = _find(case, offset)
    if not np.linalg.norm(point) <= LARGEST_LEVER:
        return None
    pairs = zip(point, std, strict=True)
    place = ", ".join(f"{1e3 * x:.0f} ± {1e3 * s:.0f}" for x, s in pairs)
    numbers = ",".join(f"{x:.4f}" for x in point)
    return Explanation(
        CODE,
        f"the torque seems to act about a point ({place}) mm from the logged frame",
        f"give `sensor_pose_in_log`='{numbers},0,0,0,1' if the sensor is there, or log "
        "the torque about the logged frame",
        fitted,
        3,
        argument="sensor_pose_in_log",
        parameters=_seen_from_log(fitted.solution[0, :10], point),
        effect=float(np.linalg.norm(point / np.maximum(std, 1e-12))),
    )


def moved(motion: Motion, point: Array) -> Motion:
    """The motion of a point (3,) of the moving frame."""
    return Motion(
        motion.a + _arms(motion) @ point, motion.rest, motion.axes, motion.known
    )


def _arms(motion: Motion) -> Array:
    """(O, K, 3, 3) acceleration of points by their place: [alpha]x + [w]x [w]x."""
    S = vector_to_tensor(motion.rest[..., 3:])
    turning = S - np.trace(S, axis1=-2, axis2=-1)[..., None, None] * np.eye(3)
    return skew(motion.rest[..., :3]) + turning


def _find(case: Case, offset: float) -> tuple[Array, Array, Fitted]:
    """The point (3,) [m], its standard deviations, and its fit."""
    point, std = np.zeros(3), np.full(3, np.inf)

    def build(motion: Motion) -> Rows:
        return newton_euler(case, moved(motion, point))

    motion = case.motion_at(case.time[None] - offset)
    fitted = fit_rows(case, build(motion))
    for _ in range(STEPS):
        effect = REGRESSOR_BY_FEATURE[:3] @ fitted.solution[0, :10]  # (3, 6)
        columns = np.einsum("kxj,xc->kcj", _arms(motion)[0], effect)
        late = offset_columns(case, build, offset, fitted.solution[0])
        step = linear_step(fitted, 0, np.concatenate((columns, late), axis=2))
        point = point + np.clip(step.change[:3], -LARGEST_STEP, LARGEST_STEP)
        std = np.sqrt(step.covariance.diagonal()[:3])
        offset += float(np.clip(step.change[3], -0.02, 0.02))
        motion = case.motion_at(case.time[None] - offset)
        fitted = fit_rows(case, build(motion))
    return point, std, fitted


def _seen_from_log(vector: Array, point: Array) -> Array:
    """Parameters (10,) with the COM as seen from the logged frame."""
    seen = vector.copy()
    seen[1:4] += vector[0] * point
    return seen
