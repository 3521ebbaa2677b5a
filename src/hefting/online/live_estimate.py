"""Live estimate: the estimate of the object at a time of a stream. The last one is that
of `hefting.identify` on the whole stream, also if an accuracy was asked for."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, Literal

import numpy as np

from hefting.core.errors import InputError
from hefting.core.estimate import Estimate
from hefting.core.measurements import Measurements
from hefting.core.messages import Message, codes, note
from hefting.core.recording import Recording, Stream
from hefting.identification.estimator import accuracy_of, shape_of
from hefting.identification.identify import identify_understood
from hefting.identification.run import understand
from hefting.logs.given import as_recording
from hefting.logs.orientations import with_given_sensor_pose
from hefting.online.understanding import Settings

LiveStateName = Literal[
    "waiting",
    "too little motion",
    "mistaken",
    "nothing held",
    "identified",
    "sufficient",
    "contradicted",
    "lost source",
]


LEAST_SPREAD = 0.3
"""[m/s²] Spread of the acceleration that shows whether a body is held: several times
its errors."""
NO_ESTIMATE = "live-waiting", "live-little-motion", "live-mistaken", "live-nothing-held"
"""Codes of messages on why there is no estimate."""
UNSEEN_SHARE = 0.05
"""Share of the earlier object's mass below which nothing is held."""


@dataclass(frozen=True, eq=False)
class LiveEstimate:
    """The estimate of the object at a time of a stream.

    Examples
    --------
    >>> live = hefting.LiveIdentifier()
    >>> live.latest is None  # before any sample
    True
    >>> live.close()
    """

    time: float
    """[s] Newest stamp of the stream."""
    state: LiveStateName
    """``"waiting"`` for streams, ``"too little motion"``, ``"mistaken"`` if more motion
    does not help, ``"nothing held"`` apart from the tool, ``"identified"``,
    ``"sufficient"`` if it also has the accuracy `until` and may be used,
    ``"contradicted"`` while the wrench is not that of the object (touched, slipped or
    swapped), ``"lost source"``."""
    estimate: Estimate | None = None
    """None before the motion suffices."""
    object: int = 1
    """Number of the object, which increases when another is held."""
    previous: Estimate | None = None
    """The last estimate of the previous object."""
    recent: Measurements | None = field(default=None, repr=False)
    """Samples since the stream was last understood, corrected by that understanding: the
    newest ones of the estimate."""
    messages: tuple[Message, ...] = ()
    """Messages on the stream; the estimate has its own."""
    counts: Mapping[str, Any] = field(default_factory=dict[str, Any])
    """Numbers of ``samples``, of those ``dropped`` as they came too fast, and by reason
    of those ``skipped``."""

    @property
    def sufficient(self) -> bool:
        """Whether the estimate reaches the accuracy that was asked for."""
        return self.state == "sufficient"

    def to_dict(self) -> dict[str, Any]:
        """JSON-ready values: keys of `Estimate.to_dict`, where there is one, and
        ``state``, ``sufficient``, ``time``, ``object``, ``previous``, ``counts``."""
        own = {} if self.estimate is None else self.estimate.to_dict()
        messages = [message.to_dict() for message in self.messages]
        before = self.previous
        return own | {
            "messages": [*messages, *own.get("messages", [])],
            "time": self.time,
            "state": self.state,
            "sufficient": self.sufficient,
            "object": self.object,
            "previous": before
            and {"mass": before.mass, "center_of_mass": before.center_of_mass.tolist()},
            "counts": {
                k: dict(v) if isinstance(v, Mapping) else v
                for k, v in self.counts.items()
            },
        }


