"""Smoothing of finished recordings: from poses to velocities and accelerations with
realistic errors.

Position, and the four components of the orientation's quaternion, are each smoothed by
a penalised quintic spline of most likely bandwidth, noise level and order
(`hefting.motion.curve`).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from hefting.core.errors import InputError
from hefting.core.spatial import Array, Mask
from hefting.motion.bspline import FEWEST_SEGMENT_SAMPLES, TIMES_EVALUATED_TOGETHER
from hefting.motion.curve import Curve
from hefting.motion.state import Motion, motion_from_channels, motion_from_pieces

POSE_WIDTH = {"time": (), "position": (3,), "orientation": (4,)}
"""Shape of a sample of each array of poses."""


@dataclass(frozen=True)
class SmoothedPoses:
    """Poses of a finished recording as smooth curves, to be read at any time inside
    it."""

    orientation: Curve
    """of the quaternion's four components"""
    position: Curve | None
    first: float
    """[s] latest beginning of a curve"""
    last: float
    """[s] earliest end of a curve"""

    def at(self, time: ArrayLike, spread: bool = True) -> Motion:
        """Motion at times (L,) [s]; NaN, of infinite deviation, inside a gap too long
        to bridge.

        Without `spread` the deviations are zero wherever the motion is known: they cost
        as much as the rest. Raises `InputError` for times outside the recording.
        """
        at = np.atleast_1d(np.asarray(time, dtype=float))
        if len(at) and (at.min() < self.first or at.max() > self.last):
            raise InputError(
                f"the motion is wanted from {at.min():.6g} to {at.max():.6g} s, "
                f"but known from {self.first:.6g} to {self.last:.6g} s",
                fix="ask only for times inside the recording",
            )
        if len(at) <= TIMES_EVALUATED_TOGETHER:
            return self._at(at, spread)
        pieces = (
            self._at(at[first : first + TIMES_EVALUATED_TOGETHER], spread)
            for first in range(0, len(at), TIMES_EVALUATED_TOGETHER)
        )
        return motion_from_pieces(at, pieces)

    def lasting_variances(self, time: Array) -> Array:
        """(2, L) error variances of linear and angular acceleration along one axis at
        times (L,) [s], without those at jumps: those of
        `hefting.motion.state.lasting_variances`."""
        curves = (self.position, self.orientation)
        linear, angular = (
            np.zeros(len(time)) if each is None else each.lasting_variance(time)
            for each in curves
        )
        return np.stack((linear, 4.0 * angular))

    def covers(self, time: Array) -> Mask:
        """(L,) times [s] at which the motion is known: inside, and not in a long
        gap."""
        inside = (time >= self.first) & (time <= self.last)
        curves = (self.orientation, self.position)
        for curve in (curve for curve in curves if curve is not None):
            inside &= curve.knots.locate(time)[2]
        return inside

    @property
    def bandwidth(self) -> float:
        """[rad/s] of the errors: the geometric mean of both curves'."""
        bandwidth = self.orientation.smoothness.bandwidth
        if self.position is None:
            return bandwidth
        return float(np.sqrt(self.position.smoothness.bandwidth * bandwidth))

    def _at(self, at: Array, spread: bool) -> Motion:
        q = self.orientation.evaluate(at, spread)
        if self.position is None:
            return motion_from_channels(at, None, q, self.bandwidth)
        p0, p1, p2, _, p2_std, p2_jump = self.position.evaluate(at, spread)
        p = p0, p1, p2, p2_std, p2_jump
        return motion_from_channels(at, p, q, self.bandwidth)


