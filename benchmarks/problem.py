"""The problem of all benchmarks: a hammer moved by the paper's sinusoids, with moderate
noise."""

from functools import cache

from hefting import NOISE_LEVELS, Measurements
from hefting.simulation import UR5, hammer, sinusoids, wield

try:
    from hefting import Shape
except ImportError:  # the code before
    from hefting import PointMasses as Shape

RATE = 100.0
"""Samples a second: 150 of them are the paper's 1.5 s, 3,500 its whole motion."""


@cache
def wielded(samples: int) -> Measurements:
    """So many samples of the motion."""
    motion = UR5.motion(sinusoids(samples / RATE, RATE, angular_speed=1.0))
    return wield(motion, hammer().parameters).with_noise(
        NOISE_LEVELS["moderate"], seed=1
    )


@cache
def shape(points: int) -> Shape:
    """About so many points inside the hammer."""
    return Shape.from_mesh(hammer().mesh(), points=points)
