"""Path: the motion of a recording as a function of time. It can be evaluated at the
times of the wrench, shifted by a clock offset."""

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial

import numpy as np
from numpy.typing import ArrayLike

from hefting.core.recording import Recording, Stream
from hefting.core.spatial import (
    STANDARD_GRAVITY,
    TENSOR_COLUMNS,
    TENSOR_ROWS,
    Array,
    Mask,
    immutable,
    interpolated,
    rotation_matrices,
)
from hefting.motion import Curves, SmoothedPoses, smooth_poses
from hefting.motion.bspline import TIMES_EVALUATED_TOGETHER
from hefting.motion.measure import TWIST, Source, may_move, nearest_rows, reads_columns
from hefting.motion.state import angular_motion

FEWEST_POSES_OF_PATH = 8
"""Least number of orientations for a motion to be smoothed."""
DIFFERENTIATION_STEP = 2e-3
"""[s] Step of the numerical derivatives by time. A motion of 15 Hz advances by 0.19 rad
of its phase in it."""
MOTION_COLUMNS = slice(0, 12)
"""Columns of a reading that hold a, alpha and vech(w w'), as in
`hefting.core.regressor` but with a instead of a - g."""
WORLD_AXES_COLUMNS = slice(12, 21)
"""Columns of a reading that hold the rotation matrix (3, 3) from world to sensor axes,
by rows."""


Read = Callable[[Array, bool], tuple[Array, Array, Mask]]
"""Function of times (K,) and of whether variances are needed: rows (K, 21) as in
`Reading.value`, variances (2, K) or zeros, and a mask (K,) of known rows."""


@immutable
class Reading:
    """Motion at K times in sensor axes, with its derivatives by time."""

    time: Array
    """(K,) [s] Times of the values: those asked for, limited to the motion's span."""
    value: Array
    """(K, 21): see `MOTION_COLUMNS` and `WORLD_AXES_COLUMNS`"""
    rate: Array
    """(K, 21) First derivative by time; zero if it was not asked for."""
    curvature: Array
    """(K, 21) Second derivative by time; zero if it was not asked for."""
    variances: Array
    """(2, K) Error variance of the linear [m²/s⁴] and the angular [rad²/s⁴]
    acceleration along one axis."""
    in_gap: Mask
    """(K,) True in gaps of the motion, where the values are not valid."""
    known: Mask
    """(K,) False in gaps, and outside the time span of the motion, where the values are
    those at its ends."""


@immutable
class Path:
    """Motion as a function of time."""

    kind: str
    """A key of `hefting.motion.measure.DESCRIPTIONS`."""
    first: float
    """[s] Start of the motion."""
    last: float
    """[s] End of the motion."""
    read: Read
    """Of times from `first` to `last`. It can be pickled."""
    bandwidth: float
    """[rad/s] Bandwidth of the motion's errors; infinite if it is exact."""
    gravity_measured: bool = False
    """Whether gravity is contained in a measured specific force instead of modelled."""
    curves: Curves | None = None
    """The smooth curves that it is evaluated from, if any."""
    plain: "Path | None" = None
    """The motion as logged, if this one is filtered as a wrench is."""

    @property
    def smooth(self) -> bool:
        """Whether averages by `hefting.ingest.blocks` keep all its frequencies;
        measured accelerations contain vibrations."""
        return self.kind in ("smooth", "orientation")

    @property
    def moves(self) -> bool:
        """Whether it moves, so that the wrench may be delayed relative to it."""
        return self.kind != "static"

    def scaled(self, linear: float, angular: float) -> "Path":
        """The motion with linear accelerations multiplied by one factor, and angular
        ones and squares of angular velocities by another."""
        read = partial(_read_scaled, self.read, linear, angular)
        return replace(self, read=read, curves=None)

    def felt(self, grid: Array, value: Array) -> "Path":
        """The motion as filtered for a wrench: rows (n, 21), as in `Reading.value`, at
        instants (n,) [s]."""
        return replace(
            self, read=partial(_read_felt, self.read, grid, value), plain=self
        )

    def known_at(self, time: Array) -> Mask:
        """(K,) whether the motion is known at times [s], as in `Reading.known`."""
        if self.curves is None:
            return self.at(time, spread=False).known
        inside = (time >= self.first) & (time <= self.last)
        return inside & self.curves.alone.covers(time)

    def at(self, time: Array, rates: bool = False, spread: bool = True) -> Reading:
        """Motion at any times (K,) [s].

        Parameters
        ----------
        time : (K,) [s]; times outside the motion are not `known`.
        rates : whether to compute the derivatives by time.
        spread : whether to compute the variances of the errors.
        """
        inside = np.clip(time, self.first, self.last)
        value, variances, there = self.read(inside, spread)
        known = there & (inside == time)
        if not (rates and self.moves):
            zero = np.zeros_like(value)
            return Reading(inside, value, zero, zero, variances, ~there, known)
        earlier = np.maximum(inside - DIFFERENTIATION_STEP, self.first)
        later = np.minimum(inside + DIFFERENTIATION_STEP, self.last)
        around, _, known_around = self.read(np.concatenate((earlier, later)), False)
        before, after = np.split(around, 2)
        usable = (np.logical_and(*np.split(known_around, 2)) & there)[:, None]
        back, forth = (inside - earlier)[:, None], (later - inside)[:, None]
        rate = np.where(usable, (after - before) / np.maximum(back + forth, 1e-12), 0.0)
        whole = (
            usable
            & (back > 0.5 * DIFFERENTIATION_STEP)
            & (forth > 0.5 * DIFFERENTIATION_STEP)
        )
        slopes = (after - value) / np.maximum(forth, 1e-12) - (
            value - before
        ) / np.maximum(back, 1e-12)
        curvature = np.where(whole, 2.0 * slopes / np.maximum(back + forth, 1e-12), 0.0)
        return Reading(inside, value, rate, curvature, variances, ~there, known)


