"""Files of shapes: their bytes, with checks of size before parsing, as a small file can
demand much memory and time; and the vertices of PLY files."""

import json
import os
import struct
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from hefting.core.errors import InputError
from hefting.core.files import MAX_JSON, MAX_LISTS, check_readable
from hefting.core.spatial import Array

MAX_WORDS = 12_000_000
"""Most words, and most lines, of a mesh or point cloud in text. A word takes up to 130
bytes of memory while it is read (ASCII PLY, .off), 1.6 GB in all; an ASCII .stl of this
size has 570,000 triangles."""

MAX_LINE = 10_000
"""Longest line of a point cloud in text [characters]."""

MAX_CLOUD = 1_000_000
"""Most points of a cloud, whose hull then takes some seconds."""

MAX_NUMBERS = 50_000_000
"""Most numbers that the vertices of a PLY file may have in all (0.4 GB)."""

MAX_NODES, MAX_LEVELS, MAX_USED = 10_000, 100, 40_000_000
"""Most nodes of a scene, or parts of meshes, levels of nodes, and uses of numbers: the
time to place a node grows with its level."""

NUMPY = b"\x93NUMPY"
"""First bytes of a NumPy file."""
PART = 2**20
"""Bytes of a block in which words are counted."""
MAX_BYTES = 200_000_000
"""Size of the largest file that is read [bytes]."""
PlyKind = str | tuple[str, str]
"""Type of a property of a PLY file; for a list the types of its length and its items."""
PlyElement = tuple[str, int, list[tuple[str, PlyKind]]]
"""Element of a PLY file: name, number, properties with their types."""
PLY_TYPES = dict(
    zip(
        [
            "char",
            "uchar",
            "short",
            "ushort",
            "int",
            "uint",
            "float",
            "double",
            "int8",
            "uint8",
            "int16",
            "uint16",
            "int32",
            "uint32",
            "float32",
            "float64",
        ],
        2 * ["i1", "u1", "i2", "u2", "i4", "u4", "f4", "f8"],
        strict=True,
    )
)
PLY_ORDERS = {"binary_little_endian": "<", "binary_big_endian": ">"}


def check_text(data: bytes, path: str | Path) -> None:
    """`InputError` for a text of more than `MAX_WORDS` words or lines."""
    lines, words, between = 0, 0, True
    for first in range(0, len(data), PART):
        text = np.frombuffer(data, np.uint8, min(PART, len(data) - first), first)
        # separators of words: control characters, blanks, commas, semicolons
        blank = (text <= ord(" ")) | (text == ord(",")) | (text == ord(";"))
        starts = ~blank
        starts[1:] &= blank[:-1]
        starts[0] &= between
        words += int(np.count_nonzero(starts))
        lines += int(np.count_nonzero((text < ord(" ")) & (text != ord("\t"))))
        between = bool(blank[-1])
        if max(words, lines) > MAX_WORDS:
            what = f"holds more than {MAX_WORDS // 1_000_000} million words of text"
            fix = "simplify or downsample it, or export it as a binary file"
            raise InputError(what, path, fix)


def check_count(count: int, path: str | Path) -> None:
    """`InputError` for a cloud of more than `MAX_CLOUD` points."""
    if count > MAX_CLOUD:
        raise InputError(
            f"the point cloud has more than {MAX_CLOUD:,} points", path, "downsample it"
        )


def load_array(path: str | Path) -> np.ndarray:
    """The numbers of a NumPy file, read where they are used; `ValueError` for others."""
    try:
        with np.errstate(over="ignore"):  # for sizes in a damaged header
            array = np.load(path, mmap_mode="r", allow_pickle=False)
    except Exception as error:  # a damaged header makes NumPy fail in any way
        raise ValueError("not a whole array") from error
    if array.dtype.kind not in "fiu":
        raise ValueError("not an array of numbers")
    return array


def check_glb(data: bytes) -> None:
    """`ValueError` or `LookupError` for a binary glTF scene whose header is too large for
    JSON, that has too many nodes, levels of them or parts, or whose arrays are longer than
    the file (glTF allows arrays without data, filled with zeros) or used too often."""
    header = data[20 : 20 + struct.unpack_from("<I", data, 12)[0]]
    if len(header) > MAX_JSON or header.count(b"[") + header.count(b"{") > MAX_LISTS:
        raise ValueError("the header is too large")
    scene = json.loads(header)
    counts = [abs(each["count"]) for each in scene["accessors"]]
    empty = [0 if "bufferView" in a else abs(a["count"]) for a in scene["accessors"]]
    nodes, meshes = scene.get("nodes", []), [m["primitives"] for m in scene["meshes"]]
    used = [
        counts[k]
        for parts in meshes
        for part in parts
        for k in (*part["attributes"].values(), part.get("indices", 0))
    ]
    placed = [len(meshes[node["mesh"]]) for node in nodes if "mesh" in node]
    below = [node.get("children", ()) for node in nodes]
    many = sum(map(len, meshes)), sum(placed), len(nodes), sum(map(len, below))
    if (
        sum(counts) > len(data)
        or sum(empty) > MAX_CLOUD
        or sum(used) > MAX_USED
        or max(many) > MAX_NODES
        or _levels(below) > MAX_LEVELS
    ):
        raise ValueError("too long arrays, or too many parts")


