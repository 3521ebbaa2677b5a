"""An object in a robot's hand: what it is made of, how it looks, and where it is in the
sensor frame."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property, reduce
from operator import add
from pathlib import Path
from typing import TYPE_CHECKING, Any, Self

import numpy as np
from numpy.typing import ArrayLike

from hefting.core.errors import InputError
from hefting.core.inertia import InertialParameters
from hefting.core.spatial import STANDARD_GRAVITY, Array, check_pose, frozen
from hefting.shapes import Shape
from hefting.shapes.checks import unit_scale
from hefting.shapes.reading import read_mesh
from hefting.shapes.solid import Solid, solid_from_mesh
from hefting.simulation.objects import SECTIONS, Assembly
from hefting.simulation.wield import truth

if TYPE_CHECKING:
    import trimesh


@dataclass(frozen=True, eq=False)
class HeldObject:
    """A rigid object, its true inertial parameters and its surface, held in a known
    pose."""

    name: str
    in_object: InertialParameters
    """True parameters in the object's frame, that of its surface."""
    surface: "trimesh.Trimesh"
    """As one would scan it [m]."""
    pose: Array
    """(4, 4) of the object in the sensor frame"""

    def __post_init__(self):
        object.__setattr__(self, "pose", frozen(check_pose(self.pose)))

    @classmethod
    def of(cls, assembly: Assembly, pose: ArrayLike, sections: int = SECTIONS) -> Self:
        """An assembly of parts; `sections` are the sides of the prisms for its
        cylinders."""
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
        """Parts in one frame, each a mesh file and its density [kg/m³]; `unit` and
        `pose` as for `Shape`.

        The truth is the integral over the meshes. Raises `InputError` for a mesh that
        cannot be read or is not watertight, and for a density that is not positive.
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

    def points(
        self, points: int | None = None, points_per_cm3: float | None = None
    ) -> Shape:
        """Point masses in the surface, in the sensor frame, as `Shape.from_mesh`
        chooses them."""
        return Shape.from_mesh(
            self.surface, pose=self.pose, points=points, points_per_cm3=points_per_cm3
        )

    def truth(
        self,
        gravity: ArrayLike = STANDARD_GRAVITY,
        on_sensor: bool = False,
        mesh_unit: str = "m",
    ) -> dict[str, Any]:
        """What is to be found, ready for JSON; see `hefting.simulation.truth`."""
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
    """A solid of one material, in the frame of its mesh."""
    if not 0.0 < density < np.inf:
        raise InputError(
            f"the density is {density} kg/m³, which is not positive", where=where
        )
    mass, second = density * solid.volume, solid.second_moment
    inertia = mass * (np.trace(second) * np.eye(3) - second)
    return InertialParameters.from_com(mass, solid.centroid, inertia)
