"""NumPy's .npz: named arrays of numbers, one sample for each row; see `MemoryTable`.
Nothing in it is unpickled."""

import zipfile
from math import prod
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.lib import format as npy

from hefting.core.errors import InputError
from hefting.logs.layout import Layout
from hefting.logs.registry import Format
from hefting.logs.table import LONGEST_LIST, check_cells

if TYPE_CHECKING:
    from hefting.logs.memory_table import MemoryTable


def open_npz(path: str | Path, _layout: Layout | None = None) -> "MemoryTable":
    """The arrays of numbers in the .npz at `path`; the layout is not used. Of other
    arrays, and those of more than `LONGEST_LIST` numbers per sample, such as images, only
    names and shapes are read.

    Raises `InputError` for a file that cannot be read, holds more than `MAX_CELLS`
    numbers or none, or has one of these other arrays by the name of a stream (`ARRAYS`).
    """
    from hefting.logs.memory_table import MemoryTable

    try:
        with zipfile.ZipFile(path) as archive:
            arrays, others = _arrays(archive, path)
    except InputError:
        raise
    except Exception as error:  # damaged, encrypted, or packed in another way
        raise InputError(
            f"cannot be read as .npz ({str(error)[:80]})", path, "write the file again"
        ) from error
    if not arrays:
        first = next(iter(others.items()), None)
        held = f": {first[0]!r} holds {_kind(first[1].dtype)}" if first else ""
        fix = "write it by numpy.savez(file, time=..., pose=..., wrench=...)"
        raise InputError(f"holds no arrays of numbers{held}", path, fix)
    return MemoryTable.of_arrays(str(path), arrays | others)


def _arrays(
    archive: zipfile.ZipFile, path: str | Path
) -> tuple[dict[str, Any], dict[str, Any]]:
    """The arrays of an archive that may be columns, and placeholders of the same shapes
    for the others. `InputError` for one of the latter by the name of a stream."""
    from hefting.logs.arrays import ARRAYS

    arrays: dict[str, Any] = {}
    others: dict[str, Any] = {}
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
        size, own = prod(shape), name.removesuffix(".npy")
        large = size > LONGEST_LIST * max(shape, default=1)
        if large or dtype.kind not in "iufbmM":
            if own in ARRAYS:
                what = f"array {own!r} {shape} holds {_kind(dtype)}, which is not read"
                raise InputError(what, path, "write it as numbers, one sample a row")
            if shape:  # a scalar is no array of samples
                text = large or dtype.hasobject
                one = np.full((), "", object) if text else np.empty((), dtype)
                others[own] = np.broadcast_to(one, shape)
            continue
        cells += size
        check_cells(cells, path)
        with archive.open(name) as member:
            array = npy.read_array(member, allow_pickle=False)
        arrays[own] = array
    return arrays, others


def _kind(dtype: Any) -> str:
    return "Python objects" if dtype.hasobject else str(dtype)[:40]


FORMAT = Format(
    name="NumPy",
    description="NumPy's named arrays, such as time, pose, wrench, or others by name or column map",
    suffixes=(".npz",),
    help_names=(".npz",),
    open_table=open_npz,
    in_blocks=False,
)
"""Arrays as `numpy.savez` writes them."""
