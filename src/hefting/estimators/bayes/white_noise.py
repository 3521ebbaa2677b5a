"""White noise of measurements by what changes from sample to sample, where nothing else tells it."""

from math import comb

import numpy as np

from hefting.measurements import Measurements, Noise
from hefting.spatial import Array

ORDER = 4
"""Of the differences: motion at a tenth of the sampling rate is weakened by (2 sin 18°)^4 / sqrt(70), 57 times."""


def white_noise(measurements: Measurements) -> Noise:
    """Levels of white noise in wrench and accelerations, by the median size of their fourth differences in time.

    Samples are those of a sensor, in order of time, much faster than the motion. Noise that lasts over several samples
    is hardly seen. Zero for fewer than five samples.
    """
    z = measurements
    return Noise(*(_level(v) for v in (z.force, z.torque, z.linear_acceleration, z.angular_acceleration)))


def _level(series: Array) -> float:
    if len(series) <= ORDER:
        return 0.0
    differences = np.abs(np.diff(series, ORDER, axis=0))
    return float(np.median(differences)) / (0.67449 * comb(2 * ORDER, ORDER) ** 0.5)
