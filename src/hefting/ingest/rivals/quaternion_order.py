"""The quaternion's real part was logged first, where it is read as the last."""

from dataclasses import replace

import numpy as np

from hefting.ingest.rivals.case import Case
from hefting.ingest.rivals.explanation import Explanation, explained_by_poses

CODE = "quaternion-order"


def explain(case: Case) -> Explanation | None:
    """The poses with the quaternion's parts in the other order."""
    orientation = case.recording["orientation"]
    q = np.roll(orientation.values, -1, axis=1)
    streams = {**case.recording.streams, "orientation": replace(orientation, values=q)}
    fitted = explained_by_poses(case, replace(case.recording, streams=streams))
    if fitted is None:
        return None
    return Explanation(
        CODE,
        "the quaternions seem to be logged as w, x, y, z",
        "put the real part last, as qw",
        fitted,
        0,
    )
