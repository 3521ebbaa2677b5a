"""The part of a recording in which one body was held, and a mistake in it; and spans of
a log that were left out, with their causes."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from hefting.core.estimate import Estimate
from hefting.core.immutable import immutable
from hefting.core.recording import Recording, Stream
from hefting.core.spatial import Array, Mask, in_sensor_axes, median, runs_of
from hefting.ingest.changes.stretches import Changes
from hefting.ingest.conditioned import Conditioned
from hefting.ingest.rivals.case import Case
from hefting.ingest.rivals.consequence import Doubt, doubt_of
from hefting.ingest.weights import may_be_acceleration, weights_at_rest

CAUSES = {
    "contact": "contact: the object touched something",
    "spike": "spikes of the sensor",
    "saturation": "the sensor at its limit",
    "no-pose": "no pose: before, after or in a gap of the motion",
    "no-wrench": "no wrench: a gap in the samples, or a stream that stood still",
    "pose": "poses that no body can have passed",
    "touched": "touched: no free body explains the wrench",
    "other": "another object, or another grasp",
}
"""Causes of leaving something out, in words; the first ones are masks of
`hefting.ingest.outliers.Outliers`."""
GAP = 5.0
"""Length of a step in steps of median length, above which samples are missing."""
MOST_MORE_KNOTS = 6
"""Largest number of knots, beyond two, of the drift beside which mistakes are judged."""

Condition = Callable[[Recording], Conditioned]


@dataclass(frozen=True)
class Span:
    """A part of a log that was left out."""

    cause: str
    """A key of `CAUSES`"""
    start: float
    """[s] since the log's first sample, on the clock of the motion; for static poses
    the row, counted from 0"""
    end: float
    """[s] the same; equal to `start` for a single sample"""
    samples: int
    """Number of samples of the stream concerned; 0 if they are missing"""


def left_out_of(
    whole: Recording,
    part: Recording,
    found: Conditioned,
    changes: Changes | None,
    *,
    later: float = 0.0,
) -> tuple[Span, ...]:
    """What was left out, in order of time.

    Parameters
    ----------
    whole : what was to be used, before poses were left out.
    part : of it that was used, without the poses that were left out.
    found : of the part.
    changes : with times since the first sample of `whole`; None where all of it was used.
    later : [s] from the first sample of the log to that of `whole`.
    """
    wrench, first = part["wrench"], whole.start - later
    time = wrench.time - first - found.offset
    masks: dict[str, Mask] = {}
    outliers = found.outliers
    if outliers is not None and not outliers.rejected.all():
        masks = dict(vars(outliers))
    if found.path is not None and found.path.moves:
        masks["no-pose"] = ~found.path.known_at(wrench.time - found.offset)
    spans = [s for cause, mask in masks.items() for s in runs(cause, time, mask)]
    if not part.static:
        spans += _missing(time)
        spans += _stalled_ends(whole, part, first)
        spans += _faulty_poses(whole, part, first)
    spans += [] if changes is None else _of_changes(changes.later(later))
    return tuple(sorted(spans, key=lambda span: (span.start, span.cause)))


def runs(cause: str, time: Array, mask: Mask) -> list[Span]:
    """A span for each run of samples at `time` (K,) [s] in a mask (K,)."""
    return [
        Span(cause, float(time[b]), float(time[e - 1]), e - b) for b, e in runs_of(mask)
    ]


def _missing(time: Array) -> list[Span]:
    """Spans of steps that are much longer than the median."""
    steps = np.diff(time)
    if not len(steps):
        return []
    long = np.flatnonzero(steps > GAP * median(steps))
    return [Span("no-wrench", float(time[i]), float(time[i + 1]), 0) for i in long]


def _stalled_ends(whole: Recording, part: Recording, first: float) -> list[Span]:
    """Spans of samples of the wrench, while there are poses, before the first and after
    the last one in the part."""
    every, kept, poses = whole["wrench"], part["wrench"], part["orientation"]
    within = (every.time >= poses.time[0]) & (every.time <= poses.time[-1])
    ends = (every.time < kept.time[0]) | (every.time > kept.time[-1])
    return runs("no-wrench", every.time - first, within & ends)


def _faulty_poses(whole: Recording, part: Recording, first: float) -> list[Span]:
    """Spans of poses, within the part's time, that the part does not have."""
    spans: list[Span] = []
    for name in ("position", "orientation"):
        if not (whole.has(name) and part.has(name)):
            continue
        every, kept = whole[name], part[name]
        spans += runs("pose", every.time - first, _absent(every, kept, part))
    return list(dict.fromkeys(spans))


