"""Samples of joint torques with the joints' motion, smoothed by the project's
spline."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Self

import numpy as np

from hefting.core.errors import InputError
from hefting.core.spatial import Array, Indices
from hefting.motion.curve import Curve

FEWEST = 20
"""Samples of a run that a motion is found from."""


@dataclass(frozen=True, eq=False)
class TorqueSamples:
    """Motion and torques of n joints at K instants."""

    time: Array
    """(K,) [s], increasing"""
    position: Array
    """(K, n) [rad] or [m]"""
    velocity: Array
    """(K, n) [rad/s] or [m/s]"""
    acceleration: Array
    """(K, n) [rad/s²] or [m/s²]"""
    torque: Array
    """(K, n) [N m] or [N], exerted by the motors on the links"""

    @classmethod
    def smoothed(
        cls, joint_time: Array, position: Array, time: Array, torque: Array
    ) -> Self:
        """From joint positions (L, n) at `joint_time` (L,) and torques (K, n) at `time`
        (K,) [s]: each joint's motion is a spline through its positions.

        Torques outside the positions' time, or in gaps, are left out. Raises
        `InputError` for fewer than `FEWEST` samples.
        """
        for what, many in (("positions", len(joint_time)), ("torques", len(time))):
            if many < FEWEST:
                raise InputError(
                    f"{many} samples of joint {what} are too few",
                    fix=f"record at least {FEWEST}, moving",
                )
        motion = np.empty((3, *torque.shape))
        for j in range(position.shape[1]):
            own = position[:, j : j + 1]
            if not np.ptp(own):
                motion[:, :, j] = np.array((own[0, 0], 0.0, 0.0))[:, None]
                motion[:, (time < joint_time[0]) | (time > joint_time[-1]), j] = np.nan
                continue
            curve = Curve.fit(joint_time, own, f"position of joint {j + 1}")
            for k, values in enumerate(curve.evaluate(time, spread=False)[:3]):
                motion[k, :, j] = values[:, 0]
        kept = np.isfinite(motion).all(axis=(0, 2))
        if kept.sum() < FEWEST:
            raise InputError(
                "hardly any torque was measured while the joints' positions were"
            )
        position, velocity, acceleration = motion[:, kept]
        return cls(time[kept], position, velocity, acceleration, torque[kept])

    def __getitem__(self, part: slice) -> TorqueSamples:
        return TorqueSamples(
            self.time[part],
            self.position[part],
            self.velocity[part],
            self.acceleration[part],
            self.torque[part],
        )

    def bins(self, rate: float) -> Indices:
        """Index of the first sample of each 1 / `rate` seconds that has any; each
        sample's own, where they come no faster."""
        interval = float(np.median(np.diff(self.time)))
        if interval * rate > 0.7:
            return np.arange(len(self.time))
        number = np.floor((self.time - self.time[0]) * rate + 1e-6)
        return np.flatnonzero(np.diff(number, prepend=-1.0))
