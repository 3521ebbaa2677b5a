"""Errors of the parameters where gravity's direction was estimated."""

from dataclasses import replace

import numpy as np

from hefting.core.measurements import Measurements
from hefting.core.recording import Recording
from hefting.core.spatial import Array, in_sensor_axes
from hefting.estimators.sample_state import SampleState
from hefting.ingest.conditioned import Conditioned
from hefting.ingest.free_fit import FreeFit, free_fit
from hefting.motion import Measured, measure
from hefting.motion.measure import Source


def errors_of_estimated_gravity(
    recording: Recording,
    source: Source,
    found: Conditioned,
    measured: Measured,
    measurements: Measurements,
    fit: FreeFit,
    *,
    drift: bool,
) -> Array | None:
    """Errors (10, 2) of the parameters by one standard deviation of gravity's direction
    about each axis across it.

    Parameters
    ----------
    recording : as recorded.
    source : where the motion comes from.
    found : what conditioning found, with gravity (3,) and the standard deviation of its
        direction.
    measured : the motion.
    measurements : the samples of the unconstrained fit.
    fit : their unconstrained least squares.
    drift : whether the drift of the bias was removed.

    None where the direction was given, or is undetermined.
    """
    if found.tilt_std is None or not np.isfinite(found.tilt_std):
        return None
    from scipy.spatial.transform import Rotation

    free_bias = fit.bias is not None
    errors = []
    # the two axes across gravity
    for axis in np.linalg.svd(found.gravity[None])[2][1:]:
        turned = Rotation.from_rotvec(found.tilt_std * axis).apply(
            np.array(found.gravity)
        )
        if measured.motion is None:  # nothing was averaged, so the rows are the same
            other = measure(
                found.corrected(recording, drift), turned, source, found.curves
            ).measurements
            tilted = replace(
                measurements,
                gravity=other.gravity,
                linear_acceleration=other.linear_acceleration,
            )
        else:
            change = in_sensor_axes(measured.motion.orientation, turned - found.gravity)
            tilted = replace(measurements, gravity=measurements.gravity + change)
            if measured.source == "accelerometer":  # it measures a - g
                acceleration = measurements.linear_acceleration + change
                tilted = replace(tilted, linear_acceleration=acceleration)
        errors.append(free_fit(SampleState.of(tilted), free_bias).vector - fit.vector)
    return np.array(errors).T
