"""Live view: the estimate of the object while a stream runs, in any number of browsers.
Needs viser.

The server keeps the content, so that a browser that connects later shows all of it.
"""

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import numpy as np

from hefting.core.estimate import Estimate
from hefting.core.measurements import Measurements
from hefting.core.regressor import predict_wrench
from hefting.core.spatial import Array
from hefting.online import LiveEstimate
from hefting.online.history import FORWARD
from hefting.scene import PARTS, com_reach, headline_of, scene_of
from hefting.shapes import Shape
from hefting.viewer.drawing import ObjectDrawing
from hefting.viewer.motion import HEIGHT, add_plot, curves, scales_of
from hefting.viewer.panel import BAD, CARE, GOOD, LEVELS, block, bold, line, small
from hefting.viewer.server import Follower
from hefting.viewer.viewer import FROM

if TYPE_CHECKING:
    from viser import GuiApi, ViserServer

LAST = 20.0
"""[s] Duration of the wrench that is drawn."""
MOST_SAMPLES = 500
"""Most samples of the wrench that are drawn."""
MOST_ESTIMATES = 600
"""Most estimates in curves over time; if there are more, every second one is dropped."""
COLOURS = {
    "identified": GOOD,
    "sufficient": GOOD,
    "contradicted": BAD,
    "lost source": BAD,
}
"""Colours of states; `CARE` for others, in which something is awaited."""
AWAY = 2.2
"""Distance of the camera over the size of the scene."""
LARGEST_START = 1e5
"""[s] Larger stamps, as of the wall clock, are drawn relative to the first one: labels
with all their digits would overlap."""
MOST_MESSAGES = 4
INTERVALS = {
    "mass [kg]": {"mass": "#0072B2", "low": "#0072B280", "high": "#0072B280"},
    "COM, ± [mm]": {"x": "#D55E00", "y": "#009E73", "z": "#0072B2"},
}
"""Plots over time: their curves, and the colours of these."""


class LiveView:
    """Page of a stream's live estimates, and of the object's shape if it is known. `say`
    turns names of arguments in backquotes into the reader's."""

    def __init__(
        self,
        server: "ViserServer",
        shape: Shape | None = None,
        say: Callable[[str], str] = str,
    ):
        self.server, self.shape, self.say = server, shape, say
        gui = server.gui
        gui.configure_theme(show_logo=False, show_share_button=False)
        gui.set_panel_label("Hefting")
        self.text = gui.add_html(block(bold("waiting", CARE)))
        with gui.add_folder("Over time, with 95 % intervals", expand_by_default=True):
            self.intervals = Intervals(gui)
        with gui.add_folder("Wrench on the object", expand_by_default=True):
            self.wrench = RecentWrench(gui)
        server.scene.set_up_direction("+z")
        self.drawing: ObjectDrawing | None = None
        self.shown: LiveEstimate | None = None
        self._start = 0.0
        self._follower: Follower[LiveEstimate] = Follower(self._draw, self._fail)

    def show(self, found: LiveEstimate) -> None:
        """Show an estimate soon, in another thread; skips all but the latest."""
        self._follower.want(found)

    def settle(self) -> bool:
        """Wait until the latest estimate is shown; whether it is."""
        return self._follower.settle()

    def close(self) -> None:
        """End the thread."""
        self._follower.close()

    def _draw(self, found: LiveEstimate) -> None:
        before = -np.inf if self.shown is None else self.shown.time
        with self.server.atomic():
            self.text.content = live_html(found, self.say)
            if not 0.0 <= found.time - before <= FORWARD:  # first, or the clock jumped
                self._start = found.time if abs(found.time) > LARGEST_START else 0.0
                self.intervals.forget()
                self.wrench.forget()
            self.wrench.show(found.recent, found.estimate, self._start)
            if found.estimate is not None:
                time = found.time - self._start
                self.intervals.add(time, found.object, found.estimate)
            if found.estimate is not None or self.drawing is not None:
                self._draw_object(found.estimate)
        self.shown = found

    def _draw_object(self, estimate: Estimate | None) -> None:
        masses = None if estimate is None else estimate.point_masses
        with_masses = masses is not None and self.shape is not None
        scene = scene_of({"estimate": estimate}, self.shape, masses=with_masses)
        if self.drawing is None:
            self.drawing = ObjectDrawing(self.server.scene, scene)
            self._aim(scene.corners, self.drawing.size)
        self.drawing.show(scene)

    def _aim(self, corners: Array, size: float) -> None:
        middle = 0.5 * (corners.min(axis=0) + corners.max(axis=0))
        place = middle + AWAY * size * FROM / np.linalg.norm(FROM)
        clients = self.server.get_clients().values()
        for camera in (self.server.initial_camera, *(c.camera for c in clients)):
            camera.position, camera.look_at = place, middle
            camera.near = 1e-2 * size

    def _fail(self, error: Exception) -> None:
        self.text.content = block(bold("cannot be shown", BAD) + line(str(error)))


