"""Panel beside the scene: the answer, a legend of the colours, and controls of the
instant, the method and its hyperparameters. Needs viser."""

from collections.abc import Callable
from html import escape
from typing import TYPE_CHECKING, Any

import numpy as np

from hefting.core.errors import InputError
from hefting.core.spatial import Array
from hefting.core.summary import samples_told
from hefting.viewer import Answer, Playback, Session, Settings
from hefting.viewer.drawing import (
    ARROWS,
    AXES,
    COM,
    GREY,
    INERTIA,
    MASSES,
    SURFACE,
    TRUTH,
    axes_length,
)

if TYPE_CHECKING:
    from viser import ViserServer

MOST_REASONS = 3
"""Most reasons for doubt that are shown."""
GOOD, CARE, BAD = "#16916B", "#C07500", "#D64937"
"""Colours of the verdict, readable on white and on black."""
LEVELS = {"good": GOOD, "usable with care": CARE, "do not use": BAD}
TYPICAL_POSE_STD = (5.0, 5.0)
"""[mm] and [°] Initial values: those of the Bayes method for a pose that is not exact."""
NUMBERS = {
    "c1": ("c1", "dynamism at which the full model takes over", 0.01, 0.01),
    "regularization": ("lambda", "pull to equal masses [N/kg]", 0.0, 0.001),
}
"""Label, hint, smallest value and step of each hyperparameter's number."""


def answer_html(
    answer: Answer, used: str, static: bool, say: Callable[[str], str] = str
) -> str:
    """Verdict, reasons for doubt, numbers with their 95 % intervals, and their basis: the
    part `used` of the recording, in words, and the number of samples, or of `static`
    poses. `say` turns names of arguments in backquotes into the reader's. All text is
    escaped."""
    if answer.estimate is None:
        return block(bold("no answer yet", BAD) + line(say(answer.refusal)))
    headline, verdict = answer.headline, answer.estimate.verdict
    assert headline is not None
    lines = [bold(f"verdict: {verdict.level}", LEVELS[verdict.level])]
    lines += [
        small(f"- {say(str(reason))}") for reason in verdict.reasons[:MOST_REASONS]
    ]
    more = len(verdict.reasons) - MOST_REASONS
    lines += [small(f"and {more} more")] if more > 0 else []
    lines += [line(number) for number in headline.numbers]
    count = answer.estimate.samples
    kind = f"{count} poses" if static else samples_told(count)
    lines.append(small(f"± 95 %. {answer.estimate.method}, {used}, {kind}"))
    missing = {body.missing for body in answer.scene.bodies if body.missing}
    lines += [small(f"no ellipsoid: {why}") for why in sorted(missing)]
    return block("".join(lines))


def legend_html(answer: Answer, size: float, largest: Array) -> str:
    """Legend of colours and lengths. `size` is that of the scene [m], `largest` (2,) the
    largest force [N] and torque [N m]."""
    scene = answer.scene
    rows = [_mark(COM, "COM, with the region that holds it (95 %)")]
    if any(body.ellipsoid and body.name != "truth" for body in scene.bodies):
        rows.append(_mark(INERTIA, "uniform ellipsoid of equal inertia"))
    if any(body.name == "truth" for body in scene.bodies):
        rows.append(_mark(TRUTH, "truth: COM, uniform ellipsoid"))
    if scene.surface is not None:
        of_object = SURFACE, "shape"
        of_box = GREY, "box around the object"
        rows.append(_mark(*(of_object if scene.surface.is_object else of_box)))
    masses = None if scene.points is None else scene.points.masses
    if masses is not None:
        rows.append(_scale(1e3 * float(masses.max())))
    rows += [_mark(colour, name) for name, colour in ARROWS.items()]
    rows += [_mark(colour, f"{axis} of the sensor") for axis, colour in AXES.items()]
    force, torque = largest
    rows.append(
        small(
            f"axes: {1e3 * axes_length(size):g} mm long; longest arrows: "
            f"{force:.3g} N, {torque:.3g} N m; without bias"
        )
    )
    return block("".join(rows))


def block(inner: str) -> str:
    """Content of the panel, with its margins."""
    style = "padding:0.4em 0.8em;font-size:13px;line-height:1.35;overflow-wrap:anywhere"
    return f'<div style="{style}">{inner}</div>'


def bold(text: str, colour: str) -> str:
    """A bold line in a colour; the text is escaped."""
    return f'<div style="font-weight:700;color:{colour}">{escape(text)}</div>'


def line(text: str) -> str:
    """A line; the text is escaped."""
    return f"<div>{escape(text)}</div>"


def small(text: str) -> str:
    """A line of small print; the text is escaped."""
    return f'<div style="font-size:85%;opacity:0.8">{escape(text)}</div>'


