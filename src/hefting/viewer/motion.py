"""Motion along a recording: the arm, arrows and curves of the wrench. Needs viser."""

import re
from typing import TYPE_CHECKING, Any

import numpy as np

from hefting.core.estimate import Estimate
from hefting.core.regressor import predict_wrench
from hefting.core.spatial import Array
from hefting.plots.style import COMPONENTS
from hefting.robots import Arm
from hefting.robots.arm import Geometry
from hefting.scene import PARTS
from hefting.scene.surface import LinkSurfaces, coarser
from hefting.viewer import Frame, Playback
from hefting.viewer.drawing import ARROWS, GREY, SENSOR, SURFACE, rgb

if TYPE_CHECKING:
    from viser import GuiApi, SceneApi

MOST_TRIANGLES = 4_000
"""Most triangles of one drawn mesh."""
THICKNESS = 0.012
"""[m] Thickness of the lines from joint to joint."""
LONGEST = {"force": 1.0, "torque": 0.6}
"""Length of the longest arrow over the size of the scene."""
APART = 0.02
"""Distance between the arrows of the measured and the predicted wrench over the size of
the scene, so that neither hides the other."""
HEIGHT = 170
"""[pixels] Height of a plot."""


class ArmDrawing:
    """Links of an arm, drawn by their geometries, or without any as lines from their joint
    to the next ones. `joints` (N, n) are the positions [rad, m] at each frame, in the
    columns to which the arm's links refer."""

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
        # the line between two joints represents the link that bears the second one
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
        origins = self.position[index]
        ends = np.stack((origins[self._bearers], origins[self._bare]), axis=1)
        return np.asarray(ends, dtype=np.float32)

    def _draw(
        self, api: "SceneApi", name: str, geometries: tuple[Geometry, ...]
    ) -> bool:
        """Draw a link's visual geometries, or if none can be read its collision
        geometries; returns whether there are any."""
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
        """Vertices (V, 3) [m] in the link's frame and at most `MOST_TRIANGLES` triangles
        of a geometry; None if its mesh cannot be read."""
        surface = self._surfaces.read(geometry)
        return None if surface is None else coarser(*surface, MOST_TRIANGLES)


def plain(name: str) -> str:
    """A name from a file made safe as part of a node's name."""
    return re.sub(r"[^\w .-]", "_", name)[:40]


def arrow(vector: Array, scale: float, aside: float) -> Array:
    """Tail and tip (2, 3) [m] of an arrow of a vector (3,) times `scale`, displaced by
    `aside` [m] perpendicular to it."""
    across = np.cross(vector, (0.0, 0.0, 1.0))
    if np.linalg.norm(across) < 1e-3 * np.linalg.norm(vector):
        across = np.cross(vector, (1.0, 0.0, 0.0))
    tail = aside * across / (np.linalg.norm(across) or 1.0)
    return np.array((tail, tail + scale * vector))


class WrenchArrows:
    """Arrows of force and torque on the object in sensor axes, measured and predicted,
    without bias. The largest of the playback have the lengths `LONGEST` times `size`
    [m], that of the scene."""

    def __init__(self, api: "SceneApi", playback: Playback, size: float):
        self.playback, self.size = playback, size
        lengths = size * np.array(list(LONGEST.values()))
        self.scales = lengths / playback.largest
        self.nodes: dict[str, Any] = {}
        for name, colour in ARROWS.items():
            part, kind = name.split(", ")
            self.nodes[name] = api.add_arrows(
                f"{SENSOR}/wrench/{part}/{kind}",
                np.zeros((1, 2, 3)),
                rgb(colour),
                shaft_radius=0.007 * size,
                head_radius=0.02 * size,
                head_length=0.05 * size,
                visible=False,
            )
        self.hidden = False

    def show(self, frame: Frame, estimate: Estimate | None) -> None:
        """Draw the wrench at a frame without the estimate's bias, and the predicted."""
        wrenches = {"measured": frame.measured - self.playback.bias(estimate)}
        if estimate is not None:
            wrenches["predicted"] = self.playback.predicted(estimate, frame.sample)
        for name, node in self.nodes.items():
            part, kind = name.split(", ")
            i = list(LONGEST).index(part)
            if kind in wrenches:
                vector = wrenches[kind][3 * i : 3 * i + 3]
                aside = APART * self.size * (0.5 if kind == "measured" else -0.5)
                points = arrow(vector, self.scales[i], aside)
                node.points = np.asarray(points[None], dtype=np.float32)
            node.visible = kind in wrenches and not self.hidden


