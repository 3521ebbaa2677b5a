"""Condensed: what is needed of a recording's samples once it was understood, as sums
over them.

It takes the place of the samples where these are let go, and is a few tens of kilobytes
however many they are: only the number of time scales grows, with their logarithm.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any, Self

import numpy as np

from hefting.core.measurements import Measurements, MotionNoise
from hefting.core.moments import Moments
from hefting.core.regressor import FULL_MAP, MOTION, WRENCH
from hefting.core.spatial import Array
from hefting.estimators.sample_state import SampleState
from hefting.ingest.excitation import directions_of

FULL = ("full",)
"""`Estimator.sampling` of the methods that know the full model alone."""


@dataclass(frozen=True, eq=False)
class Condensed:
    """Sums over the measurements of one recording."""

    rows: int
    """number of measurements"""
    samples: float
    """number of samples of the log that are averaged in these"""
    span: float
    """[s] from the first to the last"""
    motion_noise: MotionNoise | None
    """errors of the accelerations, where known"""
    wrench_square: Array
    """(2,) sum of squares of force [N²] and torque [N² m²]"""
    counted: Moments
    """each measurement weighs by its number of samples"""
    directions: Array
    """(4, 4) of gravity, see `hefting.ingest.excitation.Excitation`"""
    states: Mapping[tuple[Any, ...], SampleState] = field(default_factory=dict)
    """what methods see, by their `sampling`, with a record of time; the full model's is
    always there"""

    @classmethod
    def of(cls, measurements: Measurements, counts: Array) -> Self:
        """Of measurements, in each of which so many samples `counts` (K,) are
        averaged."""
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
        """That of the full model, with a record of time."""
        return self.states[FULL]

    def weighed(self, weight: float) -> Self:
        """The same with so many times the weight of each measurement."""
        states = {key: state.scaled(weight) for key, state in self.states.items()}
        directions = weight**0.5 * self.directions
        return replace(self, directions=directions, states=states)

    def residual_square(self, vector: Array, bias: Array | None) -> Array:
        """(6,) mean square of the residuals [N², N² m²] of the measurements, by their
        number of samples, for parameters (10,) and a bias (6,) [N, N m]."""
        factor = self.counted.factor
        effect = FULL_MAP.reshape(-1, 10) @ np.asarray(vector, dtype=float)
        left = factor[:, WRENCH] - factor[:, MOTION] @ effect.reshape(12, 6)
        if bias is not None:
            left = left - np.outer(self.counted.ones, bias)
        return np.sum(left**2, axis=0) / max(self.samples, 1e-300)
