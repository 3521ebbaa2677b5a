"""NumPy's .npz: named arrays of numbers, one sample a row; see `MemoryTable`. Nothing
in it is unpickled."""

import zipfile
import zlib
from math import prod
from pathlib import Path
from tokenize import TokenError
from typing import Any

from numpy.lib import format as npy

from hefting.core.errors import InputError
from hefting.logs.layout import Layout
from hefting.logs.memory_table import MemoryTable
from hefting.logs.registry import Format
from hefting.logs.table import LONGEST_LIST, MAX_CELLS

DAMAGED = (
    zipfile.BadZipFile,
    zlib.error,
    EOFError,
    LookupError,
    MemoryError,
    NotImplementedError,
    OverflowError,
    RuntimeError,
    SyntaxError,
    TokenError,
    TypeError,
    ValueError,
)
"""What reading a damaged archive raises, or one packed or encrypted in another way."""


def open_npz(path: str | Path, _layout: Layout | None = None) -> MemoryTable:
    """The arrays of numbers in the .npz at `path`; a layout says nothing about it. Left
    out are arrays of more than `LONGEST_LIST` numbers a sample, such as images.

    Raises `InputError` where it cannot be read, holds more than `MAX_CELLS` numbers, or
    none.
    """
    try:
        with zipfile.ZipFile(path) as archive:
            arrays, objects = _arrays(archive, path)
    except DAMAGED as error:
        raise InputError(
            f"cannot be read as .npz ({str(error)[:80]})", path, "write the file again"
        ) from error
    if not arrays:
        held = f": {objects[0]!r} holds Python objects" if objects else ""
        fix = "write it by numpy.savez(file, time=..., pose=..., wrench=...)"
        raise InputError(f"holds no arrays of numbers{held}", path, fix)
    return MemoryTable.of_arrays(str(path), arrays)


def _arrays(
    archive: zipfile.ZipFile, path: str | Path
) -> tuple[dict[str, Any], list[str]]:
    """The arrays of an archive that may be columns, and the names of those that hold
    Python objects, which are not read."""
    arrays: dict[str, Any] = {}
    objects: list[str] = []
    cells = 0
    for name in archive.namelist():
        if not name.endswith(".npy"):
            continue
        with archive.open(name) as member:
            version = npy.read_magic(member)
            new = (
                npy.read_array_header_1_0
                if version == (1, 0)
                else npy.read_array_header_2_0
            )
            shape, _, dtype = new(member)
        if dtype.hasobject:
            objects.append(name.removesuffix(".npy"))
        size = prod(shape)
        if dtype.kind not in "iufbmM" or size > LONGEST_LIST * max(shape, default=1):
            continue
        cells += size
        if cells > MAX_CELLS:
            what = f"holds more than {MAX_CELLS:,} numbers, too many to read"
            raise InputError(what, path, "cut out the part of interest")
        with archive.open(name) as member:
            array = npy.read_array(member, allow_pickle=False)
        arrays[name.removesuffix(".npy")] = array
    return arrays, objects


FORMAT = Format(
    name="NumPy",
    description="NumPy's named arrays, such as time, pose, wrench, or others that names or a map tell",
    suffixes=(".npz",),
    help_names=(".npz",),
    open_table=open_npz,
    in_blocks=False,
)
"""Arrays as `numpy.savez` writes them."""
