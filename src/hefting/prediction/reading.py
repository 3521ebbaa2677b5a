"""Reading: how far what a sensor reads may be from the wrench it bears."""

import numpy as np

from hefting.core.sensor_accuracy import SensorAccuracy
from hefting.core.spatial import Array


def reading_std(wrench: Array, accuracy: SensorAccuracy | None) -> Array:
    """(K, 6) standard deviations [N, N m] of the reading of a sensor that bears wrenches
    (K, 6): by gain, cross-talk and offset, without noise and bias. Zeros where nothing
    is said of the sensor."""
    if accuracy is None:
        return np.zeros_like(wrench)
    variance = np.square(wrench) @ np.square(accuracy.channel_stds).T
    variance += np.square(accuracy.gain_std * wrench)
    variance += np.square(accuracy.slow_std * wrench) + np.square(accuracy.offset_std)
    return np.sqrt(variance)
