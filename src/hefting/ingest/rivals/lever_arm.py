"""The sensor is elsewhere than the logged frame, with the same axes: the pose is that of
a flange behind it, or the torque is about a point of the tool."""

import numpy as np

from hefting.ingest.rivals.case import Case
from hefting.ingest.rivals.explanation import Explanation, fit_as_given
from hefting.ingest.rivals.placement import (
    LARGEST_LEVER,
    advice,
    find_placement,
    place_text,
    seen_from_log,
    turned_and_moved,
)

CODE = "lever-arm"
STEPS = 5
"""Gauss-Newton steps of the point and the clock offset."""


def explain(case: Case) -> Explanation | None:
    """The point, from the logged frame's origin."""
    if not case.path.moves or case.path.kind == "orientation":
        return None
    _, offset = fit_as_given(case)
    found = find_placement(
        case, np.eye(3), offset, turns=False, moves=True, steps=STEPS
    )
    point, std = found.point, np.sqrt(found.covariance.diagonal())
    if not np.linalg.norm(point) <= LARGEST_LEVER:
        return None
    otherwise = " if the sensor is there, or log the torque about the logged frame"
    return Explanation(
        CODE,
        f"the torque seems to act about a point {place_text(point, std)} from the "
        "logged frame",
        advice(case, np.eye(3), point, otherwise=otherwise),
        found.fitted,
        3,
        argument="sensor_pose_in_log",
        parameters=seen_from_log(found.parameters, point),
        effect=float(np.linalg.norm(point / np.maximum(std, 1e-12))),
        alternative=lambda: turned_and_moved(case, CODE, np.eye(3), found.offset),
    )
