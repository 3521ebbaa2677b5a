"""Non-negative least squares, by SciPy."""

import numpy as np

from hefting.core.spatial import Array


def nonnegative_least_squares(A: Array, b: Array) -> Array:
    """(n,) x >= 0 that minimises |A x - b|, for A (r, n) and b (r,) (Lawson & Hanson,
    1974).

    Raises `RuntimeError` after 100 n steps without an end, which rounding could cause.
    """
    from scipy.optimize import nnls  # pyright: ignore[reportUnknownVariableType]

    return np.asarray(nnls(A, b, maxiter=100 * A.shape[1])[0], dtype=float)
