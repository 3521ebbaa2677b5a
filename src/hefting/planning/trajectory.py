"""Joint trajectories that start and end at rest: B-splines of degree five."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike
from scipy.interpolate import BSpline

from hefting.core.spatial import Array, frozen
from hefting.robots.joint_motion import JointMotion

DEGREE = 5
AT_REST = 3
"""Equal control points at each end."""


def knots_of(duration: float, pieces: int) -> Array:
    """Of so many equal polynomial pieces over `duration` [s]."""
    inner = np.linspace(0.0, duration, pieces + 1)
    return np.concatenate((np.zeros(DEGREE), inner, np.full(DEGREE, duration)))


@dataclass(frozen=True, eq=False)
class Trajectory:
    """q(t) = sum_i B_i(t) c_i, three times continuously differentiable and more."""

    knots: Array
    """(m + 6,) [s]"""
    points: Array
    """(m, n) control points [rad]; the first three are equal, and the last three"""

    def __post_init__(self):
        object.__setattr__(self, "knots", frozen(self.knots))
        object.__setattr__(self, "points", frozen(self.points))

    @property
    def duration(self) -> float:
        """[s]"""
        return float(self.knots[-1])

    @property
    def start(self) -> Array:
        """(n,) [rad]"""
        return self.points[0]

    @cached_property
    def _derivatives(self) -> tuple[BSpline, ...]:
        own = BSpline(self.knots, self.points, DEGREE)
        return tuple(own.derivative(k) if k else own for k in range(4))

    def at(self, time: ArrayLike) -> JointMotion:
        """At instants (K,) [s]; at rest before the start and after the end."""
        t = np.asarray(time, dtype=float)
        inside = np.clip(t, 0.0, self.duration)
        q, v, a = (each(inside) for each in self._derivatives[:3])
        return JointMotion(t, q, v, a)

    def jerk(self, time: ArrayLike) -> Array:
        """(K, n) [rad/s³]"""
        return self._derivatives[3](np.asarray(time, dtype=float))

    def sampled(self, rate: float) -> JointMotion:
        """At `rate` [Hz], start and end among the samples."""
        count = max(round(self.duration * rate), 1)
        return self.at(np.linspace(0.0, self.duration, count + 1))
