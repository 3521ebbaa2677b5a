"""Other poses in the place of the logged ones."""

from hefting.core.recording import Recording
from hefting.ingest.path import path_of, static_path
from hefting.ingest.rivals.case import Case
from hefting.ingest.rivals.evidence import Fitted
from hefting.ingest.rivals.explanation import newton_euler, over_offsets


def explained_by_poses(case: Case, recording: Recording) -> Fitted | None:
    """The fit with the poses of another recording; None where there is no motion in
    them."""
    if case.path.kind in ("columns", "accelerometer"):
        return None
    path = (
        path_of(recording, "auto", case.gravity)
        if case.path.moves
        else static_path(recording)
    )
    if path is None:
        return None
    other = case.with_path(recording, path)
    return over_offsets(other, lambda motion: newton_euler(other, motion))[0]