def _absent(every: Stream, kept: Stream, part: Recording) -> Mask:
    """(K,) samples of a stream within the part's time that are not kept."""
    low, high = part["wrench"].time[[0, -1]]
    inside = (every.time >= low) & (every.time <= high)
    between = (kept.time >= low) & (kept.time <= high)
    if np.array_equal(every.time[inside], kept.time[between]):
        return np.zeros(len(inside), dtype=bool)  # the usual case, without sorting
    return np.asarray(inside & ~np.isin(every.time, kept.time))


def _of_changes(changes: Changes) -> list[Span]:
    chosen = changes.chosen
    others = [s for s in changes.stretches if s is not chosen]
    spans = [Span("other", s.start, s.end, 0) for s in others]
    return spans + [Span("touched", t.start, t.end, 0) for t in changes.touches]


@immutable
class ChosenPart:
    """The recording, or its stretch of one free body that is used."""

    recording: Recording
    found: Conditioned
    """conditioning of that part"""
    doubt: Doubt | None
    """a mistake in it, or that much of it is unexplained"""
    changes: Changes | None = None
    """of the object in the whole recording"""


def choose_part(
    recording: Recording,
    found: Conditioned,
    fit: Condition,
    *,
    may_be_biased: bool,
    tool: Estimate | None,
    as_given: bool,
    sensor_errors: float,
) -> ChosenPart:
    """The part of a recording to use: where the object changes its longest stretch, if
    possible with an object in the hand, else all of it.

    All of it is used too if a mistake explains it, or the part was given. `fit` conditions
    a part without looking for changes; `sensor_errors` as in `Case`.
    """
    with_tool, changes = tool is not None, found.changes
    case_of = partial(_case, may_be_biased=may_be_biased, sensor_errors=sensor_errors)
    case = case_of(recording, found)
    may_change = changes is not None and not as_given
    whole = doubt_of(case, with_tool=with_tool, pairs=not may_change)
    if may_change and whole is not None and whole.needs_no_change:
        whole = doubt_of(case, with_tool=with_tool)
    if changes is None or (whole is not None and whole.needs_no_change):
        return ChosenPart(recording, found, whole)
    if tool is not None:
        changes = changes.beside(tool.parameters.vector)
    if as_given:
        return ChosenPart(recording, found, whole, changes)
    stretch = changes.chosen
    part = recording.slice(stretch.start, stretch.duration)
    of_part = fit(part)
    doubt = doubt_of(case_of(part, of_part), with_tool=with_tool)
    if doubt is not None and doubt.is_fatal:
        # two mistakes at once may imitate a change
        whole = doubt_of(case, with_tool=with_tool)
        if whole is not None and whole.needs_no_change:
            return ChosenPart(recording, found, whole)
    return ChosenPart(part, of_part, doubt, changes)


def _case(
    recording: Recording,
    found: Conditioned,
    *,
    may_be_biased: bool,
    sensor_errors: float,
) -> Case | None:
    """The case on which mistakes are judged, None if there is none. If what is
    unexplained may be accelerations of a sensor of unknown position, only samples at
    rest count."""
    if found.path is None:
        return None
    case = Case.of(
        recording,
        found.path,
        found.gravity,
        found.offset,
        biased=may_be_biased,
        parameters=found.parameters,
    )
    case = replace(case, sensor_errors=sensor_errors)
    # mistakes are judged beside the drift that is removed
    case = case.with_drift(min(max(len(found.bias.knots) - 2, 0), MOST_MORE_KNOTS))
    if found.curves is None or not may_be_acceleration(recording, found):
        return case
    time, poses = case.time - case.offset, found.curves.poses
    known = poses.covers(time)
    motion = poses.at(time[known])
    gravity = in_sensor_axes(motion.orientation, found.gravity)
    mass, noise = abs(float(found.parameters[0])), float(case.noise[0])
    rest = np.zeros(len(time))
    rest[known] = weights_at_rest(motion, gravity, mass, noise)
    return None if rest[known].all() else replace(case, worth=case.worth * rest)
