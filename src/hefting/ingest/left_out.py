"""Spans of a log that were left out, with their causes."""

from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from hefting.core.recording import Recording, Stream
from hefting.core.spatial import Array, Mask, median, runs_of
from hefting.ingest.changes.stretches import Changes
from hefting.ingest.conditioned import Conditioned

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
    changes = None if changes is None else changes.later(later)
    if not part.static:
        used = () if changes is None else changes.used
        spans += [
            gap
            for gap in _missing(time)
            # unless it is a contact between stretches of one body
            if not any(
                gap.start < b.start and a.end < gap.end for a, b in pairwise(used)
            )
        ]
        spans += _stalled_ends(whole, part, first)
        spans += _faulty_poses(whole, part, first)
    spans += [] if changes is None else _of_changes(changes)
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
    used = changes.used
    others = [s for s in changes.stretches if s not in used]
    spans = [Span("other", s.start, s.end, 0) for s in others]
    return spans + [Span("touched", t.start, t.end, 0) for t in changes.touches]