def _levels(children: list[list[int]]) -> int:
    """Number of levels of nodes with these children, at most one too many."""
    count, level = 0, set(range(len(children)))
    while level and count <= MAX_LEVELS:
        count, level = count + 1, {child for node in level for child in children[node]}
    return count


@dataclass(frozen=True)
class PlyVertices:
    """Vertices of a PLY file."""

    columns: dict[str, Array]
    """Every vertex property by its name, (n,)."""
    has_faces: bool
    """Whether the file also lists faces."""

    @property
    def positions(self) -> Array:
        """(n, 3) in the unit of the file."""
        return np.column_stack([self.columns[axis] for axis in "xyz"]).astype(float)


def read_ply_vertices(path: str | Path) -> PlyVertices:
    """Vertex properties of an ASCII or binary PLY file. `InputError` if damaged."""
    _, data = read_bytes(path, (".ply",), "a PLY file")
    fix = "export it again as ASCII or binary PLY"
    if not data.startswith(b"ply") or _ply_body(data) == 0:
        raise InputError("not a PLY file", path, fix)
    try:
        form, elements, start = _read_ply_header(data)
        _check_vertices(elements[0])
        _, count, properties = elements[0]
        if count * len(properties) > MAX_NUMBERS:
            raise ValueError("too many numbers")
        if form == "ascii":
            check_text(data, path)
            columns = _read_ascii(data[start:], count, [name for name, _ in properties])
        else:
            record = np.dtype([(n, PLY_ORDERS[form] + kind) for n, kind in properties])  # type: ignore[operator]
            table = np.frombuffer(data, record, count=count, offset=start)
            columns = {n: table[n].astype(float) for n, _ in properties}
    except (ValueError, KeyError, IndexError) as error:
        raise InputError(
            "damaged PLY file, or one without x, y, z of vertices first", path, fix
        ) from error
    return PlyVertices(columns, any(n == "face" and k > 0 for n, k, _ in elements))


def _check_vertices(element: PlyElement) -> None:
    name, count, properties = element
    names = {n for n, _ in properties}
    if name != "vertex" or count < 1 or not {"x", "y", "z"} <= names:
        raise ValueError("no vertices")
    if not all(isinstance(kind, str) for _, kind in properties):
        raise ValueError("lists among the vertices")


def _read_ascii(text: bytes, count: int, names: list[str]) -> dict[str, Array]:
    if count * (2 * len(names) - 1) > len(text):
        raise ValueError("truncated")
    lines = [line for line in text.decode("ascii").splitlines() if line.strip()]
    table = np.loadtxt(lines[:count], ndmin=2, comments=None)
    if table.shape != (count, len(names)):
        raise ValueError("truncated")
    return dict(zip(names, table.T, strict=True))


def _ply_body(data: bytes) -> int:
    """Offset of the first byte after the header of a PLY file; 0 if there is none."""
    end = data.find(b"end_header", 0, 100_000)
    return 0 if end < 0 else data.find(b"\n", end) + 1


def _read_ply_header(data: bytes) -> tuple[str, list[PlyElement], int]:
    """Format, elements (name, number, properties with their types) and length of the
    header of a PLY file.

    Raises ValueError, KeyError or IndexError for an invalid header.
    """
    form, elements, start = "", [], _ply_body(data)
    for line in data[:start].decode("ascii", "replace").splitlines():
        match line.split():
            case ["format", form, _]:
                pass
            case ["element", name, count]:
                elements.append((name, int(count), []))
            case ["property", "list", length, kind, name]:
                elements[-1][2].append((name, (PLY_TYPES[length], PLY_TYPES[kind])))
            case ["property", kind, name]:
                elements[-1][2].append((name, PLY_TYPES[kind]))
    return form, elements, start


def read_bytes(
    path: str | Path, suffixes: tuple[str, ...], kind: str
) -> tuple[str, bytes]:
    """Suffix and bytes of a file; `InputError` unless it has one of the suffixes, can be
    read, and is neither empty nor larger than `MAX_BYTES`."""
    file, suffix = Path(path), Path(path).suffix.lower()
    if suffix not in suffixes:
        what = f"'{suffix}' is not {kind} this can read"
        raise InputError(what, path, f"use one of {', '.join(suffixes)}")
    check_readable(path)
    try:
        if not file.is_file():
            what = "is not a file" if os.path.lexists(file) else "no such file"
            raise InputError(what, path, "check the path")
        if file.stat().st_size > MAX_BYTES:
            what = f"larger than {MAX_BYTES // 1_000_000} MB"
            raise InputError(what, path, "simplify or downsample it")
        data = file.read_bytes()
    except (OSError, ValueError) as error:
        raise InputError(
            "the file cannot be read", path, "check its permissions"
        ) from error
    if not data.strip():
        raise InputError("the file is empty", path, "export it again")
    first = data[:512].lstrip().lower()
    if first.startswith((b"<!doctype", b"<html", b"version https://git-lfs")):
        raise InputError(
            f"a web page or a placeholder, not {kind}", path, "download the file itself"
        )
    return suffix, data