class WrenchPlots:
    """Plots of force and torque over the whole recording: measured, and predicted by the
    estimate with its bias. A vertical line marks the end of the samples of the
    estimate."""

    def __init__(self, gui: "GuiApi", playback: Playback):
        self.playback = playback
        z = playback.found.measurements
        self._samples = z[playback.samples]  # type: ignore[index]
        times = "pose" if playback.static else "time [s]"
        self.handles = [
            add_plot(
                gui, f"{name} [{unit}]", times, self._data(first, None, 0), curves()
            )
            for name, unit, first in PARTS
        ]

    def show(self, index: int, estimate: Estimate | None) -> None:
        """Draw the wrench predicted by an estimate, and the line at a frame."""
        for (_, _, first), handle in zip(PARTS, self.handles, strict=True):
            data = self._data(first, estimate, index)
            scales = scales_of(data)
            if scales != handle.scales:  # setting a scale resets the user's zoom
                handle.scales = scales
            handle.data = data

    def _data(
        self, first: int, estimate: Estimate | None, index: int
    ) -> tuple[Array, ...]:
        """Times, three measured and three predicted components from column `first` on, and
        the line, NaN except at two neighbouring frames."""
        part = slice(first, first + 3)
        measured = self._samples.wrench[:, part]
        predicted = np.full_like(measured, np.nan)
        if estimate is not None:
            whole = predict_wrench(self._samples, estimate.sensed_vector)
            predicted = (whole + self.playback.bias(estimate))[:, part]
        line = np.full(len(measured), np.nan)
        before = max(index - 1, 0)
        line[before], line[index] = measured.min(), measured.max()
        return (self.playback.times, *measured.T, *predicted.T, line)


def add_plot(
    gui: "GuiApi", title: str, times: str, data: tuple[Array, ...], drawn: Any
) -> Any:
    """A plot of force or torque: the arrays of `data` over the first one, whose axis is
    called `times`, in the styles `drawn`, as from `curves`."""
    return gui.add_uplot(
        data,
        drawn,
        title=title,
        scales=scales_of(data),
        axes=({"label": times, "size": 30, "labelSize": 20}, {"size": 44}),
        legend={"show": False},
        height=HEIGHT,
        padding=(10, 14, 0, 0),
    )


def scales_of(data: tuple[Array, ...]) -> dict[str, Any]:
    """Scales of a plot that hold the measured curves, and the predicted ones up to about
    the same size beyond. They change in steps, to change seldom."""
    measured, predicted = np.array(data[1:4]), np.array(data[4:7])
    low, high = float(measured.min()), float(measured.max())
    step = 0.2 * (high - low) or 1.0
    known = predicted[np.isfinite(predicted)]
    beyond = (
        low - float(known.min(initial=low)),
        float(known.max(initial=high)) - high,
    )
    below, above = (step * min(np.ceil(each / step) + 0.4, 5.4) for each in beyond)
    return {"x": {"time": False}, "y": {"range": (low - below, high + above)}}


def curves() -> tuple[Any, ...]:
    """Styles of the arrays of `WrenchPlots`."""
    measured = [
        {"label": f"{axis} measured", "stroke": f"{colour}60", "width": 4}
        for axis, colour in COMPONENTS.items()
    ]
    predicted = [
        {"label": f"{axis} predicted", "stroke": colour, "width": 1}
        for axis, colour in COMPONENTS.items()
    ]
    line = {"label": "instant", "stroke": "#888888", "width": 1}
    drawn = [
        each | {"points": {"show": False}} for each in (*measured, *predicted, line)
    ]
    return ({"label": "time"}, *drawn)
