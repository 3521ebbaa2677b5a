"""How far a motion is from its limits, as shares, and how that changes with it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple, Self

import numpy as np

from hefting.core.spatial import Array, cross, frozen
from hefting.planning.half_spaces import HalfSpace
from hefting.planning.information import expected_wrench
from hefting.planning.kinematics import TipMotion
from hefting.planning.limits import Limits

CLEARANCE = 0.005
"""[m] from walls, and of the links and the object from each other: what a corner moves
at 0.25 m/s in a fiftieth of a second."""
CLEARANCE_SCALE = 0.1
"""[m] into a wall that counts as much as going a whole limit beyond it."""


class JointStates(NamedTuple):
    """Joint motion on a grid; each (K, n)."""

    position: Array
    speed: Array
    acceleration: Array
    jerk: Array


@dataclass(frozen=True, eq=False)
class Constraints:
    """Limits as numbers that are at most zero where they are kept: a share of the limit
    less one."""

    limits: Limits
    corners: Array
    """(c, 3) [m] in the sensor frame"""
    body: Array
    """(10,) parameters of the body whose wrench is expected"""
    normals: Array
    """(p, 3) of half-spaces, in root axes"""
    offsets: Array
    """(p,) [m] with the margin"""

    @classmethod
    def of(
        cls,
        limits: Limits,
        corners: Array,
        body: Array,
        half_spaces: Sequence[HalfSpace] = (),
    ) -> Self:
        """With the half-spaces that the corners keep to."""
        normals = np.array([each.normal for each in half_spaces]).reshape(-1, 3)
        offsets = CLEARANCE + np.array([each.offset for each in half_spaces])
        return cls(
            limits, frozen(corners), frozen(body), frozen(normals), frozen(offsets)
        )

    @property
    def joint_scales(self) -> tuple[tuple[Array, Array], ...]:
        """Middle and half-width of what each of position, speed, acceleration and jerk
        may be, (n,) each; infinite where nothing binds."""
        own = self.limits
        ends = own.position
        bounded = np.isfinite(ends).all(axis=1)
        middle = np.where(bounded, ends.sum(axis=1) / 2.0, 0.0)
        half = np.where(bounded, (ends[:, 1] - ends[:, 0]) / 2.0, np.inf)
        zero = np.zeros(len(ends))
        return (
            (np.nan_to_num(middle), half),
            (zero, own.speed),
            (zero, own.acceleration),
            (zero, own.jerk),
        )

    @property
    def _ways(self) -> Array:
        """(3, c, 1) [m] to the corners"""
        return self.corners.T[:, :, None]

    def joint_shares(self, states: JointStates) -> list[Array]:
        """Signed shares (K, n) of the limits of each of position, speed, acceleration
        and jerk."""
        pairs = zip(states, self.joint_scales, strict=True)
        return [(x - middle) / half for x, (middle, half) in pairs]

    def corner_velocities(self, tip: TipMotion) -> Array:
        """(c, 3, K) in sensor axes [m/s]"""
        turning = cross(tip.angular_velocity[:, None], self._ways)
        return tip.velocity + turning.swapaxes(0, 1)

    def corner_slopes(self, by: Array) -> tuple[Array, Array]:
        """Derivatives (3, K) by velocity and angular velocity of what has those `by`
        (c, 3, K) by the velocities of the corners."""
        return by.sum(axis=0), cross(self._ways, by.swapaxes(0, 1)).sum(axis=1)

    def corner_shares(self, velocities: Array) -> Array:
        """(c, K) speeds of the corners over the limit."""
        return np.sqrt((velocities**2).sum(axis=1)) / self.limits.corner_speed

    def wrench_shares(self, x: Array) -> Array:
        """(6, K) signed shares of the sensor's range that the body is expected to use,
        for features (12, K)."""
        return expected_wrench(x, self.body) / self.wrench_range[:, None]

    @property
    def wrench_range(self) -> Array:
        """(6,) infinite where there is none"""
        own = self.limits
        return np.repeat([own.force or np.inf, own.torque or np.inf], 3)

    @property
    def has_wrench_range(self) -> bool:
        """Whether the sensor has a range."""
        return bool(np.isfinite(self.wrench_range).any())

    def clearances(self, tip: TipMotion) -> Array:
        """(p, c, K) [m] of the corners from the half-spaces, beyond the margin."""
        normals = np.einsum("pj,jik->pik", self.normals, tip.rotation)
        along = np.einsum("pik,ci->pck", normals, self.corners)
        return (
            along + (self.normals @ tip.position)[:, None] - self.offsets[:, None, None]
        )

    def clearance_slopes(self, tip: TipMotion, by: Array) -> tuple[Array, Array]:
        """Derivatives (3, K) by shifts and turns of the tip of what has those `by` (p,
        c, K) by the clearances."""
        normals = np.einsum("pj,jik->pik", self.normals, tip.rotation)
        push = np.einsum("pck,pik->cik", by, normals)
        return self.corner_slopes(push)
