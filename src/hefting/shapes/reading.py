"""Reading meshes and point clouds from files, which are not trusted."""

import io
import re
import struct
import warnings
from array import array
from itertools import pairwise
from pathlib import Path

import numpy as np

from hefting.core.errors import InputError
from hefting.core.spatial import Array
from hefting.shapes.files import (
    MAX_LINE,
    NUMPY,
    check_count,
    check_glb,
    check_text,
    load_array,
    read_bytes,
    read_ply_vertices,
)

MESH_SUFFIXES = (".stl", ".obj", ".ply", ".off", ".glb")
CLOUD_SUFFIXES = (".xyz", ".csv", ".txt", ".npy", ".ply")
MAX_FACES = 3_000_000
"""Most triangles of a mesh, after the instances of a scene are laid out."""
STL_HEADER = 84
"""Bytes of a binary STL file before its triangles: a comment of 80 and their number."""
STL_TRIANGLE = np.dtype(
    [("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")]
)
"""A triangle of a binary STL file."""
STL_VERTEX = re.compile(
    rb"vertex\s++(\S{1,40})\s++(\S{1,40})\s++(\S{1,40})(?!\S)", re.IGNORECASE
)
"""A corner of a triangle in an ASCII STL file."""


def read_mesh(path: str | Path) -> tuple[Array, np.ndarray]:
    """Vertices (V, 3) in the unit of the file and faces (F, 3) of a mesh file; scenes
    become one mesh.

    Nothing but the file itself is opened: no textures, materials, or addresses it may
    name. Raises `InputError` for a file that is missing, too big, of another kind, or
    damaged.
    """
    suffix, data = read_bytes(path, MESH_SUFFIXES, "a mesh")
    if suffix == ".stl" and _is_binary_stl(data):
        return _binary_stl(data, path)
    if suffix != ".glb":
        check_text(data, path)
    try:
        read = {".stl": _ascii_stl, ".obj": _obj}.get(suffix)
        vertices, faces = read(data) if read else _by_trimesh(data, suffix, path)
    except InputError:
        raise
    except Exception as error:  # a damaged file makes a parser fail in any way
        what = f"not a readable {suffix} mesh"
        raise InputError(
            what, path, "export it again, for example as binary .stl"
        ) from error
    _check_faces(len(faces), path)
    return vertices, faces


