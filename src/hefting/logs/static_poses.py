"""Rows of a table that are static poses: without a time, or seconds apart."""

from dataclasses import replace

import numpy as np

from hefting.core.messages import error, note, warning
from hefting.core.recording import Recording, Stream
from hefting.core.spatial import Array, median, own, quantile, rotation_matrices

STATIC_STREAMS = {
    *("position", "orientation", "joint_positions", "wrench", "accelerometer")
}
"""Streams that are measured at rest; a table with others is none of static poses."""

FEWEST_SMOOTH, LARGEST_STEP = 50, 0.1
"""Smallest number of poses of a smooth motion, and its largest step as a share of the
poses' extent: an arm at 3 rad/s, logged at 20 Hz, turns by 0.15 rad from row to row."""

PAUSE, TURN = 0.9, 0.35
"""Time [s] and change of the pose from row to row above which rows are static poses, as
the motion between them cannot be found."""

FEWEST_IN_MILLISECONDS = 500
"""Smallest number of rows whose time may be found to be in milliseconds."""
SECONDS_APART = 2.0
"""[s] Least time between them."""
SLOWEST = 0.01
"""[rad/s] Largest speed of a motion that must be in milliseconds: up to 10 rad/s then."""


def without_times(recording: Recording) -> Recording:
    """The recording; where its rows are seconds apart and turned against each other as
    static poses, without times."""
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
    warnings = (*left, warning("poses-static", what))
    return replace(recording, streams=kept, static=True, warnings=warnings, angles=None)


def without_unit(recording: Recording) -> Recording:
    """`without_times` of a recording whose time has no stated unit; with an error where
    it must be in milliseconds, as rows are evenly seconds apart and poses nevertheless
    move smoothly, more slowly than an arm is moved."""
    stream = _pose_stream(recording)
    if recording.static or len(stream) < FEWEST_IN_MILLISECONDS:
        return without_times(recording)
    steps = np.diff(stream.time)
    step = median(steps)
    uneven = quantile(np.abs(steps - step), 0.99)
    if step < SECONDS_APART or uneven > step / 4 or not _moves_smoothly(recording):
        return without_times(recording)
    poses = _poses_of(recording)
    turns = np.abs(np.diff(poses, axis=0)).reshape(len(steps), -1).max(axis=1)
    speed = float(turns.max() / step)
    if speed > SLOWEST or np.ptp(poses, axis=0).max() < TURN:
        return without_times(recording)
    what = (
        f"time seems to be in milliseconds: rows are {step:.3g} s apart, and the arm turns "
        f'by {speed:.2g} rad/s at most; give time in seconds, or its unit, "ms" or "s", '
        "in a column map"
    )
    left = (m for m in recording.warnings if getattr(m, "code", "") != "time-step-long")
    warnings = (*left, error("time-unit", what, "column_map"))
    return replace(recording, warnings=warnings)


def warn_about_static(recording: Recording) -> Recording:
    """The recording, with a note that its rows are taken as static poses, or a warning
    where they are unlikely to be."""
    signs = [f"there is {n}" for n in recording.streams if n not in STATIC_STREAMS]
    count = max(len(stream) for stream in recording.streams.values())
    signs += ["they move smoothly"] if _moves_smoothly(recording) else []
    also = f", although {' and '.join(signs)}" if signs else ""
    what = (
        f"there is no column time: each of {count} rows is taken as a static pose{also}; of rows in "
        "motion give the rate in the column map that hefting map LOG writes, time = { rate = 250 } [Hz]"
    )
    if not signs and count <= 1000:
        said = note("no-time-column", what)
        return replace(recording, notes=(*recording.notes, said))
    said = warning("no-time-column", what)
    if signs:
        said = warning("time-missing", what, "column_map")
    return replace(recording, warnings=(*recording.warnings, said))


def _moves_smoothly(recording: Recording) -> bool:
    """Whether all steps between successive poses are small against the poses' extent,
    as between static poses they are not."""
    poses = _poses_of(recording)
    if len(poses) < FEWEST_SMOOTH:
        return False
    steps = np.abs(np.diff(poses, axis=0)).max()
    return bool(steps < LARGEST_STEP * np.ptp(poses, axis=0).max())


def _pose_stream(recording: Recording) -> Stream:
    """Orientations, or joint angles without these."""
    turned = "orientation" in recording.streams
    return recording["orientation" if turned else "joint_positions"]


def _poses_of(recording: Recording) -> Array:
    """(K, 3, 3) orientations, or (K, n) joint angles without these."""
    values = _pose_stream(recording).values
    return rotation_matrices(values) if "orientation" in recording.streams else values
