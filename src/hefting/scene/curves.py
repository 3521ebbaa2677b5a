"""Curves: the wrench measured and explained over time, and as many of its samples as a
screen shows, as plain data for any renderer."""

import numpy as np
from numpy.typing import ArrayLike

from hefting.core.estimate import Estimate
from hefting.core.immutable import immutable
from hefting.core.measurements import Measurements
from hefting.core.regressor import predict_wrench
from hefting.core.spatial import Array, Indices

PARTS = (("Force", "N", 0), ("Torque", "N m", 3))
"""Of a wrench: name, unit and first column of each."""
MOST = 2_000
"""Samples of a curve that are drawn at most: two a pixel column of a wide screen."""
GAP = 5.0
"""Steps of the median length that a step is longer than over which no line is drawn."""


@immutable
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
    """The wrench measured and the wrench explained by an estimate made from it, which
    is static if it has no duration. `start` is the time [s] that counts as zero, by
    default that of the first measurement."""
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


def gaps_between(time: Array, shown: Indices) -> Indices:
    """Positions of those of the `shown` samples of times (K,) [s] that a gap
    precedes."""
    steps = np.diff(time)
    if not len(steps):
        return np.zeros(0, dtype=np.intp)
    before = np.append(0, np.cumsum(steps > GAP * np.median(steps)))
    return 1 + np.flatnonzero(np.diff(before[shown]))


def thinned(values: ArrayLike, most: int = MOST) -> Indices:
    """Indices of at most `most` (2 c + 2 or more) samples of c curves (K, c), or one
    (K,), that have their time in common; what is not finite is passed over.

    Of short curves all. Else the first and the last, and of consecutive parts of equal
    length the lowest and the highest sample of each curve: no peak is lost.
    """
    columns = np.asarray(values, dtype=float)
    columns = columns.reshape(len(columns), -1)
    if len(columns) <= most:
        return np.arange(len(columns))
    parts = (most - 2) // (2 * columns.shape[1])
    length = -(-len(columns) // parts)
    padded = np.full((parts * length, columns.shape[1]), np.nan)
    padded[: len(columns)] = columns
    blocks = padded.reshape(parts, length, -1)
    begin = length * np.arange(parts)[:, None]
    lowest = begin + np.where(np.isnan(blocks), np.inf, blocks).argmin(axis=1)
    highest = begin + np.where(np.isnan(blocks), -np.inf, blocks).argmax(axis=1)
    chosen = np.unique((lowest, highest))
    chosen = np.append(chosen[chosen < len(columns)], (0, len(columns) - 1))
    return np.unique(chosen)
