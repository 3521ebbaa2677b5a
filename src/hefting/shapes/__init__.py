"""Shapes: mesh, convex hull, point cloud, labelled parts or box -> `Shape` in the
sensor frame.

This file reads shapes and poses from their textual forms and from values in memory.
"""

from __future__ import annotations

import re
from os.path import isfile
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from hefting.core.errors import InputError
from hefting.core.files import MAX_JSON, read_bytes, read_json
from hefting.core.quantity import UNITS, turned_about
from hefting.core.spatial import Array, check_pose, frozen, plain, pose_matrix
from hefting.shapes.files import NUMPY, load_array, read_ply_vertices
from hefting.shapes.reading import CLOUD_SUFFIXES, MESH_SUFFIXES
from hefting.shapes.shape import LABELS, Shape

__all__ = ["Shape", "as_shape", "load_shape", "parse_pose"]

HOW_POSES_ARE_GIVEN = (
    "give x,y,z,qx,qy,qz,qw, or turns as in 30mm,0,0.1,z:90, or a JSON, text or .npy file "
    "with seven numbers or a 4 x 4 matrix"
)

BY_TRIMESH = (".gltf", ".3mf", ".dae")
BY_HAND = (".step", ".stp", ".iges", ".igs", ".sldprt", ".fbx", ".blend", ".usd")
"""Endings of files of shapes that trimesh, or the program that made them, converts."""


def load_shape(
    spec: str | Path,
    unit: str | None = None,
    pose: ArrayLike | str | Path | None = None,
    points: int | None = None,
    points_per_cm3: float | None = None,
    hull: bool = False,
) -> Shape:
    """Point masses from ``box:X0,X1,Y0,Y1,Z0,Z1`` (metres, sensor frame) or from a file
    whose kind follows from its suffix.

    .stl, .obj, .off, .glb and .ply with faces are meshes; .xyz, .txt, .csv, .npy and
    .ply without faces are filled point clouds; .ply without faces but with labels are
    labelled parts, of which all points are kept. With `hull` the convex hull of the
    file's vertices is used. The pose may be text, as for `parse_pose`. Other parameters
    and errors are those of `Shape.from_mesh`.

    Examples
    --------
    >>> shape = hefting.load_shape("demo/hammer.stl", unit="mm")
    >>> shape.extents.round(3).tolist()
    [0.125, 0.028, 0.292]
    """
    text = str(spec)
    if text.lower().startswith("box:"):
        if pose is not None or unit not in (None, "m"):
            fix = "leave out the object's pose and unit"
            raise InputError("a box is given in metres in the sensor frame", text, fix)
        try:
            sides = [float(number) for number in text[4:].split(",")]
        except ValueError:
            sides = []
        if len(sides) != 6:
            raise InputError(
                "a box is six numbers", text, "give box:X0,X1,Y0,Y1,Z0,Z1 in metres"
            )
        return Shape.from_box(*sides, points=points, points_per_cm3=points_per_cm3)
    pose = None if pose is None else as_pose(pose)
    suffix = Path(text).suffix.lower()
    if hull and suffix in (*MESH_SUFFIXES, *CLOUD_SUFFIXES):
        return Shape.from_hull(text, unit, pose, points, points_per_cm3)
    cloud = suffix in CLOUD_SUFFIXES
    if suffix == ".ply":
        vertices = read_ply_vertices(text)
        cloud = not vertices.has_faces
        if cloud and any(name in vertices.columns for name in LABELS):
            return Shape.from_parts(text, unit, pose)
    if cloud:
        return Shape.from_cloud(text, unit, pose, points, points_per_cm3)
    if suffix not in MESH_SUFFIXES:
        known = ", ".join(sorted({*MESH_SUFFIXES, *CLOUD_SUFFIXES}))
        fix = f"give box:X0,X1,Y0,Y1,Z0,Z1 or a file ending in {known}"
        if suffix in BY_TRIMESH:
            load = f"trimesh.load_scene({text!r}).to_mesh().export({text + '.stl'!r})"
            fix = f'convert it: pip install "trimesh[easy]", then in Python {load}'
        elif suffix in BY_HAND:
            fix = "export it as .stl, and give the unit it is exported in"
        raise InputError("not a shape that is read", text, fix)
    return Shape.from_mesh(text, unit, pose, points, points_per_cm3)


