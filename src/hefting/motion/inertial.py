"""Smoothing: curves through the poses of a recording, to which a gyroscope and an
accelerometer are fused as measured derivatives.

With q the orientation and R its matrix, a gyroscope measures dq/dt = q w / 2
(quaternion product) and an accelerometer d²p/dt² = R f + g. Each sensor has a constant
bias and a constant clock offset; the accelerometer also has a lever arm, its position
in the sensor frame. These are estimated relative to the curves through the poses. The
curves are then fitted again with the corrected readings as additional observations.
This is done `CALIBRATION_ROUNDS` times.
"""

from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import ArrayLike

from hefting.core.errors import InputError
from hefting.core.messages import Message, note, warning
from hefting.core.quantity import significant
from hefting.core.recording import Recording, Stream, block_starts
from hefting.core.spatial import (
    STANDARD_GRAVITY,
    Array,
    frozen,
    immutable,
    in_sensor_axes,
    rotation_matrices,
    skew,
)
from hefting.motion.bspline import FEWEST_SEGMENT_SAMPLES, Observation
from hefting.motion.curve import Curve, fresh_rows
from hefting.motion.spline import SmoothedPoses, fit_poses
from hefting.motion.state import Motion

CALIBRATION_ROUNDS = 3
"""Number of alternations between calibrating sensors against the curves and fitting the
curves to them."""
CLOCK_STD = 0.02
"""[s] Prior standard deviation of a sensor's clock offset."""
LEVER_STD = 0.05
"""[m] Prior standard deviation of an accelerometer's distance from the sensor origin,
along each axis."""
GYROSCOPE_BIAS_STD = 0.05
"""[rad/s] Prior standard deviation of a gyroscope's bias about each axis."""
ACCELEROMETER_BIAS_STD = 0.5
"""[m/s²] Prior standard deviation of an accelerometer's bias along each axis."""
SPECIFIC_FORCE_STEP = 0.005
"""[s] Step of the numerical derivative of the specific force."""
LARGEST_ACCELEROMETER_BIAS = 1.5
"""[m/s²] Largest bias of an accelerometer that is used: beyond, it measures another
quantity, or gravity is wrong."""
FEWEST_READINGS = 50
"""Least number of readings of an inertial sensor that is used."""
CONTRADICTING_DEVIATION = 0.2
"""Ratio of a sensor's deviation from the poses to the variation of the motion, above
which it may contradict them."""
CONTRADICTING_MAP_RATIO = 0.7
"""Ratio of the residual after a linear map of the motion to the deviation without it,
below which such a sensor has other axes or units."""


@immutable
class Curves:
    """Smooth curves through the poses of a recording."""

    poses: SmoothedPoses
    alone: SmoothedPoses
    """Curves from the poses without inertial sensors, whose clocks and axes may differ"""
    source: str
    """``"smooth"``, or ``"inertial"`` if a gyroscope or an accelerometer was used"""
    notes: tuple[Message, ...]
    """Notes on those sensors."""
    warnings: tuple[Message, ...]


def smooth_poses(
    recording: Recording,
    gravity: ArrayLike = STANDARD_GRAVITY,
    alone: SmoothedPoses | None = None,
) -> Curves:
    """Fit smooth curves to the poses of a recording, and to its gyroscope and
    accelerometer if it has them.

    `gravity` (3,) is in world axes [m/s²]; `alone` are the curves without those sensors,
    if already fitted. Raises `InputError` for fewer than `FEWEST_SEGMENT_SAMPLES` poses.
    """
    poses = _fit_recorded_poses(recording) if alone is None else alone
    streams = recording.streams
    accelerometer = streams.get("accelerometer") or streams.get("linear_accelerometer")
    if accelerometer is None and "gyroscope" not in streams:
        return Curves(poses, poses, "smooth", (), ())
    gravity_removed = not recording.has("accelerometer")
    fused, notes, warnings = fuse(
        poses, frozen(gravity), streams.get("gyroscope"), accelerometer, gravity_removed
    )
    return Curves(fused, poses, "inertial" if notes else "smooth", notes, warnings)


