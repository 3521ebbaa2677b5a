"""From a recording to measurements: motion and wrench at common instants, in sensor
axes."""

from __future__ import annotations

from dataclasses import replace
from typing import Literal, get_args

import numpy as np
from numpy.typing import ArrayLike, NDArray

from hefting.core.errors import InputError
from hefting.core.measurements import Measurements, MotionNoise
from hefting.core.messages import Message, note, warning
from hefting.core.recording import Recording, Stream
from hefting.core.spatial import (
    STANDARD_GRAVITY,
    Array,
    Mask,
    check_gravity,
    immutable,
    in_sensor_axes,
    interpolated,
    median,
    rotation_matrices,
)
from hefting.motion.bspline import FEWEST_SEGMENT_SAMPLES
from hefting.motion.inertial import Curves, smooth_poses
from hefting.motion.state import Motion

Source = Literal["auto", "columns", "smooth", "filter"]
SOURCES = get_args(Source)
MANY_OUTSIDE = 0.1
"""Share of wrench samples outside the time of the poses from which on there is a warning,
as their clocks may differ: an offset of 0.3 s leaves 6 % of 5 s."""
IMPLAUSIBLE_VALUE = 1e9
"""[N, N m, m/s²] Bound on wrench and gravity; larger numbers are errors of the log."""

DESCRIPTIONS = {
    "static": "static poses: gravity only",
    "columns": "twist and acceleration columns of the log",
    "smooth": "poses, smoothed",
    "inertial": "poses and inertial sensors, smoothed",
    "filter": "poses, filtered live with a lag of 0.1 s",
    "accelerometer": "orientation, smoothed, and the accelerometer",
    "orientation": "orientation alone: gravity only",
}
"""Sources of the motion, in words."""

REST_GAP = 0.1
"""[s] Gap between stretches at rest, and least median length of those."""
LARGEST_AT_REST = 2e-3
"""[m, rad] Change of a pose at rest, root mean square."""
POSE_STREAMS = ("position", "orientation")
TWIST = ("linear_acceleration", "angular_velocity", "angular_acceleration")


@immutable
class Measured:
    """Measurements, and how their motion was found."""

    measurements: Measurements
    """At the wrench's own instants, wrench as recorded."""
    source: str
    """A key of `DESCRIPTIONS`."""
    motion: Motion | None
    """Smoothed motion at the same instants, with standard deviations; None if the log
    has the motion."""
    warnings: tuple[Message, ...] = ()
    """Warnings of what is not modelled, of gaps, and of many samples left out."""
    notes: tuple[Message, ...] = ()
    """Notes on what was found, and on a few samples left out."""
    rows: NDArray[np.integer] | None = None
    """(K,) rows of the wrench's stream at the measurements; None for other instants."""


def measure(
    recording: Recording,
    gravity: ArrayLike = STANDARD_GRAVITY,
    source: Source = "auto",
    curves: Curves | None = None,
    of: str = "wrench sample",
    counts: Array | None = None,
) -> Measured:
    """Motion and wrench of a recording at the instants of its wrench; nothing is
    extrapolated.

    Parameters
    ----------
    gravity : (3,) in world axes [m/s²].
    source : ``"auto"`` takes twist and acceleration columns where the log has them,
        else smooths the poses; ``"columns"``, ``"smooth"`` and ``"filter"`` (a
        fixed-lag Kalman filter, as live) ask for one of them.
    curves : the poses' smooth curves (`smooth_poses`), where they are known already.
    of : what messages call a row of the wrench.
    counts : (N,) number of those that each row of the wrench represents; by default one.

    A recording of static poses, of one held pose, or of orientation alone, gives zero
    motion: the reduced model. With orientation and an accelerometer (specific force a -
    g), the latter gives the acceleration. Raises `InputError` if the wrench, the
    orientation, or streams that `source` needs are missing.

    Examples
    --------
    >>> measured = hefting.measure(hefting.read_log("demo/log.csv"))
    >>> measured.measurements.angular_acceleration.shape, measured.source
    ((1000, 3), 'smooth')
    """
    g_world = check_gravity(gravity)
    check_source(source)
    wrench, orientation = recording["wrench"], recording["orientation"]
    if (
        not (np.abs(wrench.values) < IMPLAUSIBLE_VALUE).all()
        or not (np.abs(g_world) < IMPLAUSIBLE_VALUE).all()
    ):
        raise InputError(
            f"wrench or gravity is above {IMPLAUSIBLE_VALUE:g}",
            recording.source,
            "give newtons and m/s²",
        )
    if recording.static:
        if not np.array_equal(wrench.rows, orientation.rows):
            raise InputError(
                "some static poses lack a wrench or an orientation",
                where=recording.source,
            )
        z = _static_measurements(wrench, orientation.values, g_world)
        return Measured(z, "static", None, rows=wrench.rows)

    counts = np.ones(len(wrench)) if counts is None else counts
    kept = _samples_within_poses(recording, wrench)
    warnings, notes = (), ()
    if not kept.all():
        what = f"{_counted(counts[~kept], of)} before the first or after the last pose left out"
        if counts[~kept].sum() > MANY_OUTSIDE * counts.sum():
            warnings = (warning("outside-poses", what),)
        else:
            notes = (note("outside-poses", what),)
        wrench, counts = wrench[kept], counts[kept]
    if reads_columns(recording, source):
        z = _from_columns(recording, wrench, g_world)
        return Measured(z, "columns", None, warnings, notes, wrench.rows)
    if curves is None and not may_move(recording):
        held = orientation.values[nearest_rows(orientation.time, wrench.time)]
        z = _static_measurements(wrench, held, g_world)
        z = replace(z, motion_noise=MotionNoise(0.0, 0.0))
        return Measured(z, "static", None, warnings, notes, wrench.rows)
    if source == "filter":
        motion, wrench = _filtered(recording, wrench)
        kind, counts = "filter", np.ones(len(wrench))
    else:
        curves = curves or smooth_poses(recording, g_world)
        motion = curves.poses.at(wrench.time)
        kind = curves.source
        warnings, notes = warnings + curves.warnings, notes + curves.notes
    known = motion.known
    if not known.all():
        what = f"{_counted(counts[~known], of)} in gaps of the poses left out"
        warnings += (warning("gaps-in-poses", what),)
        wrench, motion = wrench[known], motion[known]
    z, motion, rows, reduced = _from_motion(recording, wrench, motion, g_world)
    kind = reduced or kind
    if kind == "orientation":
        what = "no position and no accelerometer: only gravity is modelled, so mass and COM at most"
        warnings += (warning("gravity-only", what),)
    rows = None if kind == "filter" else rows
    return Measured(z, kind, motion, warnings, notes, rows)


