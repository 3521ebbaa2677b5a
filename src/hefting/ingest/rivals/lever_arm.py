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
CHANCE = 16.0
"""Squared distance [standard deviations] of the point from the line to the COM that is
chance: torques of another gain had up to 12, lever arms of 120 mm 600 and more."""
LARGE_GAIN = 0.1
"""Error of a gain that is more than a sensor's own."""


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
    parameters = seen_from_log(found.parameters, point)
    # torques of another gain are those about a point on the line to the COM
    com = parameters[1:4] / (parameters[0] or 1.0)
    gain = 1.0 - float(point @ com) / max(float(com @ com), 1e-12)
    off = point - (1.0 - gain) * com
    scaled = gain > 0.0 and off @ np.linalg.solve(found.covariance, off) < CHANCE
    times = ""
    if scaled:
        times = f", or to be {gain:.2f} times what it is"
        otherwise += ", after its unit and calibration are checked"
    return Explanation(
        CODE,
        f"the torque seems to act about a point {place_text(point, std)} from the "
        f"logged frame{times}",
        advice(case, np.eye(3), point, otherwise=otherwise),
        found.fitted,
        3,
        argument="sensor_pose_in_log",
        parameters=parameters,
        effect=float(np.linalg.norm(point / np.maximum(std, 1e-12))),
        is_grave=scaled and abs(gain - 1.0) > LARGE_GAIN,
        alternative=lambda: turned_and_moved(case, CODE, np.eye(3), found.offset),
    )