def as_shape(
    shape: Any, unit: str | None = None, pose: ArrayLike | str | Path | None = None
) -> Shape | None:
    """Shape from a file, text, mesh or points.

    Parameters
    ----------
    shape : path, str, mesh, array or Shape
        A file or ``box:X0,X1,Y0,Y1,Z0,Z1`` (`load_shape`); an object with ``vertices``
        and ``faces``, such as a ``trimesh.Trimesh``, or a ``trimesh.Scene``; points
        (n, 3) that fill the object, or a ``trimesh.PointCloud`` of such. A `Shape`,
        and None, are returned as they are. For points of the surface alone use
        `Shape.from_hull`.
    unit : str, optional
        Length unit of a file, mesh or points: m, cm, mm or in.
    pose : (4, 4), seven numbers, or text, optional
        Pose of its frame in the sensor frame; text as for `parse_pose`.

    Returns
    -------
    Shape or None

    Raises
    ------
    InputError
        For a value that is no shape, and for a unit or pose given with a `Shape`.
    """
    matrix = None if pose is None else as_pose(pose)
    if shape is None or isinstance(shape, Shape):
        if unit is not None or matrix is not None:
            what = "`unit` and `object_pose` are those of a shape's file or mesh"
            fix = "leave them out" if shape is None else "give them to `load_shape`"
            raise InputError(what, fix=fix)
        return shape
    if isinstance(shape, str | Path):
        return load_shape(shape, unit, matrix)
    if hasattr(shape, "to_mesh"):  # of trimesh, a scene
        shape = shape.to_mesh()
    points = getattr(shape, "vertices", shape)
    if getattr(shape, "faces", None) is not None:
        return Shape.from_mesh(shape, unit, matrix)
    if np.ndim(points) != 2:
        what = f"a value of type {type(shape).__name__} is not a shape"
        fix = "give a file, box:X0,X1,Y0,Y1,Z0,Z1, a mesh, or points (n, 3)"
        raise InputError(what, fix=fix)
    return Shape.from_cloud(points, unit, matrix)


def as_pose(pose: ArrayLike | str | Path) -> Array:
    """Pose (4, 4) from a matrix, seven numbers, or text as for `parse_pose`; `InputError`
    for anything else."""
    if isinstance(pose, str | Path):
        return parse_pose(pose)
    matrix = frozen(plain(pose))
    if matrix.shape not in ((4, 4), (7,)):
        what = f"a pose is a 4 x 4 matrix, not of shape {matrix.shape}"
        fix = "or give x, y, z, qx, qy, qz, qw"
        raise InputError(what, fix=fix)
    return pose_matrix(matrix) if matrix.shape == (7,) else check_pose(matrix)


def parse_pose(source: str | Path) -> Array:
    """Pose (4, 4) of an object in the sensor frame from ``x,y,z,qx,qy,qz,qw``, from
    ``x,y,z`` for parallel axes, with turns such as ``z:90`` [degrees] behind, each about
    an axis of the frame as turned so far, or from a JSON, text or ``.npy`` file.

    Lengths are in metres, or have a unit, as ``30mm``. The file holds a 4 x 4 matrix or
    those numbers. Raises `InputError` unless the quaternion has unit norm, or the matrix
    is a rigid motion, within 1e-3.

    Examples
    --------
    >>> hefting.parse_pose("0,0,100mm,z:90")[:3, 3].tolist()
    [0.0, 0.0, 0.1]
    """
    text = str(source)
    words = [word.strip() for word in text.split(",")]
    turns = [word for word in words if re.match(r"[xyz]:[-+.\d]", word)]
    try:
        numbers = [_length(word) for word in words if word not in turns]
        numbers = numbers or [0.0, 0.0, 0.0]
    except (ValueError, KeyError):
        numbers, turns = _numbers_in(text), []
    try:
        array = np.asarray(numbers, dtype=float)
    except (TypeError, ValueError, OverflowError):
        array = np.empty(0)
    try:
        if array.shape == (3,):
            array = np.append(array, (0.0, 0.0, 0.0, 1.0))
        if array.shape in ((7,), (4, 4)):
            pose = pose_matrix(array) if array.ndim == 1 else check_pose(array)
            for turn in turns:
                pose = pose @ turned_about(turn)
            return pose
    except InputError as error:
        raise InputError(error.what, text, error.fix) from None
    raise InputError("not a pose", text, HOW_POSES_ARE_GIVEN)


def _length(word: str) -> float:
    """A length [m], with or without its unit. `ValueError` or `KeyError` for another
    word."""
    number = word.rstrip("cm")
    return float(number) * UNITS["length"][word[len(number) :] or "m"]


def _numbers_in(path: str) -> Any:
    """The numbers of a JSON file, of NumPy's, or of text as it and scanners write it."""
    if not isfile(path):
        raise InputError("neither numbers nor a file", path, HOW_POSES_ARE_GIVEN)
    data = read_bytes(path, MAX_JSON, "a pose")
    if data.startswith(NUMPY):
        try:
            return load_array(path)
        except ValueError:
            return None
    words = data.replace(b",", b" ").split()
    try:
        numbers = np.array([float(word) for word in words])
    except ValueError:
        return read_json(path, HOW_POSES_ARE_GIVEN)
    return numbers.reshape(4, 4) if numbers.size == 16 else numbers
