"""Central intervals of mixtures of Gaussians."""

from functools import lru_cache
from math import erfc, exp, pi

import numpy as np

from hefting.core.spatial import Array

MOST_STEPS = 60
"""Largest number of Newton steps in finding an end."""
TOLERANCE = 0.02
"""Relative error of a tail's probability from which on one step more leaves, of a
Gaussian, some 2e-5 of its standard deviation."""


def mixture_ends(means: Array, stds: Array, weights: Array, tail: float) -> Array:
    """(2, k) ends of k mixtures of Gaussians, beyond each of which is the probability
    `tail`, less than one half.

    `means` and `stds` are (j, k), `weights` (j,). Newton's method with bisection, for
    the logarithm of the probability, which is nearly linear. The upper end is the lower
    one of the mirrored mixture.
    """
    center = np.array((means.T, -means.T))  # (2, k, j)
    width = np.ascontiguousarray(stds.T)
    rate = 1.0 / width
    density = (0.5 / np.pi) ** 0.5 * rate * weights
    each = center + normal_quantile(tail) * width
    low, high, x = each.min(axis=2), each.max(axis=2), each @ weights
    for _ in range(MOST_STEPS):
        t = (x[:, :, None] - center) * rate
        bell = np.exp(-0.5 * t * t)
        below = np.maximum(normal_cdf(t, bell) @ weights, 1e-300)
        slope = np.maximum((bell * density).sum(axis=2), 1e-300)
        off = np.log(below / tail)
        low, high = np.where(off < 0.0, x, low), np.where(off < 0.0, high, x)
        new = x - off * below / slope
        new = np.where((new >= low) & (new <= high), new, 0.5 * (low + high))
        done = (np.abs(off) <= TOLERANCE) | (new == x)
        x = new
        if done.all():
            break
    x[1] *= -1.0
    return x


def normal_cdf(t: Array, bell: Array) -> Array:
    """Probability that a standard normal number is below t, `bell` being exp(-t²/2);
    within 7.5e-8 (Abramowitz & Stegun 26.2.17). SciPy's takes a tenth of a second to
    import."""
    k = 1.0 / (1.0 + 0.2316419 * np.abs(t))
    tail = k * (
        0.319381530
        + k * (-0.356563782 + k * (1.781477937 + k * (-1.821255978 + k * 1.330274429)))
    )
    tail *= bell * (0.5 / np.pi) ** 0.5
    return np.asarray(np.where(t < 0.0, tail, 1.0 - tail), dtype=float)


@lru_cache
def normal_quantile(probability: float) -> float:
    """Quantile of the standard normal distribution, to rounding, by Newton's method."""
    x = 0.0
    for _ in range(MOST_STEPS):
        error = 0.5 * erfc(-x / 2.0**0.5) - probability
        step = error * (2.0 * pi) ** 0.5 * exp(0.5 * x * x)
        x -= min(max(step, -0.5), 0.5)
        if abs(step) < 1e-12:
            break
    return x
