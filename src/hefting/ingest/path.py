"""Path: the motion of a recording as a function of time, to be read at instants shifted
against the wrench's."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from hefting.core.recording import Recording, Stream
from hefting.core.spatial import (
    STANDARD_GRAVITY,
    TENSOR_COLUMNS,
    TENSOR_ROWS,
    Array,
    Mask,
    rotation_matrices,
)
from hefting.motion import Curves, smooth_poses
from hefting.motion.measure import POSE_STREAMS, TWIST, Source

FEWEST_POSES_OF_PATH = 8
"""Fewest orientations from which a motion is smoothed."""
DIFFERENTIATION_STEP = 2e-3
"""[s] Step of the numerical derivatives by time. A motion of 15 Hz advances by 0.19 rad
of its phase in it."""
MOTION_COLUMNS = slice(0, 12)
"""Columns of a reading that hold a, alpha and vech(w w'), as in
`hefting.core.regressor` but with a instead of a - g."""
WORLD_AXES_COLUMNS = slice(12, 21)
"""Columns of a reading that hold the rotation matrix (3, 3) from world to sensor axes,
by rows."""


@dataclass(frozen=True, eq=False)
class Reading:
    """Motion at K instants in sensor axes, with its derivatives by time."""

    time: Array
    """(K,) [s] at which the motion was read: the nearest of its own time"""
    value: Array
    """(K, 21): see `MOTION_COLUMNS` and `WORLD_AXES_COLUMNS`"""
    rate: Array
    """(K, 21) first derivative by time; zero where it was not asked for"""
    curvature: Array
    """(K, 21) second derivative by time; zero where it was not asked for"""
    variances: Array
    """(2, K) of the errors of linear [m²/s⁴] and angular [rad²/s⁴] acceleration, one
    axis each"""
    in_gap: Mask
    """(K,) True in gaps of the motion; the values there mean nothing"""
    known: Mask
    """(K,) False in gaps, and outside the motion's time, where the values are those of
    its ends"""


@dataclass(frozen=True, eq=False)
class Path:
    """Motion as a function of time."""

    kind: str
    """A key of `hefting.motion.measure.DESCRIPTIONS`."""
    first: float
    """s, when it begins"""
    last: float
    """s, when it ends"""
    read: Callable[[Array, bool], tuple[Array, Array, Mask]]
    """rows (K, 21), variances (2, K), zero unless asked for, and whether known (K,), at
    times between the two"""
    bandwidth: float
    """rad/s of the motion's errors; infinite where it is exact"""
    gravity_measured: bool = False
    """Whether gravity is part of a measured acceleration, as an accelerometer's, and
    not modelled."""
    curves: Curves | None = None
    """The curves behind it, if any."""

    @property
    def smooth(self) -> bool:
        """Whether it holds nothing faster than `hefting.ingest.blocks` averages over;
        sensors feel vibrations."""
        return self.kind in ("smooth", "orientation")

    @property
    def moves(self) -> bool:
        """Whether there is motion that the wrench may be late against."""
        return self.kind != "static"

    def at(self, time: Array, rates: bool = False, spread: bool = True) -> Reading:
        """Motion at any times (K,) [s], with its `rates` and the `spread` of its errors
        if asked for.

        Not known outside its own time.
        """
        inside = np.clip(time, self.first, self.last)
        value, variances, there = self.read(inside, spread)
        known = there & (inside == time)
        if not (rates and self.moves):
            zero = np.zeros_like(value)
            return Reading(inside, value, zero, zero, variances, ~there, known)
        earlier, later = (
            np.maximum(inside - DIFFERENTIATION_STEP, self.first),
            np.minimum(inside + DIFFERENTIATION_STEP, self.last),
        )
        before, _, known_before = self.read(earlier, False)
        after, _, known_after = self.read(later, False)
        usable = (known_before & known_after & there)[:, None]
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
    """The motion of a recording, from the streams `hefting.motion.measure` would take
    it from.

    `gravity` (3,) [m/s²] serves an accelerometer beside the poses; here the poses count
    alone. None where there is
    no motion to shift: static poses, a held pose, too few of them.
    """
    if recording.static:
        return None
    if source == "columns" or (source == "auto" and recording.has(*TWIST)):
        return _columns(recording)
    moves = any(
        np.ptp(recording[name].values, axis=0).any()
        for name in POSE_STREAMS
        if recording.has(name)
    )
    felt = recording.has("accelerometer") and not recording.has("position")
    orientation = recording["orientation"]
    if not (moves or felt) or len(orientation) < FEWEST_POSES_OF_PATH:
        return None
    curves = smooth_poses(recording, gravity)
    if recording.has("position"):
        return _smoothed(curves)
    return _felt(curves, recording["accelerometer"]) if felt else _turning(curves)


def static_path(recording: Recording) -> Path:
    """Poses without motion: those of a static recording, at its rows, or the one that
    is held."""
    orientation = recording["orientation"]
    world = _world(orientation.values)

    def read(time: Array, spread: bool) -> tuple[Array, Array, Mask]:
        row = np.clip(np.searchsorted(orientation.time, time), 0, len(world) - 1)
        K = len(time)
        return (
            np.hstack((np.zeros((K, 12)), world[row])),
            np.zeros((2, K)),
            np.ones(K, dtype=bool),
        )

    return Path("static", -np.inf, np.inf, read, np.inf)


def _world(quaternions: Array) -> Array:
    """(K, 9)"""
    return np.swapaxes(rotation_matrices(quaternions), 1, 2).reshape(-1, 9)


def _rows(
    a: Array | None, w: Array, alpha: Array, quaternions: Array
) -> tuple[Array, Mask]:
    """Rows (K, 21), zero where anything is not finite, and where that is not so;
    gravity alone without `a`."""
    rows = np.zeros((len(w), 21))
    rows[:, WORLD_AXES_COLUMNS] = _world(quaternions)
    if a is not None:
        rows[:, 0:3], rows[:, 3:6], rows[:, 6:12] = (
            a,
            alpha,
            w[:, TENSOR_ROWS] * w[:, TENSOR_COLUMNS],
        )
    known = np.asarray(np.isfinite(rows).all(axis=1) & np.isfinite(alpha).all(axis=1))
    rows[~known] = 0.0
    return rows, known


def _smoothed(curves: Curves) -> Path:
    poses = curves.alone

    def read(time: Array, spread: bool) -> tuple[Array, Array, Mask]:
        m = poses.at(time, spread)
        assert m.linear_acceleration_std is not None
        rows, known = _rows(
            m.linear_acceleration,
            m.angular_velocity,
            m.angular_acceleration,
            m.orientation,
        )
        variances = np.square(
            np.stack((m.linear_acceleration_std, m.angular_acceleration_std))
        )
        return rows, np.where(known, variances, 0.0), known

    bandwidth = poses.at([poses.first], spread=False).bandwidth
    return Path("smooth", poses.first, poses.last, read, bandwidth, curves=curves)


def _turning(curves: Curves) -> Path:
    """Orientation alone: gravity is all that is modelled."""
    poses = curves.alone

    def read(time: Array, spread: bool) -> tuple[Array, Array, Mask]:
        m = poses.at(time, spread=False)
        rows, known = _rows(
            None, m.angular_velocity, m.angular_acceleration, m.orientation
        )
        return rows, np.zeros((2, len(time))), known

    return Path(
        "orientation",
        poses.first,
        poses.last,
        read,
        poses.orientation.smoothness.bandwidth,
        curves=curves,
    )


def _felt(curves: Curves, accelerometer: Stream) -> Path:
    """Orientation, and the specific force a - g."""
    poses = curves.alone
    spread_felt = (
        float(np.std(np.diff(accelerometer.values, axis=0)) / np.sqrt(2.0))
        if len(accelerometer) > 1
        else 0.0
    )

    def read(time: Array, spread: bool) -> tuple[Array, Array, Mask]:
        m = poses.at(time, spread)
        f = np.column_stack(
            [
                np.interp(time, accelerometer.time, column)
                for column in accelerometer.values.T
            ]
        )
        rows, known = _rows(
            f, m.angular_velocity, m.angular_acceleration, m.orientation
        )
        std = np.stack((np.full(len(time), spread_felt), m.angular_acceleration_std))
        return rows, np.where(known, np.square(std), 0.0), known

    first, last = (
        max(poses.first, accelerometer.time[0]),
        min(poses.last, accelerometer.time[-1]),
    )
    return Path(
        "accelerometer",
        first,
        last,
        read,
        poses.orientation.smoothness.bandwidth,
        True,
        curves,
    )


def _columns(recording: Recording) -> Path | None:
    """The log's own twist and acceleration columns, between samples by cubic
    interpolation."""
    from scipy.interpolate import CubicSpline

    from hefting.motion.spline import aligned

    streams = [recording[name] for name in TWIST]
    orientation = recording["orientation"]
    if min(len(s) for s in (orientation, *streams)) < FEWEST_POSES_OF_PATH:
        return None
    turn = CubicSpline(orientation.time, aligned(orientation.values))
    curves = [CubicSpline(s.time, s.values) for s in streams]

    def read(time: Array, spread: bool) -> tuple[Array, Array, Mask]:
        q = turn(time)
        q = q / np.linalg.norm(q, axis=1, keepdims=True)
        world = _world(q).reshape(-1, 3, 3)
        a, w, alpha = (np.einsum("kij,kj->ki", world, curve(time)) for curve in curves)
        rows, known = _rows(a, w, alpha, q)
        return rows, np.zeros((2, len(time))), known

    first = max(float(s.time[0]) for s in (orientation, *streams))
    last = min(float(s.time[-1]) for s in (orientation, *streams))
    return Path("columns", first, last, read, np.inf)
