"""MATLAB's .mat of versions 5 to 7: arrays of numbers, in structures and cells too; see
`MemoryTable`. Numbers are read, nothing else of it (source: MATLAB's MAT-File Format)."""

import struct
import zlib
from collections.abc import Iterator, Sequence
from itertools import islice
from math import prod
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from hefting.core.errors import InputError
from hefting.logs.canonical import MAX_COLUMNS
from hefting.logs.layout import Layout
from hefting.logs.registry import Format
from hefting.logs.table import LONGEST_LIST, MAX_CELLS, check_cells

if TYPE_CHECKING:
    from hefting.logs.memory_table import MemoryTable

HEADER = 128
"""Length of the text and version before the first array [bytes]."""
PACKED, CELL, STRUCT, OBJECT, TEXT, OPAQUE, NUMBERS = 15, 1, 2, 3, 4, 17, range(6, 16)
"""Type of a packed element; classes of arrays."""
TYPES = {1: "i1", 2: "u1", 3: "i2", 4: "u2", 5: "i4", 6: "u4", 7: "f4", 9: "f8"}
TYPES |= {12: "i8", 13: "u8"}
"""Types of numbers, as NumPy's."""
OF_DATA = (
    *("timetable", "table", "timeseries", "datetime", "duration", "quaternion"),
    *("se3", "so3", "Simulink.SimulationData.Dataset"),
)
"""Classes of objects that may hold the recording; others are passed over."""
MOST_ARRAYS, DEEPEST = 1_000_000, 20
"""Largest number of arrays, and of structures in one another."""
SAVE = "save it by save('log.mat', '-v7')"


