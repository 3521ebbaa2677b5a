"""LAPACK routines called directly: on matrices of 22 columns NumPy's wrappers cost more than the work.

They are SciPy's own, taken from its extension module without importing `scipy.linalg`, which takes twice as long as
NumPy and is needed for nothing else where the routines are.
"""

import sys
from importlib.machinery import EXTENSION_SUFFIXES
from importlib.util import find_spec, module_from_spec, spec_from_file_location
from pathlib import Path
from typing import Any


def _routines() -> Any:
    """SciPy's module of LAPACK routines, by its file; by `scipy.linalg` where that is imported or this fails."""
    name = "scipy.linalg._flapack"
    if "scipy.linalg" not in sys.modules and sys.platform != "win32":  # Windows finds its libraries through SciPy
        found = find_spec("scipy")
        folder = Path(found.origin).parent / "linalg" if found is not None and found.origin else None
        for suffix in EXTENSION_SUFFIXES if folder else ():
            file = folder / f"_flapack{suffix}"
            spec = spec_from_file_location(name, file) if file.is_file() else None
            if spec is None or spec.loader is None:
                continue
            try:
                module = module_from_spec(spec)
                spec.loader.exec_module(module)
            except ImportError:
                break
            return module
    import scipy.linalg.lapack

    return scipy.linalg.lapack


lapack: Any = _routines()
"""Its routines exist at run time only, so type checkers do not know them."""
