"""LAPACK routines called directly: on matrices of 22 columns NumPy's wrappers cost more
than the work.

They are SciPy's own, taken from its extension module by its file: importing
`scipy.linalg` takes twice as long as importing NumPy, and is needed for nothing else
where the routines are. Where that fails it is imported.
"""

import sys
from importlib.machinery import EXTENSION_SUFFIXES
from importlib.util import find_spec, module_from_spec, spec_from_file_location
from pathlib import Path
from typing import Any

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
