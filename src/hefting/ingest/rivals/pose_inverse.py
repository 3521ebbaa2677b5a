"""The logged pose is that of the world in the sensor frame, not of the sensor in the
world."""

from dataclasses import replace

import numpy as np

from hefting.ingest.rivals.case import Case
from hefting.ingest.rivals.explanation import Explanation, explained_by_poses

CODE = "pose-inverse"


def explain(case: Case) -> Explanation | None:
    """The inverse poses; or with the orientation inverted alone."""
    from scipy.spatial.transform import Rotation

    recording = case.recording
    orientation = recording["orientation"]
    q = orientation.values * np.array((-1.0, -1.0, -1.0, 1.0))
    streams = {**recording.streams, "orientation": replace(orientation, values=q)}
    tried = [("orientation", replace(recording, streams=streams))]
    position = recording.streams.get("position")
    if position is not None and len(position) == len(orientation):
        p = -Rotation.from_quat(q).apply(np.array(position.values))
        whole = {**streams, "position": replace(position, values=p)}
        tried.insert(0, ("pose", replace(recording, streams=whole)))
    found = [(name, explained_by_poses(case, other)) for name, other in tried]
    best = [(name, fitted) for name, fitted in found if fitted is not None]
    if not best:
        return None
    name, fitted = max(best, key=lambda each: each[1].likelihood.max())
    return Explanation(
        CODE,
        f"the logged {name} seems to be that of the world in the sensor frame",
        "log that of the sensor in the world, which is its inverse",
        fitted,
        0,
    )
