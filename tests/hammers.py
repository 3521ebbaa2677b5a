"""A hammer, its shape, and noisy samples of an arm that wields it."""

from functools import cache

from hefting.core.measurements import NOISE_LEVELS, Measurements, Noise
from hefting.shapes import Shape
from hefting.simulation import UR5, hammer, sinusoids, wield

NOISE = NOISE_LEVELS["moderate"]


@cache
def shape() -> Shape:
    return Shape.from_mesh(hammer().mesh(), points=56)


@cache
def exact(samples: int = 1000, speed: float = 1.5) -> Measurements:
    return wield(
        UR5.motion(sinusoids(samples / 100.0, 100.0, speed)), hammer().parameters
    )


def noisy(seed: int, samples: int = 1000, noise: Noise = NOISE) -> Measurements:
    return exact(samples).with_noise(noise, seed)
