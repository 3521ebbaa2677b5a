"""LAPACK routines called directly: on matrices of 22 columns NumPy's wrappers cost more than the work."""

from typing import Any

import scipy.linalg.lapack

lapack: Any = scipy.linalg.lapack
"""Its routines exist at run time only, so type checkers do not know them."""
