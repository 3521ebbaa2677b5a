"""Contacts as limits: how clear the links and the object are of each other and of the
walls, linear about a motion."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol, Self

import numpy as np

from hefting.core.spatial import Array

NEAR = 0.05
"""[m] Clearances below are followed; what is farther does not get near in one round."""
STEP = 1e-3
"""[rad] of the differences that tell how clearances change."""


class Clear(Protocol):
    """What tells clearances."""

    def clearance(self, q: Array) -> Array: ...


@dataclass(frozen=True, eq=False)
class Cuts:
    """Clearances on a grid of K instants, linear in the joint positions."""

    position: Array
    """(K, n) at which they were found [rad]"""
    clearance: Array
    """(K,) [m]"""
    slope: Array
    """(K, n) [m/rad]; zero where all is far"""

    @classmethod
    def of(cls, space: Clear, position: Array) -> Self:
        """About joint positions (K, n)."""
        clearance = space.clearance(position)
        slope = np.zeros_like(position)
        near = np.flatnonzero(clearance < NEAR)
        if len(near):
            n = position.shape[1]
            steps = STEP * np.concatenate((np.eye(n), -np.eye(n)))
            moved = position[near, None] + steps
            own = space.clearance(moved.reshape(-1, n)).reshape(len(near), 2, n)
            slope[near] = (own[:, 0] - own[:, 1]) / (2.0 * STEP)
        return cls(position, clearance, slope)

    def at(self, position: Array) -> Array:
        """(K,) clearances at joint positions (K, n)."""
        return self.clearance + ((position - self.position) * self.slope).sum(axis=1)
