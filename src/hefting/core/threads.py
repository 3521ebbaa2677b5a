"""Threads of the linear algebra: one, which is enough for matrices of a few dozen rows.
With more, libraries wait for each other in a loop, which multiplies the processor time,
and results may differ in the last bit."""

import os
import sys

ONE_THREAD = {
    "OMP_NUM_THREADS": "1",
    "OPENBLAS_NUM_THREADS": "1",
    "MKL_NUM_THREADS": "1",
}
"""Environment of a process that computes on one thread."""


def use_one_thread() -> None:
    """Compute on one thread unless the user's environment sets the number. Libraries
    read it when they are loaded; if NumPy is, nothing changes."""
    if "numpy" not in sys.modules and not ONE_THREAD.keys() & os.environ.keys():
        os.environ.update(ONE_THREAD)