def path_of(
    recording: Recording, source: Source = "auto", gravity: ArrayLike = STANDARD_GRAVITY
) -> Path | None:
    """The motion of a recording, from the streams that `hefting.motion.measure` uses.

    Parameters
    ----------
    recording : the recording.
    source : as for `hefting.motion.measure`.
    gravity : (3,) in world axes [m/s²], for an accelerometer next to the poses. Of the
        curves found, the path is that of the poses alone.

    None if no motion can be shifted: static poses, a pose that is held, rests alone,
    too few poses.
    """
    if recording.static:
        return None
    if reads_columns(recording, source):
        return _columns_path(recording)
    enough = len(recording["orientation"]) >= FEWEST_POSES_OF_PATH
    if not (enough and may_move(recording)):
        return None
    curves = smooth_poses(recording, gravity)
    if recording.has("accelerometer") and not recording.has("position"):
        return _accelerometer_path(curves, recording["accelerometer"])
    return _pose_path(curves)


def static_path(recording: Recording) -> Path:
    """Path without motion: static poses, or a pose that is held."""
    orientation = recording["orientation"]
    turned = np.swapaxes(rotation_matrices(orientation.values), 1, 2)
    world = turned.reshape(-1, 9)  # from world to sensor axes, by rows
    read = partial(_read_static, orientation.time, world)
    return Path("static", -np.inf, np.inf, read, np.inf)


def _read_static(
    at: Array, world: Array, time: Array, spread: bool
) -> tuple[Array, Array, Mask]:
    row = nearest_rows(at, time)
    K = len(time)
    rows = np.hstack((np.zeros((K, 12)), world[row]))
    return rows, np.zeros((2, K)), np.ones(K, dtype=bool)


def _reading_rows(
    a: Array | None, w: Array, alpha: Array, world: Array
) -> tuple[Array, Mask]:
    """Rows (K, 21) of a `Reading`, and a mask (K,) of those that are finite.

    From vectors (3, K) in sensor axes, and the rotation (3, 3, K) to them from world
    axes. Rows that are not finite are zero. Without an acceleration `a` the motion
    columns are zero, so that only gravity is modelled.
    """
    columns = np.zeros((21, world.shape[2]))
    columns[WORLD_AXES_COLUMNS] = world.reshape(9, -1)
    if a is not None:
        columns[0:3] = a
        columns[3:6] = alpha
        np.multiply(w[TENSOR_ROWS], w[TENSOR_COLUMNS], out=columns[6:12])
    finite = np.isfinite(columns if a is not None else np.vstack((columns, alpha)))
    known = np.asarray(finite.all(axis=0))
    columns[:, ~known] = 0.0
    return columns.T, known


def _pose_path(curves: Curves) -> Path:
    """Path of poses; for orientations alone only gravity is modelled."""
    poses = curves.alone
    kind = "orientation" if poses.position is None else "smooth"
    read = partial(_read_in_pieces, partial(_read_poses, poses))
    return Path(kind, poses.first, poses.last, read, poses.bandwidth, curves=curves)


def _read_scaled(
    read: Read, linear: float, angular: float, time: Array, spread: bool
) -> tuple[Array, Array, Mask]:
    value, variances, known = read(time, spread)
    factors = np.ones(value.shape[1])
    factors[MOTION_COLUMNS] = np.repeat((linear, angular), (3, 9))
    return value * factors, variances * np.square([[linear], [angular]]), known


