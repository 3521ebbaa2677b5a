"""Times of arrival: samples that waited in a queue have times close together after a
pause, and are spread over it."""

from dataclasses import replace

import numpy as np

from hefting.core.messages import note
from hefting.core.recording import Recording
from hefting.core.spatial import Array, Mask, median, own
from hefting.ingest.lost_rows import with_time_of_lost_rows
from hefting.motion.measure import Source

SHORT = 0.1
"""Interval, over the usual one, below which two samples arrived together."""
FEWEST = 3
"""Samples of a bunch: two come together by jitter as well."""
WHOLE = 0.6
"""Intervals that a pause and its bunch may last longer or shorter than as many usual
ones."""
MOST = 0.3
"""Share of short intervals above which the times have another cause."""


def with_mended_times(recording: Recording, source: Source = "auto") -> Recording:
    """The recording with the times of samples that arrived in bunches, and of rows that
    were lost (`with_time_of_lost_rows`, of the same arguments), with a note or a
    warning of them."""
    return with_time_of_lost_rows(_with_bunches_spread(recording), source)


def _with_bunches_spread(recording: Recording) -> Recording:
    if recording.static:
        return recording
    each = {id(s.time): s.time for s in recording.streams.values()}
    spread = {key: spread_bunches(time) for key, time in each.items()}
    if not any(moved.any() for _, moved in spread.values()):
        return recording
    streams = {
        name: replace(s, time=spread[id(s.time)][0])
        for name, s in recording.streams.items()
    }
    angles = recording.angles
    if angles is not None:
        angles = replace(angles, time=spread_bunches(angles.time)[0])
    found = replace(recording, streams=streams, angles=angles)
    name = max(streams, key=lambda n: spread[id(recording[n].time)][1].mean())
    moved = spread[id(recording[name].time)][1]
    said = note(
        "times-bunched",
        f"{moved.sum()} of {len(moved)} times of the {name} come several at once after a "
        "pause, as times of arrival do: they were spread over it; log the time of each "
        "sample",
    )
    return replace(found, notes=(*recording.notes, said))


def spread_bunches(time: Array) -> tuple[Array, Mask]:
    """Times (K,) [s] with those of bunches spread evenly between the samples before and
    after, and a mask (K,) of these. Bunches that follow one another last, with the pauses
    before them, as long as their samples usually do."""
    moved = np.zeros(len(time), dtype=bool)
    steps = np.diff(time)
    if len(steps) < 3:
        return time, moved
    usual = median(steps)
    short = steps < SHORT * usual
    if not 0.0 < short.mean() <= MOST:
        return time, moved
    together = np.concatenate((short, [False])) | np.concatenate(([False], short))
    edges = np.flatnonzero(np.diff(np.concatenate(([0], together, [0]))))
    before, after = edges[::2] - 1, edges[1::2]
    inside = (before >= 0) & (after < len(time))
    before, after = before[inside], after[inside]
    lasted = time[after] - time[before]
    whole = np.abs(lasted - (after - before) * usual) < WHOLE * usual
    whole &= after - before > FEWEST
    for start, end in zip(before[whole].tolist(), after[whole].tolist(), strict=True):
        moved[start + 1 : end] = True
    if not moved.any():
        return time, moved
    rows, kept = np.arange(len(time)), ~moved
    return own(np.interp(rows, rows[kept], time[kept])), moved
