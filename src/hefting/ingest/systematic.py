"""Systematic errors of the parameters, which more samples do not reduce: by the clock
offset, by a drift that was removed, and by gravity if its direction was estimated or
its size is uncertain. For several recordings together: errors that each has of its own,
and errors common to all."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from hefting.core.estimate import Estimate
from hefting.core.gravity import Gravity
from hefting.core.measurements import Measurements, Noise
from hefting.core.moments import triangular
from hefting.core.recording import Recording
from hefting.core.regressor import GRAVITY, predict_wrench
from hefting.core.spatial import Array, in_sensor_axes
from hefting.estimators.quadratic import Quadratic, ScaledSVD, least_squares
from hefting.estimators.sample_state import SampleState
from hefting.ingest.conditioned import Conditioned
from hefting.ingest.free_fit import FreeFit, free_fit
from hefting.ingest.ingested import Ingested
from hefting.ingest.tool import tool_covariance
from hefting.motion import Measured, measure
from hefting.motion.measure import Source

OFFSET_ERROR_RATIO = 5.0
"""Error of a clock offset over the standard deviation of the robust fit, which includes
only errors that show in its residuals. In parts of 4 to 9 s of recordings with an
optical, a strain-gauge and a capacitive sensor the offset was 3 to 20 such deviations
from that of the whole."""
UNKNOWN_OFFSET_STD = 0.02
"""[s] Standard deviation of a clock offset that the motion does not determine: that of
separate drivers for robot and sensor."""


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

    `fit` is unconstrained least squares of the `measurements`, from which the `drift` of
    the bias may be removed. None where the direction was given, or is undetermined.
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

    The motion's `source` is one of `hefting.motion.measure.DESCRIPTIONS`; `fit` is
    unconstrained least squares of `state`, both with the gravity assumed.
    """
    if not gravity.std or source == "accelerometer":
        return None
    larger = with_gravity_scaled(state, 1.0 + gravity.relative_std)
    solved = least_squares(larger, fit.bias is not None, fit.noise)
    return solved.solution[:10] - fit.vector


def with_gravity_scaled(state: SampleState, factor: float) -> SampleState:
    """State of the full model for gravity times `factor`."""
    rows = state.full.factor.copy()
    change = (factor - 1.0) * rows[:, GRAVITY]
    rows[:, 0:3] -= change
    rows[:, GRAVITY] += change
    return replace(state, full=replace(state.full, factor=triangular(rows)))


def offset_error(found: Conditioned) -> float:
    """[s] Standard deviation left of a clock offset; zero without a clock or motion."""
    if found.offset_std is None:
        return 0.0
    known = np.isfinite(found.offset_std)
    std = OFFSET_ERROR_RATIO * found.offset_std if known else UNKNOWN_OFFSET_STD
    return float(np.hypot(std, found.offset_left))


def errors_of_clock_offset(
    found: Conditioned, measurements: Measurements, fit: FreeFit
) -> Array | None:
    """Error (10,) of the parameters by one standard deviation of the clock offset.

    A wrench that is late by dt is wrong by its rate of change times dt: the error is
    what least squares makes of that rate. None where there is no clock or no motion.

    `fit` is unconstrained least squares of the `measurements`.
    """
    std = offset_error(found)
    if not std > 0.0 or len(measurements) < 3:
        return None
    predicted = predict_wrench(measurements, fit.vector)
    rate = np.gradient(predicted, measurements.time, axis=0)
    late = replace(measurements, force=rate[:, :3], torque=rate[:, 3:])
    solved = least_squares(SampleState.of(late), fit.bias is not None, fit.noise)
    return std * solved.solution[:10]


def errors_of_drift(
    found: Conditioned, measurements: Measurements, fit: FreeFit
) -> Array | None:
    """Errors (10, 6) of the parameters by those of a linear drift that was removed: E,
    with E E' their covariance.

    In the rise of a single move a drift is told from the object's weight only in part.
    None where there is no such drift.

    `fit` is unconstrained least squares of the `measurements`, without the drift.
    """
    drift = found.bias
    if drift.rise is None or fit.bias is None:
        return None
    z, errors = measurements, []
    values, axes = np.linalg.eigh(drift.rise)
    slope = (z.time - z.time.mean()) / np.ptp(drift.knots)
    for rise in (axes * np.sqrt(np.maximum(values, 0.0))).T:
        wrench = slope[:, None] * rise
        added = replace(z, force=wrench[:, :3], torque=wrench[:, 3:])
        solved = least_squares(SampleState.of(added), True, fit.noise)
        errors.append(solved.solution[:10])
    return np.array(errors).T


def shares_of(parts: Sequence[Ingested], noise: Noise) -> list[Array]:
    """P (10, 10) of each recording: derivative of the joint least squares by that
    recording's own."""
    free_bias = parts[0].bias == "estimate"
    rows = [Quadratic.of(part.state, noise, free_bias).A for part in parts]
    svd = ScaledSVD.of(np.concatenate(rows))
    half = svd.V.T / svd.S / svd.scale[:, None]
    return [half @ half.T @ (A.T @ A) for A in rows]


def common_errors(
    parts: Sequence[Ingested], noise: Noise, tool: Estimate | None
) -> tuple[Array | None, Array | None]:
    """(10, 10) covariance of errors that all samples of a recording share: of a tool in
    all recordings, and of each recording's clock and gravity direction; and the error
    (10,) by one standard deviation of gravity's size, in all."""
    shares = shares_of(parts, noise)
    of_tool = tool_covariance(tool)
    systematic = np.zeros((10, 10)) if of_tool is None else of_tool.copy()
    size = np.zeros(10)
    for part, P in zip(parts, shares, strict=True):
        own = np.zeros((10, 10)) if part.systematic is None else part.systematic
        own = own if of_tool is None else own - of_tool
        if part.clock_error is not None:
            own = own + np.outer(part.clock_error, part.clock_error)
        systematic += P @ own @ P.T
        if part.gravity_error is not None:
            size += P @ part.gravity_error
    systematic = 0.5 * (systematic + systematic.T)
    return (
        systematic if systematic.any() else None,
        size if parts[0].gravity_error is not None else None,
    )
