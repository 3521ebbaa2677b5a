"""The arm as nodes of viser, moving with the recording. Needs viser."""

import re
from typing import TYPE_CHECKING, Any

import numpy as np

from hefting.core.errors import InputError
from hefting.core.spatial import Array, rotation_matrices
from hefting.robots import Arm
from hefting.robots.visuals import LARGEST_SIZE, Geometry
from hefting.scene.surface import coarser
from hefting.shapes.reading import read_mesh
from hefting.viewer.colours import GREY, SURFACE, rgb
from hefting.viewer.playback import Playback

if TYPE_CHECKING:
    from viser import SceneApi

MOST_BYTES = 200_000_000
"""Sizes of all meshes that are read of one arm [bytes]."""
MOST_TRIANGLES = 4_000
"""Triangles of one mesh that are drawn at most."""
THICKNESS = 0.012
"""Of the line from joint to joint [m]."""


class ArmDrawing:
    """Links of an arm as their geometries, those without any as lines from their joint
    to the next ones.

    Parameters
    ----------
    api : viser.SceneApi
        Where they are drawn.
    arm : Arm
        The links.
    playback : Playback
        Whose recording has the joint positions.
    """

    def __init__(self, api: "SceneApi", arm: Arm, playback: Playback):
        self.arm = arm
        joints = playback.at("joint_positions")
        assert joints is not None  # `Arm.from_urdf` asks for them
        self.position, self.orientation = arm.poses(joints)
        self.frames: list[Any] = []
        self._left = MOST_BYTES
        drawn: list[bool] = []
        for i, link in enumerate(arm.links):
            name = f"/arm/{i} {plain(link.name)}"
            self.frames.append(api.add_frame(name, show_axes=False))
            drawn.append(self._draw(api, name, link.geometries))
        # what lies between two joints is the link that bears the second
        parents = [link.parent for link in arm.links]
        bare = [i for i, at in enumerate(parents) if at is not None and not drawn[at]]
        self._bare = np.array(bare, dtype=np.intp)
        self._bearers = np.array([parents[i] for i in bare], dtype=np.intp)
        self.lines: Any = None
        if len(bare):
            self.lines = api.add_line_segments(
                "/arm/lines", self._segments(0), rgb(GREY), thickness=THICKNESS
            )

    def show(self, index: int) -> None:
        """Move the links to a frame of the playback."""
        for i, node in enumerate(self.frames):
            node.position = self.position[index, i]
            node.wxyz = self.orientation[index, i, [3, 0, 1, 2]]
        if self.lines is not None:
            self.lines.points = self._segments(index)

    def _segments(self, index: int) -> np.ndarray:
        """Ends (n, 2, 3) of the lines [m]."""
        origins = self.position[index]
        ends = np.stack((origins[self._bearers], origins[self._bare]), axis=1)
        return np.asarray(ends, dtype=np.float32)

    def _draw(
        self, api: "SceneApi", name: str, geometries: tuple[Geometry, ...]
    ) -> bool:
        """Draw what a link looks like: its visual parts; if none of them can be read,
        those for collisions. Whether anything is drawn."""
        for part in ("visual", "collision"):
            meshes = [self._mesh(each) for each in geometries if each.part == part]
            known = [mesh for mesh in meshes if mesh is not None]
            for i, (vertices, faces) in enumerate(known):
                api.add_mesh_simple(
                    f"{name}/{i}",
                    vertices,
                    faces,
                    color=rgb(SURFACE),
                    flat_shading=False,
                    side="double",
                )
            if known:
                return True
        return False

    def _mesh(self, geometry: Geometry) -> tuple[Array, np.ndarray] | None:
        """Vertices (V, 3) [m] in the link's frame and triangles of a geometry; None
        where its mesh cannot be read."""
        try:
            vertices, faces = self._own(geometry)
        except InputError:
            return None
        if not len(faces) or not np.abs(vertices).max() <= LARGEST_SIZE:
            return None  # also where a vertex is not finite
        if not np.ptp(vertices, axis=0).max() > 0.0:
            return None
        vertices, faces = coarser(vertices, faces, MOST_TRIANGLES)
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


def plain(name: str) -> str:
    """A name from a file as part of a node's name."""
    return re.sub(r"[^\w .-]", "_", name)[:40]
