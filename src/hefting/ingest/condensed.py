"""Sums over the samples of a recording: `Condensed`, all that is needed of the samples
once they are understood, and `Excitation`, how the motion excites the parameters.

`Condensed` can replace the samples. It has a few tens of kilobytes: only the number of
time scales grows, with the logarithm of the number of samples.
"""

from collections.abc import Mapping, Sequence
from dataclasses import field, replace
from typing import Any, Self

import numpy as np

from hefting.core.measurements import Measurements, MotionNoise
from hefting.core.moments import Moments, triangular
from hefting.core.regressor import FULL_MAP, GRAVITY, MOTION, WRENCH
from hefting.core.spatial import Array, immutable
from hefting.estimators.sample_state import SampleState

ANGULAR_ACCELERATION = slice(3, 6)
FORCE = slice(15, 18)
"""Column slices of the features, see `hefting.core.regressor`."""


@immutable
class Excitation:
    """Moments of the features, and of gravity's directions in sensor axes."""

    moments: Moments
    """of the features of all samples"""
    directions: Array
    """(4, 4) triangular factor of [direction of gravity | 1], by weight"""
    angular_noise: float = 0.0
    """[rad/s²] standard deviation of the angular acceleration; 0 where unknown"""

    @classmethod
    def of(cls, measurements: Measurements) -> Self:
        """From samples."""
        z = measurements
        known = 0.0 if z.noise is None else z.noise.angular_acceleration
        return cls(Moments.of(z), directions_of(z), known)

    @classmethod
    def of_all(cls, each: Sequence[Self], moments: Moments) -> Self:
        """That of several recordings, whose common moments are `moments`."""
        rows = triangular(np.concatenate([one.directions for one in each]))
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
        """Whether gravity is not zero throughout."""
        return bool(self.moments.factor[:, GRAVITY].any())

    @property
    def angular_acceleration(self) -> Array:
        """(22, 3) virtual samples whose sum of squares is the weighted mean square of
        the angular acceleration [rad²/s⁴]."""
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
        """(4, 3) virtual samples whose sum of squares is the mean square of gravity's
        direction or, with `mean`, its variance."""
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


FULL = ("full",)
"""`Estimator.sampling` of methods that use the full model only."""


@immutable
class Condensed:
    """Sums over the measurements of one recording."""

    rows: int
    """number of measurements"""
    samples: float
    """number of samples of the log, which are averaged in the measurements"""
    span: float
    """[s] from the first to the last"""
    motion_noise: MotionNoise | None
    """errors of the accelerations, where known"""
    wrench_square: Array
    """(2,) sum of squares of force [N²] and torque [N² m²]"""
    counted: Moments
    """moments in which each measurement weighs as many samples as it averages"""
    directions: Array
    """(4, 4) of gravity, see `hefting.ingest.condensed.Excitation`"""
    states: Mapping[tuple[Any, ...], SampleState] = field(default_factory=dict)
    """what an estimator has seen, by its `sampling`, with a time record; that of the
    full model is always there"""

    @classmethod
    def of(cls, measurements: Measurements, counts: Array) -> Self:
        """From measurements, each the average of `counts` (K,) samples."""
        z = measurements
        square = np.sum(z.wrench.reshape(-1, 2, 3) ** 2, axis=(0, 2))
        return cls(
            len(z),
            float(counts.sum()),
            float(np.ptp(z.time)) if len(z) else 0.0,
            z.motion_noise,
            square,
            Moments.of(replace(z, weights=counts)),
            directions_of(z),
            {FULL: SampleState.empty(with_record=True).fold(z)},
        )

    @property
    def state(self) -> SampleState:
        """State of the full model, with a time record."""
        return self.states[FULL]

    def weighed(self, weight: float) -> Self:
        """These sums with every weight multiplied by `weight`."""
        states = {key: state.scaled(weight) for key, state in self.states.items()}
        directions = weight**0.5 * self.directions
        return replace(self, directions=directions, states=states)

    def residual_square(self, vector: Array, bias: Array | None) -> Array:
        """(6,) mean square of the residuals [N², N² m²], weighed by counts, for
        parameters (10,) and a bias (6,) [N, N m]."""
        factor = self.counted.factor
        effect = FULL_MAP.reshape(-1, 10) @ np.asarray(vector, dtype=float)
        left = factor[:, WRENCH] - factor[:, MOTION] @ effect.reshape(12, 6)
        if bias is not None:
            left = left - np.outer(self.counted.ones, bias)
        return np.sum(left**2, axis=0) / max(self.samples, 1e-300)
