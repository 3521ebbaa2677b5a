"""Surface: the triangles of a shape, as many as a picture needs."""

from dataclasses import dataclass

import numpy as np

from hefting.core.spatial import Array, frozen
from hefting.shapes import Shape

MOST_TRIANGLES = 30_000
"""Triangles that are drawn at most: a picture of three views then takes a second or
two, and shows the mesh to two percent of its size or better."""
FINEST = 200
"""Cells along the longest side in which vertices are merged at first."""


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
