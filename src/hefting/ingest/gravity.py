"""Errors of the parameters where gravity's direction was estimated, or its size is not
known exactly."""

from dataclasses import replace

import numpy as np

from hefting.core.gravity import Gravity
from hefting.core.measurements import Measurements
from hefting.core.moments import triangular
from hefting.core.recording import Recording
from hefting.core.regressor import GRAVITY
from hefting.core.spatial import Array, in_sensor_axes
from hefting.estimators.ols import least_squares
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


def errors_of_gravity_size(
    gravity: Gravity, source: str, state: SampleState, fit: FreeFit
) -> Array | None:
    """Error (10,) of the parameters by one standard deviation of gravity's size.

    It is what least squares changes by with a gravity that is larger by that much: of
    static poses the mass and the first moment, by the same share, and of moving ones
    the rest as well. None where the size is exact, or is no part of the motion: an
    accelerometer measures the acceleration less gravity.

    Parameters
    ----------
    gravity : as assumed.
    source : where the motion comes from (`hefting.motion.measure.DESCRIPTIONS`).
    state : moments of the samples with the gravity assumed.
    fit : their unconstrained least squares.
    """
    if not gravity.std or source == "accelerometer":
        return None
    larger = with_gravity_scaled(state, 1.0 + gravity.relative_std)
    solved = least_squares(larger, fit.bias is not None, fit.noise)
    return solved.solution[:10] - fit.vector


def with_gravity_scaled(state: SampleState, factor: float) -> SampleState:
    """The state of the full model for a gravity so many times as large."""
    rows = state.full.factor.copy()
    change = (factor - 1.0) * rows[:, GRAVITY]
    rows[:, 0:3] -= change
    rows[:, GRAVITY] += change
    return replace(state, full=replace(state.full, factor=triangular(rows)))
