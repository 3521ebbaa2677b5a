"""Dashboards: a recording and what was found from it in one file, for programs of
others to show.

    write_dashboard(replay_of(recording, estimate, shape), "out.mcap")

Each kind of file is a module of this package that ends in its `DASHBOARD`; here is
their list, and what is done with one.
"""

from collections.abc import Callable
from dataclasses import dataclass
from importlib import import_module
from pathlib import Path

import numpy as np

from hefting.core.errors import InputError
from hefting.core.estimate import Estimate
from hefting.core.gravity import ON_EARTH, Gravity
from hefting.core.immutable import immutable
from hefting.core.messages import Message
from hefting.core.progress import report
from hefting.core.recording import Recording, Stream
from hefting.prediction import Prediction, predict
from hefting.scene import Scene, scene_of
from hefting.shapes import Shape

__all__ = ["Dashboard", "Replay", "dashboard_for", "replay_of", "write_dashboard"]

FILES = ("foxglove",)
"""The module of each kind of file."""
WRITING = "writing the file"
"""What is reported as progress while a file is written."""


@immutable
class Replay:
    """A recording, and what is shown with it. All wrenches have the sign of
    `hefting.core.spatial`, but for that in `recording`."""

    recording: Recording
    """As it was logged."""
    estimate: Estimate
    prediction: Prediction
    """The wrench that the object needs along the recorded motion."""
    scene: Scene
    """The object, in sensor axes; the estimate is the body ``"estimate"``."""

    @property
    def curves(self) -> dict[str, Stream]:
        """Wrenches (N, 6) [N, N m], in sensor axes: ``predicted``; where the recording
        has a wrench, ``measured``, put right and less the bias, and ``residual``, the
        measured minus the predicted one."""
        p = self.prediction
        found = {"predicted": Stream(p.time, p.wrench)}
        if p.agreement is not None:
            a = p.agreement
            found["measured"] = Stream(a.time, a.wrench)
            found["residual"] = Stream(a.time, a.difference)
        return found

    @property
    def warnings(self) -> tuple[str, ...]:
        """What the estimate warns of, then what applying it to this recording does."""
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
    """A recording beside what was found from it, or from another of the same object.

    Gravity is that of the estimate, where it tells it.

    Raises
    ------
    InputError
        For static poses, and as `hefting.predict` does.
    """
    if recording.static:
        raise InputError(
            "static poses have no times, which a replay needs",
            recording.source,
            "give a recording with a time column",
        )
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
    """A kind of file that a dashboard shows."""

    name: str
    """Of the program that shows it."""
    suffixes: tuple[str, ...]
    """Endings of the file names, in small letters."""
    check: Callable[[], None]
    """Raises `MissingDependencyError` where what writes it is not installed."""
    write: Callable[[Replay, str | Path, Callable[[str], str]], tuple[str, ...]]
    """Writes a replay, whole or not at all, and returns the names of the streams that it
    does not hold; the last argument turns names of arguments in messages into the
    reader's."""


def dashboard_for(path: str | Path) -> Dashboard:
    """The kind of file that is written to `path`, by its suffix; `InputError` where
    there is none."""
    known = [import_module(f"{__name__}.{file}").DASHBOARD for file in FILES]
    suffix = Path(path).suffix.lower()
    for each in known:
        if suffix in each.suffixes:
            return each
    suffixes = ", ".join(suffix for each in known for suffix in each.suffixes)
    raise InputError(
        f"'{suffix}' cannot hold an estimate beside a recording",
        path,
        f"use {suffixes}",
    )


def write_dashboard(
    replay: Replay, path: str | Path, say: Callable[[str], str] = str
) -> tuple[str, ...]:
    """Write a recording and what was found from it, whole or not at all, to a file
    whose suffix says which kind; returns the names of the streams that it cannot hold.
    `say` turns names of arguments in backquotes, in messages, into the reader's.

    Raises `InputError` for another suffix, and where the file cannot be written,
    `MissingDependencyError` where a library that writes the file is not installed.
    """
    kind = dashboard_for(path)
    kind.check()
    report(WRITING)
    return kind.write(replay, path, say)
