"""Objects to wield: boxes and cylinders of different materials joined, with exact inertia and a mesh."""

from dataclasses import dataclass, field
from functools import reduce
from operator import add
from typing import TYPE_CHECKING, Literal

import numpy as np

from hefting.inertia import InertialParameters
from hefting.spatial import Array, frozen

if TYPE_CHECKING:
    import trimesh

STEEL, ASH_WOOD = 7850.0, 680.0
"""Densities [kg/m³]."""

SECTIONS = 96
"""Sides of the prism that stands for a cylinder in a mesh: its volume is 0.07 % too small."""


@dataclass(frozen=True, eq=False)
class Part:
    """A homogeneous solid, its centre and axes given in the assembly's frame."""

    solid: Literal["box", "cylinder"]
    size: tuple[float, ...]
    """Box: its three sides; cylinder: radius and height [m]."""
    density: float
    """[kg/m³]"""
    center: tuple[float, float, float]
    """[m]"""
    axes: Array = field(default_factory=lambda: np.eye(3))
    """(3, 3) part axes to assembly axes; a cylinder stands along its z"""

    def __post_init__(self):
        object.__setattr__(self, "axes", frozen(self.axes))

    @property
    def parameters(self) -> InertialParameters:
        """Closed-form parameters in the assembly's frame."""
        if self.solid == "box":
            square = np.square(self.size)
            mass = self.density * float(np.prod(self.size))
            inertia = mass / 12.0 * (square.sum() - square)
        else:
            radius, height = self.size
            mass = self.density * np.pi * radius**2 * height
            across = mass / 12.0 * (3.0 * radius**2 + height**2)
            inertia = np.array((across, across, mass / 2.0 * radius**2))
        return InertialParameters.from_com(mass, self.center, (self.axes * inertia) @ self.axes.T)

    def mesh(self, sections: int = SECTIONS) -> "trimesh.Trimesh":
        """Closed surface [m] in the assembly's frame; a cylinder is a prism of that many sides."""
        import trimesh

        pose = np.eye(4)
        pose[:3, :3], pose[:3, 3] = self.axes, self.center
        if self.solid == "box":
            return trimesh.creation.box(self.size, transform=pose)
        return trimesh.creation.cylinder(*self.size, sections=sections, transform=pose)


@dataclass(frozen=True, eq=False)
class Assembly:
    """Parts that do not overlap, rigidly joined."""

    name: str
    parts: tuple[Part, ...]

    @property
    def parameters(self) -> InertialParameters:
        """Exact parameters in the assembly's frame."""
        return reduce(add, (part.parameters for part in self.parts))

    def mesh(self) -> "trimesh.Trimesh":
        """One watertight surface [m] around all parts, which says nothing of their materials."""
        import trimesh

        return trimesh.boolean.union([part.mesh() for part in self.parts], engine="manifold")


def hammer() -> Assembly:
    """A joiner's hammer: handle of ash wood along z from its lower end at the origin, steel head along x.

    It has 0.67 kg, five sixths of it in the head, and its centre of mass 0.25 m up; a homogeneous body of the
    same shape would have it at 0.175 m.
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
