"""Surfaces: triangles of a shape, reduced to as many as a picture needs, and of a robot's
links; ellipsoids of the COM's 95 % region, and of equal inertia."""

import numpy as np

from hefting.core.errors import InputError
from hefting.core.estimate import Estimate
from hefting.core.inertia import InertialParameters, com_jacobian
from hefting.core.sensor_accuracy import Z95
from hefting.core.spatial import (
    Array,
    changed_rows,
    freeze,
    immutable,
    own,
    rotation_matrices,
)
from hefting.robots.arm import LARGEST_SIZE, Geometry
from hefting.shapes import Shape
from hefting.shapes.reading import read_mesh

CHI95 = 2.7954834829151074
"""Radius that holds 95 % of a normal distribution in three dimensions, in standard
deviations: the root of the 0.95 quantile of chi-squared with 3 degrees of freedom."""
MOST_TRIANGLES = 30_000
"""Most triangles that are drawn: a picture of three views then takes one or two seconds,
and shows the mesh with errors of at most two percent of its size."""
FINEST = 200
"""Cells along the longest side of the first grid in which vertices are merged."""
MOST_BYTES = 200_000_000
"""Largest total size of the mesh files of one arm [bytes]."""


@immutable
class Ellipsoid:
    """The points ``center + half_axes @ u`` with |u| <= 1."""

    center: Array
    """(3,) [m]"""
    half_axes: Array
    """(3, 3) [m], a half-axis in each column"""

    def __post_init__(self):
        freeze(self, "center", "half_axes")

    @property
    def reach(self) -> Array:
        """(3,) [m] farthest distance from the center along each axis of the frame."""
        return np.linalg.norm(self.half_axes, axis=1)

    @property
    def principal(self) -> tuple[Array, Array]:
        """Lengths (3,) [m] of the perpendicular half-axes, the longest first, and the
        rotation (3, 3) with their directions as columns, by a singular value
        decomposition of `half_axes`, which need not be perpendicular."""
        rotation, lengths, _ = np.linalg.svd(self.half_axes)
        if np.linalg.det(rotation) < 0.0:
            rotation[:, 2] = -rotation[:, 2]
        return lengths, rotation

    def triangles(self, rings: int = 16) -> tuple[Array, np.ndarray]:
        """Its surface: vertices (V, 3) [m] and triangles (F, 3) of their indices, on
        `rings` circles of latitude with twice as many points each."""
        polar = np.pi * (np.arange(rings) + 0.5) / rings
        azimuth = np.pi * np.arange(2 * rings) / rings
        p, a = (grid.ravel() for grid in np.meshgrid(polar, azimuth, indexing="ij"))
        ball = np.column_stack(
            (np.sin(p) * np.cos(a), np.sin(p) * np.sin(a), np.cos(p))
        )
        ball = np.vstack((ball, (0.0, 0.0, 1.0), (0.0, 0.0, -1.0)))
        return self.center + ball @ self.half_axes.T, _ball_faces(rings)

    def shadow(self, i: int, j: int) -> Array:
        """Outline (120, 2) [m] of the ellipsoid seen along the third axis, projected on
        axes `i` and `j`."""
        # the shadow of {A u} is {B u}, B the two rows of A: an ellipse of matrix B B'
        rows = self.half_axes[[i, j]]
        values, vectors = np.linalg.eigh(rows @ rows.T)
        angle = np.linspace(0.0, 2.0 * np.pi, 120)
        circle = np.vstack((np.cos(angle), np.sin(angle)))
        outline = (vectors * np.sqrt(np.maximum(values, 0.0))) @ circle
        return self.center[[i, j]] + outline.T


def _ball_faces(rings: int) -> np.ndarray:
    """(F, 3) triangles of a grid of points on a ball and its two poles, the last two."""
    around = 2 * rings
    row, column = np.divmod(np.arange(around * (rings - 1)), around)
    here, beside = around * row + column, around * row + (column + 1) % around
    below, diagonal = here + around, beside + around
    i = np.arange(around)
    north, south, last = around * rings, around * rings + 1, around * (rings - 1)
    return np.vstack(
        (
            np.column_stack((here, below, diagonal)),
            np.column_stack((here, diagonal, beside)),
            np.column_stack((np.full(around, north), i, (i + 1) % around)),
            np.column_stack(
                (last + (i + 1) % around, last + i, np.full(around, south))
            ),
        )
    )


def uniform_ellipsoid(body: InertialParameters) -> Ellipsoid | None:
    """The ellipsoid of uniform density with the mass, COM and inertia of `body`.

    From J1 = m/5 (s2² + s3²) and so on: s1² = 5/(2m) (J2 + J3 - J1). None when no body
    has these parameters.
    """
    if not body.consistency().is_consistent:
        return None
    moments, axes = body.principal()
    square = 2.5 / body.mass * (moments.sum() - 2.0 * moments)
    return Ellipsoid(body.center_of_mass, axes * np.sqrt(np.maximum(square, 0.0)))


