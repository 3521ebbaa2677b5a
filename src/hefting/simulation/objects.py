"""Objects to wield, with exact inertia: assemblies of boxes and cylinders, or meshes;
and their pose in the sensor frame."""

from collections.abc import Sequence
from dataclasses import field
from functools import cached_property, reduce
from operator import add
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal, Self

import numpy as np
from numpy.typing import ArrayLike

from hefting.core.errors import InputError
from hefting.core.inertia import InertialParameters
from hefting.core.spatial import (
    STANDARD_GRAVITY,
    Array,
    check_pose,
    freeze,
    frozen,
    immutable,
)
from hefting.shapes import Shape
from hefting.shapes.checks import unit_scale
from hefting.shapes.reading import read_mesh
from hefting.shapes.solid import Solid, solid_from_mesh
from hefting.simulation.wield import truth

if TYPE_CHECKING:
    import trimesh

STEEL, ASH_WOOD = 7850.0, 680.0
"""Densities [kg/m³]."""

SECTIONS = 96
"""Number of sides of the prism for a cylinder in a mesh, whose volume is 0.07 % too
small."""


@immutable
class Part:
    """A homogeneous solid, with centre and axes in the assembly's frame."""

    solid: Literal["box", "cylinder", "half cylinder"]
    size: tuple[float, ...]
    """three sides of a box; radius and height of cylinders [m]"""
    density: float
    """[kg/m³]; negative for a hole in a solid of that density"""
    center: tuple[float, float, float]
    """[m]; for a half cylinder, of its flat side"""
    axes: Array = field(default_factory=lambda: np.eye(3))
    """(3, 3) part axes to assembly axes; cylinders along z, half ones at positive y"""

    def __post_init__(self):
        freeze(self, "axes")

    @property
    def parameters(self) -> InertialParameters:
        """Closed-form parameters in the assembly's frame."""
        if self.solid == "box":
            square = np.square(self.size)
            mass = self.density * float(np.prod(self.size))
            inertia = mass / 12.0 * (square.sum() - square)
        else:
            # about the middle of its flat side, half a cylinder has the moments of a
            # whole one of half the density
            radius, height = self.size
            share = 1.0 if self.solid == "cylinder" else 0.5
            mass = share * self.density * np.pi * radius**2 * height
            across = mass / 12.0 * (3.0 * radius**2 + height**2)
            inertia = np.array((across, across, mass / 2.0 * radius**2))
        middle = InertialParameters.from_com(
            mass, (0.0, 0.0, 0.0), np.diag(inertia)
        ).vector.copy()
        if self.solid == "half cylinder":
            middle[2] = mass * 4.0 * self.size[0] / (3.0 * np.pi)
        return InertialParameters(middle).moved(self._pose)

    @property
    def _pose(self) -> Array:
        pose = np.eye(4)
        pose[:3, :3], pose[:3, 3] = self.axes, self.center
        return pose

    def mesh(self, sections: int = SECTIONS) -> "trimesh.Trimesh":
        """Closed surface [m] in the assembly's frame; a cylinder is a prism with
        `sections` sides."""
        import trimesh

        if self.solid == "box":
            return trimesh.creation.box(self.size, transform=self._pose)
        if self.solid == "cylinder":
            return trimesh.creation.cylinder(
                *self.size, sections=sections, transform=self._pose
            )
        angle = np.linspace(0.0, np.pi, sections // 2 + 1)
        rim = self.size[0] * np.column_stack((np.cos(angle), np.sin(angle)))
        ends = [
            np.column_stack((rim, np.full(len(rim), z)))
            for z in (-0.5 * self.size[1], 0.5 * self.size[1])
        ]
        return trimesh.convex.convex_hull(np.vstack(ends)).apply_transform(self._pose)


@immutable
class Assembly:
    """Rigidly joined parts, which do not overlap, except for holes inside others."""

    name: str
    parts: tuple[Part, ...]
    outline: tuple[Part, ...] | None = None
    """visible parts and holes; by default all"""

    @property
    def parameters(self) -> InertialParameters:
        """Exact parameters in the assembly's frame."""
        return reduce(add, (part.parameters for part in self.parts))

    def mesh(self, sections: int = SECTIONS) -> "trimesh.Trimesh":
        """One watertight surface [m] of the visible parts."""
        import trimesh

        shown = self.parts if self.outline is None else self.outline
        solids = [part.mesh(sections) for part in shown if part.density > 0.0]
        holes = [part.mesh(sections) for part in shown if part.density < 0.0]
        surface = trimesh.boolean.union(solids, engine="manifold")
        if holes:
            return trimesh.boolean.difference([surface, *holes], engine="manifold")
        return surface


HAMMER_POSE = frozen(
    (
        (1.0, 0.0, 0.0, 0.0),
        (0.0, 0.0, 1.0, -0.08),
        (0.0, -1.0, 0.0, 0.06),
        (0.0, 0.0, 0.0, 1.0),
    )
)
"""Pose of the hammer in the sensor frame: held by its handle 80 mm from the end, at a
distance of 60 mm."""


def hammer() -> Assembly:
    """A joiner's hammer: handle of ash wood along z from the origin, steel head along x.

    Its mass is 0.67 kg, five sixths of it in the head, with the centre of mass at z =
    0.25 m; a homogeneous body of the same shape would have it at 0.175 m.
    """
    along_x = np.array(((0.0, 0.0, 1.0), (0.0, 1.0, 0.0), (-1.0, 0.0, 0.0)))
    return Assembly(
        "hammer",
        (
            Part("cylinder", (0.014, 0.260), ASH_WOOD, (0.0, 0.0, 0.130)),
            Part("box", (0.050, 0.028, 0.032), STEEL, (0.0, 0.0, 0.276)),
            Part("cylinder", (0.013, 0.030), STEEL, (0.040, 0.0, 0.276), along_x),
            Part("box", (0.045, 0.024, 0.010), STEEL, (-0.0475, 0.0, 0.276)),
        ),
    )


@immutable
class HeldObject:
    """A rigid object with true inertial parameters and a surface, in a known pose."""

    name: str
    in_object: InertialParameters
    """true parameters, in the frame of the surface"""
    surface: "trimesh.Trimesh"
    """visible surface [m]"""
    pose: Array
    """(4, 4) of the object in the sensor frame"""

    def __post_init__(self):
        object.__setattr__(self, "pose", frozen(check_pose(self.pose)))

    @classmethod
    def of(cls, assembly: Assembly, pose: ArrayLike, sections: int = SECTIONS) -> Self:
        """A held assembly; `sections` as of `Part.mesh`."""
        return cls(
            assembly.name, assembly.parameters, assembly.mesh(sections), frozen(pose)
        )

    @classmethod
    def from_meshes(
        cls,
        parts: Sequence[tuple[str | Path, float]],
        unit: str | None = "m",
        pose: ArrayLike | None = None,
    ) -> Self:
        """An object of mesh files in one frame, each with its density [kg/m³]; `unit` and
        `pose` as for `Shape`.

        True parameters are integrals over the meshes. Raises `InputError` for a mesh
        that cannot be read or is not watertight, and for a density that is not positive.
        """
        import trimesh

        if not parts:
            raise InputError("an object needs at least one mesh")
        bodies, surfaces = [], []
        for path, density in parts:
            vertices, faces = read_mesh(path)
            solid = solid_from_mesh(vertices * unit_scale(unit), faces, path)
            if solid.cap_fraction > 0.0:
                fix = "repair it: what is inside decides the truth"
                raise InputError("the mesh is not watertight", path, fix)
            bodies.append(_filled(solid, density, path))
            surfaces.append(trimesh.Trimesh(solid.vertices, solid.faces, process=False))
        surface = (
            surfaces[0] if len(surfaces) == 1 else trimesh.util.concatenate(surfaces)
        )
        name = "+".join(Path(path).stem for path, _ in parts)
        place = np.eye(4) if pose is None else frozen(pose)
        return cls(name, reduce(add, bodies), surface, place)  # type: ignore[arg-type]

    @cached_property
    def parameters(self) -> InertialParameters:
        """True parameters in the sensor frame."""
        return self.in_object.moved(self.pose)

    @property
    def extents(self) -> Array:
        """Sides (3,) [m] of the bounding box along the object's axes."""
        return frozen(self.surface.extents)

    def points(self, points: int | None = None) -> Shape:
        """Point masses in the surface by `Shape.from_mesh`, in the sensor frame."""
        return Shape.from_mesh(self.surface, pose=self.pose, points=points)

    def truth(
        self,
        gravity: ArrayLike = STANDARD_GRAVITY,
        on_sensor: bool = False,
        mesh_unit: str = "m",
    ) -> dict[str, Any]:
        """As `hefting.simulation.truth`."""
        return truth(
            self.parameters,
            self.extents,
            self.pose,
            gravity,
            mesh_unit,
            on_sensor,
            self.name,
        )


def _filled(solid: Solid, density: float, where: str | Path) -> InertialParameters:
    if not 0.0 < density < np.inf:
        raise InputError(
            f"the density is {density} kg/m³, which is not positive", where=where
        )
    mass, second = density * solid.volume, solid.second_moment
    inertia = mass * (np.trace(second) * np.eye(3) - second)
    return InertialParameters.from_com(mass, solid.centroid, inertia)
