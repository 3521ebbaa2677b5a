"""Errors of the motion in the likelihood: variances of the accelerations, and over how
many samples the errors are correlated."""

from dataclasses import dataclass
from typing import Self

import numpy as np

from hefting.core.measurements import MotionNoise
from hefting.core.spatial import Array
from hefting.estimators.joint_state import State


@dataclass(frozen=True, eq=False)
class MotionErrors:
    """Errors of the accelerations."""

    variances: Array | None
    """(6,) Linear [m²/s⁴] and angular [rad²/s⁴]; None if the motion is exact."""
    memory: float
    """Number of samples over which the errors are correlated, at least 1."""

    @classmethod
    def of(cls, noise: MotionNoise | None, state: State) -> Self:
        """Errors for the samples of a state, at their mean interval."""
        if noise is None or not (noise.linear or noise.angular):
            return cls(None, 1.0)
        step = state.duration / max(state.samples - 1, 1)
        memory = max(noise.memory / step, 1.0) if step > 0.0 else 1.0
        return cls(np.repeat((noise.linear**2, noise.angular**2), 3), memory)

    @property
    def white(self) -> Array | None:
        """(6,) Variances of white errors; None if the errors are correlated in time,
        which are treated as independent of the motion."""
        return self.variances if self.memory == 1.0 else None
