"""Controls of the viewer: the instant, the method and its hyperparameters. Needs
viser."""

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import numpy as np

from hefting.core.errors import InputError
from hefting.viewer.playback import Playback
from hefting.viewer.session import Session, Settings

if TYPE_CHECKING:
    from viser import ViserServer

TYPICAL_POSE_STD = (5.0, 5.0)
"""[mm] and [°] shown before any is set: what Bayes reckons with where the pose is not
exact."""
NUMBERS = {
    "c1": ("c1", "dynamism at which the full model takes over"),
    "regularization": ("lambda", "pull to equal masses [N/kg]"),
}
"""Label and hint of the number of each hyperparameter."""
LEAST = {"c1": 0.01, "regularization": 0.0}
"""Smallest value of each."""
STEPS = {"c1": 0.01, "regularization": 0.001}
"""How finely each is shown and set."""


class Controls:
    """Widgets that say which instant and which settings are wanted.

    Parameters
    ----------
    server : viser.ViserServer
        Whose panel they are in.
    session, playback
        What is chosen from.
    changed : callable
        Called, in any thread, when something else is wanted.
    """

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
            name: gui.add_number(
                label, 1.0, min=LEAST[name], step=STEPS[name], hint=hint
            )
            for name, (label, hint) in NUMBERS.items()
        }
        self._show_settings()
        self._set_defaults(own)
        self._listen()

    @property
    def chosen_time(self) -> float:
        """Time that is wanted, as those of `Playback.times`."""
        return min(float(self.time.value), float(self._playback.times[-1]))

    @property
    def settings(self) -> Settings:
        """Settings that are wanted."""
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
        """Those of a method for which there are controls."""
        if method in self._session.given:
            return set()
        estimator = self._session.estimator(Settings(method))
        names = set(estimator.hyperparameters(getattr(estimator, "model", None)))
        if self._session.shape is None:
            names.discard("pose_std")
        return names & {*NUMBERS, "pose_std"}

    def _listen(self) -> None:
        """Follow every widget."""

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
        """Show the controls that the method has."""
        names = self._hyperparameters(str(self.method.value))
        for name, number in self.numbers.items():
            number.visible = name in names
        self.pose_known.visible = "pose_std" in names
        for number in (self.pose_mm, self.pose_degrees):
            number.visible = "pose_std" in names and bool(self.pose_known.value)

    def _set_defaults(self, own: dict[str, Any]) -> None:
        """Set the numbers of a method to what it would take by itself."""
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
