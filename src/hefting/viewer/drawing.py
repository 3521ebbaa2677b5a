"""Drawing: a scene as nodes of viser in the frame of the sensor, and the colours of the
viewer. Needs viser."""

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import numpy as np

from hefting.core.spatial import Array, interpolated
from hefting.plots.style import BLUE, GREEN, ORANGE, PURPLE, SKY, VERMILION
from hefting.scene import Body, Ellipsoid, PointSet, Scene, Surface

if TYPE_CHECKING:
    from viser import SceneApi

Colour = tuple[int, int, int]

GREY, PALE = "#8A8A8A", "#B9C4CF"
AXES = {"x": BLUE, "y": VERMILION, "z": GREEN}
COM, INERTIA, SURFACE, TRUTH = VERMILION, PURPLE, PALE, GREY
ARROWS = {
    "force, measured": ORANGE,
    "force, predicted": "#A65200",
    "torque, measured": SKY,
    "torque, predicted": BLUE,
}
"""Colours of the arrows of the wrench; the predicted one of each pair is darker."""
MASSES = ("#7B5EA7", "#3B8BC2", "#2BA58D", "#8CC63F", "#F2B705")
"""Colour scale from zero to the largest mass, visible on white and on black."""
SENSOR = "/sensor"
"""Node that moves with the sensor; the object's nodes are below it."""
LEAST_SIZE = 0.05
"""[m] Least size of a scene."""
MOST_REACH = 3.0
"""Reach of a COM region over the size of the scene above which it is not drawn, as it
would hide everything else."""
STROKES = {
    "x": (((0, 0), (1, 1)), ((0, 1), (1, 0))),
    "y": (((0, 1), (0.5, 0.5)), ((1, 1), (0.5, 0.5)), ((0.5, 0.5), (0.5, 0))),
    "z": (((0, 1), (1, 1)), ((1, 1), (0, 0)), ((0, 0), (1, 0))),
}
"""Strokes of letters: ends (right, up) in a unit square."""
NO_SHADOWS: dict[str, Any] = {"cast_shadow": False, "receive_shadow": False}
EDGES = tuple((i, i | bit) for bit in (1, 2, 4) for i in range(8) if not i & bit)
"""Edges of a box whose corner i is at the high end of the axes whose bits are set in i."""
AXES_SHARE = 0.5
"""Greatest length of the sensor's axes over the size of the scene."""


def rgb(colour: str) -> Colour:
    """Red, green and blue (0 to 255) of ``"#RRGGBB"``."""
    red, green, blue = (int(colour[i : i + 2], 16) for i in (1, 3, 5))
    return red, green, blue


def colours_of(masses: Array) -> np.ndarray:
    """Colours (n, 3), 0 to 255, of masses (n,) [kg] on the scale `MASSES`."""
    scale = np.array([rgb(colour) for colour in MASSES], dtype=float)
    share = masses / (float(masses.max(initial=0.0)) or 1.0)
    at = np.clip(share, 0.0, 1.0) * (len(scale) - 1)
    return (
        interpolated(at, np.arange(float(len(scale))), scale).round().astype(np.uint8)
    )


def size_of(scene: Scene) -> float:
    """Largest extent of a scene [m]."""
    return max(float(np.ptp(scene.corners, axis=0).max()), LEAST_SIZE)


def axes_length(size: float) -> float:
    """Length of the drawn sensor axes [m]: the largest 1, 2 or 5 times a power of ten
    within `AXES_SHARE` of the scene's `size` [m]."""
    power = 10.0 ** np.floor(np.log10(AXES_SHARE * size))
    return float(
        max(n * power for n in (1.0, 2.0, 5.0) if n * power <= AXES_SHARE * size)
    )


