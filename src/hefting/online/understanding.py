"""Understanding: the estimate from a stream's recent history and its condensed older
parts, and the corrections of later samples."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from hefting.core.errors import InputError, NotIdentifiableError
from hefting.core.estimate import Estimate
from hefting.core.messages import Message, codes, note, warning
from hefting.core.recording import Recording
from hefting.core.spatial import Array, immutable, interpolated
from hefting.estimators import Estimator, default_method
from hefting.estimators.joint_state import State
from hefting.identification.checks import with_diagnostics
from hefting.identification.contradictions import with_contradictions
from hefting.identification.estimator import (
    accuracy_of,
    estimator_of,
    shape_of,
    state_of,
)
from hefting.identification.partials import part_of
from hefting.identification.waiting import Poses
from hefting.ingest.free_fit import TYPICAL_SIZE
from hefting.ingest.identifiability import identifiability
from hefting.ingest.ingest import ingest
from hefting.ingest.ingested import Ingested
from hefting.ingest.joint import joint, what_others_tell
from hefting.ingest.plausibility import (
    holds_nothing,
    mistake_in,
    named_instead,
    require_object,
)
from hefting.ingest.weights import weights_by_motion
from hefting.motion.kalman import PoseFilter
from hefting.online.expected import Expected
from hefting.shapes import Shape

MOST_PARTS = 8
"""Largest number of condensed parts, of some 20 s at 100 Hz each; beyond, the oldest is
forgotten."""
SHORTEST = 1.0
"""[s] No shorter history is understood, as offset and bias are not distinguished."""
FEWEST_ROWS = 30
"""Least number of poses and wrenches."""
TUNED_ON = 1_000
"""Number of latest poses on which the filter is tuned."""
UNKNOWN = {"bias-undetermined", "bias-unknown", "nothing-held", "sign-uncertain"}
"""Codes of messages on a recording too poor for an answer while more will come."""


@dataclass(frozen=True)
class Settings:
    """The user's settings for a stream."""

    shape: Shape | None = None
    method: str | Estimator | None = None
    reading: Mapping[str, Any] = field(default_factory=dict[str, Any])
    """Arguments of `hefting.ingest.ingest.ingest`."""
    hyperparameters: Mapping[str, Any] = field(default_factory=dict[str, Any])
    """Of the estimator, with ``until``."""
    sensor_pose: Array | None = None
    """(4, 4) pose of the sensor in the frame whose poses come; None for that frame."""


@dataclass(frozen=True)
class Task:
    """A history to understand."""

    recording: Recording | None
    """The recent history; None before there is enough."""
    condense: tuple[Recording, ...] = ()
    """Older parts of the same object that were cut off."""
    forget: bool = False
    """Whether another object is held since, so that older parts are forgotten."""


@immutable
class Understanding:
    """Findings about a history, and what adding later samples needs."""

    end: float
    """[s] Last sample that was used, on the clock of the motion."""
    obstacle: Message | None = None
    """Why there is no estimate, and what helps."""
    estimate: Estimate | None = None
    found: Ingested | None = None
    """The recent history without its samples."""
    estimator: Estimator | None = None
    others: tuple[State, ...] = ()
    """State of the estimator for each condensed part."""
    recent: State | None = None
    """State of the estimator for the recent history."""
    weight: float = 1.0
    """Mean weight of the samples before it was made one."""
    expected: Expected | None = None
    """Prediction of samples of the same object."""
    pose_filter: PoseFilter | None = None
    """Tuned on the latest poses; None without poses of a moving sensor."""
    changed: float | None = None
    """[s] Time since which another object is held, by `hefting.ingest.changes`."""