def fit_poses(
    time: ArrayLike,
    position: ArrayLike | None,
    orientation: ArrayLike,
    position_time: ArrayLike | None = None,
) -> SmoothedPoses:
    """Smooth curves through measured poses.

    Held values, repeated as often as a slower stream repeats between its updates, count
    once.

    Parameters
    ----------
    time : ArrayLike
        (K,) [s], increasing, with any spacing.
    position : ArrayLike or None
        (K, 3) [m] of the sensor's origin in world axes.
    orientation : ArrayLike
        (K, 4) quaternions xyzw of the sensor in the world; their signs and lengths do
        not matter.
    position_time : ArrayLike or None
        (P,) [s] where positions (P, 3) come at times of their own; `time` by default.

    Raises
    ------
    InputError
        For arrays that do not fit, times that do not increase, and fewer than eight
        poses.
    """
    if position is None or position_time is None:
        time, position, orientation = check_poses(time, position, orientation)
        own_time = time
    else:
        own_time, checked = _checked(position_time, {"position": position})
        position = checked["position"]
        time, _, orientation = check_poses(time, None, orientation)
    count = min(len(time), len(own_time))
    if count < FEWEST_SEGMENT_SAMPLES:
        raise InputError(
            f"{count} poses are too few to differentiate",
            fix=f"record at least {FEWEST_SEGMENT_SAMPLES}",
        )
    q = Curve.fit(time, aligned(orientation), "orientation")
    p = None if position is None else Curve.fit(own_time, position, "position")
    return SmoothedPoses(q, p, max(time[0], own_time[0]), min(time[-1], own_time[-1]))


def smooth(
    time: ArrayLike,
    position: ArrayLike | None,
    orientation: ArrayLike,
    at: ArrayLike | None = None,
    position_time: ArrayLike | None = None,
) -> Motion:
    """Motion of the sensor from its measured poses, at times `at` (L,) [s] or at those
    of the orientations.

    Other arguments and errors as for `fit_poses`, and `SmoothedPoses.at` for times
    outside the recording. The variances are those of the spline as a Gaussian process
    of the smoothness found: in the interior, at the ends and beside gaps. Inside a gap
    too long to bridge the motion is NaN, its deviation infinite.

    Examples
    --------
    >>> log = hefting.read_log("demo/log.csv")
    >>> position, orientation = log["position"], log["orientation"]
    >>> motion = hefting.smooth(position.time, position.values, orientation.values)
    >>> motion.linear_acceleration.shape
    (1000, 3)
    """
    fitted = fit_poses(time, position, orientation, position_time)
    return fitted.at(time if at is None else at)


def check_poses(time, position, orientation) -> tuple[Array, Array | None, Array]:
    """Float arrays (K,), (K, 3) or None, (K, 4) of unit length; `InputError` if they do
    not fit."""
    given = {"orientation": orientation}
    if position is not None:
        given["position"] = position
    time, found = _checked(time, given)
    orientation = found["orientation"]
    norm = np.sqrt(np.einsum("ki,ki->k", orientation, orientation))[:, None]
    if (norm < 1e-6).any():
        raise InputError(
            f"row {int(np.argmin(norm))} is no rotation: its quaternion is zero",
            where="orientation",
        )
    return time, found.get("position"), orientation / norm


def _checked(
    time: ArrayLike, poses: Mapping[str, ArrayLike]
) -> tuple[Array, dict[str, Array]]:
    """Float arrays: the times (K,), and positions (K, 3) or orientations (K, 4) by name;
    `InputError` when they do not fit."""
    time = np.atleast_1d(np.asarray(time, dtype=float))
    arrays = {name: np.asarray(values, dtype=float) for name, values in poses.items()}
    for name, array in {"time": time, **arrays}.items():
        shape = (len(time), *POSE_WIDTH[name])
        if array.shape != shape:
            raise InputError(f"has shape {array.shape}, expected {shape}", where=name)
        if not np.isfinite(array).all():
            row = int(np.argwhere(~np.isfinite(array))[0][0])
            raise InputError(
                f"row {row} is not finite",
                where=name,
                fix="leave out the rows that were not measured",
            )
    if (np.diff(time) <= 0).any():
        row = int(np.argmax(np.diff(time) <= 0)) + 1
        raise InputError(
            f"row {row} is not later than the row before it",
            where="time",
            fix="sort it, drop doubles",
        )
    return time, arrays


def aligned(quaternions: Array, previous: Array | None = None) -> Array:
    """(K, 4) quaternions with signs such that each is near the one before, the first
    near `previous`."""
    if len(quaternions) == 0:
        return quaternions
    flips = np.einsum("ij,ij->i", quaternions[1:], quaternions[:-1]) < 0
    first = previous is not None and quaternions[0] @ previous < 0
    if not (first or flips.any()):
        return quaternions
    signs = 1.0 - 2.0 * (np.cumsum(np.concatenate(([first], flips))) % 2)
    return quaternions * signs[:, None]
