"""Errors of a predicted wrench A phi, with A (6, 10) from the motion: by the estimate's
covariance C, which gives A C A', by errors of the motion, and by the sensor."""

import numpy as np

from hefting.core.measurements import Measurements
from hefting.core.regressor import FULL_MAP, motion_features
from hefting.core.sensor_accuracy import SensorAccuracy
from hefting.core.spatial import CHUNK, Array
from hefting.core.undetermined import Covariance
from hefting.motion import Motion
from hefting.motion.state import acceleration_variances, effect_of_acceleration_errors


def reading_std(wrench: Array, accuracy: SensorAccuracy | None) -> Array:
    """(K, 6) standard deviations [N, N m] of a sensor's readings of wrenches (K, 6), by
    gain, cross-talk and offset, without noise and bias. Zeros without an accuracy."""
    if accuracy is None:
        return np.zeros_like(wrench)
    variance = np.square(wrench) @ np.square(accuracy.channel_stds).T
    variance += np.square(accuracy.gain_std * wrench)
    variance += np.square(accuracy.slow_std * wrench) + np.square(accuracy.offset_std)
    return np.sqrt(variance)


TOUCHES = 1e-6
"""[m/s², rad/s²] Entry of A up to which a parameter does not matter: the error by
smoothing where the sensor does not turn, a micronewton metre for 1 kg m²."""


class Spread(Covariance):
    """Standard deviations of linear functions of the ten parameters."""

    def std(self, rows: Array) -> Array:
        """Standard deviations (...) of ``rows @ phi``, rows (..., 10); infinite where
        an open parameter matters."""
        std = np.sqrt(np.square(rows @ self.root).sum(axis=-1))
        return np.where(
            (np.abs(rows) > TOUCHES)[..., self.open].any(axis=-1), np.inf, std
        )

    def of_wrench(self, measurements: Measurements) -> Array:
        """Standard deviations (K, 6) [N, N m] of the predicted wrench."""
        std = np.empty((len(measurements), 6))
        for first in range(0, len(std), CHUNK):
            part = slice(first, first + CHUNK)
            std[part] = self.std(regressor(measurements[part]))
        return std


def regressor(measurements: Measurements) -> Array:
    """A (K, 6, 10) of each instant, without the weights of the measurements."""
    return (motion_features(measurements) @ FULL_MAP).reshape(-1, 6, 10)


def motion_spread(vector: Array, motion: Motion | None) -> Array | None:
    """(2,) root mean square of one axis of the errors of force [N] and torque [N m] of a
    body of parameters `vector` (10,), by the standard deviations of a smoothed motion.
    None if the log gave the motion, or these are not finite."""
    if motion is None:
        return None
    spread = np.sqrt(
        effect_of_acceleration_errors(vector)
        @ acceleration_variances(motion).mean(axis=1)
        / 3.0
    )
    return spread if np.isfinite(spread).all() else None
