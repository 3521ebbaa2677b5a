"""White noise of measurements by what changes from sample to sample, where nothing else tells it."""

from math import comb

import numpy as np

from hefting.core.measurements import Measurements, MotionNoise, Noise
from hefting.core.spatial import Array

ORDER = 4
"""Of the differences: motion at a tenth of the sampling rate is weakened by (2 sin 18°)^4 / sqrt(70), 57 times."""
ENOUGH = 50
"""Samples for the levels of two orders to be compared."""
ALIKE = 0.2
"""Relative difference of these levels: noise of 150 samples makes 4 %, motion much more."""


def white_noise(measurements: Measurements) -> Noise:
    """Levels of white noise in wrench and accelerations, by the median size of their fourth differences in time.

    Samples are those of a sensor, in order of time, much faster than the motion. Noise that lasts over several samples
    is hardly seen. Zero for fewer than five samples.
    """
    z = measurements
    return Noise(*(_level(v) for v in (z.force, z.torque, z.linear_acceleration, z.angular_acceleration)))


def white_motion_noise(measurements: Measurements) -> MotionNoise | None:
    """White noise of linear [m/s²] and angular [rad/s²] acceleration; None where there is none, or the samples do not
    tell: differences of the third order must show the same level as those of the fourth, within `ALIKE`."""
    z = measurements
    levels = []
    for series in (z.linear_acceleration, z.angular_acceleration):
        level, coarser = _level(series), _level(series, ORDER - 1)
        levels.append(level if len(series) >= ENOUGH and abs(coarser - level) < ALIKE * level else 0.0)
    return MotionNoise(levels[0], levels[1]) if any(levels) else None


def _level(series: Array, order: int = ORDER) -> float:
    if len(series) <= order:
        return 0.0
    differences = np.abs(np.diff(series, order, axis=0))
    return float(np.median(differences)) / (0.67449 * comb(2 * order, order) ** 0.5)
