"""White noise in accelerations of which nothing is said, by differences of consecutive
samples.

Motion is slow, so that third and fourth differences are of noise: of white noise both
give the same level. Noise that grows towards high frequencies, as that of numerical
differentiation, does nearly so too, but changes less from one pair of samples to the
next.

What is kept of the samples are sums within blocks of consecutive ones: they do not
depend on how samples arrive, and those of several records add up.
"""

from math import comb

import numpy as np

from hefting.core.measurements import Measurements, MotionNoise, Noise
from hefting.core.regressor import ONE
from hefting.core.spatial import Array, median

FEWEST_DIFFERENCES = 50
"""Least number of differences for levels to be compared."""
LARGEST_LEVEL_DIFFERENCE = 0.2
"""Largest relative difference of the levels of two orders for white noise: by chance 4
% with 150 samples, by motion much more."""
SMALLEST_PAIR_CHANGE = 0.7
"""Variance of changes between pairs over that of white noise of the same level, below
which noise is not white: it is 0.42 for first differences of white noise, 0.23 for
second ones."""
SMALLEST_LEVEL = 0.01
"""Level of noise over the standard deviation of the accelerations below which it is
negligible: it reduces an inertia by a ten thousandth."""
ROUNDING = 1e-4
"""The same below which noise is rounding, if that of the other kind of acceleration is
larger."""
LARGEST_RATIO_OF_AXES = 10.0
"""Largest ratio of the mean noise variance of three axes to that of one, as errors of
the motion are taken to be alike along all axes."""
LARGEST_SHARE = 0.5
"""Share of the accelerations' variance above which apparent noise may be the motion of
samples that are not consecutive in time."""

LARGEST_KURTOSIS = 9.0
"""Kurtosis of the differences (3 for Gaussian noise) above which the accelerations
jump, as at the corners of trapezoids."""
NO_ROUGHNESS = np.zeros((6, 7))
"""`roughness` without samples."""


def roughness(blocks: Array) -> Array:
    """Sums over features (b, k, 22) of blocks of consecutive samples.

    Returns
    -------
    Array
        (6, 7) The number, and squares by axis of the linear [m²/s⁴] and angular
        [rad²/s⁴] accelerations: of fourth differences, third ones, changes between
        pairs, and the samples themselves; then their number and plain sums; last, that
        of fourth differences and their fourth powers. Differences are scaled so that
        white noise keeps its variance.
    """
    # samples that are left out are no neighbours
    blocks = blocks[blocks[:, :, ONE].all(axis=1)]
    x = blocks[:, :, :6] / blocks[:, :, ONE:]
    third = np.diff(x, 3, axis=1)
    pairs = x[:, :-3] + x[:, 1:-2] - x[:, 2:-1] - x[:, 3:]
    sums = np.empty(NO_ROUGHNESS.shape)
    scaled = np.diff(third, axis=1) / 70.0**0.5, third / 20.0**0.5, 0.5 * pairs, x
    for row, each in zip(sums[:4], scaled, strict=True):
        row[0] = each.shape[0] * each.shape[1]
        row[1:] = np.einsum("bki,bki->i", each, each)
    sums[4, 0], sums[4, 1:] = sums[3, 0], x.sum(axis=(0, 1))
    sums[5, 0], sums[5, 1:] = sums[0, 0], (scaled[0] ** 4).sum(axis=(0, 1))
    return sums


def white_noise_of(sums: Array) -> MotionNoise | None:
    """White noise of the accelerations from their `roughness` (6, 7).

    None if none is found, if it would be most of the accelerations, is along some axes
    only or comes in jumps, or if the noise of either kind of acceleration is coloured:
    intervals that allow for the other kind alone are too narrow.
    """
    if sums[:, 0].min() < FEWEST_DIFFERENCES:
        return None
    mean = sums[:, 1:] / sums[:, :1]
    mean[3] -= mean[4] ** 2
    axes = mean[:4].reshape(4, 2, 3)
    fourth, third, pairs, whole = axes.mean(axis=2)
    fourth = np.maximum(fourth, 1e-300)
    noisy = (np.abs((third / fourth) ** 0.5 - 1.0) < LARGEST_LEVEL_DIFFERENCE) & (
        fourth > ROUNDING**2 * whole
    )
    fourth_powers = mean[5].reshape(2, 3).mean(axis=1)
    kurtosis = fourth_powers / np.maximum(np.square(axes[0]).mean(axis=1), 1e-300)
    unclear = (
        (kurtosis > LARGEST_KURTOSIS)
        | (pairs < SMALLEST_PAIR_CHANGE * fourth)
        | (fourth > LARGEST_SHARE * whole)
        | (fourth > LARGEST_RATIO_OF_AXES * axes[0].min(axis=1))
    )
    matters = noisy & (fourth > SMALLEST_LEVEL**2 * whole)
    if not matters.any() or (noisy & unclear).any():
        return None
    linear, angular = np.where(noisy, fourth, 0.0) ** 0.5
    return MotionNoise(float(linear), float(angular))


DIFFERENCE_ORDER = 4
"""Order of the differences. They attenuate motion at a tenth of the sampling rate 57
times, by (2 sin 18°)^4 / sqrt(70)."""
FEWEST_SAMPLES_FOR_ORDERS = 50
"""Number of samples below which the levels of two orders are not compared."""


def white_noise(measurements: Measurements) -> Noise:
    """Levels of white noise in wrench and accelerations, from the median absolute
    fourth differences in time.

    The samples are in order of time and much faster than the motion. Noise that is
    correlated over several samples contributes little. Zero for fewer than five
    samples.
    """
    z = measurements
    return Noise(
        *(
            _level(v)
            for v in (z.force, z.torque, z.linear_acceleration, z.angular_acceleration)
        )
    )


def white_motion_noise(measurements: Measurements) -> MotionNoise | None:
    """White noise of linear [m/s²] and angular [rad/s²] acceleration; None unless
    differences of third and fourth order give the same level, within
    `LARGEST_LEVEL_DIFFERENCE`."""
    z = measurements
    levels: list[float] = []
    for series in (z.linear_acceleration, z.angular_acceleration):
        level, coarser = _level(series), _level(series, DIFFERENCE_ORDER - 1)
        levels.append(
            level
            if len(series) >= FEWEST_SAMPLES_FOR_ORDERS
            and abs(coarser - level) < LARGEST_LEVEL_DIFFERENCE * level
            else 0.0
        )
    return MotionNoise(levels[0], levels[1]) if any(levels) else None


def _level(series: Array, order: int = DIFFERENCE_ORDER) -> float:
    """Standard deviation of a series' white noise (K, d), by differences."""
    if len(series) <= order:
        return 0.0
    differences = np.abs(np.diff(series, order, axis=0))
    return median(differences) / (0.67449 * comb(2 * order, order) ** 0.5)
