"""Reading shapes from files (meshes, point clouds, labelled parts), and checks of what
is said of them.

Files are not trusted.
"""

import io
import json
import struct
import warnings
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from hefting.core.errors import InputError, nearest
from hefting.core.messages import Message, warning
from hefting.core.spatial import Array, inverse_pose
from hefting.shapes.sampling import MAX_POINTS

MESH_SUFFIXES = (".stl", ".obj", ".ply", ".off", ".glb")
CLOUD_SUFFIXES = (".xyz", ".csv", ".txt", ".npy", ".ply")
MAX_BYTES = 200_000_000
"""Largest file read."""
MAX_FACES = 3_000_000
"""Most triangles of a mesh, after the instances of a scene are laid out."""

UNITS = {"m": 1.0, "cm": 1e-2, "mm": 1e-3, "in": 0.0254}
"""Length units [m] of a shape's file."""

STL_HEADER = 84
"""Bytes of a binary STL file before its triangles: a comment of 80, and their
number."""
STL_TRIANGLE = np.dtype(
    [("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")]
)
"""A triangle of a binary STL file."""

PLY_TYPES = {
    **{
        "char": "i1",
        "uchar": "u1",
        "short": "i2",
        "ushort": "u2",
        "int": "i4",
        "uint": "u4",
    },
    **{
        "int8": "i1",
        "uint8": "u1",
        "int16": "i2",
        "uint16": "u2",
        "int32": "i4",
        "uint32": "u4",
    },
    **{"float": "f4", "double": "f8", "float32": "f4", "float64": "f8"},
}
PLY_ORDERS = {"binary_little_endian": "<", "binary_big_endian": ">"}
PlyKind = str | tuple[str, str]
"""Type of a property of a PLY file; of a list those of its length and its items."""


def read_mesh(path: str | Path) -> tuple[Array, np.ndarray]:
    """Vertices (V, 3) in the unit of the file and faces (F, 3) of a mesh file; scenes
    become one mesh.

    Nothing but the file itself is opened: no textures, materials, or addresses it may
    name. Raises `InputError` for a file that is missing, too big, of another kind, or
    damaged.
    """
    suffix, data = _contents(path, MESH_SUFFIXES, "a mesh")
    if suffix == ".stl" and _is_binary_stl(data):
        return _binary_stl(data, path)
    if suffix == ".ply" and (mesh := _binary_ply(data, path)) is not None:
        return mesh
    import trimesh

    try:
        if suffix == ".glb":
            _check_glb(data)
        elif suffix in (".obj", ".off") or data.startswith(b"solid"):
            data = _as_utf8(data)
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            scene = trimesh.load_scene(
                io.BytesIO(data),
                file_type=suffix[1:],
                process=False,
                skip_materials=True,
            )
            faces = 0
            for node in scene.graph.nodes_geometry:
                faces += len(getattr(scene.geometry[scene.graph[node][1]], "faces", ()))
                _check_faces(faces, path)
            mesh = scene.to_mesh()
        return np.asarray(mesh.vertices, dtype=float), np.asarray(
            mesh.faces, dtype=np.int64
        )
    except InputError:
        raise
    except Exception as error:  # a damaged file makes a parser fail in any way
        what = f"not a readable {suffix} mesh"
        raise InputError(
            what, path, "export it again, for example as binary .stl"
        ) from error


def _binary_stl(data: bytes, path: str | Path) -> tuple[Array, np.ndarray]:
    """Vertices and faces of a binary STL file, three vertices a face."""
    triangles = np.frombuffer(data, STL_TRIANGLE, offset=STL_HEADER)
    _check_faces(len(triangles), path)
    with np.errstate(invalid="ignore"):  # what is not finite is refused later
        vertices = triangles["corners"].astype(float).reshape(-1, 3)
    return vertices, np.arange(len(vertices)).reshape(-1, 3)


def _binary_ply(data: bytes, path: str | Path) -> tuple[Array, np.ndarray] | None:
    """Vertices and faces of a whole binary PLY file of vertices and triangles; None for
    any other."""
    try:
        form, ((vertex, count, properties), (face, number, entries)), start = (
            _ply_header(data)
        )
        order = PLY_ORDERS[form]
        points = np.dtype([(name, order + kind) for name, kind in properties])  # type: ignore[operator]
        lists = [(name, kind) for name, kind in entries if isinstance(kind, tuple)]
        ((corners, (length, index)),) = lists
        fields: list[tuple] = [
            (name, order + kind) for name, kind in entries if isinstance(kind, str)
        ]
        place = [name for name, _ in entries].index(corners)
        fields[place:place] = [
            ("number of corners", order + length),
            (corners, order + index, 3),
        ]
        triangle = np.dtype(fields)
    except (ValueError, KeyError, TypeError):
        return None
    if (
        (vertex, face) != ("vertex", "face")
        or corners not in ("vertex_indices", "vertex_index")
        or index[0] == "f"
    ):
        return None
    if (
        min(count, number) < 1
        or len(data) != start + count * points.itemsize + number * triangle.itemsize
    ):
        return None
    faces = np.frombuffer(data, triangle, number, start + count * points.itemsize)
    if (
        not {"x", "y", "z"} <= set(points.names or ())
        or (faces["number of corners"] != 3).any()
    ):
        return None
    _check_faces(number, path)
    table = np.frombuffer(data, points, count, start)
    with np.errstate(invalid="ignore"):  # what is not finite is refused later
        return np.column_stack([table[axis] for axis in "xyz"]).astype(float), faces[
            corners
        ].astype(np.int64)


