"""Measurements: motion, gravity and wrench at K instants in sensor axes, the input of
every estimator."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields, replace
from math import isfinite
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from hefting.core.errors import InputError
from hefting.core.spatial import Array, frozen, move_motion, move_wrench


@dataclass(frozen=True)
class Noise:
    """Standard deviations of zero-mean noise, per axis. Zero means exact.

    Examples
    --------
    >>> hefting.NOISE_LEVELS["moderate"] == hefting.Noise(0.1, 0.005, 0.05, 0.5)
    True
    """

    force: float = 0.0
    """Force [N]."""
    torque: float = 0.0
    """Torque [N m]."""
    linear_acceleration: float = 0.0
    """Linear acceleration [m/s²]."""
    angular_acceleration: float = 0.0
    """Angular acceleration [rad/s²]."""


@dataclass(frozen=True)
class MotionNoise:
    """Errors of accelerations, from poses or measured: their size and duration.

    Examples
    --------
    >>> hefting.MotionNoise(linear=0.05, angular=0.5).memory
    0.0
    """

    linear: float
    """Standard deviation of the errors of the linear acceleration, per axis [m/s²]."""
    angular: float
    """The same of the angular acceleration [rad/s²]."""
    memory: float = 0.0
    """Duration of those errors [s]: 0 for white noise, pi over the bandwidth [rad/s] of
    a filter."""

    def __post_init__(self):
        for name in ("linear", "angular", "memory"):
            value = getattr(self, name)
            if not (isinstance(value, int | float) and 0.0 <= value < np.inf):
                what = f"is {value}, not finite and at least 0"
                raise InputError(what, where=f"MotionNoise.{name}")


NOISE_LEVELS = {
    "none": Noise(),
    "low": Noise(0.05, 0.0025, 0.025, 0.25),
    "moderate": Noise(0.1, 0.005, 0.05, 0.5),
    "high": Noise(0.33, 0.0067, 0.1, 1.0),
}
"""Noise levels of the paper (Nadeau et al. 2022, table II)."""


DIMENSIONS = {
    "time": 1,
    "gravity": 2,
    "linear_acceleration": 2,
    "angular_velocity": 2,
    "angular_acceleration": 2,
    "force": 2,
    "torque": 2,
    "weights": 1,
}
"""The arrays of `Measurements`: one dimension (K,) or two (K, 3)."""


@dataclass(frozen=True, eq=False)
class Measurements:
    """K samples of motion and wrench in sensor axes; see `hefting.core.spatial` for
    signs and frames.

    Examples
    --------
    >>> import numpy as np
    >>> zero = np.zeros((2, 3))
    >>> down = np.tile([0.0, 0.0, -9.81], (2, 1))
    >>> time = [0.0, 0.1]
    >>> z = hefting.Measurements(time, down, zero, zero, zero, -down, zero)
    >>> len(z), z.wrench.shape
    (2, (2, 6))
    """

    time: Array
    """(K,) [s]"""
    gravity: Array
    """(K, 3) gravity [m/s²]"""
    linear_acceleration: Array
    """(K, 3) classical acceleration of the sensor origin [m/s²]"""
    angular_velocity: Array
    """(K, 3) [rad/s]"""
    angular_acceleration: Array
    """(K, 3) [rad/s²]"""
    force: Array
    """(K, 3) exerted by the sensor on the object [N]"""
    torque: Array
    """(K, 3) about the sensor origin [N m]"""
    noise: Noise | None = None
    """noise levels, where known"""
    weights: Array | None = None
    """(K,) weight of each sample's squared residuals, or None for ones"""
    motion_noise: MotionNoise | None = None
    """errors of the accelerations if known; None for those of `noise`, else white ones
    that consecutive samples show"""

    def __post_init__(self):
        count = None
        for name, dimensions in DIMENSIONS.items():
            values = getattr(self, name)
            if values is None:
                continue
            array = frozen(values, dimensions)
            if array is not values:
                object.__setattr__(self, name, array)
            if count is None:
                count = len(array)
            shape = (count, 3) if dimensions == 2 else (count,)
            if array.shape != shape:
                what = f"has shape {array.shape}, expected {shape}"
                raise InputError(what, where=f"Measurements.{name}")
            if not isfinite(np.vdot(array, array)):  # quick; squares may overflow
                rows = np.argwhere(~np.isfinite(array))
                if len(rows):
                    what = f"sample {int(rows[0][0])} is not finite"
                    raise InputError(what, where=f"Measurements.{name}")
        if self.weights is not None and (self.weights < 0.0).any():
            raise InputError("a weight is negative", where="Measurements.weights")

    def __len__(self) -> int:
        return len(self.time)

    def __getitem__(self, index: slice | NDArray[Any]) -> Self:
        """The samples chosen by a slice, a mask (K,) or an index array."""
        chosen = {
            f.name: getattr(self, f.name)[index]
            for f in fields(self)
            if f.name in DIMENSIONS and getattr(self, f.name) is not None
        }
        return replace(self, **chosen)

    @property
    def wrench(self) -> Array:
        """(K, 6) force and torque."""
        return np.hstack((self.force, self.torque))

    @property
    def acceleration_errors(self) -> MotionNoise | None:
        """Errors of the accelerations: `motion_noise`, else the white ones of `noise`;
        None if unknown."""
        if self.motion_noise is not None or self.noise is None:
            return self.motion_noise
        return MotionNoise(
            self.noise.linear_acceleration, self.noise.angular_acceleration
        )

    def moved(self, pose_old_in_new: Array) -> Self:
        """The same motion and wrench in another frame fixed to the sensor;
        `pose_old_in_new` is (4, 4)."""
        force, torque = move_wrench(pose_old_in_new, self.force, self.torque)
        a, w, alpha = move_motion(
            pose_old_in_new,
            self.linear_acceleration,
            self.angular_velocity,
            self.angular_acceleration,
        )
        return replace(
            self,
            gravity=self.gravity @ np.asarray(pose_old_in_new)[:3, :3].T,
            linear_acceleration=a,
            angular_velocity=w,
            angular_acceleration=alpha,
            force=force,
            torque=torque,
        )

    def with_noise(self, noise: Noise, seed: int | Sequence[int]) -> Self:
        """A copy with seeded Gaussian noise added to accelerations and wrench (Nadeau
        et al. 2022, sec. V-C)."""
        rng = np.random.default_rng(seed)
        noisy = {
            level.name: getattr(self, level.name)
            + getattr(noise, level.name) * rng.normal(size=(len(self), 3))
            for level in fields(noise)
        }
        return replace(self, noise=noise, **noisy)