def reads_columns(recording: Recording, source: Source) -> bool:
    """Whether the motion is that of the log's twist and acceleration columns."""
    return source == "columns" or (source == "auto" and recording.has(*TWIST))


def may_move(recording: Recording) -> bool:
    """Whether the poses change while the wrench is measured, or an accelerometer
    without position may have measured motion."""
    may_move_unseen = recording.has("accelerometer") and not recording.has("position")
    poses_change = any(
        (recording[name].values != recording[name].values[0]).any()
        for name in POSE_STREAMS
        if recording.has(name)
    )
    return may_move_unseen or (poses_change and not _is_of_rests(recording))


def _is_of_rests(recording: Recording) -> bool:
    """Whether the wrench was measured only in stretches in which the pose rests."""
    time = recording["wrench"].time
    cuts = np.flatnonzero(np.diff(time) > REST_GAP) + 1
    few = 0 < len(cuts) < len(time) / FEWEST_SEGMENT_SAMPLES
    if (
        not few
        or median(np.array([np.ptp(t) for t in np.split(time, cuts)])) < REST_GAP
    ):
        return False
    for stream in (recording[n] for n in POSE_STREAMS if recording.has(n)):
        values = stream.values[nearest_rows(stream.time, time)]
        if values.shape[1] == 4:
            values = rotation_matrices(values).reshape(-1, 9)
        spreads = [part.var(axis=0).sum() for part in np.split(values, cuts)]
        if max(spreads) > LARGEST_AT_REST**2:
            return False
    return True


def nearest_rows(time: Array, at: Array) -> NDArray[np.intp]:
    """(L,) rows of samples at increasing times (K,) that are nearest to times (L,)."""
    return np.searchsorted(0.5 * (time[1:] + time[:-1]), at)


def _from_motion(
    recording: Recording, wrench: Stream, motion: Motion, g_world: Array
) -> tuple[Measurements, Motion, NDArray[np.integer], str | None]:
    """Measurements of a smoothed or filtered motion at the wrench samples, their motion
    and their rows.

    Without a position the acceleration is that of the accelerometer or, without that,
    zero; the last value is then the source of the motion, a key of `DESCRIPTIONS`, else
    None.
    """
    g, source = in_sensor_axes(motion.orientation, g_world), None
    a = motion.linear_acceleration
    if a is None and recording.has("accelerometer"):
        source = "accelerometer"
        wrench, g, motion, a = _accelerometer(recording[source], wrench, g, motion)
    if a is None:
        source = "orientation"
        a = w = alpha = np.zeros_like(g)
    else:
        w, alpha = motion.angular_velocity, motion.angular_acceleration
    z = Measurements(
        wrench.time, g, a, w, alpha, wrench.values[:, :3], wrench.values[:, 3:]
    )
    return z, motion, wrench.rows, source


