"""The sensor is displaced from the logged frame, with the same axes: the pose is that
of a flange behind it, or the torque is about a point of the tool."""

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
"""Number of Gauss-Newton steps of the point and the clock offset."""
CHANCE = 3.0
"""Distance, in standard deviations, of the point from the line to the COM that is
chance: up to 1.5 for torques of another gain, 14 and more for lever arms of 120 mm."""


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
    far, times = float(np.linalg.norm(com)), ""
    gain = 1.0 - float(point @ com) / max(far**2, 1e-12)
    off = np.linalg.norm(np.cross(point, com))
    if off < CHANCE * far * np.linalg.norm(std):
        times = f", or to be {gain:.2f} times what it is"
        otherwise += ", after its sign, unit and calibration are checked"
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
        # a sensor's own gain is off by less
        is_grave=bool(times) and abs(gain - 1.0) > 0.1,
        alternative=lambda: turned_and_moved(case, CODE, np.eye(3), found.offset),
    )