class Intervals:
    """Plots over time of the mass with interval, and of the COM's half-widths."""

    def __init__(self, gui: "GuiApi"):
        self._rows: list[tuple[float, ...]] = []
        self._object = 1
        self.handles: list[Any] = []
        for title, colours in INTERVALS.items():
            drawn: list[Any] = [{"label": "time"}]
            for label, stroke in colours.items():
                look = {"label": label, "stroke": stroke, "width": 1.5}
                drawn.append(look | {"points": {"show": False}})
            self.handles.append(
                gui.add_uplot(
                    (np.zeros(1), *np.full((3, 1), np.nan)),
                    tuple(drawn),
                    title=title,
                    scales={"x": {"time": False}},
                    axes=({"label": "time [s]", "size": 30, "labelSize": 20}, {}),
                    legend={"show": False},
                    height=HEIGHT,
                )
            )

    def forget(self) -> None:
        """Drop all estimates."""
        self._rows = []

    def add(self, time: float, number: int, estimate: Estimate) -> None:
        """Add the estimate of the `number`-th object at a time [s]."""
        low, high = estimate.interval("mass")
        half = np.full(3, np.nan) if (com := com_reach(estimate)) is None else 1e3 * com
        if number != self._object:  # interrupt the curves between objects
            self._object = number
            self._rows.append((time, *[np.nan] * 6))
        self._rows.append((time, estimate.mass, float(low), float(high), *half))
        if len(self._rows) > MOST_ESTIMATES:
            del self._rows[1:-1:2]
        values = np.array(self._rows)
        values[~np.isfinite(values)] = np.nan
        for k, handle in enumerate(self.handles):
            curves = values[:, 1 + 3 * k : 4 + 3 * k]
            # uPlot draws nothing if a curve begins with NaN
            first = int(np.argmax(np.isfinite(curves).all(axis=1)))
            handle.data = (values[first:, 0], *curves[first:].T)


class RecentWrench:
    """Plots of force and torque over the latest seconds, measured and predicted."""

    def __init__(self, gui: "GuiApi"):
        self._kept = np.empty((0, 13))
        empty = (np.zeros(1), *np.zeros((6, 1)))
        self.handles = [
            add_plot(gui, f"{name} [{unit}]", "time [s]", empty, curves()[:-1])
            for name, unit, _ in PARTS
        ]

    def forget(self) -> None:
        """Drop all samples."""
        self._kept = self._kept[:0]

    def show(
        self, recent: Measurements | None, estimate: Estimate | None, start: float
    ) -> None:
        """Add new samples with the wrench predicted by an estimate; times are drawn
        relative to `start` [s]."""
        if recent is None or estimate is None or not len(recent):
            return
        new = recent.time > self._kept[-1:, 0].max(initial=-np.inf)
        predicted = predict_wrench(recent, estimate.sensed_vector)
        if estimate.bias is not None:
            predicted = predicted + np.atleast_2d(estimate.bias)[-1]
        rows = np.column_stack((recent.time, recent.wrench, predicted))[new]
        kept = np.concatenate((self._kept, rows))
        self._kept = kept[kept[:, 0] > kept[-1:, 0].max(initial=0.0) - LAST]
        self._plot(self._kept[:: 1 + len(self._kept) // MOST_SAMPLES], start)

    def _plot(self, rows: Array, start: float) -> None:
        for (_, _, first), handle in zip(PARTS, self.handles, strict=True):
            measured = rows[:, 1 + first : 4 + first].T
            predicted = rows[:, 7 + first : 10 + first].T
            data = (rows[:, 0] - start, *measured, *predicted)
            handle.scales = scales_of(data)
            handle.data = data


def live_html(found: LiveEstimate, say: Callable[[str], str] = str) -> str:
    """State, verdict, numbers with their 95 % intervals, and messages, with `say` as in
    `LiveView`. All text is escaped."""
    state = f"{found.state}, {found.time:.1f} s"
    if found.object > 1:
        state += f", object {found.object}"
    lines = [bold(state, COLOURS.get(found.state, CARE))]
    if found.estimate is not None:
        verdict = found.estimate.verdict
        lines.append(bold(f"verdict: {verdict.level}", LEVELS[verdict.level]))
        lines += [line(number) for number in headline_of(found.estimate).numbers]
        lines.append(small(f"± 95 %. {found.estimate.method}"))
    lines += [small(f"- {say(str(each))}") for each in found.messages[-MOST_MESSAGES:]]
    dropped = found.counts.get("dropped", 0)
    lines += [small(f"{dropped:,} samples dropped")] if dropped else []
    return block("".join(lines))