class ObjectDrawing:
    """The object, as nodes below `SENSOR`; the surface is that of the first scene."""

    def __init__(self, api: "SceneApi", scene: Scene):
        self._api = api
        self.size = size_of(scene)
        self._nodes: dict[str, Any] = {}
        self._absent: set[str] = set()  # nodes that the present scene does not have
        self.hidden: set[str] = set()
        """Kinds of hidden nodes: ``"shape"``, ``"masses"``, ``"inertia"``,
        ``"region"``, ``"truth"``"""
        self._draw_axes()
        if scene.surface is not None:
            self._draw_surface(scene.surface)

    def show(self, scene: Scene) -> None:
        """Draw a scene in place of the previous one."""
        self._draw_points(scene.points)
        names = {body.name for body in scene.bodies}
        for body in scene.bodies:
            self._draw_body(body)
        if "estimate" not in names:
            self._draw_body(Body("estimate", np.full(3, np.nan)))
        self.hide(self.hidden)

    def hide(self, kinds: set[str]) -> None:
        """Hide these kinds of nodes, and show the others."""
        self.hidden = set(kinds)
        for name, node in self._nodes.items():
            parts = set(name.split("/"))
            node.visible = name not in self._absent and not parts & self.hidden

    def _draw_axes(self) -> None:
        length = axes_length(self.size)
        self.sensor = self._api.add_frame(
            SENSOR, axes_length=length, axes_radius=0.02 * length, show_axes=False
        )
        for axis, colour in AXES.items():
            tip = length * np.eye(3)["xyz".index(axis)]
            arm = np.array([[np.zeros(3), tip]])
            for name, points, thickness in (
                (axis, arm, 3.0),
                (f"{axis}/name", letter(axis, length), 2.0),
            ):
                self._api.add_line_segments(
                    f"{SENSOR}/axes/{name}",
                    points,
                    rgb(colour),
                    thickness=thickness,
                    thickness_units="screen",
                )

    def _draw_surface(self, surface: Surface) -> None:
        name, vertices = f"{SENSOR}/shape", surface.vertices
        if surface.is_object:
            look: dict[str, Any] = {"opacity": 0.35, "side": "double", **NO_SHADOWS}
            node = self._api.add_mesh_simple(
                name, vertices, surface.faces, color=rgb(SURFACE), **look
            )
        else:
            look = {"thickness": 1.5, "thickness_units": "screen"}
            edges = vertices[list(EDGES)]
            node = self._api.add_line_segments(name, edges, rgb(GREY), **look)
        self._nodes["shape"] = node

    def _draw_points(self, points: PointSet | None) -> None:
        if points is None:
            self._absent.add("masses")
            return
        colours = np.tile(
            np.array(rgb(GREY), dtype=np.uint8), (len(points.positions), 1)
        )
        if points.masses is not None:
            colours = colours_of(points.masses)

        node = self._node(
            "masses",
            self._api.add_point_cloud,
            points.positions,
            colours,
            point_size=0.018 * self.size,
            point_shape="circle",
            precision="float32",
        )
        if node.points.shape != points.positions.shape:
            node.points = np.asarray(points.positions, dtype=np.float32)
        node.colors = colours

    def _draw_body(self, body: Body) -> None:
        known = body.name != "estimate"
        place = f"{body.name}/truth" if known else body.name
        self._draw_center(f"{place}/com", body.center, TRUTH if known else COM)
        region = body.region
        if region is not None and region.reach.max() > MOST_REACH * self.size:
            region = None
        self._draw_ellipsoid(f"{place}/region", region, COM, 0.35)
        colour, opacity = (TRUTH, 0.25) if known else (INERTIA, 0.2)
        self._draw_ellipsoid(f"{place}/inertia", body.ellipsoid, colour, opacity)

    def _draw_center(self, name: str, center: Array, colour: str) -> None:
        if not np.isfinite(center).all():
            self._absent.add(name)
            return
        self._node(
            name,
            self._api.add_icosphere,
            0.018 * self.size,
            rgb(colour),
            subdivisions=2,
            **NO_SHADOWS,
        ).position = center

    def _draw_ellipsoid(
        self, name: str, ellipsoid: Ellipsoid | None, colour: str, opacity: float
    ) -> None:
        if ellipsoid is None:
            self._absent.add(name)
            return
        vertices, faces = ellipsoid.triangles()
        self._node(
            name,
            self._api.add_mesh_simple,
            vertices,
            faces,
            color=rgb(colour),
            opacity=opacity,
            side="double",
            **NO_SHADOWS,
        ).vertices = np.asarray(vertices, dtype=np.float32)

    def _node(self, name: str, add: Callable[..., Any], *what: Any, **look: Any) -> Any:
        """The node of a present part; `add` makes it the first time."""
        self._absent.discard(name)
        if name not in self._nodes:
            self._nodes[name] = add(f"{SENSOR}/{name}", *what, **look)
        return self._nodes[name]


def letter(axis: str, length: float) -> Array:
    """Strokes (n, 2, 3) [m] of the letter x, y or z beyond the end of an axis of the given
    length [m], as viser's labels lag behind moving nodes."""
    i = "xyz".index(axis)
    right, up = np.roll(np.eye(3), -i, axis=0)[:2]
    ends = np.array(STROKES[axis]) - 0.5
    at = (1.15 * right) + 0.16 * (ends[..., :1] * right + ends[..., 1:] * up)
    return length * at