def _check_faces(count: int, path: str | Path) -> None:
    if count > MAX_FACES:
        raise InputError(
            f"the mesh has more than {MAX_FACES} triangles", path, "simplify it"
        )


def _check_glb(data: bytes) -> None:
    """Raise ValueError for arrays longer than the file that holds them (glTF allows
    ones made of nothing)."""
    length = struct.unpack_from("<I", data, 12)[0]
    accessors = json.loads(data[20 : 20 + length])["accessors"]
    if sum(accessor["count"] for accessor in accessors) > len(data):
        raise ValueError("arrays longer than the file")


def _is_binary_stl(data: bytes) -> bool:
    if len(data) < STL_HEADER:
        return False
    return (
        len(data)
        == STL_HEADER
        + STL_TRIANGLE.itemsize * struct.unpack_from("<I", data, STL_HEADER - 4)[0]
    )


def _as_utf8(data: bytes) -> bytes:
    """Text in UTF-8; what is not is taken as Latin-1, which only comments and names can
    differ in."""
    try:
        data.decode()
    except UnicodeDecodeError:
        return data.decode("latin-1").encode()
    return data


def read_cloud(path: str | Path) -> Array:
    """Points (n, 3) in the unit of the file: .xyz, .txt or .csv (x, y, z first or
    named), .npy, .ply."""
    suffix, data = _contents(path, CLOUD_SUFFIXES, "a point cloud")
    if suffix == ".ply":
        return read_ply_vertices(path).positions
    try:
        if suffix == ".npy":
            points = np.array(
                np.load(path, mmap_mode="r", allow_pickle=False), dtype=float
            )
        else:
            points = _text_table(data.decode("utf-8-sig"))
    except (ValueError, OSError, EOFError, MemoryError) as error:
        what = f"not a readable {suffix} point cloud"
        raise InputError(
            what, path, "give one point a row: x, y, z, numbers only"
        ) from error
    if points.ndim != 2 or points.shape[1] < 3 or len(points) == 0:
        raise InputError(
            f"a point cloud has three columns, not shape {points.shape}",
            path,
            "give x, y, z",
        )
    return np.ascontiguousarray(points[:, :3])


def _text_table(text: str) -> Array:
    """Numbers of a text table; a header naming x, y and z picks the columns."""
    lines = [
        line
        for line in text.splitlines()
        if line.strip() and not line.lstrip().startswith("#")
    ]
    separator = next((c for c in ",;\t" if c in lines[0]), None) if lines else None
    columns = None
    names = (
        [name.strip().strip('"').lower() for name in lines[0].split(separator)]
        if lines
        else []
    )
    if {"x", "y", "z"} <= set(names):
        columns, lines = [names.index(axis) for axis in "xyz"], lines[1:]
    if not lines:
        return np.empty((0, 3))
    return np.loadtxt(
        lines, delimiter=separator, usecols=columns, ndmin=2, comments=None
    )


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
    """Vertex properties of an ASCII or binary PLY file. Raises `InputError` for a
    damaged one."""
    _, data = _contents(path, (".ply",), "a PLY file")
    fix = "export it again as ASCII or binary PLY"
    if not data.startswith(b"ply") or _ply_body(data) == 0:
        raise InputError("not a PLY file", path, fix)
    try:
        form, elements, start = _ply_header(data)
        name, count, properties = elements[0]
        names = [n for n, _ in properties]
        if name != "vertex" or count < 1 or not {"x", "y", "z"} <= set(names):
            raise ValueError("no vertices")
        if not all(isinstance(kind, str) for _, kind in properties):
            raise ValueError("lists among the vertices")
        if form == "ascii":
            if count * (2 * len(names) - 1) > len(data) - start:
                raise ValueError("truncated")
            lines = [
                line
                for line in data[start:].decode("ascii").splitlines()
                if line.strip()
            ][:count]
            table = np.loadtxt(lines, ndmin=2, comments=None)
            if table.shape != (count, len(names)):
                raise ValueError("truncated")
            columns = dict(zip(names, table.T, strict=True))
        else:
            record = np.dtype([(n, PLY_ORDERS[form] + kind) for n, kind in properties])  # type: ignore[operator]
            table = np.frombuffer(data, record, count=count, offset=start)
            columns = {n: table[n].astype(float) for n in names}
    except (ValueError, KeyError, IndexError) as error:
        raise InputError(
            "damaged PLY file, or one without x, y, z of vertices first", path, fix
        ) from error
    return PlyVertices(columns, any(n == "face" and k > 0 for n, k, _ in elements))


def _ply_body(data: bytes) -> int:
    """Where the header of a PLY file has ended; 0 if it does not."""
    end = data.find(b"end_header", 0, 100_000)
    return 0 if end < 0 else data.find(b"\n", end) + 1