def final_estimate(
    last: LiveEstimate,
    recordings: Sequence[Recording | str | Path | dict[str, Stream]] | None,
    settings: Settings,
    since: float | None,
) -> LiveEstimate:
    """The last live estimate with the estimate from the whole stream by `settings`; with
    that of the previous object if nothing is held at the end; unchanged if the whole
    stream cannot be identified, or was not kept.

    `recordings` are those of each clock of the stream with wrench and poses; None if it
    was too long to be kept. The last object is held since the stamp `since` [s]; None for
    the first one.
    """
    if recordings is None:
        what = (
            "the stream is too long to be kept: the final answer is the last live one"
        )
        return replace(last, messages=(*last.messages, note("live-not-kept", what)))
    if not recordings:
        return last
    start, understood, before = 0.0, None, last.previous
    shape, hyperparameters = settings.shape, dict(settings.hyperparameters)
    try:
        logs = [
            Recording(each, source="live")
            if isinstance(each, dict)
            else as_recording(each)
            for each in recordings
        ]
        if settings.sensor_pose is not None:
            logs = [with_given_sensor_pose(one, settings.sensor_pose) for one in logs]
        if since is not None:  # an object is held in one clock: the last
            logs = logs[-1:]
            # a log has its own time of the start, but the same end
            start = max(logs[0].duration - (last.time - since), 0.0)
        whole = logs[0] if len(logs) == 1 else logs
        shape = shape_of(settings.method, shape, hyperparameters)
        accuracy = accuracy_of(settings.method, hyperparameters)
        understood = understand(whole, accuracy, start=start, **settings.reading)
        found = identify_understood(
            understood, shape, settings.method, hyperparameters, stop=False
        )
    except InputError as error:
        if understood is not None and _is_empty(understood.measurements, before):
            return _of_object_before(last, since)
        why = note("live-little-motion", f"no final answer: {error}")
        return replace(last, messages=(*last.messages, why))
    estimate, messages = found.estimate, _past_waiting(last)
    doubted = not estimate.verdict.usable
    if doubted and _is_empty(understood.measurements, before):
        return _of_object_before(last, since)
    if since is not None:
        what = f"the final answer is of object {last.object} alone, as with `start`={start:.3f}"
        messages = (*messages, note("live-part-used", what, "start"))
    empty = "nothing-held" in codes(estimate.warnings)
    state = "nothing held" if empty else state_of(estimate)
    return replace(last, estimate=estimate, state=state, messages=messages)


def state_of(estimate: Estimate) -> LiveStateName:
    """State of an estimate: whether it has the wanted accuracy, and may be used."""
    enough = estimate.sufficient and estimate.verdict.usable
    return "sufficient" if enough else "identified"


def _is_empty(z: Measurements, before: Estimate | None) -> bool:
    """Whether the force is that of no body compared with the object `before`: the bias
    found with that, of either sign, or constant where the motion would show a body."""
    if before is None or not len(z):
        return False
    load = z.linear_acceleration - z.gravity
    least = UNSEEN_SHARE * before.mass
    bias = np.zeros(6) if before.common_bias is None else before.common_bias
    apart = np.median(z.force, axis=0) - np.outer((1.0, -1.0), bias[:3])
    weight = least * float(np.linalg.norm(load, axis=1).mean())
    if np.linalg.norm(apart, axis=1).min() < weight:
        return True
    load, force = load - load.mean(axis=0), z.force - z.force.mean(axis=0)
    spread = float(np.square(load).sum())
    shows = spread > len(z) * LEAST_SPREAD**2
    return shows and abs(float((load * force).sum())) < least * spread


def _of_object_before(last: LiveEstimate, since: float | None) -> LiveEstimate:
    """The final estimate of an object that was put down before the end."""
    number, before = last.object - 1, last.previous
    assert before is not None
    when = "" if since is None else f" since {since:.2f} s"
    what = f"nothing is held{when}: the final answer is of object {number}, before"
    message = note("live-nothing-held", f"{what} ({before.mass:.4g} kg)")
    return replace(
        last,
        state="nothing held",
        estimate=before,
        object=number,
        previous=None,
        messages=(*_past_waiting(last), message),
    )


def _past_waiting(last: LiveEstimate) -> tuple[Message, ...]:
    """Messages on the stream, except those on why there is no estimate."""
    return tuple(m for m in last.messages if m.code not in NO_ESTIMATE)