def _static_measurements(
    wrench: Stream, orientation: Array, g_world: Array
) -> Measurements:
    """Static poses: gravity turned into sensor axes, no motion."""
    g = in_sensor_axes(orientation, g_world)
    zero = np.zeros_like(g)
    return Measurements(
        wrench.time, g, zero, zero, zero, wrench.values[:, :3], wrench.values[:, 3:]
    )


def check_source(source: str) -> None:
    """`InputError` for a word that names no source of motion."""
    if source not in SOURCES:
        raise InputError(
            f"unknown source of motion '{source}'", fix=f"use {', '.join(SOURCES)}"
        )


def _samples_within_poses(recording: Recording, wrench: Stream) -> Mask:
    """(N,) the wrench samples between the first and the last pose; `InputError` where
    there is none."""
    poses = [recording[name].time for name in POSE_STREAMS if recording.has(name)]
    first, last = max(time[0] for time in poses), min(time[-1] for time in poses)
    kept = (wrench.time >= first) & (wrench.time <= last)
    if not kept.any():
        begin, end = wrench.time[[0, -1]]
        raise InputError(
            f"no wrench was measured while the pose was: it from {begin:.12g} to "
            f"{end:.12g} s, the pose from {first:.12g} to {last:.12g} s",
            recording.source,
            "give both the times of one clock",
        )
    return kept


def _counted(counts: Array, of: str) -> str:
    """The sum of the counts (K,) with its noun, as in "3 wrench samples"."""
    n = round(float(counts.sum()))
    return f"{n} {of}{'' if n == 1 else 's'}"


def _read_at(at: Array, stream: Stream) -> Array:
    """A stream's values (K, d) at times inside it, linearly interpolated."""
    if np.array_equal(stream.time, at):
        return stream.values
    return interpolated(at, stream.time, stream.values)


def _from_columns(recording: Recording, wrench: Stream, g_world: Array) -> Measurements:
    """Motion from the log's own twist and acceleration columns, given in world axes."""
    for name in TWIST:  # `recording[name]` raises if it is missing
        stream = recording[name]
        if stream.time[0] > wrench.time[0] or stream.time[-1] < wrench.time[-1]:
            raise InputError(
                f"the {name} does not cover all wrench samples",
                where=recording.source,
                fix="use `start`, `duration`",
            )
    quaternions = recording["orientation"]
    if np.array_equal(quaternions.time, wrench.time):
        turns = quaternions.values
    else:
        from scipy.spatial.transform import Rotation, Slerp

        turns = Slerp(quaternions.time, Rotation.from_quat(quaternions.values))(
            wrench.time
        ).as_quat()
    a, w, alpha = (
        in_sensor_axes(turns, _read_at(wrench.time, recording[name])) for name in TWIST
    )
    g = in_sensor_axes(turns, g_world)
    return Measurements(
        wrench.time, g, a, w, alpha, wrench.values[:, :3], wrench.values[:, 3:]
    )


def _filtered(recording: Recording, wrench: Stream) -> tuple[Motion, Stream]:
    """Motion by a live filter that is tuned on the same recording, and the wrench at
    its instants."""
    from hefting.motion.kalman import PoseFilter

    orientation = recording["orientation"]
    time, values, position = orientation.time, orientation.values, None
    if recording.has("position"):
        position = recording["position"].values
        if not np.array_equal(recording["position"].time, time):
            raise InputError(
                "the live filter takes position and orientation together, but they come at different times",
                where=recording.source,
                fix="use `motion`='smooth'",
            )
    live = PoseFilter.tuned(time, position, values)
    _, motion = live.update(live.start(), time, position, values)
    kept = (motion.time >= wrench.time[0]) & (motion.time <= wrench.time[-1])
    if not kept.any():
        raise InputError(
            "the recording ends before the filter has settled", where=recording.source
        )
    motion = motion[kept]
    return motion, Stream(motion.time, _read_at(motion.time, wrench))


def _accelerometer(
    accelerometer: Stream, wrench: Stream, g: Array, motion: Motion
) -> tuple[Stream, Array, Motion, Array]:
    """Linear acceleration (K, 3) from the specific force a - g, at the wrench samples
    the accelerometer covers."""
    kept = (wrench.time >= accelerometer.time[0]) & (
        wrench.time <= accelerometer.time[-1]
    )
    if not kept.any():
        raise InputError(
            "accelerometer and wrench were never measured at the same time"
        )
    wrench, g, motion = wrench[kept], g[kept], motion[kept]
    a = _read_at(wrench.time, accelerometer) + g
    steps = np.diff(accelerometer.values, axis=0)
    spread = np.full(
        len(g), float(np.std(steps) / np.sqrt(2.0)) if len(steps) else np.inf
    )
    return (
        wrench,
        g,
        replace(motion, linear_acceleration=a, linear_acceleration_std=spread),
        a,
    )
