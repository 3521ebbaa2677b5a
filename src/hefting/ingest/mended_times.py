"""Corrected times of samples.

Samples that waited in a queue arrive in a bunch after a pause: they are spread over it.
A logger that makes its time of the row number gives lost rows no time: time is even,
but poses or joints step by two rows or more at once. The samples after such a step get
later times.
"""

from dataclasses import replace

import numpy as np

from hefting.core.messages import note, warning
from hefting.core.recording import Recording
from hefting.core.spatial import (
    Array,
    Indices,
    Mask,
    column_medians,
    lengths,
    median,
    own,
    runs_of,
)
from hefting.ingest.unmeasured import where_in_time
from hefting.motion.measure import POSE_STREAMS, Source, reads_columns
from hefting.motion.pose_steps import ROWS_AT_A_TIME, displacement, white_noise

SHORT_INTERVAL = 0.1
"""Interval over the usual one below which two samples arrived together."""
FEWEST_TOGETHER = 3
"""Fewest samples in a bunch: two arrive together by jitter as well."""
WHOLE_PAUSE = 0.6
"""Largest difference between the duration of a pause with its bunch and that of as many
usual intervals, in such intervals."""
MOST_SHORT = 0.3
"""Share of short intervals above which they are not taken for bunches."""
MANY = 0.05
"""Share of rows lost above which a warning is given."""
EVEN = 0.1
"""Largest difference of two intervals of even time, over the usual one."""
NEIGHBOURS = np.array((-4, -3, -2, -1, 1, 2, 3, 4))
"""Places, relative to a step, of the steps that it is compared with."""
ODD = 0.35
"""Relative difference in length from a neighbour above which a step is examined."""
CLEAR_STEP = 10.0
"""Length of the expected step, in standard deviations of the noise, from which on its
multiples are distinguished."""
STEADY = 0.2
"""Largest spread of a step's neighbours, over their length, for these to predict it."""
ALONG = 0.2
"""Largest part of a step across its neighbours, over the part along them."""
WHOLE = 0.25
"""Largest difference of a step from a whole number of expected steps."""
MOST_IN_A_ROW = 10
"""Largest number of rows lost in one step; a longer step is a jump."""
SMALLEST_NOISE = 1e-12
"""[m] or [rad] Against division by zero."""
OTHERS = 0.25
"""Largest number of odd steps that are no whole number of rows, over those that are,
for rows to be lost. Where a stream is read with jitter as many steps are short as long;
in two recordings of a real arm the ratio is three."""
FEWEST_FOR_RHYTHM = 5
"""Fewest steps of lost rows that may have a rhythm."""
RHYTHM = 0.5
"""Share of the distances between these steps that are within one row of the median,
above which the poses have another clock and no row is lost. For 12 % of the rows lost
at random it is a fifth."""
FIRST_LOOKED_AT = 300
"""Number of odd steps, evenly chosen, that are examined first."""
ROWS_FOR_DIGIT = 10_000
"""Number of rows in which the smallest change is looked for at a time."""
PASSES = 3
"""Number of times that the rows of a step are counted, beside neighbours divided by
their own numbers of rows."""


def with_mended_times(recording: Recording, source: Source = "auto") -> Recording:
    """The recording with its times corrected for bunches and for lost rows, and a note or a
    warning; arguments as for `with_time_of_lost_rows`."""
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
    """Times (K,) [s] with each bunch spread evenly between the samples before and after
    it, and the mask (K,) of the samples of bunches. A bunch with the pause before it lasts
    about as many usual intervals as it has samples."""
    moved = np.zeros(len(time), dtype=bool)
    steps = np.diff(time)
    if len(steps) < 3:
        return time, moved
    usual = median(steps)
    short = steps < SHORT_INTERVAL * usual
    if not 0.0 < short.mean() <= MOST_SHORT:
        return time, moved
    together = np.concatenate((short, [False])) | np.concatenate(([False], short))
    for begin, end in runs_of(together):
        if begin and end < len(time) and end - begin >= FEWEST_TOGETHER:
            longer = time[end] - time[begin - 1] - (end - begin + 1) * usual
            moved[begin:end] = abs(longer) < WHOLE_PAUSE * usual
    if not moved.any():
        return time, moved
    rows, kept = np.arange(len(time)), ~moved
    return own(np.interp(rows, rows[kept], time[kept])), moved


def with_time_of_lost_rows(recording: Recording, source: Source = "auto") -> Recording:
    """The recording with later times after each lost row, found from the steps of its poses
    or, without these, of its joints; and with a note or a warning.

    Only even time that all streams share may be made of the row number. The recording is
    returned as it is if it has static poses, logs its motion beside the poses, or lost no
    row.

    The motion's `source` is as for `hefting.motion.measure.measure`.
    """
    time = next(iter(recording.streams.values())).time
    has_poses = recording.has(*POSE_STREAMS)
    if (
        recording.static
        or len(time) <= len(NEIGHBOURS)
        or not (has_poses or recording.has("joint_positions"))
        or reads_columns(recording, source)
        or not all(np.array_equal(s.time, time) for s in recording.streams.values())
    ):
        return recording
    usual = float(time[-1] - time[0]) / (len(time) - 1)
    if np.ptp(np.diff(time)) > EVEN * usual:
        return recording
    if has_poses:
        steps = np.empty((len(time) - 1, 6))
        for name, columns in zip(POSE_STREAMS, np.hsplit(steps, 2), strict=True):
            values = recording[name].values
            columns[:] = displacement(values[:-1], values[1:])
            columns /= _noise_of_steps(values, columns)
    else:
        joints = np.unwrap(recording["joint_positions"].values, axis=0)
        steps = np.diff(joints, axis=0)
        steps /= _noise_of_steps(joints, steps)
    lost = _rows_lost(steps)
    if not lost.any():
        return recording
    later = usual * np.concatenate(([0.0], np.cumsum(lost)))
    shared = own(time + later)
    streams = {n: replace(s, time=shared) for n, s in recording.streams.items()}
    angles = recording.angles
    if angles is not None:
        late = np.interp(angles.time, time, later)
        angles = replace(angles, time=angles.time + late)
    found = replace(recording, streams=streams, angles=angles)
    number, share = int(lost.sum()), float(lost.sum() / len(time))
    where = where_in_time(time[1:] - time[0], lost > 0)
    what = "poses" if has_poses else "joints"
    said = warning(
        "rows-lost",
        f"{number} row{'s' if number > 1 else ''} ({100.0 * share:.2g} %) seem lost, as "
        f"time is even but the {what} step by several rows {where}: each was given "
        f"{usual:.3g} s; log the time of each sample",
    )
    if share > MANY:
        return replace(found, warnings=(*recording.warnings, said))
    return replace(found, notes=(*recording.notes, note(said.code, str(said))))