def _fit_recorded_poses(recording: Recording) -> SmoothedPoses:
    """Smooth curves through the orientation and the position, if there is one;
    `InputError` for too few poses to differentiate."""
    orientation, position = recording["orientation"], None
    poses = len(orientation)
    if recording.has("position"):
        position = recording["position"]
        # an empty position stream is left to the fit
        poses = min(poses, len(position) or poses)
    if poses < FEWEST_SEGMENT_SAMPLES:
        raise InputError(
            f"{poses} poses are too few to find velocities from",
            where=recording.source,
            fix="give a longer recording, or static poses without the time column",
        )
    if position is None:
        return fit_poses(orientation.time, None, orientation.values)
    return fit_poses(
        orientation.time, position.values, orientation.values, position.time
    )


def fuse(
    poses: SmoothedPoses,
    gravity: Array,
    gyroscope: Stream | None = None,
    accelerometer: Stream | None = None,
    gravity_removed: bool = False,
) -> tuple[SmoothedPoses, tuple[Message, ...], tuple[Message, ...]]:
    """Fit curves through the poses alone to inertial sensors as well: the fitted
    curves, notes on the sensors that were used, and warnings.

    The gyroscope is in sensor axes [rad/s], the accelerometer's specific force a - g
    too [m/s²], or, where `gravity_removed`, the acceleration a; it is not used if the
    position was not measured. `gravity` (3,) is in world axes [m/s²]. A sensor that
    contradicts the poses (other axes, other units, another gravity) is not used, and a
    warning says so.
    """
    messages: list[Message] = []
    if gyroscope is not None and len(gyroscope) >= FEWEST_READINGS:
        poses, new = _fuse_gyroscope(poses, gyroscope)
        messages += new
    if (
        accelerometer is not None
        and len(accelerometer) >= FEWEST_READINGS
        and poses.position is not None
    ):
        removed = np.zeros(3) if gravity_removed else gravity
        poses, new = _fuse_accelerometer(poses, accelerometer, removed)
        messages += new
    notes, warnings = (
        tuple(message for message in messages if message.severity == severity)
        for severity in ("note", "warning")
    )
    return poses, notes, warnings


def _fuse_gyroscope(
    poses: SmoothedPoses, gyroscope: Stream
) -> tuple[SmoothedPoses, list[Message]]:
    raw, gyroscope = len(gyroscope), _average_fast_readings(gyroscope)
    fitted, found = poses, _Calibration()
    for round_ in range(CALIBRATION_ROUNDS):
        turning = replace(fitted, position=None)
        readings, motion = _synchronise(turning, gyroscope, found.clock)
        if len(readings) < FEWEST_READINGS:
            return poses, []
        w = motion.angular_velocity
        columns = np.concatenate(
            (_identities(len(w)), -motion.angular_acceleration[:, :, None]), axis=2
        )
        step = _ridge(
            columns,
            readings.values - w - found.bias,
            (GYROSCOPE_BIAS_STD,) * 3 + (CLOCK_STD,),
        )
        found = _Calibration(found.bias + step[:3], found.clock + step[3])
        readings, motion = _synchronise(turning, gyroscope, found.clock)
        if round_ == 0 and _contradicts(
            readings.values - found.bias, motion.angular_velocity
        ):
            what = "the gyroscope contradicts the poses: not used; is it in sensor axes and rad/s?"
            return poses, [warning("gyroscope-contradicts-poses", what)]
        q, rate = fitted.orientation.derivatives(readings.time, (0, 1))
        z = 0.5 * _quaternion_product(q.T, readings.values - found.bias)
        curve, variance = _refit(
            fitted.orientation, readings.time, z, rate.T, 1, "orientation", round_
        )
        fitted = replace(fitted, orientation=curve)
    spread = 2.0 * np.sqrt(variance * raw / len(gyroscope))
    what = (
        f"gyroscope used: noise {spread:.2g} rad/s, bias {_format_vector(found.bias)} rad/s, "
        f"{_format_delay(found.clock)}"
    )
    return fitted, [note("gyroscope-used", what)]


