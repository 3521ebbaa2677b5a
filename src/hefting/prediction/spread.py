"""How far a predicted wrench A phi, A (6, 10) known from the motion, may be off: by an
estimate's covariance C, which makes A C A', by the motion's errors, and by the sensor
that reads it."""

import numpy as np

from hefting.core.covariance import Covariance
from hefting.core.measurements import Measurements
from hefting.core.regressor import FULL_MAP, motion_features
from hefting.core.sensor_accuracy import SensorAccuracy
from hefting.core.spatial import CHUNK, Array
from hefting.motion import Motion
from hefting.motion.state import acceleration_variances
from hefting.motion.weighting import effect_of_acceleration_errors


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


TOUCHES = 1e-6
"""[m/s², rad/s²] Entry of A below which a parameter does not matter: what smoothing
makes of a sensor that does not turn; a micronewton metre for 1 kg m²."""


class Spread(Covariance):
    """What a covariance of the ten parameters makes of what is linear in them."""

    def std(self, rows: Array) -> Array:
        """Standard deviations (...) of ``rows @ phi``, rows (..., 10); infinite where
        an open parameter matters."""
        std = np.sqrt(np.square(rows @ self.root).sum(axis=-1))
        return np.where(
            (np.abs(rows) > TOUCHES)[..., self.open].any(axis=-1), np.inf, std
        )

    def of_wrench(self, measurements: Measurements) -> Array:
        """Standard deviations (K, 6) [N, N m] of the wrench that the motion needs."""
        std = np.empty((len(measurements), 6))
        for first in range(0, len(std), CHUNK):
            part = slice(first, first + CHUNK)
            std[part] = self.std(regressor(measurements[part]))
        return std


def regressor(measurements: Measurements) -> Array:
    """A (K, 6, 10) of each instant; of the motion alone, with no regard to weights."""
    return (motion_features(measurements) @ FULL_MAP).reshape(-1, 6, 10)


def motion_spread(vector: Array, motion: Motion | None) -> Array | None:
    """What the errors of a smoothed motion add to the wrench (2,): root mean square an
    axis of force and torque.

    By the motion's own deviations; None where the log gave the motion, or does not tell
    them.
    """
    if motion is None:
        return None
    spread = np.sqrt(
        effect_of_acceleration_errors(vector)
        @ acceleration_variances(motion).mean(axis=1)
        / 3.0
    )
    return spread if np.isfinite(spread).all() else None
