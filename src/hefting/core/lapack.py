"""LAPACK routines called directly: for matrices of 22 columns NumPy's wrappers cost
more than the work.

The routines are SciPy's, loaded from its extension module by file, as importing
`scipy.linalg` takes twice as long as importing NumPy. If that fails, it is imported.
"""

import sys
from importlib.machinery import EXTENSION_SUFFIXES
from importlib.util import find_spec, module_from_spec, spec_from_file_location
from pathlib import Path
from typing import Any

import numpy as np

from hefting.core.spatial import Array

lapack: Any = None
"""Its routines exist at run time only, so type checkers do not know them."""

_scipy = find_spec("scipy")
# there SciPy finds DLLs
if (
    "scipy.linalg" not in sys.modules
    and _scipy
    and _scipy.origin
    and sys.platform != "win32"
):
    for _suffix in EXTENSION_SUFFIXES:
        _file = Path(_scipy.origin).parent / "linalg" / f"_flapack{_suffix}"
        _spec = (
            spec_from_file_location("scipy.linalg._flapack", _file)
            if _file.is_file()
            else None
        )
        if _spec is None or _spec.loader is None:
            continue
        try:
            lapack = module_from_spec(_spec)
            _spec.loader.exec_module(lapack)
        except ImportError:
            lapack = None
        break
if lapack is None:
    import scipy.linalg.lapack

    lapack = scipy.linalg.lapack


WELL_CONDITIONED = 1e6
"""Largest trace of the inverse of a matrix with unit diagonal for which the inverse of
its triangular factor is used, as no eigenvalue is near zero."""


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
    """(10, 10) X with X'X the inverse of a matrix with unit diagonal; None unless that
    is `WELL_CONDITIONED`."""
    factor, failed = lapack.dpotrf(unit, lower=1)
    if failed:
        return None
    root = lapack.dtrtri(factor, lower=1)[0]
    return root if np.vdot(root, root) < WELL_CONDITIONED else None