def _fuse_accelerometer(
    poses: SmoothedPoses, accelerometer: Stream, gravity: Array
) -> tuple[SmoothedPoses, list[Message]]:
    assert poses.position is not None
    raw, accelerometer = len(accelerometer), _average_fast_readings(accelerometer)
    fitted, found = poses, _Calibration()
    for round_ in range(CALIBRATION_ROUNDS):
        readings, motion = _synchronise(fitted, accelerometer, found.clock)
        if len(readings) < FEWEST_READINGS:
            return poses, []
        force = _specific_force(motion, gravity)
        later = fitted.at(
            np.minimum(readings.time + SPECIFIC_FORCE_STEP, fitted.last), spread=False
        )
        slope = (_specific_force(later, gravity) - force) / SPECIFIC_FORCE_STEP
        columns = np.concatenate(
            (_identities(len(force)), _lever_columns(motion), -slope[:, :, None]),
            axis=2,
        )
        misfit = (
            readings.values - force - found.bias - _lever_columns(motion) @ found.lever
        )
        known = later.known  # the last readings before a gap have no derivative
        step = _ridge(
            columns[known],
            misfit[known],
            (ACCELEROMETER_BIAS_STD,) * 3 + (LEVER_STD,) * 3 + (CLOCK_STD,),
        )
        found = _Calibration(
            found.bias + step[:3], found.clock + step[6], found.lever + step[3:6]
        )
        readings, motion = _synchronise(fitted, accelerometer, found.clock)
        own = readings.values - found.bias - _lever_columns(motion) @ found.lever
        foreign = round_ == 0 and _contradicts(own, _specific_force(motion, gravity))
        if foreign or np.linalg.norm(found.bias) > LARGEST_ACCELEROMETER_BIAS:
            contradicts = "the accelerometer contradicts the poses: not used; is it in sensor axes and m/s²"
            what = f"{contradicts}, and gravity as given?"
            return poses, [warning("accelerometer-contradicts-poses", what, "gravity")]
        R = rotation_matrices(motion.orientation)
        z = np.einsum("kij,kj->ki", R, own) + gravity
        assert fitted.position is not None
        (acceleration,) = fitted.position.derivatives(readings.time, (2,))
        curve, variance = _refit(
            fitted.position, readings.time, z, acceleration.T, 2, "position", round_
        )
        fitted = replace(fitted, position=curve)
    spread = np.sqrt(variance * raw / len(accelerometer))
    what = (
        f"accelerometer used: noise {spread:.2g} m/s², bias {_format_vector(found.bias)} m/s², "
        f"at {_format_vector(1e3 * found.lever)} mm, {_format_delay(found.clock)}"
    )
    return fitted, [note("accelerometer-used", what)]


@dataclass(frozen=True)
class _Calibration:
    """Constant errors of an inertial sensor."""

    bias: Array = field(default_factory=lambda: np.zeros(3))
    """(3,) Bias in the sensor's unit."""
    clock: float = 0.0
    """[s] Delay of its time stamps."""
    lever: Array = field(default_factory=lambda: np.zeros(3))
    """(3,) [m] Its position in the sensor frame."""


def _average_fast_readings(stream: Stream) -> Stream:
    """The stream without repeated values, averaged over short blocks if it is fast."""
    kept = fresh_rows(stream.time, stream.values)
    stream = stream if kept.all() else stream[kept]
    starts = block_starts(stream.time)
    if starts is None:
        return stream
    count = np.diff(np.append(starts, len(stream)))
    time = (
        np.add.reduceat(stream.time - stream.time[0], starts) / count + stream.time[0]
    )
    return Stream(
        time,
        np.add.reduceat(stream.values, starts, axis=0) / count[:, None],
        stream.rows[starts],
    )


def _synchronise(
    poses: SmoothedPoses, stream: Stream, delay: float
) -> tuple[Stream, Motion]:
    """The readings at the times of measurement, corrected for `delay` [s], and the
    motion then; without readings where the motion is unknown."""
    time = stream.time - delay
    stream = replace(stream, time=time)[(time >= poses.first) & (time <= poses.last)]
    motion = poses.at(stream.time, spread=False)
    known = motion.known
    return (stream, motion) if known.all() else (stream[known], motion[known])


