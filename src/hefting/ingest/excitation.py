"""Excitation: what a motion can tell of a body, and what it felt, as sums over its
samples: where gravity pointed, about which axes the sensor was accelerated."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import reduce
from typing import Self

import numpy as np

from hefting.core.measurements import Measurements
from hefting.core.moments import Moments, triangular
from hefting.core.regressor import GRAVITY
from hefting.core.spatial import Array

ANGULAR_ACCELERATION = slice(3, 6)
FORCE = slice(15, 18)
"""Columns of the features, see `hefting.core.regressor`."""


@dataclass(frozen=True, eq=False)
class Excitation:
    """Moments of the samples, and of the directions of gravity in sensor axes."""

    moments: Moments
    """of the features, as of one recording"""
    directions: Array
    """(4, 4) triangular factor of [direction of gravity | 1], by weight"""
    angular_noise: float = 0.0
    """[rad/s²] standard deviation of the angular acceleration, where it is known"""

    @classmethod
    def of(cls, measurements: Measurements, moments: Moments | None = None) -> Self:
        """Of samples; their `moments`, where they are known."""
        z = measurements
        known = 0.0 if z.noise is None else z.noise.angular_acceleration
        moments = Moments.of(z) if moments is None else moments
        return cls(moments, directions_of(z), known)

    @classmethod
    def of_all(cls, each: Sequence[Self], moments: Moments) -> Self:
        """Of several recordings; `moments` are those of all together."""
        rows = reduce(_stacked, [one.directions for one in each])
        return cls(moments, rows, max(one.angular_noise for one in each))

    @property
    def samples(self) -> int:
        """Number of samples."""
        return self.moments.samples

    @property
    def weight(self) -> float:
        """Sum of the samples' weights."""
        return max(float(np.sum(self.moments.ones**2)), 1e-300)

    @property
    def has_gravity(self) -> bool:
        """Whether there is any gravity."""
        return bool(self.moments.factor[:, GRAVITY].any())

    @property
    def angular_acceleration(self) -> Array:
        """(22, 3) virtual samples whose squares add up to the mean square of the
        angular acceleration [rad²/s⁴], by weight."""
        rows = self.moments.factor[:, ANGULAR_ACCELERATION]
        return rows / np.sqrt(self.weight)

    @property
    def force(self) -> float:
        """Root-mean-square force [N]."""
        return self._rms(self.moments.factor[:, FORCE])

    @property
    def gravity(self) -> float:
        """Root-mean-square gravity [m/s²]."""
        return self._rms(self.moments.factor[:, GRAVITY])

    def directions_about(self, mean: bool) -> Array:
        """(4, 3) virtual samples whose squares add up to the mean square of gravity's
        direction or, with `mean`, of its deviation from the mean."""
        ones, rows = self.directions[:, 3], self.directions[:, :3]
        weight = max(float(ones @ ones), 1e-300)
        if mean:
            rows = rows - np.outer(ones, ones @ rows / weight)
        return rows / np.sqrt(weight)

    def _rms(self, rows: Array) -> float:
        return float(np.sqrt(np.sum(rows**2) / self.weight))


def directions_of(measurements: Measurements) -> Array:
    """(4, 4) triangular factor of [direction of gravity | 1] of samples, by weight."""
    z = measurements
    size = np.linalg.norm(z.gravity, axis=1, keepdims=True)
    rows = np.column_stack((z.gravity / np.maximum(size, 1e-300), np.ones(len(z))))
    if z.weights is not None:
        rows *= np.sqrt(z.weights)[:, None]
    return triangular(rows)


def _stacked(first: Array, second: Array) -> Array:
    return triangular(np.concatenate((first, second)))
