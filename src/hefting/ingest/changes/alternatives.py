"""Alternatives to a change: what is wrong all the time explains the wrench as well.

Each alternative is linear, and the same throughout the recording: every channel is any
linear function of some columns and of a smoothly drifting bias. Between them they hold
turned or flipped axes, wrong units and crosstalk (any function of the motion's
features), a tilted base (of the axes), a late clock and a filter (of the features a
moment earlier and later), each as a special case.
"""

import numpy as np

from hefting.core.spatial import Array
from hefting.ingest.changes.bodies import DRIFT_FUNCTIONS, drift_functions
from hefting.ingest.changes.cells import Cells

LAGS = (0.1, 0.3)
"""[s] Times by which the features are moved both ways: wrenches are up to 0.3 s late."""
EXTRA_DRIFT = 3
"""Polynomials of time that the bias has beside `DRIFT_FUNCTIONS`."""
NEGLIGIBLE_DIRECTION = 1e-6
"""Singular value of the columns, as a share of the largest, below which a direction of
them is left out."""


def alternative_residuals(cells: Cells) -> list[tuple[Array, float]]:
    """Residuals (M, 6) of each alternative, in units of the cells' scale, and the number
    of unknowns of a channel."""
    x = cells.features
    columns = [
        np.hstack((x, cells.axes)),
        *(np.hstack((x, _moved(cells, lag), _moved(cells, -lag))) for lag in LAGS),
    ]
    T = drift_functions(cells.time, DRIFT_FUNCTIONS + EXTRA_DRIFT)
    return [_regressed(np.hstack((c, T)), cells.whitened) for c in columns]


def _moved(cells: Cells, lag: float) -> Array:
    """(M, 12) features a time [s] later, interpolated."""
    return np.column_stack(
        [np.interp(cells.time + lag, cells.time, column) for column in cells.features.T]
    )


def _regressed(columns: Array, values: Array) -> tuple[Array, float]:
    """Residuals of least squares, and the number of unknowns that were determined."""
    size = np.linalg.norm(columns, axis=0)
    scaled = columns / np.maximum(size, 1e-300)
    left, singular, _ = np.linalg.svd(scaled, full_matrices=False)
    left = left[:, singular > NEGLIGIBLE_DIRECTION * singular[0]]
    return values - left @ (left.T @ values), float(left.shape[1])
