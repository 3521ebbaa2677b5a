"""Errors of the motion as the likelihood takes them: variances of accelerations, and
how many samples they last."""

from dataclasses import dataclass
from typing import Self

import numpy as np

from hefting.core.measurements import MotionNoise
from hefting.core.spatial import Array
from hefting.estimators.sample_state import SampleState


@dataclass(frozen=True, eq=False)
class MotionErrors:
    """Errors of the accelerations."""

    variances: Array | None
    """(6,) linear [m²/s⁴] and angular [rad²/s⁴]; None where the motion is exact"""
    memory: float
    """samples over which they last, at least 1"""

    @classmethod
    def of(cls, noise: MotionNoise | None, state: SampleState) -> Self:
        """Of the samples of a state."""
        if noise is None or not (noise.linear or noise.angular):
            return cls(None, 1.0)
        step = state.duration / max(state.samples - 1, 1)
        memory = max(noise.memory / step, 1.0) if step > 0.0 else 1.0
        return cls(np.repeat((noise.linear**2, noise.angular**2), 3), memory)

    @property
    def white(self) -> Array | None:
        """(6,) variances of white errors; None where they last, and so count as
        independent of the motion."""
        return self.variances if self.memory == 1.0 else None
