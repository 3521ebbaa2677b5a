"""White noise in accelerations of which nothing is said, by differences of consecutive
samples.

Motion is slow, so that third and fourth differences are of noise: of white noise both
give the same level. Noise that grows towards high frequencies, as that of numerical
differentiation, does nearly so too, but changes less from one pair of samples to the
next.

What is kept of the samples are sums within blocks of consecutive ones: they do not
depend on how samples arrive, and those of several records add up.
"""

import numpy as np

from hefting.core.measurements import MotionNoise
from hefting.core.regressor import ONE
from hefting.core.spatial import Array

FEWEST_DIFFERENCES = 50
"""Number of differences from which on levels are compared."""
LARGEST_LEVEL_DIFFERENCE = 0.2
"""Largest relative difference of the levels of two orders for white noise: with 150
samples chance makes 4 %, motion makes much more."""
SMALLEST_PAIR_CHANGE = 0.7
"""Variance of changes between pairs, over that of white noise of the level found, below
which noise is not white: it is 0.42 of a derivative of white noise, 0.23 of a second
one."""
SMALLEST_LEVEL = 1e-4
"""Level of noise over the root mean square of the accelerations below which it is
rounding."""

NO_ROUGHNESS = np.zeros((4, 3))
"""`roughness` of no samples."""


def roughness(blocks: Array) -> Array:
    """Sums over features (b, k, 22) of blocks of consecutive samples.

    Returns
    -------
    Array
        (4, 3) of fourth differences, third ones, changes between pairs, and samples:
        their number, and the squares of their linear [m²/s⁴] and of their angular
        [rad²/s⁴] accelerations per axis. Differences are scaled as to make no
        difference to the variance of white noise.
    """
    weights = blocks[:, :, ONE]
    if not weights.all():
        return NO_ROUGHNESS  # samples that are left out are no neighbours
    x = blocks[:, :, :6] / weights[:, :, None]
    third = np.diff(x, 3, axis=1)
    pairs = x[:, :-3] + x[:, 1:-2] - x[:, 2:-1] - x[:, 3:]
    found = (np.diff(third, axis=1) / 70.0**0.5, third / 20.0**0.5, 0.5 * pairs, x)
    return np.array([_sums(each) for each in found])


def white_noise_of(sums: Array) -> MotionNoise | None:
    """White noise of the accelerations by their `roughness` (4, 3); None where none is
    found."""
    number = sums[:, :1]
    if number.min() < FEWEST_DIFFERENCES:
        return None
    fourth, third, pairs, whole = np.sqrt(sums[:, 1:] / number)
    white = (
        (np.abs(third - fourth) < LARGEST_LEVEL_DIFFERENCE * fourth)
        & (pairs > SMALLEST_PAIR_CHANGE**0.5 * fourth)
        & (fourth > SMALLEST_LEVEL * whole)
    )
    linear, angular = np.where(white, fourth, 0.0)
    return MotionNoise(float(linear), float(angular)) if white.any() else None


def _sums(x: Array) -> Array:
    """(3,) number of rows of x (b, k, 6), and mean squares over three axes, summed."""
    squares = np.einsum("bki,bki->i", x, x).reshape(2, 3).sum(axis=1) / 3.0
    return np.array((float(x.shape[0] * x.shape[1]), *squares))