class Understander:
    """Understands successive histories; keeps the condensed parts."""

    def __init__(self, settings: Settings):
        self._settings = settings
        self._hyperparameters = dict(settings.hyperparameters)
        self._shape = shape_of(settings.method, settings.shape, self._hyperparameters)
        default = default_method(self._shape is not None)
        self._method: str | Estimator = settings.method or default
        self._parts: list[Ingested] = []

    def __call__(self, task: Task) -> Understanding | None:
        """The understanding of a task; None if its history is too short."""
        if task.forget:
            self._parts = []
        for older in task.condense:
            self._condense(older)
        recording = task.recording
        if recording is None or not long_enough(recording):
            return None
        end = float(recording["wrench"].time[-1])
        try:
            return self._understood(recording)
        except InputError as error:
            return Understanding(end, obstacle=_obstacle(error))
        except np.linalg.LinAlgError:
            what = "the samples are of no size that wrenches have"
            return Understanding(end, obstacle=warning("live-mistaken", what))

    def _understood(self, recording: Recording) -> Understanding:
        """The understanding of the recent history with the parts. Raises `InputError`
        if it cannot be ingested."""
        reading = dict(self._settings.reading)
        recent = ingest(recording, **reading)
        # at rest only the older parts determine whether there is a bias, and the sign
        if again := what_others_tell([*self._parts, recent])[-1]:
            recent = ingest(recording, **(reading | again))
        known = Understanding(
            end=float(recent.measurements.time[-1]), changed=_changed(recent)
        )
        try:
            return self._identified(known, recent, recording)
        except InputError as error:
            obstacle = _obstacle(error, mistake_in(recent) is not None)
            known, why = replace(known, obstacle=obstacle), error.what
        if holds_nothing(recent):  # the next object is noticed as a change
            said = why if recent.tool is None else f"nothing is held: {why}"
            known = replace(
                known,
                obstacle=note("live-nothing-held", said),
                found=recent.without_samples(),
                weight=_mean_weight(recent),
                expected=Expected.of(recent),
                pose_filter=_filter(recording),
            )
        return known

    def _identified(
        self, known: Understanding, recent: Ingested, recording: Recording
    ) -> Understanding:
        """As `hefting.identification.partials.identify_parts`, with what is needed
        later. Raises `InputError` without an estimate."""
        unknown = [m for m in recent.warnings if m.code in UNKNOWN]
        if unknown and not self._parts:
            if "nothing-held" in codes(unknown):
                raise NotIdentifiableError(str(unknown[0]))
            raise named_instead(_too_little(recent, unknown[0]), recent)
        parts = [*self._parts, recent]
        found = recent
        if len(parts) > 1:
            names = [f"part {i}" for i in range(1, len(parts) + 1)]
            accuracy = accuracy_of(self._method, self._hyperparameters)
            found = with_contradictions(joint(parts, names), accuracy)
        require_object(found, self._shape)
        estimator = estimator_of(
            self._method, found, self._shape, dict(self._hyperparameters)
        )
        states = [state_of(estimator, part) for part in found.recordings]
        estimate = estimator.estimate(estimator.merge_all(states))
        estimate = with_diagnostics(estimate, estimator, found, self._shape)
        return replace(
            known,
            estimate=estimate,
            found=recent.without_samples(),
            estimator=estimator,
            others=tuple(states[:-1]),
            recent=states[-1],
            weight=_mean_weight(recent),
            expected=Expected.of(recent, estimate if self._parts else None),
            pose_filter=_filter(recording),
        )

    def _condense(self, recording: Recording) -> None:
        if not long_enough(recording):
            return
        settings = {k: v for k, v in self._hyperparameters.items() if k != "until"}
        method = self._method
        if isinstance(method, Estimator) and method.asked is not None:
            method = replace(method, until=None)  # type: ignore[call-arg]
        try:
            found = ingest(recording, **self._settings.reading)
            part = part_of(found, self._shape, method, settings)
        except (InputError, np.linalg.LinAlgError):
            return
        if codes(found.warnings) & UNKNOWN:
            return
        self._parts = [*self._parts, part][-MOST_PARTS:]


def long_enough(recording: Recording) -> bool:
    """Whether there are enough wrenches and poses."""
    return recording.has("wrench", "orientation") and all(
        len(stream) >= FEWEST_ROWS and stream.time[-1] - stream.time[0] >= SHORTEST
        for stream in (recording["wrench"], recording["orientation"])
    )


def _changed(found: Ingested) -> float | None:
    """[s] Start of the last stretch, if another object is held in it."""
    changes = found.changes
    if changes is None or len(changes.stretches) < 2:
        return None
    if changes.stretches[-2].event in (None, "touched"):
        return None
    return found.log_start + changes.stretches[-1].start


def _mean_weight(found: Ingested) -> float:
    """Mean weight of the samples by the errors of their motion."""
    motion = found.motion
    if motion is None or found.source == "orientation" or len(motion.time) < 2:
        return 1.0
    return float(weights_by_motion(found.conditioned, motion).mean())


def _filter(recording: Recording) -> PoseFilter | None:
    """Filter of new poses; None without poses to tune it on. Poses at rest before the
    motion are left out, as they would make it slow."""
    orientation = recording["orientation"][-TUNED_ON:]
    position = None
    if recording.has("position"):
        stream = recording["position"]
        position = interpolated(orientation.time, stream.time, stream.values)
    poses = Poses(orientation.time, position, orientation.values)
    latest = np.searchsorted(poses.time, poses.time[-1] - SHORTEST)
    fewest = min(int(latest), len(poses.time) - FEWEST_ROWS)
    poses = poses[min(poses.first_moved or 0, fewest) :]
    try:
        return PoseFilter.tuned(poses.time, poses.position, poses.orientation)
    except (InputError, np.linalg.LinAlgError, ValueError):
        return None


def _too_little(found: Ingested, message: Message) -> InputError:
    seen = identifiability(found.excitation, found.beside_bias, TYPICAL_SIZE)
    what = "; ".join(seen.summary) or str(message)
    return NotIdentifiableError(what, fix="turn the sensor to other orientations")


def _obstacle(error: InputError, mistaken: bool = False) -> Message:
    """A message on why there is no estimate. More motion does not help if the samples
    are `mistaken`, or the error has another cause than too little information."""
    fix = f"; {error.fix}" if error.fix else ""
    if mistaken or not isinstance(error, NotIdentifiableError):
        return warning("live-mistaken", f"no estimate: {error.what}{fix}")
    return note("live-little-motion", f"no estimate yet: {error.what}{fix}")
