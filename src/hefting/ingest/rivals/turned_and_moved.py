"""The sensor's axes are turned, and its origin is elsewhere than the logged frame's: tried
where one of both is the likeliest mistake."""

import numpy as np

from hefting.core.spatial import Array
from hefting.ingest.rivals.case import Case
from hefting.ingest.rivals.explanation import Explanation
from hefting.ingest.rivals.placement import (
    LARGEST_LEVER,
    advice,
    angle_and_axis,
    find_placement,
    place_text,
    seen_from_log,
    turn_text,
)

STEPS = 6
"""Gauss-Newton steps of turn, place and clock offset."""


def turned_and_moved(
    case: Case, code: str, R: Array, offset: float
) -> Explanation | None:
    """Both, from a rotation (3, 3) and a clock offset [s], under the code of the one that
    explains more alone."""
    if not case.path.moves or case.path.kind == "orientation":
        return None
    found = find_placement(case, R, offset, turns=True, moves=True, steps=STEPS)
    point, C = found.point, found.covariance
    if not np.linalg.norm(point) <= LARGEST_LEVER:
        return None
    angle, axis = angle_and_axis(found.R)
    known = float(np.sqrt(axis @ C[:3, :3] @ axis))
    std = np.sqrt(C.diagonal()[3:])
    return Explanation(
        code,
        f"the sensor's axes seem turned by {turn_text(found.R, known)} of the logged "
        f"ones, and its origin at {place_text(point, std)} of the logged frame",
        advice(case, found.R, point),
        found.fitted,
        6,
        argument="sensor_pose_in_log",
        parameters=seen_from_log(found.parameters, found.R.T @ point),
        effect=min(
            angle / max(known, 1e-12),
            float(np.linalg.norm(point / np.maximum(std, 1e-12))),
        ),
    )
