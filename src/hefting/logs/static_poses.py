"""Rows of a table that are static poses: without a time, or seconds apart."""

from dataclasses import replace

import numpy as np

from hefting.core.messages import warning
from hefting.core.recording import Recording, Stream
from hefting.core.spatial import Array, median, own, rotation_matrices

STATIC_STREAMS = {
    *("position", "orientation", "joint_positions", "wrench", "accelerometer")
}
"""Streams that can be measured at rest, so that a table of them without times may be
static poses."""

FEWEST_SMOOTH, LARGEST_STEP = 50, 0.1
"""Poses, and the largest step among them over their extent, from which on they are
those of a motion: an arm that turns by 3 rad/s, logged at 20 Hz, goes 0.15 rad a row."""

PAUSE, TURN = 0.9, 0.35
"""Time [s] and change of the pose from row to row above which rows are static poses, as
the motion between them cannot be found."""


def without_times(recording: Recording) -> Recording:
    """The recording; of static poses that have times, as rows seconds apart that are each
    turned against the one before, it is without these."""
    stream = _pose_stream(recording)
    if recording.static or len(stream) < 2:
        return recording
    pause = median(np.diff(stream.time))
    if pause < PAUSE:
        return recording
    turns = np.abs(np.diff(_poses_of(recording), axis=0)).reshape(len(stream) - 1, -1)
    kept = {
        name: replace(each, time=own(np.arange(float(len(stream)))))
        for name, each in recording.streams.items()
        if name in STATIC_STREAMS and np.array_equal(each.rows, stream.rows)
    }
    if median(turns.max(axis=1)) < TURN or "wrench" not in kept:
        return recording
    what = f"each of {len(stream)} rows, some {pause:.3g} s apart, is taken as a static pose"
    left = (m for m in recording.warnings if getattr(m, "code", "") != "time-step-long")
    said = (*left, warning("poses-static", what))
    return replace(recording, streams=kept, static=True, warnings=said, angles=None)


def warn_about_static(recording: Recording) -> Recording:
    """The recording, with a warning when its rows hardly are static poses."""
    signs = [f"there is {n}" for n in recording.streams if n not in STATIC_STREAMS]
    count = max(len(stream) for stream in recording.streams.values())
    signs += ["they move smoothly"] if _moves_smoothly(recording) else []
    if not signs and count <= 1000:
        return recording
    also = f", although {' and '.join(signs)}" if signs else ""
    what = (
        f"there is no column time: each of {count} rows is taken as a static pose{also}; "
        "of rows in motion give the rate in a column map, time = { rate = 250 } [Hz]"
    )
    return replace(
        recording, warnings=(*recording.warnings, warning("no-time-column", what))
    )


def _moves_smoothly(recording: Recording) -> bool:
    """Whether no step from one pose to the next is a large part of the way that all of
    them go, as between static poses it is."""
    poses = _poses_of(recording)
    if len(poses) < FEWEST_SMOOTH:
        return False
    steps = np.abs(np.diff(poses, axis=0)).max()
    return bool(steps < LARGEST_STEP * np.ptp(poses, axis=0).max())


def _pose_stream(recording: Recording) -> Stream:
    """Orientations, or joint angles where there are none."""
    turned = "orientation" in recording.streams
    return recording["orientation" if turned else "joint_positions"]


def _poses_of(recording: Recording) -> Array:
    """(K, 3, 3) orientations, or (K, n) joint angles where there are none."""
    values = _pose_stream(recording).values
    return rotation_matrices(values) if "orientation" in recording.streams else values
