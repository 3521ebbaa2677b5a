"""Samples at which the wrench was not measured, which are left out first: its stream
stalled, had not begun, had ended, or repeated its last message; or a number such as
-9999 stands for no value."""

from dataclasses import replace

import numpy as np

from hefting.core.messages import Message, note, warning
from hefting.core.recording import Recording, Stream
from hefting.core.spatial import Array, Indices, Mask, distinct, median
from hefting.ingest.channels import (
    SAMPLES_FOR_NOISE,
    has_noise,
    noise_of_channel,
)
from hefting.ingest.poses import where_in_time

FEWEST_REPEATED = 20
"""Number of successive equal samples that are no chance: with noise of one step two
channels repeat for so long once in 1e20."""
TIMES_HELD = 10.0
"""The same over the usual number of equal samples, as a slow stream that is logged
faster repeats each value."""
MANY_LEFT_OUT = 0.05
"""Share of samples left out above which a warning is given."""
FEWEST_CHANNELS = 2
"""Least number of channels with noise for stalls to be found: a wrench without noise
rests with the body."""
FAR = 10.0
"""Size of a number that stands for no value, over that of all others."""


def without_stalled_wrench(recording: Recording) -> Recording:
    """The recording without the samples that a stalled stream of the wrench repeated,
    and a note or warning. It is unchanged for static poses, a wrench without noise or
    with larger steps, or if there are no such samples."""
    wrench = recording["wrench"]
    if recording.static or len(wrench) < FEWEST_REPEATED:
        return recording
    repeats = stalled(wrench.values)
    if not repeats.any() or repeats.all():
        return recording
    samples, where = _places(wrench, repeats)
    what = f"{samples} of a stream that stood still left out, {where}"
    many = repeats.mean() > MANY_LEFT_OUT
    said = (
        warning("wrench-stalled", f"{what}: did its driver run?")
        if many
        else note("wrench-stalled", what)
    )
    return _without(recording, repeats, said)


def without_blank_wrench(recording: Recording) -> Recording:
    """The recording without the samples of the wrench in which the same number, far
    from all others, is in several channels, and a note. It is unchanged for static
    poses or without such samples."""
    wrench = recording["wrench"]
    values = wrench.values
    if recording.static or not values.size:
        return recording
    size = np.abs(values)
    at = size == size.max()
    if np.count_nonzero(at.any(axis=0)) < FEWEST_CHANNELS:
        return recording
    blank = at.any(axis=1)
    if blank.all() or not FAR * size[~blank].max() < size.max():
        return recording
    samples, where = _places(wrench, blank)
    what = f"{samples} of {values[at][0]:g} in several channels left out, {where}"
    return _without(recording, blank, note("wrench-blank", what))


def _places(wrench: Stream, mask: Mask) -> tuple[str, str]:
    """How many samples (K,) are left out, and where, in words."""
    samples = f"{int(mask.sum())} samples of the wrench ({100.0 * mask.mean():.2g} %)"
    return samples, where_in_time(wrench.time - wrench.time[0], mask)


def _without(recording: Recording, mask: Mask, said: Message) -> Recording:
    """The recording without some samples of the wrench (K,), with the message
    `said`."""
    kept = {**recording.streams, "wrench": recording["wrench"][~mask]}
    recording = replace(recording, streams=kept)
    if said.severity == "note":
        return replace(recording, notes=(*recording.notes, said))
    return replace(recording, warnings=(*recording.warnings, said))


def stalled(values: Array) -> Mask:
    """Mask (K,) of values (K, 6) that are repeated too long to be chance."""
    first = _first_of_runs(values)
    lengths = np.diff(np.append(first, len(values)))
    usual = median(lengths)
    long = lengths >= max(FEWEST_REPEATED, TIMES_HELD * usual)
    if not long.any() or len(first) < FEWEST_REPEATED:
        return np.zeros(len(values), dtype=bool)
    never_rests = _always_changes(values[first])
    return np.repeat(long & (never_rests.sum() >= FEWEST_CHANNELS), lengths)


def _always_changes(values: Array) -> Mask:
    """Channels (6,) of values (K, 6) whose noise exceeds a step, so that they change at
    rest too."""
    steps = [
        np.diff(distinct(channel[:SAMPLES_FOR_NOISE])).min(initial=np.inf)
        for channel in values.T
    ]
    noise = [noise_of_channel(channel) for channel in values.T]
    return has_noise(values) & (np.array(noise) > np.array(steps))


def _first_of_runs(values: Array) -> Indices:
    """Indices of the values (K, 6) that differ from the one before."""
    changes = (values[1:] != values[:-1]).any(axis=1)
    return np.concatenate(([0], 1 + np.flatnonzero(changes)))