def open_matlab(path: str | Path, _layout: Layout | None = None) -> "MemoryTable":
    """The arrays of numbers in the .mat at `path`; the layout is not used.

    Axes of length 1 are left out; ``s.t`` of a structure is ``s.t``, and elements of an
    array of structures, or of a cell, are samples where they are alike.

    Raises `InputError` for another version, a damaged file, one that holds more than
    `MAX_CELLS` numbers, and objects of `OF_DATA`, whose form MATLAB does not publish.
    """
    from hefting.logs.memory_table import MemoryTable

    check_cells(Path(path).stat().st_size // 8, path)
    data = Path(path).read_bytes()
    if b"\x89HDF\r\n\x1a\n" in (data[:8], data[512:520]):
        raise InputError("is of MATLAB 7.3 (HDF5)", path, SAVE)
    order = {b"IM": "<", b"MI": ">"}.get(data[126:HEADER], "")
    if not order:
        raise InputError("is not of MATLAB 5 to 7", path, SAVE)
    try:
        arrays = _Reader(path, order).arrays(memoryview(data)[HEADER:])
    except (ValueError, LookupError, StopIteration, struct.error, zlib.error) as error:
        what = f"cannot be read as .mat ({str(error)[:80] or 'it ends too early'})"
        raise InputError(what, path, SAVE) from error
    if not arrays:
        fix = "save its arrays by save('log.mat', 'time', 'pose', 'wrench', '-v7')"
        raise InputError("holds no arrays of numbers", path, fix)
    return MemoryTable.of_arrays(str(path), arrays)


class _Reader:
    """Reads the arrays of a file, of which `order` is that of bytes in a number."""

    def __init__(self, path: str | Path, order: str):
        self._path, self._order = path, order
        self._bytes, self._count, self._cells = 0, 0, 0

    def arrays(self, data: memoryview) -> dict[str, Any]:
        """The arrays, and dictionaries of them, by name."""
        found = {}
        for kind, part in self._elements(data):
            if kind == PACKED:
                most = 8 * (MAX_CELLS + 1) - self._bytes
                unpacked = zlib.decompressobj().decompress(part, most)
                self._bytes += len(unpacked)
                check_cells(self._bytes // 8, self._path)
                _, part = next(self._elements(memoryview(unpacked)))
            name, value = self._array(part)
            if name and value is not None:
                found[name] = value
            if len(found) > MAX_COLUMNS:
                raise ValueError(f"more than {MAX_COLUMNS:,} arrays")
        return found

    def _elements(self, data: memoryview) -> Iterator[tuple[int, memoryview]]:
        """Type and content of each element; `ValueError` where one is cut."""
        at = 0
        while at < len(data):
            kind, size = struct.unpack_from(f"{self._order}II", data, at)
            begin, padded = at + 8, kind != PACKED
            if kind >> 16:  # up to four bytes, in place of the size
                begin, kind, size = at + 4, kind & 0xFFFF, kind >> 16
            at = begin + size + (-(begin + size - at) % 8 if padded else 0)
            if begin + size > len(data):
                raise ValueError("it ends too early")
            yield kind, data[begin : begin + size]

    def _array(self, data: memoryview, depth: int = 0) -> tuple[str, Any]:
        """Name and value of an array: numbers, a dictionary, or None for others."""
        self._count += 1
        if depth > DEEPEST or self._count > MOST_ARRAYS:
            raise ValueError(f"more than {MOST_ARRAYS:,} arrays, or too deep")
        parts = self._elements(data)
        if not len(data):  # an empty field
            return "", None
        flags = self._integers(parts)[0]
        kind = flags & 0xFF
        if kind == OPAQUE:
            return self._opaque([_text(part) for _, part in islice(parts, 3)])
        shape = [int(n) for n in self._integers(parts)]
        name = _text(next(parts)[1])
        if kind in NUMBERS and not flags & 0x800:  # not complex
            form, part = next(parts)
            values = np.frombuffer(part, self._order + TYPES[form])
            if prod(shape) != len(values) or min(shape) < 0:
                raise ValueError(f"{len(values)} numbers of shape {shape}"[:60])
            self._cells += len(values)
            check_cells(self._cells, self._path)
            return name, values.reshape(shape, order="F").squeeze()
        if kind == CELL:
            return name, _together([self._array(p, depth + 1)[1] for _, p in parts])
        if kind not in (STRUCT, OBJECT):
            return name, None if kind == TEXT and shape[0] < 2 else _others(
                min(max(shape), len(data))
            )
        if kind == OBJECT:
            next(parts)
        (length,), (_, names) = self._integers(parts), next(parts)
        if len(names) > MAX_COLUMNS * length:
            raise ValueError(f"more than {MAX_COLUMNS:,} fields")
        fields = [_text(names[i : i + length]) for i in range(0, len(names), length)]
        values = [self._array(part, depth + 1)[1] for _, part in parts]
        held = {f: _together(values[i :: len(fields)]) for i, f in enumerate(fields)}
        return name, {f: value for f, value in held.items() if value is not None}

    def _integers(self, parts: Iterator[tuple[int, memoryview]]) -> Sequence[int]:
        part = next(parts)[1]
        if len(part) > 256:
            raise ValueError("more than 64 axes")
        return np.frombuffer(part, f"{self._order}i4").tolist()

    def _opaque(self, texts: list[str]) -> tuple[str, None]:
        """`InputError` for an object of `OF_DATA`."""
        name, _, kind = texts
        if kind in OF_DATA:
            what = f"{name[:40] or 'a field'} is a {kind}, whose form is MATLAB's own"
            fix = (
                "save numbers in its place: seconds(t), posixtime(t), compact(q), T.Variables, "
                "table2struct(T, 'ToScalar', true)"
            )
            raise InputError(what, self._path, fix)
        return name, None


def _together(values: list[Any]) -> Any:
    """One value; several of one shape as samples, or else by their numbers."""
    if len(values) < 2:
        return values[0] if values else None
    keys = [value.keys() if isinstance(value, dict) else None for value in values]
    if keys[0] and keys.count(keys[0]) == len(keys):
        return {key: _together([value[key] for value in values]) for key in keys[0]}
    shapes = {getattr(value, "shape", None) for value in values}
    if len(shapes) == 1 and None not in shapes:
        return np.stack(values)
    some = values if len(values) <= LONGEST_LIST else []
    return {str(k): v for k, v in enumerate(some) if v is not None} or _others(
        len(values)
    )


def _others(count: int) -> Any:
    """In place of several texts, and of other arrays: a time must not be passed over."""
    return np.broadcast_to(np.full((), "", object), count)


def _text(data: memoryview) -> str:
    return bytes(data[:1000]).split(b"\0")[0].decode(errors="replace")


FORMAT = Format(
    name="MATLAB",
    description="MATLAB's arrays and structures, saved with `-v7`, by name or column map",
    suffixes=(".mat",),
    help_names=(".mat",),
    open_table=open_matlab,
    in_blocks=False,
)
"""Arrays as `save` writes them."""
