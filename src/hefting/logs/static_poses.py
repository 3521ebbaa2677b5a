"""Rows of a table that are static poses: where they have no times, or times of which each
is another pose."""

from dataclasses import replace

import numpy as np

from hefting.core.messages import warning
from hefting.core.recording import Recording
from hefting.core.spatial import median, own, rotation_matrices

FEWEST_SMOOTH, LARGEST_STEP = 50, 0.1
"""Poses, and the largest step among them over their extent, from which on they are
those of a motion: an arm that turns by 3 rad/s, logged at 20 Hz, goes 0.15 rad a row."""

PAUSE, TURN = 0.9, 0.35
"""Time [s] and turn [rad] from one row to the next, as a rule, from which on rows are
static poses: nothing tells the motion between them."""

STATIC_STREAMS = (
    "position",
    "orientation",
    "joint_positions",
    "wrench",
    "accelerometer",
)
"""Streams that can be measured at rest, so that a table of them without times may be
static poses."""


def without_times(recording: Recording) -> Recording:
    """The recording of static poses that have times without these; others as they are."""
    streams = recording.streams
    turned = "orientation" if "orientation" in streams else "joint_positions"
    if recording.static or not {turned, "wrench"} <= {*streams}:
        return recording
    poses, rows = streams[turned], streams["wrench"].rows
    if len(poses) < 2 or not np.array_equal(poses.rows, rows):
        return recording
    pause = median(np.diff(poses.time))
    if turned == "orientation":
        cosines = np.einsum("ki,ki->k", poses.values[1:], poses.values[:-1])
        turn = median(2.0 * np.arccos(np.minimum(np.abs(cosines), 1.0)))
    else:
        turn = median(np.abs(np.diff(poses.values, axis=0)).max(axis=1))
    if pause < PAUSE or turn < TURN:
        return recording
    count = own(np.arange(float(len(rows))))
    kept = {
        name: replace(stream, time=count)
        for name, stream in streams.items()
        if name in STATIC_STREAMS and np.array_equal(stream.rows, rows)
    }
    what = (
        f"each of {len(rows)} rows is taken as a static pose: they are {pause:.3g} s and "
        f"{np.degrees(turn):.0f}° apart, as a rule"
    )
    left = (m for m in recording.warnings if getattr(m, "code", "") != "time-step-long")
    warnings = (*left, warning("poses-static", what))
    return replace(recording, streams=kept, static=True, warnings=warnings, angles=None)


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
    turned = "orientation" in recording.streams
    stream = recording["orientation" if turned else "joint_positions"]
    poses = rotation_matrices(stream.values) if turned else stream.values
    if len(poses) < FEWEST_SMOOTH:
        return False
    steps = np.abs(np.diff(poses, axis=0)).max()
    return bool(steps < LARGEST_STEP * np.ptp(poses, axis=0).max())
