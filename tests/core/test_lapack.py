"""The routines are SciPy's own, whichever is imported first."""

import subprocess
import sys

import pytest


@pytest.mark.parametrize("first", ["", "import scipy.linalg.lapack\n"])
def test_the_routines_are_those_of_scipy(first):
    code = (
        f"import sys\n{first}from hefting.core.lapack import lapack\n"
        f"assert ('scipy.linalg' in sys.modules) is {bool(first)}\n"
        "import numpy as np, scipy.linalg, scipy.linalg.lapack as whole\n"
        "assert all(getattr(lapack, name) is getattr(whole, name) for name in ('dgeqrf', 'dtpqrt', 'dposv'))\n"
        "a = np.diag((4.0, 9.0))\n"
        "assert np.array_equal(lapack.dpotrf(a)[0], np.diag((2.0, 3.0)))\n"
        "assert np.array_equal(scipy.linalg.cholesky(a), np.diag((2.0, 3.0)))\n"
    )
    subprocess.run([sys.executable, "-c", code], check=True)


def test_scipy_is_imported_where_its_file_is_not_found():
    code = (
        "import importlib.util as util, sys\nutil.find_spec = lambda name: None\n"
        "from hefting.core.lapack import lapack\n"
        "assert lapack is sys.modules['scipy.linalg.lapack']\n"
    )
    subprocess.run([sys.executable, "-c", code], check=True)
