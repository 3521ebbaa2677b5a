"""Dashboards: a recording with its estimate in one file for other programs to show.

    write_dashboard(replay_of(recording, estimate, shape), "out.mcap")

Each kind of file is a module of this package that ends in its `DASHBOARD`; this file
lists and uses them.
"""

from collections.abc import Callable
from dataclasses import dataclass
from importlib import import_module
from pathlib import Path

import numpy as np

from hefting.core.errors import InputError
from hefting.core.estimate import Estimate
from hefting.core.gravity import ON_EARTH, Gravity
from hefting.core.messages import Message
from hefting.core.progress import report
from hefting.core.recording import Recording, Stream
from hefting.core.spatial import immutable
from hefting.prediction import Prediction, predict
from hefting.scene import Scene, scene_of
from hefting.shapes import Shape

__all__ = ["Dashboard", "Replay", "dashboard_for", "replay_of", "write_dashboard"]

FILES = ("foxglove",)
"""The module of each kind of file."""
WRITING = "writing the file"
"""Progress report of writing a file."""


@immutable
class Replay:
    """A recording, and what is shown with it. All wrenches except that of `recording` have
    the sign of `hefting.core.spatial`."""

    recording: Recording
    """As logged."""
    estimate: Estimate
    prediction: Prediction
    """The wrench that the object needs along the recorded motion."""
    scene: Scene
    """The object, in sensor axes; the estimate is the body ``"estimate"``."""

    @property
    def curves(self) -> dict[str, Stream]:
        """Wrenches (N, 6) [N, N m], in sensor axes: ``predicted``; if the recording has a
        wrench, ``measured``, corrected and without bias, and ``residual``, the measured
        minus the predicted one."""
        p = self.prediction
        curves = {"predicted": Stream(p.time, p.wrench)}
        if p.agreement is not None:
            a = p.agreement
            curves["measured"] = Stream(a.time, a.wrench)
            curves["residual"] = Stream(a.time, a.difference)
        return curves

    @property
    def warnings(self) -> tuple[str, ...]:
        """Warnings of the estimate, then others of its prediction for the recording."""
        own = self.estimate.warnings
        repeated = {*own, *self.recording.warnings}
        more = [
            text
            for text in self.prediction.warnings
            if text not in repeated
            and not (isinstance(text, Message) and text.code == "estimate-doubtful")
        ]
        return (*own, *more)


def replay_of(
    recording: Recording, estimate: Estimate, shape: Shape | None = None
) -> Replay:
    """A recording with an estimate from it, or from another one of the same object.

    Gravity is that of the estimate's provenance, or without it that on Earth.

    Raises
    ------
    InputError
        For static poses, and as `hefting.predict` does.
    """
    if recording.static:
        what = "static poses have no times, which a replay needs"
        raise InputError(what, recording.source, "give a recording with a time column")
    prediction = predict(estimate, recording, gravity=_gravity_of(estimate))
    scene = scene_of({"estimate": estimate}, shape)
    return Replay(recording, estimate, prediction, scene)


def _gravity_of(estimate: Estimate) -> Gravity:
    try:
        vector = np.asarray(estimate.provenance.get("gravity"), dtype=float)
        return Gravity.of(vector)
    except (InputError, TypeError, ValueError, OverflowError):
        return ON_EARTH


@dataclass(frozen=True, eq=False, kw_only=True)
class Dashboard:
    """A kind of file for dashboards."""

    name: str
    """Name of the program that shows it."""
    suffixes: tuple[str, ...]
    """Suffixes of the files, in lower case."""
    check: Callable[[], None]
    """Raises `MissingDependencyError` unless the libraries that write it are installed."""
    write: Callable[[Replay, str | Path, Callable[[str], str]], tuple[str, ...]]
    """Writes a replay, whole or not at all, and returns the names of the streams that it
    cannot hold; the last argument turns names of arguments in messages into the
    reader's."""


def dashboard_for(path: str | Path) -> Dashboard:
    """The kind of file of a path's suffix; `InputError` if there is none."""
    known = [import_module(f"{__name__}.{file}").DASHBOARD for file in FILES]
    suffix = Path(path).suffix.lower()
    for each in known:
        if suffix in each.suffixes:
            return each
    suffixes = ", ".join(suffix for each in known for suffix in each.suffixes)
    what = f"'{suffix}' cannot hold an estimate beside a recording"
    raise InputError(what, path, f"use {suffixes}")


def write_dashboard(
    replay: Replay, path: str | Path, say: Callable[[str], str] = str
) -> tuple[str, ...]:
    """Write a replay, whole or not at all, to a file of the kind of its suffix; returns
    the names of the streams that it cannot hold. `say` turns names of arguments in
    backquotes, in messages, into the reader's.

    Raises `InputError` for an unknown suffix and if the file cannot be written,
    `MissingDependencyError` if a library that writes it is not installed.
    """
    kind = dashboard_for(path)
    kind.check()
    report(WRITING)
    return kind.write(replay, path, say)
