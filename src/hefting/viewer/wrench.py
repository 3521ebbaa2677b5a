"""Arrows of the wrench at the sensor, and its curves over time. Needs viser."""

from typing import TYPE_CHECKING, Any

import numpy as np

from hefting.core.estimate import Estimate
from hefting.core.regressor import predict_wrench
from hefting.core.spatial import Array
from hefting.plots.style import COMPONENTS, PARTS
from hefting.viewer.colours import ARROWS, rgb
from hefting.viewer.drawing import SENSOR
from hefting.viewer.playback import Frame, Playback

if TYPE_CHECKING:
    from viser import GuiApi, SceneApi

LONGEST = {"force": 1.0, "torque": 0.6}
"""Length of the longest arrow over the size of the scene."""
APART = 0.02
"""Distance between the arrows of the measured and the predicted, over the size of the
scene: they would hide one another."""
HEIGHT = 170
"""Of a plot [pixels]."""


def arrow(vector: Array, scale: float, aside: float) -> Array:
    """Tail and tip (2, 3) [m] of an arrow along a vector, moved aside across it."""
    across = np.cross(vector, (0.0, 0.0, 1.0))
    if np.linalg.norm(across) < 1e-3 * np.linalg.norm(vector):
        across = np.cross(vector, (1.0, 0.0, 0.0))
    tail = aside * across / (np.linalg.norm(across) or 1.0)
    return np.array((tail, tail + scale * vector))


class WrenchArrows:
    """Force and torque on the object in sensor axes, measured and predicted, without
    bias.

    Parameters
    ----------
    api : viser.SceneApi
        Where they are drawn.
    playback : Playback
        Whose largest force and torque have arrows of the lengths `LONGEST`.
    size : float
        Size of the scene [m].
    """

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
        """Draw the wrench at a frame, as an estimate explains it."""
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
    """Force and torque over the whole recording: measured, and as the estimate predicts
    it with its bias. A vertical line stands at the instant up to which the estimate
    goes."""

    def __init__(self, gui: "GuiApi", playback: Playback):
        self.playback = playback
        self.handles: list[Any] = []
        z = playback.found.measurements
        self._measured = z.wrench[playback.samples]
        self._samples = z[playback.samples]
        for name, unit, first in PARTS:
            self.handles.append(
                gui.add_uplot(
                    self._data(first, None, 0),
                    self._series(),
                    title=f"{name} [{unit}]: wide measured, thin predicted",
                    scales={"x": {"time": False}},
                    axes=(
                        {"label": "pose" if playback.static else "time [s]", "size": 30,
                         "labelSize": 20},
                        {"size": 44},
                    ),
                    legend={"show": False},
                    height=HEIGHT,
                )
            )

    def show(self, index: int, estimate: Estimate | None) -> None:
        """Draw the wrench that an estimate predicts, and the line at a frame."""
        for (_, _, first), handle in zip(PARTS, self.handles, strict=True):
            handle.data = self._data(first, estimate, index)

    def _data(
        self, first: int, estimate: Estimate | None, index: int
    ) -> tuple[Array, ...]:
        """Times, three measured and three predicted components, and the line."""
        part = slice(first, first + 3)
        measured = self._measured[:, part]
        predicted = np.full_like(measured, np.nan)
        if estimate is not None:
            whole = predict_wrench(self._samples, estimate.sensed_vector)
            predicted = (whole + self.playback.bias(estimate))[:, part]
        line = np.full(len(measured), np.nan)
        line[index : index + 2] = (measured.min(), measured.max())[: len(line[index : index + 2])]
        return (self.playback.times, *measured.T, *predicted.T, line)

    def _series(self) -> tuple[Any, ...]:
        measured = [
            {"label": f"{axis} measured", "stroke": f"{colour}70", "width": 3}
            for axis, colour in COMPONENTS.items()
        ]
        predicted = [
            {"label": f"{axis} predicted", "stroke": colour, "width": 1}
            for axis, colour in COMPONENTS.items()
        ]
        line = {"label": "instant", "stroke": "#888888", "width": 1}
        return ({"label": "time"}, *measured, *predicted, line)
