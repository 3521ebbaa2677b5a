"""One stream that is estimated while it comes, until that is good enough."""

from dataclasses import dataclass

import numpy as np

from benchmarks.bodies import Body
from benchmarks.calibration_runs import LEVELS, RATE, motions
from hefting.core.accuracy import Accuracy
from hefting.core.measurements import NOISE_LEVELS
from hefting.core.spatial import Array
from hefting.estimators import Bayes
from hefting.simulation import wield

EVERY = 10
"""Samples from one estimate to the next."""
MOTIONS = ("sinusoids", "random", "stop and go")
"""Three each of `motions`."""


@dataclass(frozen=True, eq=False)
class Stop:
    """When a stream ended, and whether what was promised holds."""

    kind: str
    level: str
    motion: str
    time: float | None
    """s; None where it never was good enough"""
    held: Array
    """(3,) booleans: mass, COM, inertia"""


def streamed(body: Body, until: str, seed: tuple[int, ...]) -> Stop:
    """Wield a body until the accuracy is reached, for at most ten seconds."""
    rng = np.random.default_rng(seed)
    chosen = int(rng.integers(len(motions())))
    level = LEVELS[rng.integers(len(LEVELS))]
    z = wield(motions()[chosen], body.parameters).with_noise(NOISE_LEVELS[level], seed)
    estimator = Bayes(body.shape, noise=NOISE_LEVELS[level], until=until)
    asked = estimator.until
    assert isinstance(asked, Accuracy)
    state, estimate = estimator.start(), None
    for first in range(0, len(z), EVERY):
        state = estimator.update(state, z[first : first + EVERY])
        estimate = estimator.estimate(state, start=estimate)
        if estimate.sufficient:
            break
    assert estimate is not None
    truth = body.parameters
    # one draw, the truth
    errors = Accuracy.of_draws(truth.vector[None], estimate.parameters, 0.5)
    limits = (asked.mass, asked.center_of_mass, asked.inertia)
    found = (errors.mass, errors.center_of_mass, errors.inertia)
    held = np.array(
        [
            limit is None or (error or 0.0) <= limit
            for limit, error in zip(limits, found, strict=True)
        ]
    )
    time = first / RATE + EVERY / RATE if estimate.sufficient else None
    return Stop(body.kind, level, MOTIONS[chosen // 3], time, held)
