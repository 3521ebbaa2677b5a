"""Random motions to start from: Fourier series at rest at both ends."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from hefting.core.spatial import Array
from hefting.planning.problem import Basis, Problem

HIGHEST = 1.2
"""[Hz] of a random motion's terms at most."""
FILLED = 0.004
"""Share of the nearest limit that a motion may leave."""
MOST_SHRINKS = 25
"""Times that a motion is shrunk or grown towards its limits."""
SMALLEST = 1e-6
"""Share of a motion below which nothing is left of it."""


def random_ways(
    rng: np.random.Generator, time: Array, joints: int, terms: int, decay: float
) -> Array:
    """(K, n) ways of the joints from the start, of no unit: sum_k a_k (cos k w t - 1) +
    b_k sin k w t, with w one turn over the whole time, velocity and acceleration zero at
    both ends, and amplitudes falling with k to the power of `decay`."""
    k = np.arange(1, terms + 1)
    a, b = rng.normal(size=(2, terms, joints)) * (k**-decay)[:, None]
    a -= np.outer(k**2, k**2 @ a) / float(k**2 @ k**2)
    b -= np.outer(k, k @ b) / float(k @ k)
    angle = 2.0 * np.pi / time[-1] * np.outer(time, k)
    return (np.cos(angle) - 1.0) @ a + np.sin(angle) @ b


def random_motion(problem: Problem, rng: np.random.Generator) -> Array:
    """Free control points (P, n) of a random motion that fills its limits, on the
    optimisation's grid."""
    most = max(int(HIGHEST * problem.duration), 3)
    terms, decay = int(rng.integers(3, most + 1)), rng.uniform(0.0, 1.5)
    time = np.linspace(0.0, problem.duration, problem.basis.values.shape[1])
    ways = random_ways(rng, time, len(problem.start), terms, decay)
    ways *= np.exp(rng.normal(size=len(problem.start)))
    return filled(problem, fitted(problem.basis, ways))


def fitted(basis: Basis, ways: Array) -> Array:
    """Free control points (P, n) of the spline nearest to ways (K, n) on the grid."""
    return np.linalg.lstsq(basis.values[0], ways, rcond=None)[0]


def filled(problem: Problem, x: Array) -> Array:
    """The motion with all its ways multiplied by one number, so that it just keeps the
    limits on the grid."""
    x = x / max(float(np.abs(x).max()), 1e-12)
    return fill_share(lambda scale: largest_share(problem, scale * x)) * x


def fill_share(used: Callable[[float], float], first: float = 0.3) -> float:
    """Largest number found by which a motion may be multiplied, if `used` is the
    largest share of a limit then; that is nearly proportional to it."""
    low, high, scale = 0.0, np.inf, first
    for _ in range(MOST_SHRINKS):
        share = used(scale)
        if share <= 1.0:
            low = scale
        else:
            high = scale
        if (low and share > 1.0 - FILLED) or high < SMALLEST:
            break
        guess = scale * (1.0 - 0.5 * FILLED) / max(share, 0.2)
        scale = guess if low < guess < high else 0.5 * (low + high)
    return low


def largest_share(problem: Problem, x: Array) -> float:
    """Largest share of any limit that a motion uses on the grid."""
    excesses = problem.look(x).excesses()
    return 1.0 + max(float(g.max()) for g in excesses.values())
