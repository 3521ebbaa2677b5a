"""Coordinates of pseudo-inertias: ten numbers for a symmetric 4 x 4 matrix, in an
orthonormal basis."""

import math

import numpy as np

from hefting.core.inertia import InertialParameters
from hefting.core.spatial import Array

ROWS, COLUMNS = np.triu_indices(4)
"""Entry of the matrix that each coordinate stands for."""


def _basis() -> Array:
    basis = np.zeros((10, 4, 4))
    for matrix, i, j in zip(basis, ROWS, COLUMNS, strict=True):
        matrix[i, j] = matrix[j, i] = 1.0 if i == j else math.sqrt(0.5)
    return basis


BASIS = _basis().reshape(10, 16)
"""(10, 16) orthonormal basis of the symmetric 4 x 4 matrices."""
DIAGONAL = np.ascontiguousarray(BASIS[:, ::5])
"""(10, 4) takes s to vec(diag(s))."""
IDENTITY = BASIS @ np.eye(4).ravel()
"""(10,) coordinates of the identity."""
PARAMETERS_OF = np.stack(
    [InertialParameters.from_pseudo_inertia(m.reshape(4, 4)).vector for m in BASIS],
    axis=1,
)
"""(10, 10) takes coordinates of a pseudo-inertia to the parameters of its body."""


def mat(q: Array) -> Array:
    """Symmetric matrix (4, 4) of coordinates (10,)."""
    return (q @ BASIS).reshape(4, 4)


def vec(Q: Array) -> Array:
    """Coordinates (10,) of a symmetric matrix (4, 4)."""
    return BASIS @ Q.ravel()


_PAIRS = [
    4 * i[:, None] + j
    for i, j in ((ROWS, ROWS), (COLUMNS, COLUMNS), (ROWS, COLUMNS), (COLUMNS, ROWS))
]
_LENGTHS = np.where(ROWS == COLUMNS, math.sqrt(0.5), 1.0)
_SCALE = np.outer(_LENGTHS, _LENGTHS)


def congruence(G: Array) -> Array:
    """(10, 10) takes vec(X) to vec(G X G')."""
    g = G.ravel()
    first, second, third, fourth = (g.take(pair) for pair in _PAIRS)
    return _SCALE * (first * second + third * fourth)
