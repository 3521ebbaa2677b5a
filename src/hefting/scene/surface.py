"""Surfaces: triangles of a shape, as many as a picture needs, and of the links of a
robot."""

from dataclasses import dataclass

import numpy as np

from hefting.core.errors import InputError
from hefting.core.spatial import Array, frozen, rotation_matrices
from hefting.robots.visuals import LARGEST_SIZE, Geometry
from hefting.shapes import Shape
from hefting.shapes.reading import read_mesh

MOST_TRIANGLES = 30_000
"""Triangles that are drawn at most: a picture of three views then takes a second or
two, and shows the mesh to two percent of its size or better."""
FINEST = 200
"""Cells along the longest side in which vertices are merged at first."""


MOST_BYTES = 200_000_000
"""Sizes of all meshes that are read of one arm [bytes]."""


@dataclass(frozen=True, eq=False)
class Surface:
    """A closed surface of triangles, counter-clockwise seen from outside."""

    vertices: Array
    """(V, 3) [m] in sensor axes"""
    faces: np.ndarray
    """(F, 3) vertex indices"""
    is_object: bool = True
    """Whether it is the object's own surface; else the object is somewhere inside."""

    def __post_init__(self):
        object.__setattr__(self, "vertices", frozen(self.vertices))
        faces = np.array(self.faces, dtype=np.intp)
        faces.setflags(write=False)
        object.__setattr__(self, "faces", faces)


def surface_of(shape: Shape, most: int = MOST_TRIANGLES) -> Surface | None:
    """The surface of a shape with at most about so many triangles; None for a cloud,
    and where no shape is known."""
    if shape.faces is None or shape.known == "reach":
        return None
    vertices, faces = coarser(shape.hull, shape.faces, most)
    return Surface(vertices, faces, shape.known == "object")


def coarser(vertices: Array, faces: np.ndarray, most: int) -> tuple[Array, np.ndarray]:
    """The same surface with at most `most` triangles: vertices in one cell of a grid
    are merged, and the grid made coarser until that is enough."""
    size = float(np.ptp(vertices, axis=0).max())
    pitch = size / FINEST
    merged, left = vertices, faces
    while len(left) > max(most, 1):
        merged, left = _merged(vertices, faces, pitch)
        pitch *= 1.5
    return merged, left


def _merged(
    vertices: Array, faces: np.ndarray, pitch: float
) -> tuple[Array, np.ndarray]:
    """Vertices merged by cells of side `pitch`, each at its vertices' mean; triangles
    that vanish and those that occur twice are left out."""
    i, j, k = ((vertices - vertices.min(axis=0)) / pitch).astype(np.int64).T
    cell = (i * 2 * FINEST + j) * 2 * FINEST + k
    _, index, count = np.unique(cell, return_inverse=True, return_counts=True)
    means = np.column_stack(
        [np.bincount(index, vertices[:, axis]) / count for axis in range(3)]
    )
    new = index[faces]
    a, b, c = new.T
    new = new[(a != b) & (b != c) & (c != a)]
    # the smallest index first, so that equal triangles are equal rows
    first = np.argmin(new, axis=1)[:, None]
    new = np.take_along_axis(new, (first + np.arange(3)) % 3, axis=1)
    new = new[np.lexsort(new.T)]
    repeated = np.zeros(len(new), dtype=bool)
    repeated[1:] = (new[1:] == new[:-1]).all(axis=1)
    return means, new[~repeated]


class LinkSurfaces:
    """Reads geometries of one robot until their meshes are `MOST_BYTES`."""

    def __init__(self):
        self._left = MOST_BYTES

    def read(self, geometry: Geometry) -> tuple[Array, np.ndarray] | None:
        """Vertices (V, 3) [m] in the link's frame and triangles (F, 3) of a geometry.

        None where its mesh cannot be read, holds no triangle, has no extent, or is
        larger than a robot, and where the meshes are too large together.
        """
        try:
            vertices, faces = self._own(geometry)
        except InputError:
            return None
        if not len(faces) or not np.abs(vertices).max() <= LARGEST_SIZE:
            return None  # also where a vertex is not finite
        if not np.ptp(vertices, axis=0).max() > 0.0:
            return None
        turned = vertices @ rotation_matrices(geometry.orientation).T
        return turned + geometry.position, faces

    def _own(self, geometry: Geometry) -> tuple[Array, np.ndarray]:
        """The same in the geometry's own frame; `InputError` where it cannot be read."""
        if geometry.kind != "mesh":
            return simple_solid(geometry)
        assert geometry.file is not None
        self._left -= geometry.file.stat().st_size
        if self._left < 0:
            raise InputError("the meshes are too large", geometry.file)
        vertices, faces = read_mesh(geometry.file)
        return vertices * np.array(geometry.size), faces


def simple_solid(geometry: Geometry) -> tuple[Array, np.ndarray]:
    """Vertices (V, 3) [m] and triangles of a box, cylinder or sphere about its own
    origin; a cylinder stands along z."""
    from trimesh import creation

    if geometry.kind == "box":
        solid = creation.box(extents=geometry.size)
    elif geometry.kind == "cylinder":
        radius, height = geometry.size
        solid = creation.cylinder(radius, height, sections=24)
    else:
        solid = creation.icosphere(subdivisions=2, radius=geometry.size[0])
    return np.asarray(solid.vertices, dtype=float), np.asarray(solid.faces)
