"""Channels of the wrench that measure nothing: a broken wire, a column that was filled
in or copied."""

import numpy as np

from hefting.core.messages import Message, error
from hefting.core.recording import Recording

CHANNELS = ("fx", "fy", "fz", "tx", "ty", "tz")
FEWEST_SAMPLES = 20
"""Samples from which on a channel that never changes is no chance."""
NOISY_SHARE = 0.5
"""Share of a channel's samples that differ from the one before, from which on it has
noise: where no channel has, one may rest."""


def dead_channel_message(recording: Recording) -> Message | None:
    """An error that names the channels which never change, or equal another one, beside
    channels with noise; None where there are none."""
    values = recording["wrench"].values
    if len(values) < FEWEST_SAMPLES:
        return None
    noisy = np.mean(values[1:] != values[:-1], axis=0) > NOISY_SHARE
    if noisy.sum() < 2:
        return None
    still = (values == values[0]).all(axis=0)
    said = [f"{CHANNELS[c]} never changes" for c in np.flatnonzero(still)]
    for c in np.flatnonzero(noisy):
        for other in np.flatnonzero(noisy[:c]):
            if np.array_equal(values[:, c], values[:, other]):
                said.append(f"{CHANNELS[c]} is the same as {CHANNELS[other]}")
    if not said:
        return None
    what = f"{', '.join(said)}: is the channel connected, and its column the right one?"
    return error("channel-dead", what)
