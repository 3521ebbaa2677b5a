"""What a user gives, right or with a mistake, and the case that rival explanations of it
are judged by."""

from functools import cache
from typing import Any

import numpy as np
from benchmarks.given import Given, Mistake
from benchmarks.mistaken import mistakes
from scipy.signal import lfilter

from benchmarks import given as benchmark
from hefting.core.spatial import STANDARD_GRAVITY
from hefting.ingest.path import path_of
from hefting.ingest.rivals import UNDONE
from hefting.ingest.rivals.case import Case


def case_of(given: Given, offset: float = 0.0) -> Case:
    """The case of what a user gave, on a recording whose clocks agree."""
    path = path_of(given.recording)
    assert path is not None
    gravity = np.array(given.options.get("gravity", STANDARD_GRAVITY), dtype=float)
    biased = "bias" not in given.options
    return Case.of(given.recording, path, gravity, offset, biased=biased)


@cache
def correct(seed: int, noise: str = "moderate", imu: bool = False) -> Given:
    """The benchmark's recording without a mistake."""
    return benchmark.correct(seed, imu, noise)


def mistake(name: str, strength: str) -> Mistake:
    """One of the benchmark's."""
    (found,) = (
        m
        for m in mistakes()
        if (m.name, m.strength.split(" of ")[0]) == (name, strength)
    )
    return found


def undone_of(*undone: Any) -> list[tuple[Any, Any]]:
    """Of the mistakes that are undone where two at once are looked for, these."""
    return [each for each in UNDONE if each[0] in undone]


def with_coloured_noise(given: Given, newtons: float) -> Given:
    """Besides, of 30 ms correlation, and of as many N m as a sensor of 5 cm radius has."""
    noise = np.random.default_rng(5).normal(size=(1200, 6))
    keep = np.exp(-0.01 / 0.03)
    noise = lfilter([(1.0 - keep**2) ** 0.5], [1.0, -keep], noise, axis=0)[200:]
    size = newtons * np.repeat((1.0, 0.05), 3)
    return given.wrench(lambda _, w: w + noise * size)
