"""How much each sample counts, and the noise of its motion."""

import numpy as np

from hefting.core.measurements import MotionNoise
from hefting.core.spatial import Array
from hefting.estimators.raw_motion import white_motion_noise
from hefting.ingest.conditioned import Conditioned
from hefting.ingest.unmodelled import weights_at_rest
from hefting.motion import Measured
from hefting.motion.weighting import lasting_variances, sample_weights


def weights_of(found: Conditioned, measured: Measured, counts: Array) -> Array | None:
    """Weights (K,), one on average, by the number of samples averaged and by the errors
    of the smoothed motion.

    None where the motion is exact and nothing was averaged.
    """
    smoothed = (
        measured.motion is not None
        and measured.source != "orientation"
        and len(counts) > 1
    )
    if measured.source == "orientation" and measured.motion is not None:
        weights = counts * weights_at_rest(
            measured.motion, measured.measurements, found
        )
        return weights / weights.mean()
    if not smoothed and (counts == 1.0).all():
        return None
    weights = counts
    if smoothed:
        phi = np.where(np.isfinite(found.covariance.diagonal()), found.parameters, 0.0)
        noise = (max(found.noise.force, 1e-12), max(found.noise.torque, 1e-12))
        each = np.array(noise) / max(float(counts.mean()), 1.0) ** 0.5
        assert measured.motion is not None
        weights = counts * sample_weights(phi, measured.motion, *each)
    return weights / weights.mean()


def motion_noise_of(measured: Measured) -> MotionNoise | None:
    """Errors of the accelerations: those of the smoother or filter or, of logged
    accelerations, from differences."""
    motion = measured.motion
    if motion is None:
        return (
            white_motion_noise(measured.measurements)
            if measured.source == "columns"
            else None
        )
    if motion.linear_acceleration_std is None:
        return None
    linear, angular = np.sqrt(lasting_variances(motion).mean(axis=1))
    return MotionNoise(float(linear), float(angular), float(np.pi / motion.bandwidth))
