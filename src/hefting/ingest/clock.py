"""Effect of an error of the clock offset on the parameters."""

from dataclasses import replace

import numpy as np

from hefting.core.measurements import Measurements
from hefting.core.regressor import predict_wrench
from hefting.core.spatial import Array
from hefting.estimators.ols import least_squares
from hefting.estimators.sample_state import SampleState
from hefting.ingest.conditioned import Conditioned
from hefting.ingest.free_fit import FreeFit

OFFSET_ERROR_RATIO = 5.0
"""Error of a clock offset over the standard deviation of the robust fit, which knows
only of errors that its residuals show. In parts of 4 to 9 s of recordings with an
optical, a strain-gauge and a capacitive sensor the offset was 3 to 20 such deviations
from that of the whole."""
UNKNOWN_OFFSET_STD = 0.02
"""[s] Standard deviation of a clock offset that the motion does not tell: that of
separate drivers for robot and sensor."""


def offset_error(found: Conditioned) -> float:
    """Standard deviation [s] of what may be left of a clock offset; zero where there is
    no clock or no motion."""
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

    Parameters
    ----------
    found : what conditioning found.
    measurements : the samples of the unconstrained fit.
    fit : their unconstrained least squares.
    """
    std = offset_error(found)
    if not std > 0.0 or len(measurements) < 3:
        return None
    predicted = predict_wrench(measurements, fit.vector)
    rate = np.gradient(predicted, measurements.time, axis=0)
    late = replace(measurements, force=rate[:, :3], torque=rate[:, 3:])
    solved = least_squares(SampleState.of(late), fit.bias is not None, fit.noise)
    return std * solved.solution[:10]
