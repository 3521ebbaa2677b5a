"""The three angles of the orientation are of another form than they were read in."""

from dataclasses import replace

import numpy as np

from hefting.ingest.rivals.case import Case
from hefting.ingest.rivals.explanation import Explanation, explained_by_poses
from hefting.logs.orientations import quaternions

CODE = "orientation-form"
FORMS = (
    ("rotation-vector", ""),
    ("rpy", ""),
    *(("euler", order) for order in ("XYZ", "ZYX", "ZYZ")),
)
"""Forms, and orders of Euler angles, in which controllers of robots give orientations."""


def explain(case: Case) -> Explanation | None:
    """The likeliest form of the angles as they were logged."""
    angles = case.recording.angles
    if angles is None or case.recording.sensor_pose is not None:
        return None
    recording = case.recording
    within = (recording.start, recording.start + recording.duration)
    first, last = np.searchsorted(angles.time, within)
    angles, found = angles[first : last + 1], []
    for form, order in FORMS:
        logged = replace(angles, values=quaternions(angles.values, form, order))
        other = replace(recording, streams={**recording.streams, "orientation": logged})
        fitted = explained_by_poses(case, other)
        if fitted is not None:
            found.append((fitted, form, order))
    if not found:
        return None
    fitted, form, order = max(found, key=lambda each: each[0].likelihood.max())
    said = f'form = "{form}"' + (f', order = "{order}"' if order else "")
    return Explanation(
        CODE,
        "the angles of the orientation seem to be of another form than they are read in",
        f"give {said} of the orientation in a column map",
        fitted,
        0,
        argument="column_map",
    )