def _ply_header(
    data: bytes,
) -> tuple[str, list[tuple[str, int, list[tuple[str, PlyKind]]]], int]:
    """Form, elements (name, number, properties with their types) and length of the
    header of a PLY file.

    Raises ValueError, KeyError or IndexError for one that is none.
    """
    form, elements, start = "", [], _ply_body(data)
    for words in (
        line.split() for line in data[:start].decode("ascii", "replace").splitlines()
    ):
        match words:
            case ["format", form, _]:
                pass
            case ["element", name, count]:
                elements.append((name, int(count), []))
            case ["property", "list", length, kind, name]:
                elements[-1][2].append((name, (PLY_TYPES[length], PLY_TYPES[kind])))
            case ["property", kind, name]:
                elements[-1][2].append((name, PLY_TYPES[kind]))
    return form, elements, start


def _contents(
    path: str | Path, suffixes: tuple[str, ...], kind: str
) -> tuple[str, bytes]:
    """Suffix and bytes of a file of an expected kind and bearable size."""
    file, suffix = Path(path), Path(path).suffix.lower()
    if suffix not in suffixes:
        raise InputError(
            f"'{suffix}' is not {kind} this can read",
            path,
            f"use one of {', '.join(suffixes)}",
        )
    try:
        if not file.is_file():
            raise InputError("no such file", path, "check the path")
        if file.stat().st_size > MAX_BYTES:
            raise InputError(
                f"larger than {MAX_BYTES // 1_000_000} MB",
                path,
                "simplify or downsample it",
            )
        data = file.read_bytes()
    except (OSError, ValueError) as error:
        raise InputError(
            "the file cannot be read", path, "check its permissions"
        ) from error
    if not data.strip():
        raise InputError("the file is empty", path, "export it again")
    if (
        data[:512]
        .lstrip()
        .lower()
        .startswith((b"<!doctype", b"<html", b"version https://git-lfs"))
    ):
        raise InputError(
            f"a web page or a placeholder, not {kind}", path, "download the file itself"
        )
    return suffix, data


def arrays_of(source: Any) -> tuple[Array, np.ndarray] | None:
    """Vertices and faces of an object that has both (a trimesh or Open3D-like mesh),
    else None."""
    vertices, faces = getattr(source, "vertices", None), getattr(source, "faces", None)
    if vertices is None or faces is None:
        return None
    return np.asarray(vertices, dtype=float), np.asarray(faces, dtype=np.int64)


def unit_scale(unit: str | None) -> float:
    """Metres per `unit`."""
    if unit is None:
        return 1.0
    if unit not in UNITS:
        raise InputError(
            f"unknown unit '{unit}'{nearest(str(unit), UNITS)}",
            fix=f"use one of {', '.join(UNITS)}",
        )
    return UNITS[unit]


def positive(value: float, name: str) -> float:
    """`value` if it is a positive number, else `InputError`."""
    if not (np.isfinite(value) and value > 0):
        raise InputError(f"{name} must be positive, not {value}")
    return float(value)


def point_count(points: int) -> int:
    """`points` if it is a sensible number of points, else `InputError`."""
    if not isinstance(points, int | np.integer) or not 1 <= points <= MAX_POINTS:
        raise InputError(
            f"the number of points must be 1 to {MAX_POINTS}, not {points!r}"
        )
    return int(points)


def point_array(points: Any, where: Any = None) -> Array:
    """`points` as a finite array (n, 3), else `InputError`."""
    try:
        p = np.asarray(points, dtype=float)
    except (TypeError, ValueError) as error:
        raise InputError(
            "a point cloud is an array (n, 3) of numbers", where
        ) from error
    if p.ndim != 2 or p.shape[1] != 3 or len(p) == 0:
        raise InputError(f"a point cloud is an array (n, 3), not {p.shape}", where)
    if not np.isfinite(p).all() or np.abs(p).max() > 1e9:
        raise InputError(
            "the point cloud has values that are not finite",
            where,
            "remove those points",
        )
    return p


def suspicions(
    low: Array, extents: Array, pose: Array, unit: str | None
) -> tuple[Message, ...]:
    """Warnings about a bounding box (lower corner and sides in object axes) unlikely
    for a held object."""
    longest, found = float(extents.max()), []
    if longest > 3:
        what = f"the shape is {longest:.3g} m long: is its file in millimetres? pass `unit`='mm'"
        found.append(warning("shape-long", what, "unit"))
    if longest < 1e-3:
        what = f"the shape is only {longest * 1e3:.3g} mm long: is `unit`='{unit or 'm'}' too small?"
        found.append(warning("shape-small", what, "unit"))
    origin = inverse_pose(pose)[:3, 3]
    distance = float(np.linalg.norm(origin - np.clip(origin, low, low + extents)))
    if distance > 1 or (distance > 0.3 and distance > 5 * np.linalg.norm(extents)):
        what = f"the shape is {distance:.3g} m away from the sensor: check the unit and pose of the object"
        found.append(warning("shape-far", what, "pose"))
    return tuple(found)
