"""The arm as nodes of viser, moving with the recording. Needs viser."""

import re
from typing import TYPE_CHECKING, Any

import numpy as np

from hefting.core.spatial import Array
from hefting.robots import Arm
from hefting.robots.visuals import Geometry
from hefting.scene.surface import LinkSurfaces, coarser
from hefting.viewer.drawing import GREY, SURFACE, rgb

if TYPE_CHECKING:
    from viser import SceneApi

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
    joints : (N, n)
        Joint positions at each frame, in the columns that the arm's links name [rad],
        [m].
    """

    def __init__(self, api: "SceneApi", arm: Arm, joints: Array):
        self.arm = arm
        self.position, self.orientation = arm.poses(joints)
        self.frames: list[Any] = []
        self._surfaces = LinkSurfaces()
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
        """Move the links to a frame."""
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
        """Vertices (V, 3) [m] in the link's frame and triangles of a geometry, no more
        than are drawn; None where its mesh cannot be read."""
        surface = self._surfaces.read(geometry)
        return None if surface is None else coarser(*surface, MOST_TRIANGLES)


def plain(name: str) -> str:
    """A name from a file as part of a node's name."""
    return re.sub(r"[^\w .-]", "_", name)[:40]