def _noise_of_steps(values: Array, steps: Array) -> float:
    """Standard deviation of the white noise of `values` (K, m), from the steps (K - 1, n)
    between them, or half of the smallest change of a number, whichever is larger."""
    white = white_noise(steps)
    digit = np.inf
    for first in range(0, len(values) - 1, ROWS_FOR_DIGIT):
        changes = np.abs(np.diff(values[first : first + ROWS_FOR_DIGIT + 1], axis=0))
        digit = min(digit, changes.min(initial=np.inf, where=changes > 0.0))
        if 0.5 * digit <= white:
            break
    return max(white, 0.5 * digit, SMALLEST_NOISE)


def _rows_lost(steps: Array) -> Indices:
    """(K - 1,) number of rows lost within each step (K - 1, n)."""
    rows = _rows_of(steps)
    for _ in range(PASSES - 1):
        if rows.max() > 1:
            rows *= _rows_of(steps / rows[:, None])
    if _has_rhythm(np.flatnonzero(rows > 1)):
        rows[:] = 1
    return rows - 1


def _rows_of(steps: Array) -> Indices:
    """(K - 1,) length of each step (K - 1, n) in rows, by comparison with its neighbours;
    all 1 if too many odd steps are no whole number of rows."""
    rows = np.ones(len(steps), dtype=int)
    places = _odd_places(steps)
    for some in (places[:: 1 + len(places) // FIRST_LOOKED_AT], places):
        parts = range(0, len(some), ROWS_AT_A_TIME)
        each = [_rows_at(steps, some[i : i + ROWS_AT_A_TIME]) for i in parts]
        found = np.concatenate([rows[:0], *each])
        if (found == 0).sum() > OTHERS * (found > 1).sum():
            return rows
    rows[places] = np.maximum(found, 1)
    return rows


def _odd_places(steps: Array) -> Indices:
    """(n,) places of the steps (K - 1, n) whose length differs from their neighbours', where
    these are long enough to predict it."""
    length = lengths(steps)
    low = np.minimum(length[:-2], length[2:])
    high = np.maximum(length[:-2], length[2:])
    odd = (length[1:-1] > (1.0 + ODD) * low) | (length[1:-1] < (1.0 - ODD) * high)
    odd &= high > 0.5 * CLEAR_STEP
    # necessary for the median of the neighbours to be a clear step: half are as long
    reach = NEIGHBOURS.max()
    counted = np.isin(np.arange(-reach, reach + 1), NEIGHBOURS)
    beside = np.convolve(np.pad(length**2, reach, "edge"), counted, "valid")
    odd &= beside[1:-1] > 0.5 * len(NEIGHBOURS) * CLEAR_STEP**2
    return 1 + np.flatnonzero(odd)


def _rows_at(steps: Array, places: Indices) -> Indices:
    """(n,) lengths in rows of the steps at some places (n,): 0 for no whole number of rows,
    1 where the neighbours do not predict it."""
    chosen = steps[places]
    near = steps[np.clip(places[:, None] + NEIGHBOURS, 0, len(steps) - 1)]
    # the median by sorting, which is faster for few numbers
    ordered, half = np.sort(np.swapaxes(near, 1, 2), axis=2), len(NEIGHBOURS) // 2
    expected = ordered[:, :, half - 1 : half + 1].mean(axis=2)
    size = lengths(expected)
    spread = column_medians(np.abs(lengths(near) - size[:, None]).T)
    share = np.einsum("ij,ij->i", chosen, expected) / np.maximum(size, 1e-12) ** 2
    across = lengths(chosen - share[:, None] * expected)
    rows = np.rint(np.clip(share, 0.0, MOST_IN_A_ROW + 2.0)).astype(int)
    is_whole = (
        (rows >= 1)
        & (rows <= MOST_IN_A_ROW + 1)
        & (np.abs(share - rows) < np.maximum(WHOLE, ODD * (rows == 1)))
    )
    clear = (size > CLEAR_STEP) & (spread < STEADY * size)
    clear &= across < ALONG * np.maximum(share, 1.0) * size
    return np.where(clear, np.where(is_whole, rows, 0), 1)


def _has_rhythm(places: Indices) -> bool:
    """Whether the distances between these places (n,) are mostly alike."""
    between = np.diff(places)
    if len(places) < FEWEST_FOR_RHYTHM:
        return False
    return bool(np.mean(np.abs(between - median(between)) <= 1.0) > RHYTHM)
