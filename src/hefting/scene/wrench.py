"""Wrench: what was measured, what an estimate explains, and what remains, as plain
data for any renderer."""

from dataclasses import dataclass

import numpy as np

from hefting.core.estimate import Estimate
from hefting.core.measurements import Measurements
from hefting.core.regressor import predict_wrench
from hefting.core.spatial import Array

PARTS = (("Force", "N", 0), ("Torque", "N m", 3))
"""Of a wrench: name, unit and first column of each."""


@dataclass(frozen=True, eq=False)
class WrenchCurves:
    """Wrenches at K instants, exerted by the sensor on the object, in sensor axes."""

    time: Array
    """(K,) [s]; of static poses their number, counted from 1"""
    measured: Array
    """(K, 6) force [N] and torque [N m]"""
    predicted: Array
    """(K, 6) of the estimate, with its bias"""
    static: bool
    """Whether they are static poses."""

    @property
    def residual(self) -> Array:
        """(K, 6) measured less predicted."""
        return self.measured - self.predicted

    def rms(self, first: int) -> float:
        """Root mean square of the residual of the force (0) or of the torque (3)."""
        return float(np.sqrt(np.mean(self.residual[:, first : first + 3] ** 2)))


def wrench_curves(
    measurements: Measurements, estimate: Estimate, start: float | None = None
) -> WrenchCurves:
    """The wrench measured and the wrench an estimate explains.

    Parameters
    ----------
    measurements : Measurements
        That the estimate was made from.
    estimate : Estimate
        Static is one without a duration.
    start : float, optional
        Time [s] that counts as zero, by default that of the first measurement.
    """
    static = estimate.duration is None
    predicted = predict_wrench(measurements, estimate.parameters.vector)
    predicted = predicted + _bias_of_each(estimate, len(measurements))
    begin = measurements.time[0] if start is None else start
    time = measurements.time - begin
    if static:
        time = np.arange(1.0, len(measurements) + 1.0)
    return WrenchCurves(time, measurements.wrench, predicted, static)


def _bias_of_each(estimate: Estimate, samples: int) -> Array:
    """(K, 6) or (6,) bias of each of K samples; zero where it is not known."""
    bias = estimate.bias
    if bias is None or bias.ndim == 1:
        return np.zeros(6) if bias is None else bias
    try:  # provenance may be that of a file
        rows = [int(each["rows"]) for each in estimate.provenance["recordings"]]
    except (KeyError, TypeError, ValueError, OverflowError):
        return np.zeros(6)
    if len(rows) != len(bias) or min(rows) < 0 or sum(rows) != samples:
        return np.zeros(6)
    return np.repeat(bias, rows, axis=0)
