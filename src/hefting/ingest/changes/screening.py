"""Screening: whether one change may be hidden in a recording, in closed form.

The gain of a second body from cell t on is the decrease of the sum of squares by ten
more columns. With cumulative sums it is found for all t at once, and takes about a
hundredth of the time of an identification.
"""

from dataclasses import replace

import numpy as np

from hefting.core.immutable import immutable
from hefting.core.spatial import Array
from hefting.ingest.changes.bodies import (
    PARAMETERS,
    JointModel,
    autocorrelation,
    bias_columns,
    drift_degrees,
    log_ratio,
    ridge_of_bias,
)
from hefting.ingest.changes.cells import LARGEST_PARAMETERS, Cells

SENSOR_ERROR = 0.005
"""Error of a good sensor as a share of the wrench's changes, which averaging does not
lessen."""
MEDIAN_OF_NORMAL = 0.6745
"""Median size of a standard normal number."""
THIRD_DIFFERENCE = np.sqrt(20.0)
"""Standard deviation of the third difference of white noise of one."""
SUSPICIOUS = 100.0
"""Logarithm of the likelihood ratio of two bodies to one from which on changes are
looked for. In 72 simulated recordings without a change it is at most 23, in 48 in which
the object is picked up, put down, swapped or slips 34 to 6,500; weaker changes are below
what tells two bodies apart from a sensor's errors anyway."""
UNEXPLAINED_VARIANCE = 12.0
"""Variance of one body's residuals, in units of the noise, from which on changes are
looked for: a contact may be where one change explains little. In recordings of three
real sensors it is 1 to 10."""
FEWEST_CELLS_EACH_SIDE = 5
"""Fewest cells on each side of a change."""


def with_noise_scale(cells: Cells, rounding: Array) -> Cells:
    """The cells with the scale of their noise: that of the differences between
    neighbours' residuals, but no less than the error of a good sensor, and that of
    `rounding` (2,) of force [N] and torque [N m]."""
    changes = np.linalg.norm(np.std(cells.wrench, axis=0).reshape(2, 3), axis=1)
    smallest = 1e-9 * float(np.abs(cells.wrench).max()) + 1e-12
    floor = np.maximum(SENSOR_ERROR * changes, np.maximum(rounding, smallest))
    cells = replace(cells, scale=np.maximum(0.1 * changes, smallest))
    for _ in range(2):
        apart = np.diff(_one_body(cells).residual, n=3, axis=0) * cells.unit
        sizes = np.median(np.abs(apart).reshape(-1, 2, 3), axis=(0, 2))
        noise = sizes / (MEDIAN_OF_NORMAL * THIRD_DIFFERENCE)
        cells = replace(cells, scale=np.hypot(noise, floor))
    return cells


def is_suspicious(cells: Cells) -> bool:
    """Whether two bodies, one after the other, explain much more than one, or one
    explains little."""
    at = _best_change(cells)
    model = JointModel(cells, [(0, at), (at, len(cells))])
    one, two = model.fit([0, 0]), model.fit([0, 1])
    if float(one.variance.max()) > UNEXPLAINED_VARIANCE:
        return True
    tau = autocorrelation(model.residuals(two))
    return log_ratio(one, two) / tau > SUSPICIOUS


@immutable
class _OneBody:
    """The fit of one body beside a smoothly drifting bias."""

    columns: Array
    """(M, 6, q)"""
    normal: Array
    """(q, q)"""
    residual: Array
    """(M, 6)"""


def _one_body(cells: Cells) -> _OneBody:
    drift = drift_degrees(cells)
    columns = np.concatenate((cells.regressor, bias_columns(cells, drift)), axis=2)
    flat = columns.reshape(-1, columns.shape[2])
    ridge = np.concatenate((LARGEST_PARAMETERS**-2.0, ridge_of_bias(drift)))
    normal = flat.T @ flat + np.diag(ridge)
    solution = np.linalg.solve(normal, flat.T @ cells.whitened.ravel())
    residual = cells.whitened.ravel() - flat @ solution
    return _OneBody(columns, normal, residual.reshape(-1, 6))


def _best_change(cells: Cells) -> int:
    """The cell from which on a second body explains most."""
    fit = _one_body(cells)
    A = np.swapaxes(cells.regressor, 1, 2)

    def from_here_on(values: Array) -> Array:
        return np.cumsum(values[::-1], axis=0)[::-1]

    shared = from_here_on(A @ fit.columns)
    score = from_here_on(A @ fit.residual[:, :, None])
    rows = slice(FEWEST_CELLS_EACH_SIDE, len(cells) - FEWEST_CELLS_EACH_SIDE)
    shared, score = shared[rows], score[rows]
    q = shared.shape[2]
    explained = (shared.reshape(-1, q) @ np.linalg.inv(fit.normal)).reshape(
        shared.shape
    )
    information = shared[:, :, :PARAMETERS] - explained @ np.swapaxes(shared, 1, 2)
    information = information + np.diag(LARGEST_PARAMETERS**-2.0)
    gain = np.sum(score * np.linalg.solve(information, score), axis=(1, 2))
    return int(np.argmax(gain)) + FEWEST_CELLS_EACH_SIDE
