"""Bands of the inverse of a band matrix, which hold the variances of a spline's
coefficients."""

import numpy as np

from hefting.core.spatial import Array
from hefting.motion.bspline import SPLINE_DEGREE, SUPPORT, Integers

INVERSE_STRETCH = 64
"""Number of coefficients in a stretch of `inverse_bands`. Shorter stretches take fewer
steps, longer ones repeat less of the overlap."""
STRETCHES_TOGETHER = 256
"""Number of stretches inverted side by side; it bounds the memory."""


def inverse_bands(factor: Array, overlap: int, stretch: int = INVERSE_STRETCH) -> Array:
    """Lower bands (6, n) of A^-1 from the lower Cholesky bands (6, n) of A.

    The recursion runs backward (Takahashi, Fagan & Chin 1973; Hutchinson & de Hoog
    1985), in parallel over stretches of the matrix. Each starts from zeros, `overlap`
    coefficients after the end of its `stretch` coefficients; the error of that start decreases as
    exp(-2 sin(pi/2m) wc h overlap).
    """
    begins = np.arange(0, factor.shape[1], stretch)
    bands = np.zeros_like(factor)
    for first in range(0, len(begins), STRETCHES_TOGETHER):
        some = begins[first : first + STRETCHES_TOGETHER]
        _invert_stretches(bands, factor, some, overlap, stretch)
    return bands


def _invert_stretches(
    bands: Array, factor: Array, begins: Integers, overlap: int, stretch: int
) -> None:
    """Fill in the `bands` of the stretches that begin at some coefficients."""
    n, count = factor.shape[1], len(begins)
    length = min(stretch + overlap, n)
    stop = np.minimum(begins + stretch + overlap, n)
    column = stop - 1 - np.arange(length)[:, None]  # (length, count)
    own = (column >= begins) & (column < begins + stretch)
    # it is negative in a stretch that is finished; its result is not used
    column = np.maximum(column, 0)
    pivots = factor[0, column]
    slopes = (factor[1:, column] / pivots).transpose(1, 2, 0)[..., None]
    last = 1.0 / pivots**2
    rows = np.empty((length, count, SUPPORT))
    window = np.zeros((count, SUPPORT, SUPPORT))
    for k, slope in enumerate(slopes):  # (count, 5, 1)
        corner = window[:, :SPLINE_DEGREE, :SPLINE_DEGREE]
        row = -(corner @ slope)
        grown = np.empty_like(window)
        grown[:, 1:, 1:] = corner
        grown[:, 1:, :1] = row
        grown[:, 0, 1:] = row[:, :, 0]
        grown[:, 0, 0] = last[k] - (row * slope).sum(axis=1)[:, 0]
        window = grown
        rows[k] = window[:, 0]
    bands[:, column[own]] = rows[own].T
