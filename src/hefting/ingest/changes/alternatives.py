"""Alternative to a contact: something that is wrong all the time.

Turned or flipped axes, wrong units, crosstalk and a tilted base leave every channel a
linear function of the motion's features and of the axes of the world, the same
throughout the recording. Where such a function explains the wrench no contact is told.
"""

import numpy as np

from hefting.core.spatial import Array
from hefting.ingest.changes.bodies import bias_columns, drift_degrees
from hefting.ingest.changes.cells import Cells

NEGLIGIBLE_DIRECTION = 1e-6
"""Singular value of the columns, as a share of the largest, below which a direction of
them is left out."""


def variance_of_any_linear_function(cells: Cells) -> Array:
    """(2,) variance of the whitened residuals of force and torque, each channel the
    linear function of features, axes and drift that fits it best."""
    drift = bias_columns(cells, drift_degrees(cells))[:, 0, : drift_degrees(cells)]
    columns = np.hstack((cells.features, cells.axes, drift))
    size = np.maximum(np.linalg.norm(columns, axis=0), 1e-300)
    left, singular, _ = np.linalg.svd(columns / size, full_matrices=False)
    left = left[:, singular > NEGLIGIBLE_DIRECTION * singular[0]]
    residual = cells.whitened - left @ (left.T @ cells.whitened)
    square = np.sum(residual.reshape(-1, 2, 3) ** 2, axis=(0, 2))
    return square / max(3.0 * (len(cells) - left.shape[1]), 1.0)
