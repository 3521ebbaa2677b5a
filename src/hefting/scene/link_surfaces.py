"""Surfaces of the links of a robot, from the meshes and simple solids of its URDF."""

import numpy as np

from hefting.core.errors import InputError
from hefting.core.spatial import Array, rotation_matrices
from hefting.robots.visuals import LARGEST_SIZE, Geometry
from hefting.shapes.reading import read_mesh

MOST_BYTES = 200_000_000
"""Sizes of all meshes that are read of one arm [bytes]."""


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
