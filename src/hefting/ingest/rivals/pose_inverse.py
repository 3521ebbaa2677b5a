"""The logged pose is that of the world in the sensor frame, not of the sensor in the
world."""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from hefting.ingest.rivals.case import Case
from hefting.ingest.rivals.explanation import Explanation, Undone, likeliest, with_poses

CODE = "pose-inverse"


def explain(case: Case) -> Explanation | None:
    """The likelier of inverse poses and inverse orientations."""
    return likeliest(undone(case))


def undone(case: Case) -> Iterator[Undone]:
    """The inverse poses, then the inverse orientation alone."""
    from scipy.spatial.transform import Rotation

    recording = case.recording
    orientation = recording["orientation"]
    q = orientation.values * np.array((-1.0, -1.0, -1.0, 1.0))
    streams = {**recording.streams, "orientation": replace(orientation, values=q)}
    tried = [("orientation", streams)]
    position = recording.streams.get("position")
    if position is not None and len(position) == len(orientation):
        p = -Rotation.from_quat(q).apply(np.array(position.values))
        tried.insert(0, ("pose", {**streams, "position": replace(position, values=p)}))
    for name, streams in tried:
        what = f"the logged {name} seems to be that of the world in the sensor frame"
        other = with_poses(case, what, replace(recording, streams=streams))
        if other is not None:
            yield Undone(
                CODE,
                what,
                "log that of the sensor in the world, which is its inverse",
                other,
            )
