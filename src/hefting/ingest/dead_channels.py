"""Channels of the wrench, and poses, that measure nothing: a broken wire, a column that
was filled in or copied, a stream that stopped."""

import numpy as np

from hefting.core.messages import Message, error, warning
from hefting.core.recording import Recording
from hefting.core.spatial import Array

CHANNELS = ("fx", "fy", "fz", "tx", "ty", "tz")
FEWEST_SAMPLES = 20
"""Samples from which on a channel that never changes is no chance."""
SAMPLES_FOR_NOISE = 5000
"""Samples, the first ones, that tell whether a channel has noise."""
NOISY = 0.5
"""Level of noise by fourth differences over that by second ones, from which on a
channel has noise; it is 1 for white noise, and next to nothing for a wrench without
noise, of which a channel may well rest."""


def dead_channel_message(recording: Recording) -> Message | None:
    """An error that names the channels which never change, or equal another one, beside
    channels with noise; None where there are none."""
    values = recording["wrench"].values
    if len(values) < FEWEST_SAMPLES:
        return None
    second, fourth = (
        np.median(np.abs(np.diff(values[:SAMPLES_FOR_NOISE], order, axis=0)), axis=0)
        / gain**0.5
        for order, gain in ((2, 6.0), (4, 70.0))
    )
    noisy = fourth > NOISY * np.maximum(second, 1e-300)
    if noisy.sum() < 2:
        return None
    still = (values[:SAMPLES_FOR_NOISE] == values[0]).all(axis=0)
    if still.any():
        still = (values == values[0]).all(axis=0)
    said = [f"{CHANNELS[c]} never changes" for c in np.flatnonzero(still)]
    for c in np.flatnonzero(noisy):
        for other in np.flatnonzero(noisy[:c]):
            if _equal(values[:, c], values[:, other]):
                said.append(f"{CHANNELS[c]} is the same as {CHANNELS[other]}")
    if not said:
        return None
    what = f"{', '.join(said)}: is the channel connected, and its column the right one?"
    return error("channel-dead", what)


def still_pose_message(recording: Recording) -> Message | None:
    """A warning of poses that are the same throughout, which a sensor that stands still
    has too; None where they change."""
    q = recording["orientation"].values
    if len(q) < FEWEST_SAMPLES or (q != q[0]).any():
        return None
    p = recording["position"].values if recording.has("position") else q
    what = "orientation" if (p != p[0]).any() else "pose"
    text = (
        f"the {what} never changes in {len(q)} samples: did the sensor stand still, or "
        "its stream stop?"
    )
    return warning("pose-constant", text)


def _equal(one: Array, other: Array) -> bool:
    """Whether two channels (K,) are the same; the first samples of most tell."""
    first = slice(SAMPLES_FOR_NOISE)
    return np.array_equal(one[first], other[first]) and np.array_equal(one, other)
