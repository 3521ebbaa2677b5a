"""Rows of joints' streams that no joint can have sent: spikes and held rows.

Spikes are single joint angles, torques or currents, of lost or damaged messages, that
differ from their neighbours by more than a joint can move, or load its motor, in that
time. Held rows are repeated by a logger to which no message came.
"""

from dataclasses import replace

import numpy as np

from hefting.core.messages import note
from hefting.core.recording import Recording, Stream, column_names
from hefting.core.spatial import Array, Mask, interpolated, median, runs_of
from hefting.torques.samples import STICTION_SPEED

STREAMS = ("joint_positions", "joint_torques", "joint_currents")
"""Streams of the joints from which torques are identified."""
MOST_IN_A_ROW, LONGEST = 3, 0.06
"""Largest number of samples and duration [s] of a spike: a longer one may be a brief
acceleration."""
SPIKE = 12.0
"""Distance of a spike from the median of its neighbours, in standard deviations of the
noise, from which on it is one."""
HALF_WITHIN = 0.55
"""Median distance of normal noise from that median, in its standard deviations."""
STEP = 90.0, 5.0
"""Percentile of the steps between samples, and the multiple of it that is the least
distance of a spike: motion stays below it, and so do neighbours of a spike, whose
median is up to three steps away."""
LEAST_LOAD = 0.1
"""Least distance of a spike of torque or current, over the standard deviation of the
joint's values."""
BESIDE = 0.1
"""[s] Time before and after a sample over which `moving` measures a joint's motion."""
LARGEST_SHARE = 0.1
"""Share of a joint's samples above which none of them is a spike, or of rows above which
none is held: the noise is then of another kind."""


def without_spikes(recording: Recording) -> Recording:
    """The recording with each spike of the joints' streams replaced by the median of its
    neighbours, and a note of their number."""
    streams, counted = dict(recording.streams), list[str]()
    for name in filter(recording.has, STREAMS):
        values, time = streams[name].values, streams[name].time
        interval = median(np.diff(time)) if len(time) > 1 else np.inf
        many = min(MOST_IN_A_ROW, int(LONGEST / interval + 1e-6))
        if not many:
            continue
        least = 0.0 if name == "joint_positions" else LEAST_LOAD * values.std(axis=0)
        medians, spiky = spikes(values, many, least)
        if name != "joint_positions" and "joint_positions" in streams:
            spiky &= moving(streams["joint_positions"], time)
        if spiky.any():
            labels = recording.joint_names or column_names(name, values.shape[1])
            counts = zip(spiky.sum(axis=0).tolist(), labels, strict=True)
            each = ", ".join(f"{count} of {label}" for count, label in counts if count)
            counted.append(f"{name.replace('_', ' ')} ({each})")
            values = np.where(spiky, medians, values)
            streams[name] = replace(streams[name], values=values)
    if not counted:
        return recording
    what = (
        f"{recording.source}: {' and '.join(counted)} stand out from those just before and "
        "after: replaced by the median of these"
    )
    messages = (*recording.warnings, note("joint-spikes", what))
    return replace(recording, streams=streams, warnings=messages)


def moving(position: Stream, time: Array) -> Mask:
    """(K, n) whether joints are on their way at `time` (K,) [s]. They are not at
    reversals, where friction changes at once, nor at rest, where torques are unused."""
    before, after = (
        interpolated(t, position.time, position.values)
        for t in (time - BESIDE, time + BESIDE)
    )
    return np.abs(after - before) > 2.0 * BESIDE * STICTION_SPEED


def spikes(values: Array, many: int, least: Array | float) -> tuple[Array, Mask]:
    """(K, n) running medians of `values` (K, n), and (K, n) whether a value is a spike:
    of up to `many` samples, and farther than `least` (n,) from its median."""
    # SciPy's filters take long to import
    from scipy.ndimage import median_filter

    medians = median_filter(values, (2 * many + 1, 1), mode="mirror")
    distance = np.abs(values - medians)
    noise = np.median(distance, axis=0) / HALF_WITHIN
    steps = np.percentile(np.abs(np.diff(values, axis=0)), STEP[0], axis=0)
    spiky = distance > np.maximum(SPIKE * noise, np.maximum(STEP[1] * steps, least))
    return medians, spiky & (spiky.mean(axis=0) <= LARGEST_SHARE)


def without_held(recording: Recording) -> Recording:
    """The recording without rows of the joints' streams that a logger repeated while no
    message came, and a note of their number."""
    streams, counted = dict(recording.streams), list[str]()
    for name in filter(recording.has, STREAMS):
        values, time = streams[name].values, streams[name].time
        repeated = held(values, time, name == "joint_positions")
        if repeated.any():
            counted.append(f"{repeated.sum()} of {len(time)} {name.replace('_', ' ')}")
            streams[name] = Stream(time[~repeated], values[~repeated])
    if not counted:
        return recording
    what = (
        f"{recording.source}: {' and '.join(counted)} repeat the row before: left out"
    )
    messages = (*recording.warnings, note("joint-held", what))
    return replace(recording, streams=streams, warnings=messages)


def held(values: Array, time: Array, may_rest: bool) -> Mask:
    """(K,) whether rows of `values` (K, n) repeat those before for longer than `LONGEST`.

    Values that `may_rest` must jump after it, or repeat at an end of the recording,
    where samples at rest are of no use.
    """
    steps = np.abs(np.diff(values, axis=0))
    same = (steps == 0.0).all(axis=1)
    repeated = np.zeros(len(values), dtype=bool)
    # if most rows repeat, the logger is faster than the messages
    if not 0.0 < same.sum() < 0.5 * len(same):
        return repeated
    jump = STEP[1] * np.percentile(steps[~same], STEP[0], axis=0)
    for begin, end in runs_of(same):
        at_end = begin == 0 or end == len(steps)
        is_held = not may_rest or at_end or bool((steps[end] > jump).any())
        if is_held and time[end] - time[begin] > LONGEST:
            repeated[begin : end + 1] = True
    return repeated & (repeated.mean() <= LARGEST_SHARE)