def _by_trimesh(data: bytes, suffix: str, path: str | Path) -> tuple[Array, np.ndarray]:
    """Vertices and faces as trimesh reads them."""
    import logging

    import trimesh

    log = logging.getLogger("trimesh")
    if not log.handlers:  # otherwise Python prints messages about damaged files
        log.addHandler(logging.NullHandler())
    if suffix == ".glb":
        check_glb(data)
    elif suffix == ".off":
        data = data.decode(errors="replace").encode()
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        scene = trimesh.load_scene(
            io.BytesIO(data), file_type=suffix[1:], process=False, skip_materials=True
        )
        count = 0
        for node in scene.graph.nodes_geometry:
            part = scene.geometry[scene.graph[node][1]]
            corners = len(getattr(part, "vertices", ()))
            count += max(len(getattr(part, "faces", ())), corners // 3)
            _check_faces(count, path)
        mesh = scene.to_mesh()
    faces = np.asarray(mesh.faces, dtype=np.int64)
    return np.asarray(mesh.vertices, dtype=float), faces


def _ascii_stl(data: bytes) -> tuple[Array, np.ndarray]:
    """Vertices and faces of all solids in an ASCII STL file, each face with vertices of
    its own."""
    vertices = np.array(STL_VERTEX.findall(data)).astype(float)
    return vertices, np.arange(len(vertices)).reshape(-1, 3)


def _obj(data: bytes) -> tuple[Array, np.ndarray]:
    """Vertices and faces of an OBJ file, polygons as fans of triangles; what else is in
    it is passed over."""
    vertices, faces = array("d"), array("q")
    for line in data.replace(b"\\\r\n", b" ").replace(b"\\\n", b" ").splitlines():
        kind, *words = line.split() or [b""]
        if kind == b"v":
            x, y, z = map(float, words[:3])
            vertices.extend((x, y, z))
        elif kind == b"f":
            corners = [int(word.partition(b"/")[0]) for word in words]
            if 0 in corners:
                raise ValueError("there is no vertex 0")
            known = len(vertices) // 3
            first, *others = (k - 1 if k > 0 else k + known for k in corners)
            for pair in pairwise(others):
                faces.extend((first, *pair))
    return np.array(vertices).reshape(-1, 3), np.array(faces).reshape(-1, 3)


def _binary_stl(data: bytes, path: str | Path) -> tuple[Array, np.ndarray]:
    """Vertices and faces of a binary STL file, each face with vertices of its own."""
    count, size = (
        struct.unpack_from("<I", data, STL_HEADER - 4)[0],
        STL_TRIANGLE.itemsize,
    )
    if rest := len(data) - STL_HEADER - size * count:
        what = f"has {rest:,} bytes after its {count:,} triangles"
        raise InputError(what, path, "export it again")
    triangles = np.frombuffer(data, STL_TRIANGLE, offset=STL_HEADER)
    _check_faces(len(triangles), path)
    with np.errstate(invalid="ignore"):  # values that are not finite are refused later
        vertices = triangles["corners"].astype(float).reshape(-1, 3)
    return vertices, np.arange(len(vertices)).reshape(-1, 3)


def _check_faces(count: int, path: str | Path) -> None:
    if count > MAX_FACES:
        raise InputError(
            f"the mesh has more than {MAX_FACES} triangles", path, "simplify it"
        )


def _is_binary_stl(data: bytes) -> bool:
    if len(data) < STL_HEADER:
        return False
    count = struct.unpack_from("<I", data, STL_HEADER - 4)[0]
    rest = len(data) - STL_HEADER - STL_TRIANGLE.itemsize * count
    return rest == 0 or (rest > 0 and count > 0)


def read_cloud(path: str | Path) -> Array:
    """Points (n, 3) in the unit of the file: .xyz, .txt or .csv (x, y, z first or
    named), .npy, .ply."""
    suffix, data = read_bytes(path, CLOUD_SUFFIXES, "a point cloud")
    if suffix == ".ply":
        return read_ply_vertices(path).positions
    try:
        points = (_numpy_array if suffix == ".npy" else _text_table)(data, path)
    except InputError:
        raise
    except Exception as error:  # a damaged header makes NumPy fail in any way
        what = f"not a readable {suffix} point cloud"
        raise InputError(
            what, path, "give one point a row: x, y, z, numbers only"
        ) from error
    if points.ndim != 2 or points.shape[1] < 3 or len(points) == 0:
        what = f"a point cloud has three columns, not shape {points.shape}"
        raise InputError(what, path, "give x, y, z")
    return np.ascontiguousarray(points[:, :3])


def _numpy_array(data: bytes, path: str | Path) -> Array:
    """The first three columns of a NumPy file; ValueError unless it has numbers."""
    if not data.startswith(NUMPY):
        raise ValueError("not an array")
    array = load_array(path)
    check_count(len(array) if array.ndim else 0, path)
    if array.ndim != 2:
        return array  # is refused by its shape
    with np.errstate(over="ignore", invalid="ignore"):  # is refused later
        return np.array(array[:, :3], dtype=float)


def _text_table(data: bytes, path: str | Path) -> Array:
    """Numbers of a text table in UTF-8; a header naming x, y and z picks the columns.
    `InputError` for too many words or rows, `ValueError` for too long a row."""
    check_text(data, path)
    lines = data.decode("utf-8-sig").splitlines()
    lines = [line for line in lines if line.strip()]
    lines = [line for line in lines if not line.lstrip().startswith("#")]
    check_count(len(lines), path)
    if max(map(len, lines), default=0) > MAX_LINE:
        raise ValueError("a row is too long")
    head, columns = lines[0] if lines else "", None
    separator = next((c for c in ",;\t" if c in head), None)
    names = [name.strip().strip('"').lower() for name in head.split(separator)]
    if {"x", "y", "z"} <= set(names):
        columns, lines = [names.index(axis) for axis in "xyz"], lines[1:]
    if not lines:
        return np.empty((0, 3))
    return np.loadtxt(
        lines, delimiter=separator, usecols=columns, ndmin=2, comments=None
    )
