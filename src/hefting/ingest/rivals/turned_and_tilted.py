"""Both sensor and world have other axes than the logged ones: a marker attached at any
angle in a motion capture with y up, or poses by joints with wrong zeros."""

from functools import partial

import numpy as np

from hefting.core.spatial import Array, angle_between
from hefting.ingest.rivals import axes_turned, base_tilted
from hefting.ingest.rivals.axes_turned import (
    CODE,
    CROSS_TALK,
    rotation_at,
    rotation_of,
)
from hefting.ingest.rivals.base_tilted import SENSOR_ERROR, gravity_to_give
from hefting.ingest.rivals.case import Case
from hefting.ingest.rivals.explanation import Explanation
from hefting.ingest.rivals.placement import (
    advice,
    angle_and_axis,
    find_placement,
    turn_text,
)

CLEAR = 3.0
"""Standard deviations from which on a turn is larger than a sensor's errors."""
STEPS = 8
"""Gauss-Newton steps of turn, gravity's direction and clock offset."""


def explain(case: Case) -> Explanation | None:
    """The likeliest turn, with gravity's direction near the one given."""
    if not _is_modelled(case):
        return None
    turned = rotation_of(case)
    return _explain(case, turned.R, turned.offset, case.gravity)


def explain_axes(case: Case) -> Explanation | None:
    """The likeliest turn, with gravity near an axis of the world."""
    if not _is_modelled(case):
        return None
    size = float(np.linalg.norm(case.gravity))
    directions = [size * s * e for e in np.eye(3) for s in (1.0, -1.0)]

    def explained(gravity: Array) -> float:
        return rotation_at(case.with_gravity(gravity), case.likely_offsets)[2]

    gravity = max(directions, key=explained)
    R, offset, _ = rotation_at(case.with_gravity(gravity), case.offsets)
    return _explain(case, R, offset, gravity)


def _is_modelled(case: Case) -> bool:
    """Whether all accelerations are modelled; neglected ones look like a tilt."""
    return not (case.path.gravity_measured or case.path.kind == "orientation")


def _explain(case: Case, R: Array, offset: float, gravity: Array) -> Explanation:
    """From a turn (3, 3), a clock offset [s] and gravity (3,)."""
    found = find_placement(
        case,
        R,
        offset,
        turns=True,
        moves=False,
        tilts=True,
        steps=STEPS,
        gravity=gravity,
    )
    gravity, C = found.gravity, found.covariance
    angle, axis = angle_and_axis(found.R)
    known = float(np.sqrt(axis @ C[:3, :3] @ axis + 0.5 * CROSS_TALK**2))
    tilt = angle_between(case.gravity, gravity)
    std = float(np.hypot(np.sqrt(C[3:, 3:].trace() / 2.0), SENSOR_ERROR))
    turns, tilts = angle / max(known, 1e-12), tilt / std
    # where one is within a sensor's errors it is the other alone
    alone = axes_turned.explain if turns > CLEAR else base_tilted.explain
    x, y, z = gravity
    return Explanation(
        CODE,
        f"the sensor's axes seem turned by {turn_text(found.R, known)} of the logged "
        f"ones, and gravity to point along ({x:.2f}, {y:.2f}, {z:.2f}) m/s², "
        f"{np.degrees(tilt):.1f}° ± {np.degrees(std):.1g}° from where it is given",
        f"{advice(case, found.R, np.zeros(3), C[:3, :3])} and "
        f"{gravity_to_give(gravity, tilt)}; of poses by joints check their zeros",
        found.fitted,
        5,
        argument="sensor_pose_in_log",
        parameters=found.parameters,
        effect=min(turns, tilts),
        alternative=partial(alone, case),
    )
