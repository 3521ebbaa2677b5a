"""Shape: where an object may have mass, as points in the sensor frame."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from functools import cached_property, lru_cache
from pathlib import Path
from typing import Any, Self

import numpy as np
from numpy.typing import ArrayLike

from hefting.core.errors import InputError
from hefting.core.inertia import InertialParameters
from hefting.core.messages import warning
from hefting.core.spatial import Array, check_pose, frozen, own, tensor_to_vector
from hefting.core.summary import Shown
from hefting.shapes.checks import (
    DEFAULT_POINTS,
    REACH,
    ROUGH,
    SMALL_CAPS,
    SMALL_CAVITIES,
    arrays_of,
    check_doubt,
    check_hull,
    check_one_given,
    check_parts,
    check_positions,
    checked_labels,
    checked_numbers,
    count_of_points,
    doubt_of_caps,
    point_array,
    point_count,
    positive,
    shares_of,
    suspicions,
    unit_scale,
)
from hefting.shapes.clouds import (
    convex_hull,
    depth_in_hull,
    empty_share,
    voxel_representatives,
)
from hefting.shapes.files import read_ply_vertices
from hefting.shapes.reading import CLOUD_SUFFIXES, read_cloud, read_mesh
from hefting.shapes.sampling import sample
from hefting.shapes.solid import Solid, box_solid, solid_from_mesh
from hefting.shapes.winding import without_overlaps

LABELS = ("segmentation", "label", "labels")
"""Names of the property of a PLY file that holds the part of each point."""


@dataclass(frozen=True, eq=False)
class Shape(Shown):
    """Points at which a rigid object may have mass; n of them, each with an unknown
    mass m_i >= 0.

    ``Shape(positions)`` takes (n, 3) in the sensor frame [m]; the factories read
    shapes. The inertial parameters about the sensor origin are linear in the masses:
    phi = ``matrix`` @ m (Nadeau et al. 2022). Raises `InputError` for arrays of the
    wrong shape or values that are not finite.

    Examples
    --------
    >>> import trimesh
    >>> mesh = trimesh.creation.cylinder(radius=30, height=120)
    >>> shape = hefting.Shape.from_mesh(mesh, unit="mm")
    >>> shape.extents.round(3).tolist()
    [0.06, 0.06, 0.12]
    """

    positions: Array = field(repr=False)
    """Points (n, 3) [m] in the sensor frame."""
    volumes: Array | None = field(default=None, repr=False)
    """Share of the object's volume of each point (n,), with sum one; None: equal."""
    labels: np.ndarray | None = field(default=None, repr=False)
    """Part of each point, (n,) integers; None: unknown."""
    cell_inertia: Array | None = field(default=None, repr=False)
    """Inertia of the cell of each point about the point per unit mass (n, 6) [m²]: xx,
    xy, xz, yy, yz, zz in sensor axes; None: zero."""
    extents: Array = None  # type: ignore[assignment]
    """Sides (3,) [m] of the object's bounding box along the axes of `pose`; by default
    those of the points."""
    pose: Array = field(default=None, repr=False)  # type: ignore[assignment]
    """Pose of the object in the sensor frame (4, 4); by default the identity."""
    homogeneous: InertialParameters = field(default=None, repr=False)  # type: ignore[assignment]
    """The object with 1 kg of uniform density, in the sensor frame: exact for a mesh,
    otherwise from the points."""
    hull: Array = field(default=None, repr=False)  # type: ignore[assignment]
    """Points (V, 3) [m] in the sensor frame whose convex hull holds the object; by
    default `positions`."""
    faces: np.ndarray | None = field(default=None, repr=False)
    """Triangles (F, 3) of the surface, indices of `hull`; None: unknown."""
    shape_std: float = 0.0
    """Standard deviation of object from shape, as a share of its size: see `ROUGH`."""
    known: str = "object"
    """What the shape is: ``"object"``, that of the object; ``"bounds"``, a volume that
    holds the object, of any shape; ``"reach"``, the surroundings of the sensor, which
    hold an object of any size."""
    warnings: tuple[str, ...] = ()
    """Doubts about the shape, one line each."""

    def __post_init__(self):
        def keep(name, value):
            object.__setattr__(self, name, value)

        keep("positions", frozen(self.positions))
        check_positions(self.positions)
        for name, shape in (
            ("volumes", (self.n,)),
            ("cell_inertia", (self.n, 6)),
            ("extents", (3,)),
        ):
            keep(name, checked_numbers(getattr(self, name), name, shape, self.n))
        if not np.isfinite(self.positions).all():
            raise InputError("positions of point masses are not finite")
        keep("volumes", shares_of(self.volumes))
        keep("labels", checked_labels(self.labels, self.n))
        keep("pose", frozen(_pose_of(self.pose)))
        if self.extents is None:
            keep("extents", frozen(np.ptp(self.positions @ self.pose[:3, :3], axis=0)))
        if self.homogeneous is None:
            keep("homogeneous", InertialParameters(self.cell_matrix @ self.shares))
        keep("hull", self.positions if self.hull is None else frozen(self.hull))
        check_hull(self.hull)
        keep("faces", None if self.faces is None else own(np.array(self.faces)))
        keep("warnings", tuple(self.warnings))
        check_doubt(self.known, self.shape_std)

    @property
    def n(self) -> int:
        """Number of points."""
        return len(self.positions)

    @property
    def shares(self) -> Array:
        """Share of the volume of each point (n,), also where these are equal."""
        return np.full(self.n, 1.0 / self.n) if self.volumes is None else self.volumes

    @cached_property
    def volume(self) -> float:
        """Volume [m³] inside the surface, or if that is unknown, of the bounding box."""
        if self.faces is None:
            return float(np.prod(self.extents))
        corners = self.hull[self.faces] - self.hull[0]
        return abs(float(np.linalg.det(corners).sum())) / 6.0

    @cached_property
    def matrix(self) -> Array:
        """M (10, n) with phi = M m; column i is [1, p, y²+z², -xy, -xz, x²+z², -yz,
        x²+y²] at p_i."""
        x, y, z = self.positions.T
        tensor = y * y + z * z, -x * y, -x * z, x * x + z * z, -y * z, x * x + y * y
        return frozen((np.ones(self.n), x, y, z, *tensor))

    @cached_property
    def cell_matrix(self) -> Array:
        """`matrix` plus the inertia of the points' cells, so that points in a plane have
        an inertia of full rank."""
        if self.cell_inertia is None:
            return self.matrix
        matrix = self.matrix.copy()
        matrix[4:] += self.cell_inertia.T
        return frozen(matrix)

    def margin(self, center_of_mass: ArrayLike) -> float:
        """Depth of a point (3,) [m] in the object's convex hull over its largest side;
        negative outside."""
        size = float(self.extents.max()) or 1.0
        return depth_in_hull(self.hull, center_of_mass) / size

    # factories

    @classmethod
    def from_mesh(
        cls,
        mesh: Any,
        unit: str | None = "m",
        pose: ArrayLike | None = None,
        points: int | None = None,
        points_per_cm3: float | None = None,
        sampling: str = "grid",
        seed: int = 0,
    ) -> Self:
        """Points inside a surface mesh.

        Parameters
        ----------
        mesh : path to .stl, .obj, .ply, .off, .glb, or an object with ``vertices`` (V,
            3), ``faces`` (F, 3).
        unit : length unit of the mesh: m, cm, mm or in; None means m.
        pose : (4, 4) pose of the mesh's frame in the sensor frame [m]; by default the
            identity.
        points : approximate number of points (default 56).
        points_per_cm3 : their density, instead of `points`.
        sampling : ``grid``, see `sampling.grid_points`, or ``random``: uniform, exactly
            `points` of them.
        seed : of the random points.

        Meshes with holes are closed first (`solid.solid_from_mesh`). Raises
        `InputError` for a mesh that cannot be read or encloses no volume; `warnings`
        reports unlikely sizes and positions, and holes.
        """
        where, arrays = None, arrays_of(mesh)
        if arrays is None:
            where, arrays = mesh, read_mesh(mesh)
        solid = solid_from_mesh(arrays[0] * unit_scale(unit), arrays[1], where)
        solid = without_overlaps(solid)
        return cls._from_solid(
            solid, unit, pose, points, points_per_cm3, sampling, seed, where
        )

    @classmethod
    def from_hull(
        cls,
        source: Any,
        unit: str | None = "m",
        pose: ArrayLike | None = None,
        points: int | None = None,
        points_per_cm3: float | None = None,
        sampling: str = "grid",
        seed: int = 0,
    ) -> Self:
        """Points inside the convex hull of a mesh or a point cloud (a path, a mesh
        object, or (n, 3)): a `ROUGH` shape.

        For clouds of the surface alone. Other parameters and errors as for `from_mesh`.
        """
        where = source if isinstance(source, str | Path) else None
        if where is None:
            arrays = arrays_of(source)
            cloud = point_array(source) if arrays is None else arrays[0]
        elif Path(where).suffix.lower() in CLOUD_SUFFIXES:
            cloud = read_cloud(where)  # also the vertices of a .ply with faces
        else:
            cloud = read_mesh(where)[0]
        solid = solid_from_mesh(*convex_hull(cloud * unit_scale(unit), where), where)
        shape = cls._from_solid(
            solid, unit, pose, points, points_per_cm3, sampling, seed, where
        )
        return replace(shape, shape_std=ROUGH)

    @classmethod
    def from_cloud(
        cls,
        cloud: Any,
        unit: str | None = "m",
        pose: ArrayLike | None = None,
        points: int | None = None,
        points_per_cm3: float | None = None,
    ) -> Self:
        """Points of a *filled* cloud: one of its own points from each occupied voxel,
        about `points` in all.

        `cloud` is (n, 3) or a path to .xyz, .txt, .csv, .npy or .ply. A cloud of the
        surface alone puts all mass on the surface: use `from_hull` for it; `warnings`
        reports one. Other parameters and errors as for `from_mesh`.
        """
        where = cloud if isinstance(cloud, str | Path) else None
        read = point_array(cloud if where is None else read_cloud(where), where)
        p, pose = read * unit_scale(unit), _pose_of(pose)
        check_one_given(points, points_per_cm3)
        pitch = None
        if points_per_cm3 is not None:
            pitch = 0.01 * positive(points_per_cm3, "points_per_cm3") ** (-1 / 3)
        count = point_count(DEFAULT_POINTS if points is None else points)
        chosen, pitch = voxel_representatives(p, count, pitch)
        cell = np.tile(tensor_to_vector(np.eye(3) * pitch**2 / 6), (len(chosen), 1))
        extents = np.ptp(p, axis=0)
        warnings = suspicions(p.min(axis=0), extents, pose, unit)
        if (empty := empty_share(p)) > SMALL_CAVITIES:
            what = (
                f"{100 * empty:.0f} % of the cloud has no points: if they are of the "
                "surface alone, take its convex hull (`hull`)"
            )
            warnings = (*warnings, warning("cloud-hollow", what, "hull"))
        return cls(
            _posed(p[chosen], pose),
            cell_inertia=cell,
            extents=extents,
            pose=pose,
            hull=_posed(p, pose),
            warnings=warnings,
        )

    @classmethod
    def from_parts(
        cls, path: str | Path, unit: str | None = "m", pose: ArrayLike | None = None
    ) -> Self:
        """Points with the labels of their parts: all vertices of a PLY file.

        The vertices have one of the properties `LABELS`, and optionally ``volume``, their
        relative volumes. Other parameters and errors as for `from_mesh`.
        """
        vertices = read_ply_vertices(path)
        label = next((name for name in LABELS if name in vertices.columns), None)
        if label is None:
            fix = f"name a vertex property {LABELS[0]}, or use from_cloud"
            raise InputError("no labels in the PLY file", path, fix)
        points = point_array(vertices.positions, path) * unit_scale(unit)
        pose = _pose_of(pose)
        labels, volumes = vertices.columns[label], vertices.columns.get("volume")
        check_parts(labels, volumes, path)
        extents = np.ptp(points, axis=0)
        return cls(
            _posed(points, pose),
            volumes,
            labels,
            extents=extents,
            pose=pose,
            warnings=suspicions(points.min(axis=0), extents, pose, unit),
        )

    @classmethod
    def from_box(
        cls,
        x0: float,
        x1: float,
        y0: float,
        y1: float,
        z0: float,
        z1: float,
        points: int | None = None,
        points_per_cm3: float | None = None,
        sampling: str = "grid",
        seed: int = 0,
        pose: ArrayLike | None = None,
    ) -> Self:
        """Points inside a box from (x0, y0, z0) to (x1, y1, z1) [m] in the sensor frame,
        or in a frame of the given `pose` (4, 4); the box holds an object of any shape."""
        solid = box_solid((x0, y0, z0), (x1, y1, z1))
        shape = cls._from_solid(
            solid, "m", pose, points, points_per_cm3, sampling, seed, "box"
        )
        return replace(shape, shape_std=ROUGH, known="bounds")

    @classmethod
    @lru_cache
    def unknown(cls, reach: float = REACH) -> Self:
        """An unknown shape: an object of a few to some 40 cm, within `reach` [m] of the
        sensor along each axis."""
        box = cls.from_box(-reach, reach, -reach, reach, -reach, reach)
        return replace(box, known="reach", warnings=())

    @classmethod
    def _from_solid(
        cls,
        solid: Solid,
        unit: str | None,
        pose: ArrayLike | None,
        points: int | None,
        points_per_cm3: float | None,
        sampling: str,
        seed: int,
        where: Any,
    ) -> Self:
        matrix = _pose_of(pose)
        count = count_of_points(solid, points, points_per_cm3, where)
        samples = sample(solid, count, sampling, seed)
        warnings = list(suspicions(solid.lower, solid.extents, matrix, unit))
        if solid.cap_fraction > SMALL_CAPS:
            what = f"the mesh has holes; closing them added {100 * solid.cap_fraction:.0f} % of its surface"
            warnings.append(warning("mesh-holes", what))
        if samples.missed:
            what = "parts of the shape may be too thin for the points asked for, and have none"
            warnings.append(warning("thin-parts", what, "points"))
        rotation, n = matrix[:3, :3], len(samples.positions)
        second = np.broadcast_to(samples.cell_second_moment, (n, 3, 3))
        trace = np.trace(second, axis1=1, axis2=2)[:, None, None]
        cell = rotation @ (trace * np.eye(3) - second) @ rotation.T
        inertia = np.trace(solid.second_moment) * np.eye(3) - solid.second_moment
        body = InertialParameters.from_com(1.0, solid.centroid, inertia)
        return cls(
            _posed(samples.positions, matrix),
            samples.volumes,
            cell_inertia=tensor_to_vector(cell),
            extents=solid.extents,
            pose=matrix,
            homogeneous=body.moved(matrix),
            hull=_posed(solid.vertices, matrix),
            faces=solid.faces,
            shape_std=doubt_of_caps(solid.cap_fraction),
            warnings=tuple(warnings),
        )


def _pose_of(pose: ArrayLike | None) -> Array:
    return np.eye(4) if pose is None else check_pose(pose)


def _posed(points: Array, pose: Array) -> Array:
    """Points (n, 3) of the frame with this pose, in the frame of the pose."""
    return points @ pose[:3, :3].T + pose[:3, 3]
