"""A hammer, its shape, and noisy samples of an arm that wields it."""

from functools import cache

from hefting.core.measurements import NOISE_LEVELS, Measurements, Noise
from hefting.estimators.bayes import projection
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


def counted_lengths(monkeypatch) -> list[int]:
    """One number: the steps of Newton's method to nearest bodies, from here on."""
    steps, best = [0], projection._length

    def length(*arguments):
        steps[0] += 1
        return best(*arguments)

    monkeypatch.setattr(projection, "_length", length)
    return steps