def _read_felt(
    read: Read, grid: Array, value: Array, time: Array, spread: bool
) -> tuple[Array, Array, Mask]:
    return interpolated(time, grid, value), *read(time, spread)[1:]


def _read_in_pieces(read: Read, time: Array, spread: bool) -> tuple[Array, Array, Mask]:
    """As `read`, for a part of the times after the other, to bound the memory."""
    if len(time) <= TIMES_EVALUATED_TOGETHER:
        return read(time, spread)
    K = len(time)
    rows, variances, known = np.empty((K, 21)), np.empty((2, K)), np.empty(K, bool)
    for first in range(0, K, TIMES_EVALUATED_TOGETHER):
        part = slice(first, first + TIMES_EVALUATED_TOGETHER)
        rows[part], variances[:, part], known[part] = read(time[part], spread)
    return rows, variances, known


def _read_poses(
    poses: SmoothedPoses, time: Array, spread: bool
) -> tuple[Array, Array, Mask]:
    w, alpha, world = _read_orientation(poses, time)
    a, variances = None, np.zeros((2, len(time)))
    if poses.position is not None:
        (acceleration,) = poses.position.derivatives(time, (2,))
        a = np.einsum("ijk,jk->ik", world, acceleration)
        if spread:
            variances = poses.lasting_variances(time)
    rows, known = _reading_rows(a, w, alpha, world)
    return rows, np.where(known, variances, 0.0), known


def _read_orientation(poses: SmoothedPoses, time: Array) -> tuple[Array, Array, Array]:
    """Angular velocity and acceleration (3, K) in sensor axes, and the rotation
    (3, 3, K) to them from world axes."""
    q, dq, ddq = poses.orientation.derivatives(time, (0, 1, 2))
    w, alpha = angular_motion(q, dq, ddq)
    q = q / np.sqrt(np.einsum("jk,jk->k", q, q))
    return w, alpha, rotation_matrices(q.T).transpose(2, 1, 0)


def _accelerometer_path(curves: Curves, accelerometer: Stream) -> Path:
    """Path of an orientation and the measured specific force a - g."""
    poses = curves.alone
    accelerometer_std = (
        float(np.std(np.diff(accelerometer.values, axis=0)) / np.sqrt(2.0))
        if len(accelerometer) > 1
        else 0.0
    )
    first = max(poses.first, accelerometer.time[0])
    last = min(poses.last, accelerometer.time[-1])
    read = partial(_read_specific_force, poses, accelerometer, accelerometer_std)
    return Path(
        "accelerometer",
        first,
        last,
        partial(_read_in_pieces, read),
        poses.orientation.smoothness.bandwidth,
        True,
        curves,
    )


def _read_specific_force(
    poses: SmoothedPoses,
    accelerometer: Stream,
    accelerometer_std: float,
    time: Array,
    spread: bool,
) -> tuple[Array, Array, Mask]:
    f = interpolated(time, accelerometer.time, accelerometer.values)
    rows, known = _reading_rows(f.T, *_read_orientation(poses, time))
    variances = np.zeros((2, len(time)))
    if spread:
        variances = poses.lasting_variances(time)
    variances[0] = accelerometer_std**2
    return rows, np.where(known, variances, 0.0), known


def _columns_path(recording: Recording) -> Path | None:
    """Path of the log's twist and acceleration columns, interpolated by cubic splines;
    None for too few samples."""
    from scipy.interpolate import CubicSpline

    from hefting.motion.spline import aligned

    streams = [recording[name] for name in TWIST]
    orientation = recording["orientation"]
    if min(len(s) for s in (orientation, *streams)) < FEWEST_POSES_OF_PATH:
        return None
    turn = CubicSpline(orientation.time, aligned(orientation.values))
    curves = [CubicSpline(s.time, s.values) for s in streams]
    first = max(float(s.time[0]) for s in (orientation, *streams))
    last = min(float(s.time[-1]) for s in (orientation, *streams))
    return Path("columns", first, last, partial(_read_columns, turn, curves), np.inf)


def _read_columns(
    turn: Callable[[Array], Array],
    curves: Sequence[Callable[[Array], Array]],
    time: Array,
    spread: bool,
) -> tuple[Array, Array, Mask]:
    q = turn(time)
    q = q / np.linalg.norm(q, axis=1, keepdims=True)
    world = rotation_matrices(q).transpose(2, 1, 0)
    a, w, alpha = (np.einsum("ijk,kj->ik", world, curve(time)) for curve in curves)
    rows, known = _reading_rows(a, w, alpha, world)
    return rows, np.zeros((2, len(time))), known
