"""Spikes: joint angles, torques and currents that stand out from those just before and
after, of lost or damaged messages; no joint moves or loads its motor so fast."""

from dataclasses import replace

import numpy as np

from hefting.core.messages import note
from hefting.core.recording import Recording, Stream, column_names
from hefting.core.spatial import Array, Mask, median
from hefting.torques.equations import STICTION_SPEED

STREAMS = ("joint_positions", "joint_torques", "joint_currents")
"""What joint torques are identified from."""
MOST_IN_A_ROW, LONGEST = 3, 0.06
"""Samples and seconds that a spike lasts at most: what lasts longer may be a brief
acceleration."""
SPIKE = 12.0
"""Standard deviations of the noise from the median of its neighbours, from which on a
sample is a spike."""
HALF_WITHIN = 0.55
"""Standard deviations from that median that half of normal noise is within."""
STEP = 90.0, 5.0
"""Least distance of a spike, where there is hardly any noise: five times the step from
sample to sample that nine of ten are within. So no motion is one, nor what is beside
spikes, whose median is up to three steps away."""
LEAST_LOAD = 0.1
"""Least distance of a torque or current over its standard deviation."""
BESIDE = 0.1
"""[s] Before and after a torque, between which a joint must be on its way."""
LARGEST_SHARE = 0.1
"""Of a joint's samples above which none is a spike: its noise is of another kind."""


def without_spikes(recording: Recording) -> Recording:
    """The same with the median of its neighbours in place of each spike of the joints'
    streams, and a note about how many there were."""
    streams, said = dict(recording.streams), list[str]()
    for name in filter(recording.has, STREAMS):
        values, time = streams[name].values, streams[name].time
        interval = median(np.diff(time)) if len(time) > 1 else np.inf
        many = min(MOST_IN_A_ROW, int(LONGEST / interval + 1e-6))
        if not many:
            continue
        least = 0.0 if name == "joint_positions" else LEAST_LOAD * values.std(axis=0)
        usual, found = spikes(values, many, least)
        if name != "joint_positions" and "joint_positions" in streams:
            found &= moving(streams["joint_positions"], time)
        if found.any():
            labels = recording.joint_names or column_names(name, values.shape[1])
            counts = zip(found.sum(axis=0).tolist(), labels, strict=True)
            each = ", ".join(f"{count} of {label}" for count, label in counts if count)
            said.append(f"{name.replace('_', ' ')} ({each})")
            values = np.where(found, usual, values)
            streams[name] = replace(streams[name], values=values)
    if not said:
        return recording
    what = (
        f"{recording.source}: {' and '.join(said)} stand out from those just before and "
        "after: the median of these serves"
    )
    messages = (*recording.warnings, note("joint-spikes", what))
    return replace(recording, streams=streams, warnings=messages)


def moving(position: Stream, time: Array) -> Mask:
    """(K, n) whether joints are on their way at `time` (K,) [s]: not where they turn
    back, as friction changes at once, nor at rest, where torques are not used."""
    before, after = (
        np.column_stack([np.interp(t, position.time, q) for q in position.values.T])
        for t in (time - BESIDE, time + BESIDE)
    )
    return np.abs(after - before) > 2.0 * BESIDE * STICTION_SPEED


def spikes(values: Array, many: int, least: Array | float) -> tuple[Array, Mask]:
    """(K, n) medians of the neighbours of `values` (K, n), and which of these, of up to
    `many` in a row, are at least `least` (n,) away and spikes."""
    # SciPy's filters take long to import
    from scipy.ndimage import median_filter

    usual = median_filter(values, (2 * many + 1, 1), mode="mirror")
    apart = np.abs(values - usual)
    noise = np.median(apart, axis=0) / HALF_WITHIN
    steps = np.percentile(np.abs(np.diff(values, axis=0)), STEP[0], axis=0)
    found = apart > np.maximum(SPIKE * noise, np.maximum(STEP[1] * steps, least))
    return usual, found & (found.mean(axis=0) <= LARGEST_SHARE)
