"""Roots of the inverse of a matrix (10, 10), by LAPACK."""

import numpy as np

from hefting.core.lapack import lapack
from hefting.core.spatial import Array

WELL_CONDITIONED = 1e6
"""Largest trace of the inverse of a matrix with ones on its diagonal up to which the
inverse is that of its triangular factor: no eigenvalue is near zero."""


def root_of_inverse(V: Array) -> Array:
    """(k, 10) X with X'X = V^+; directions without information are left out."""
    scale = np.sqrt(np.maximum(V.diagonal(), 0.0))
    scale[scale <= 1e-13 * scale.max()] = np.inf
    unit = V / scale / scale[:, None]
    root = triangular_root(unit)
    if root is not None:
        return root / scale
    values, vectors, _ = lapack.dsyevd(unit)
    kept = values > 1e-12 * values[-1]
    return (vectors[:, kept] / np.sqrt(values[kept])).T / scale


def triangular_root(unit: Array) -> Array | None:
    """(10, 10) X with X'X the inverse of a matrix with ones on its diagonal; None where
    that is not `WELL_CONDITIONED`."""
    factor, failed = lapack.dpotrf(unit, lower=1)
    if failed:
        return None
    root = lapack.dtrtri(factor, lower=1)[0]
    return root if np.vdot(root, root) < WELL_CONDITIONED else None
