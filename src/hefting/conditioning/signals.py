"""Motion of a recording as functions of time, to be read at instants shifted against the wrench's."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from hefting.motion import Curves, smooth_poses
from hefting.motion.measure import POSE, TWIST, Source
from hefting.recording import Recording, Stream
from hefting.spatial import STANDARD_GRAVITY, TENSOR_COLUMNS, TENSOR_ROWS, Array, Mask, rotation_matrices

FEWEST_POSES = 8


@dataclass(frozen=True, eq=False)
class Snapshot:
    """Motion at K instants, in sensor axes."""

    world: Array
    """(K, 3, 3): the world's axes, as columns, in sensor axes: gravity there is ``world @ gravity``"""
    features: Array
    """(K, 12): a, alpha, vech(w w') of `hefting.regressor`, with a itself in the place of a - g"""
    linear_std: Array | None
    """(K,) [m/s²]; None where the acceleration is exact or not modelled"""
    angular_std: Array
    """(K,) [rad/s²]"""
    known: Mask
    """(K,) False outside the motion's time and in gaps; the values there mean nothing"""


@dataclass(frozen=True, eq=False)
class Signal:
    """Motion as a function of time."""

    kind: str
    """A key of `hefting.motion.measure.DESCRIPTIONS`."""
    first: float
    """s, when it begins"""
    last: float
    """s, when it ends"""
    read: Callable[[Array], Snapshot]
    """the motion at times between the two"""
    bandwidth: float
    """rad/s of the motion's errors; infinite where it is exact"""
    gravity_measured: bool = False
    """Whether gravity is part of a measured acceleration, as an accelerometer's, and not modelled."""
    curves: Curves | None = None
    """The curves behind it, if any."""

    def at(self, time: Array) -> Snapshot:
        """Motion at any times (K,) [s]; not known outside its own."""
        inside = np.clip(time, self.first, self.last)
        seen = self.read(inside)
        return Snapshot(seen.world, seen.features, seen.linear_std, seen.angular_std, seen.known & (inside == time))


def signal_of(recording: Recording, source: Source = "auto", gravity: ArrayLike = STANDARD_GRAVITY) -> Signal | None:
    """The motion of a recording, from the streams `hefting.motion.measure` would take it from.

    `gravity` (3,) [m/s²] serves an accelerometer beside the poses; here the poses count alone. None where there is
    no motion to shift: static poses, a held pose, too few of them.
    """
    if recording.static:
        return None
    if source == "columns" or (source == "auto" and recording.has(*TWIST)):
        return _columns(recording)
    moves = any(np.ptp(recording[name].values, axis=0).any() for name in POSE if recording.has(name))
    felt = recording.has("accelerometer") and not recording.has("position")
    orientation = recording["orientation"]
    if not (moves or felt) or len(orientation) < FEWEST_POSES:
        return None
    curves = smooth_poses(recording, gravity)
    if recording.has("position"):
        return _smoothed(curves)
    return _felt(curves, recording["accelerometer"]) if felt else _turning(curves)


def still(recording: Recording) -> Signal:
    """Poses without motion: those of a static recording, at its rows, or the one that is held."""
    orientation = recording["orientation"]
    world = _world(orientation.values)

    def read(time: Array) -> Snapshot:
        row = np.clip(np.searchsorted(orientation.time, time), 0, len(world) - 1)
        K = len(time)
        return Snapshot(world[row], np.zeros((K, 12)), None, np.zeros(K), np.ones(K, dtype=bool))

    return Signal("static", -np.inf, np.inf, read, np.inf)


def _world(quaternions: Array) -> Array:
    return np.swapaxes(rotation_matrices(quaternions), 1, 2)


def _features(a: Array, w: Array, alpha: Array) -> Array:
    return np.concatenate((a, alpha, w[:, TENSOR_ROWS] * w[:, TENSOR_COLUMNS]), axis=1)


def _filled(values: Array, known: Mask) -> Array:
    return np.where(known.reshape(-1, *[1] * (values.ndim - 1)), values, 0.0)


def _smoothed(curves: Curves) -> Signal:
    poses = curves.alone

    def read(time: Array) -> Snapshot:
        m = poses.at(time)
        assert m.linear_acceleration is not None
        assert m.linear_acceleration_std is not None
        features = _features(m.linear_acceleration, m.angular_velocity, m.angular_acceleration)
        known = np.asarray(np.isfinite(features).all(axis=1))
        world, features = _filled(_world(m.orientation), known), _filled(features, known)
        linear, angular = (_filled(s, known) for s in (m.linear_acceleration_std, m.angular_acceleration_std))
        return Snapshot(world, features, linear, angular, known)

    bandwidth = poses.at([poses.first]).bandwidth
    return Signal("smooth", poses.first, poses.last, read, bandwidth, curves=curves)


def _turning(curves: Curves) -> Signal:
    """Orientation alone: gravity is all that is modelled."""
    poses = curves.alone

    def read(time: Array) -> Snapshot:
        m = poses.at(time)
        known = np.asarray(np.isfinite(m.angular_acceleration).all(axis=1))
        world = _filled(_world(m.orientation), known)
        return Snapshot(world, np.zeros((len(time), 12)), None, np.zeros(len(time)), known)

    return Signal("orientation", poses.first, poses.last, read, poses.orientation.smoothness.bandwidth, curves=curves)


def _felt(curves: Curves, accelerometer: Stream) -> Signal:
    """Orientation, and the specific force a - g."""
    poses = curves.alone
    spread = float(np.std(np.diff(accelerometer.values, axis=0)) / np.sqrt(2.0)) if len(accelerometer) > 1 else 0.0

    def read(time: Array) -> Snapshot:
        m = poses.at(time)
        known = np.asarray(np.isfinite(m.angular_acceleration).all(axis=1))
        f = np.column_stack([np.interp(time, accelerometer.time, column) for column in accelerometer.values.T])
        features = _filled(_features(f, m.angular_velocity, m.angular_acceleration), known)
        world = _filled(_world(m.orientation), known)
        std = _filled(m.angular_acceleration_std, known)
        return Snapshot(world, features, np.full(len(time), spread), std, known)

    first, last = max(poses.first, accelerometer.time[0]), min(poses.last, accelerometer.time[-1])
    return Signal("accelerometer", first, last, read, poses.orientation.smoothness.bandwidth, True, curves)


def _columns(recording: Recording) -> Signal | None:
    """The log's own twist and acceleration columns, between samples by cubic interpolation."""
    from scipy.interpolate import CubicSpline

    from hefting.motion.spline import aligned

    streams = [recording[name] for name in TWIST]
    orientation = recording["orientation"]
    if min(len(s) for s in (orientation, *streams)) < FEWEST_POSES:
        return None
    turn = CubicSpline(orientation.time, aligned(orientation.values))
    curves = [CubicSpline(s.time, s.values) for s in streams]

    def read(time: Array) -> Snapshot:
        q = turn(time)
        world = _world(q / np.linalg.norm(q, axis=1, keepdims=True))
        a, w, alpha = (np.einsum("kij,kj->ki", world, curve(time)) for curve in curves)
        zero = np.zeros(len(time))
        return Snapshot(world, _features(a, w, alpha), None, zero, np.ones(len(time), dtype=bool))

    first = max(float(s.time[0]) for s in (orientation, *streams))
    last = min(float(s.time[-1]) for s in (orientation, *streams))
    return Signal("columns", first, last, read, np.inf)