def _refit(
    curve: Curve,
    time: Array,
    z: Array,
    now: Array,
    derivative: int,
    name: str,
    round_: int,
) -> tuple[Curve, float]:
    """A curve fitted again to its samples, and to derivatives z (L, d) at times (L,)
    [s], which are `now` (L, d); and the variance of these. Its smoothness is searched
    everywhere in round 0, later near that of `curve`."""
    variance = _variance(time, z - now, curve.smoothness.bandwidth)
    rates = Observation(time, z, derivative, curve.smoothness.variance / variance)
    samples, near = curve.observations[0], curve.smoothness if round_ else None
    return Curve.through((samples, rates), name, samples.time[-1], near), variance


def _variance(time: Array, residual: Array, bandwidth: float) -> float:
    """Variance of a reading for white noise of the same power below the bandwidth
    [rad/s]: that of averages over cells of 1/bandwidth, times the number of readings in
    a cell."""
    cell = np.floor((time - time[0]) * bandwidth).astype(int)
    starts = np.flatnonzero(np.diff(cell, prepend=-1))
    sums = np.add.reduceat(residual - residual.mean(axis=0), starts, axis=0)
    counts = np.diff(np.append(starts, len(cell)))
    return max(float(np.sum(sums**2 / counts[:, None])) / (3 * len(starts)), 1e-20)


def _ridge(columns: Array, values: Array, spreads: tuple[float, ...]) -> Array:
    """Ridge regression (n,) of values (K, 3) on columns (K, 3, n).

    `spreads` are the prior standard deviations of the n unknowns; the noise is the
    residual of plain least squares.
    """
    A, b, scale = columns.reshape(-1, len(spreads)), values.ravel(), np.array(spreads)
    A = A * scale
    normal, right = A.T @ A, A.T @ b
    residual = b - A @ np.linalg.lstsq(normal, right, rcond=None)[0]
    noise = max(float(np.mean(residual**2)), 1e-20)
    return np.asarray(
        scale * np.linalg.solve(normal + noise * np.eye(len(scale)), right), dtype=float
    )


def _contradicts(readings: Array, expected: Array) -> bool:
    """Whether readings (K, 3) deviate much from the expected ones, and much less from a
    linear map of these, as with other axes or units."""
    deviation = np.sum((readings - expected) ** 2)
    A = np.column_stack((expected, np.ones(len(expected))))
    best = np.sum((readings - A @ np.linalg.lstsq(A, readings, rcond=None)[0]) ** 2)
    far = deviation > CONTRADICTING_DEVIATION**2 * np.sum(
        (expected - expected.mean(axis=0)) ** 2
    )
    return bool(far and best < CONTRADICTING_MAP_RATIO**2 * deviation)


def _specific_force(motion: Motion, gravity: Array) -> Array:
    """Specific force a - g (K, 3) [m/s²] in sensor axes."""
    assert motion.linear_acceleration is not None
    return motion.linear_acceleration - in_sensor_axes(motion.orientation, gravity)


def _lever_columns(motion: Motion) -> Array:
    """(K, 3, 3) [1/s²] acceleration at a point of the sensor frame less that at its
    origin, by the point's place (3,)."""
    w = skew(motion.angular_velocity)
    return skew(motion.angular_acceleration) + w @ w


def _identities(n: int) -> Array:
    return np.broadcast_to(np.eye(3), (n, 3, 3))


def _quaternion_product(q: Array, v: Array) -> Array:
    """(K, 4) Product of quaternions q (K, 4) xyzw and pure quaternions v (K, 3)."""
    axis, scalar = q[:, :3], q[:, 3:]
    return np.column_stack((scalar * v + np.cross(axis, v), -np.sum(axis * v, axis=1)))


def _format_vector(values: Array) -> str:
    return f"({', '.join(map(significant, values))})"


def _format_delay(seconds: float) -> str:
    return f"{1e3 * abs(seconds):.1f} ms {'late' if seconds > 0 else 'early'}"
