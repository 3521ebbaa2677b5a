"""Samples at which the wrench was not measured, left out before anything is made of
them: its stream stood still, before its driver began, after it ended, or while it
repeated its last message; or a number stands for nothing, as -9999 does."""

from dataclasses import replace

import numpy as np

from hefting.core.messages import Message, note, warning
from hefting.core.recording import Recording, Stream
from hefting.core.spatial import Array, Indices, Mask
from hefting.ingest.channels import (
    SAMPLES_FOR_NOISE,
    has_noise,
    noise_of_channel,
)
from hefting.ingest.poses import where_in_time

FEWEST_REPEATED = 20
"""Samples in a row, all six channels alike, from which on they are no chance: with noise
of one step two channels are alike for so long once in 1e20."""
TIMES_HELD = 10.0
"""The same over the usual number of samples in a row: a slow stream that is logged
faster repeats each of its values."""
MANY_LEFT_OUT = 0.05
"""Share of samples left out above which a warning is given."""
FEWEST_CHANNELS = 2
"""Channels with noise without which nothing is told: a wrench without noise rests where
the body does."""
FAR = 10.0
"""Size of a number that stands for nothing, over that of all others."""


def without_stalled_wrench(recording: Recording) -> Recording:
    """The recording without the samples of the wrench that a stalled stream repeated,
    with a note or a warning of them.

    A recording of static poses, whose wrench has no noise or steps larger than it, or
    that has no such samples is returned as it is.
    """
    wrench = recording["wrench"]
    if recording.static or len(wrench) < FEWEST_REPEATED:
        return recording
    repeats = stalled(wrench.values)
    if not repeats.any() or repeats.all():
        return recording
    samples, where = _told(wrench, repeats)
    what = f"{samples} of a stream that stood still left out, {where}"
    many = repeats.mean() > MANY_LEFT_OUT
    said = (
        warning("wrench-stalled", f"{what}: did its driver run?")
        if many
        else note("wrench-stalled", what)
    )
    return _without(recording, repeats, said)


def without_blank_wrench(recording: Recording) -> Recording:
    """The recording without the samples of the wrench of which the same number, far from
    all others, stands in several channels, with a note of them; one of static poses, or
    without such samples, as it is."""
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
    samples, where = _told(wrench, blank)
    what = f"{samples} of {values[at][0]:g} in several channels left out, {where}"
    return _without(recording, blank, note("wrench-blank", what))


def _told(wrench: Stream, mask: Mask) -> tuple[str, str]:
    """How many samples (K,) are left out, and where."""
    samples = f"{int(mask.sum())} samples of the wrench ({100.0 * mask.mean():.2g} %)"
    return samples, where_in_time(wrench.time - wrench.time[0], mask)


def _without(recording: Recording, mask: Mask, said: Message) -> Recording:
    """The recording without samples of the wrench (K,), with what is said of them."""
    kept = {**recording.streams, "wrench": recording["wrench"][~mask]}
    recording = replace(recording, streams=kept)
    if said.severity == "note":
        return replace(recording, notes=(*recording.notes, said))
    return replace(recording, warnings=(*recording.warnings, said))


def stalled(values: Array) -> Mask:
    """Mask (K,) of the values (K, 6) that are repeated for longer than chance does."""
    first = _first_of_runs(values)
    lengths = np.diff(np.append(first, len(values)))
    usual = float(np.median(lengths))
    long = lengths >= max(FEWEST_REPEATED, TIMES_HELD * usual)
    if not long.any() or len(first) < FEWEST_REPEATED:
        return np.zeros(len(values), dtype=bool)
    never_rests = _always_changes(values[first])
    return np.repeat(long & (never_rests.sum() >= FEWEST_CHANNELS), lengths)


def _always_changes(values: Array) -> Mask:
    """Which channels (6,) of values (K, 6) have noise of more than a step, so that they
    change where the body rests, too."""
    steps = [
        np.diff(np.unique(channel[:SAMPLES_FOR_NOISE])).min(initial=np.inf)
        for channel in values.T
    ]
    noise = [noise_of_channel(channel) for channel in values.T]
    return has_noise(values) & (np.array(noise) > np.array(steps))


def _first_of_runs(values: Array) -> Indices:
    """Indices of the values (K, 6) that differ from the one before."""
    changes = (values[1:] != values[:-1]).any(axis=1)
    return np.concatenate(([0], 1 + np.flatnonzero(changes)))