def com_region(estimate: Estimate) -> Ellipsoid | None:
    """The region that holds the COM with 95 % probability.

    Its width along each axis follows from the estimate's intervals, which for some
    methods include errors that the covariance does not, its tilt from the covariance.
    None without either, or if an axis is open.
    """
    half = com_reach(estimate)
    if half is None or not np.isfinite(half).all():
        return None
    values, axes = np.linalg.eigh(_com_correlation(estimate))
    root = axes * np.sqrt(np.maximum(values, 0.0))
    scale = half * (CHI95 / Z95)
    return Ellipsoid(estimate.parameters.center_of_mass, scale[:, None] * root)


def com_reach(estimate: Estimate) -> Array | None:
    """`reach` (3,) [m] of the COM."""
    return reach(estimate, "center_of_mass")


def reach(estimate: Estimate, name: str) -> Array | None:
    """Distance from the value of a quantity of ``Estimate.intervals`` to the farther end of
    its 95 % interval, or without intervals by the covariance.

    ``value ± reach`` holds the interval even if it is asymmetric. Infinite where open, None
    if the method has no uncertainty.
    """
    open_ = np.asarray(getattr(estimate.undetermined, name))
    if estimate.intervals is not None:
        value = np.asarray(getattr(estimate.parameters, name))
        half = np.abs(estimate.intervals[name] - value).max(axis=0)
    elif estimate.std is not None:
        half = Z95 * np.asarray(estimate.std[name])
    elif open_.any():
        half = np.full(open_.shape, np.nan)
    else:
        return None
    return np.where(open_, np.inf, half)


def _com_correlation(estimate: Estimate) -> Array:
    """Correlation (3, 3) of the COM's errors; the identity if undetermined."""
    covariance = estimate.covariance
    if covariance is None or not np.isfinite(covariance[:4, :4]).all():
        return np.eye(3)
    jacobian = com_jacobian(estimate.parameters)[1:4, :4]
    of_com = jacobian @ covariance[:4, :4] @ jacobian.T
    std = np.sqrt(np.maximum(of_com.diagonal(), 0.0))
    if not (std > 0.0).all():
        return np.eye(3)
    return of_com / np.outer(std, std)


@immutable
class Surface:
    """A closed surface of triangles, counter-clockwise seen from outside."""

    vertices: Array
    """(V, 3) [m] in sensor axes"""
    faces: np.ndarray
    """(F, 3) vertex indices"""
    is_object: bool = True
    """Whether it is the object's own surface; else the object is somewhere inside."""

    def __post_init__(self):
        freeze(self, "vertices")
        object.__setattr__(self, "faces", own(np.array(self.faces, dtype=np.intp)))


def surface_of(shape: Shape) -> Surface | None:
    """The surface of a shape, of at most `MOST_TRIANGLES`; None without one."""
    if shape.faces is None or shape.known == "reach":
        return None
    vertices, faces = coarser(shape.hull, shape.faces, MOST_TRIANGLES)
    return Surface(vertices, faces, shape.known == "object")


def coarser(vertices: Array, faces: np.ndarray, most: int) -> tuple[Array, np.ndarray]:
    """The surface with at most `most` triangles: vertices in one cell of a grid are
    merged, with coarser and coarser grids."""
    size = float(np.ptp(vertices, axis=0).max())
    pitch = size / FINEST
    merged, remaining = vertices, faces
    while len(remaining) > max(most, 1):
        merged, remaining = _merged(vertices, faces, pitch)
        pitch *= 1.5
    return merged, remaining


def _merged(
    vertices: Array, faces: np.ndarray, pitch: float
) -> tuple[Array, np.ndarray]:
    """Vertices merged to their mean in each cell of side `pitch` [m], and the triangles
    without degenerate and repeated ones."""
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
    return means, new[changed_rows(new)]


class LinkSurfaces:
    """Reads geometries of one robot, up to meshes of `MOST_BYTES` in total."""

    def __init__(self):
        self._left = MOST_BYTES

    def read(self, geometry: Geometry) -> tuple[Array, np.ndarray] | None:
        """Vertices (V, 3) [m] in the link's frame and triangles (F, 3) of a geometry.

        None if its mesh cannot be read, has no triangle or extent, is larger than
        `LARGEST_SIZE`, or exceeds the total of `MOST_BYTES`.
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
        """The same in the geometry's own frame; `InputError` if it cannot be read."""
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
