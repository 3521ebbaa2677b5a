"""Level of white noise in measurements, estimated from differences in time."""

from math import comb

import numpy as np

from hefting.core.measurements import Measurements, MotionNoise, Noise
from hefting.core.spatial import Array
from hefting.estimators.raw_motion import LARGEST_LEVEL_DIFFERENCE

DIFFERENCE_ORDER = 4
"""Order of the differences. Motion at a tenth of the sampling rate is attenuated 57
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
    """White noise of linear [m/s²] and angular [rad/s²] acceleration; None where none
    is found.

    It is found where differences of third and fourth order give the same level, within
    `LARGEST_LEVEL_DIFFERENCE`.
    """
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
    """Standard deviation of the white noise of a series (K, d), from its differences of
    this order."""
    if len(series) <= order:
        return 0.0
    differences = np.abs(np.diff(series, order, axis=0))
    return float(np.median(differences)) / (0.67449 * comb(2 * order, order) ** 0.5)