def _mark(colour: str, text: str) -> str:
    square = f"display:inline-block;width:0.8em;height:0.8em;margin-right:0.5em;border-radius:2px;background:{colour}"
    return (
        f'<div style="font-size:85%"><span style="{square}"></span>{escape(text)}</div>'
    )


def _scale(largest: float) -> str:
    bar = (
        "display:inline-block;width:6em;height:0.8em;margin:0 0.5em;"
        f"border-radius:2px;background:linear-gradient(to right,{','.join(MASSES)})"
    )
    return (
        f'<div style="font-size:85%">mass of a point: 0<span style="{bar}"></span>'
        f"{largest:.3g} g</div>"
    )


class Controls:
    """Widgets of a server's panel for the instant of a playback and the settings of a
    session. `changed` is called, in any thread, when one of them changes."""

    def __init__(
        self,
        server: "ViserServer",
        session: Session,
        playback: Playback,
        settings: Settings,
        changed: Callable[[], None],
    ):
        self._session, self._playback, self._changed = session, playback, changed
        gui, times = server.gui, playback.times
        label = "pose" if playback.static else "time [s]"
        step = 1.0 if playback.static else 0.01
        first, last = float(times[0]), float(np.ceil(times[-1] / step) * step)
        self.time = gui.add_slider(
            label,
            first,
            round(last, 2),
            step,
            round(last, 2),
            hint="identify up to here",
        )
        self.play = gui.add_button("Play")
        names = tuple(dict.fromkeys((*session.methods, settings.method)))
        self.method = gui.add_dropdown("method", names, initial_value=settings.method)
        own = dict(settings.hyperparameters)
        typical = own.get("pose_std")
        self.pose_known = gui.add_checkbox(
            "pose-std",
            typical is not None,
            hint="say how well the shape's pose is known",
        )
        mm, degrees = TYPICAL_POSE_STD
        if typical is not None:
            mm, degrees = 1e3 * typical[0], float(np.degrees(typical[1]))
        self.pose_mm = gui.add_number(
            "position [mm]", float(mm), min=0.0, max=1e3, step=0.1
        )
        self.pose_degrees = gui.add_number(
            "angle [°]", float(degrees), min=0.0, max=180.0, step=0.1
        )
        self.numbers: dict[str, Any] = {
            name: gui.add_number(label, 1.0, min=least, step=step, hint=hint)
            for name, (label, hint, least, step) in NUMBERS.items()
        }
        self._show_settings()
        self._set_defaults(own)
        self._listen()

    @property
    def chosen_time(self) -> float:
        """Time set by the user, as those of `Playback.times`."""
        return min(float(self.time.value), float(self._playback.times[-1]))

    @property
    def settings(self) -> Settings:
        """Settings set by the user."""
        method = str(self.method.value)
        names = self._hyperparameters(method)
        chosen: dict[str, Any] = {
            name: float(number.value)
            for name, number in self.numbers.items()
            if name in names
        }
        if "pose_std" in names:
            angle = float(np.radians(self.pose_degrees.value))
            known = (1e-3 * float(self.pose_mm.value), angle)
            chosen["pose_std"] = known if self.pose_known.value else None
        return Settings(method, chosen)

    def _hyperparameters(self, method: str) -> set[str]:
        if method in self._session.given:
            return set()
        estimator = self._session.estimator(Settings(method))
        names = set(estimator.hyperparameters(getattr(estimator, "model", None)))
        if self._session.shape is None:
            names.discard("pose_std")
        return names & {*NUMBERS, "pose_std"}

    def _listen(self) -> None:
        @self.method.on_update
        def _(_: Any) -> None:
            self._show_settings()
            self._set_defaults({})
            self._changed()

        @self.pose_known.on_update
        def _(_: Any) -> None:
            self._show_settings()
            self._changed()

        for widget in (
            self.time,
            self.pose_mm,
            self.pose_degrees,
            *self.numbers.values(),
        ):
            widget.on_update(lambda _: self._changed())

    def _show_settings(self) -> None:
        names = self._hyperparameters(str(self.method.value))
        for name, number in self.numbers.items():
            number.visible = name in names
        self.pose_known.visible = "pose_std" in names
        for number in (self.pose_mm, self.pose_degrees):
            number.visible = "pose_std" in names and bool(self.pose_known.value)

    def _set_defaults(self, own: dict[str, Any]) -> None:
        method = str(self.method.value)
        if method in self._session.given:
            return
        try:
            estimator = self._session.estimator(Settings(method))
        except InputError:
            return
        for name, number in self.numbers.items():
            value = own.get(name, getattr(estimator, name, None))
            if value is not None:
                number.value = float(value)
