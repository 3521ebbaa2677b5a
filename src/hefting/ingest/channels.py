"""Channels of the wrench, and poses, that measure nothing or only coarsely: a broken
wire, a column that was filled in or copied, a stream that stopped, too few digits."""

import numpy as np

from hefting.core.errors import InputError
from hefting.core.messages import Message, error, note, warning
from hefting.core.recording import Recording
from hefting.core.spatial import WRENCH, Array, Mask, column_medians, distinct, median

FEWEST_SAMPLES = 20
"""Number of samples from which on a constant channel is no chance."""
SAMPLES_FOR_NOISE = 5000
"""Number of first samples from which the noise of a channel is found, to 2 %."""
NOISY = 0.5
"""Level of noise by fourth differences over that by second ones, from which on a
channel has noise. It is 1 for white noise, and next to 0 for a wrench without noise, of
which a channel may be constant."""

TURNED = np.radians(10.0)
"""[rad] Turn by which the weight on the sensor, of its own plate at least, changes in
sensor axes by more than rounding."""

NOTICED_SHARE = 0.005
"""Error of rounding over the wrench's changes from which on it is reported."""
LARGEST_SHARE = 0.05
"""The same from which on the answer is in doubt, as more samples do not reduce such
residuals."""
HIDING_SHARE = 0.5
"""The same from which on little is measured: the standard deviation of the changes is
below 0.6 steps, and samples that all round to one value seem exact."""
FEW_STEPS = 2.0
"""Range in steps of the other channels of a force or torque up to which a constant one
may be rounded."""
LEVELS_OF_ROUNDING = 2
"""Number of levels on either side of a frequent one that rounding of little noise has,
too."""
LEAST_RESTING, ALONE = 0.05, 10.0
"""Share of samples at one value from which on a channel rests there: with 9 % a mass was
found 11 % too small; and their number over that of any other value, which is 4 of noise
that is rounded to twice its deviation."""
ROUNDING = 1e-3
"""Deviation from whole steps, in steps, that is rounding."""


def dead_channel_message(recording: Recording) -> Message | None:
    """An error that names channels which are constant, equal another one, or rest within
    their range, while others have noise; None if there are none."""
    values = recording["wrench"].values
    repeated = np.all(values[1:] == values[:-1], axis=1)
    values = values[np.concatenate(([True], ~repeated))]
    if len(values) < FEWEST_SAMPLES:
        return None
    noisy = has_noise(values)
    still = (values[:SAMPLES_FOR_NOISE] == values[0]).all(axis=0)
    if still.any():
        still = (values == values[0]).all(axis=0)
    if still.any() and (steps := _steps(values)).any():
        noisy |= steps.ravel() > 0.0
        largest = steps.max(axis=1)
        few = np.ptp(values, axis=0).reshape(2, 3).max(axis=1) <= FEW_STEPS * largest
        still &= ~np.repeat(few & (largest > 0.0), 3)
    if noisy.sum() < 2:
        return None
    said = [f"{WRENCH[c]} never changes" for c in np.flatnonzero(still)]
    for c in np.flatnonzero(noisy):
        for other in np.flatnonzero(noisy[:c]):
            if _equal(values[:, c], values[:, other]):
                said.append(f"{WRENCH[c]} is the same as {WRENCH[other]}")
    for name, channel in zip(WRENCH, values.T, strict=True):
        if _rests(channel):
            said.append(f"{name} often has one value, as in a filter's dead zone")
    if not said:
        return None
    what = f"{', '.join(said)}: is the channel connected, and its column the right one?"
    return error("channel-dead", what)


def _rests(channel: Array) -> bool:
    """Whether one value within the range of a channel (K,) is far more frequent than the
    others, though noise exceeds its steps."""
    channel = channel[:: -(-len(channel) // SAMPLES_FOR_NOISE)]
    levels, counts = np.unique(channel, return_counts=True)
    at = counts.argmax()
    other = np.delete(counts, at).max(initial=1)
    if not counts[at] > max(LEAST_RESTING * len(channel), ALONE * other):
        return False
    moving = channel[channel != levels[at]]
    within = min(at, len(levels) - 1 - at) > LEVELS_OF_ROUNDING
    return bool(within) and not step_beyond_noise(moving)


def require_changing_wrench(recording: Recording) -> None:
    """`InputError` for a wrench that is constant although the sensor turns."""
    values, q = recording["wrench"].values, recording["orientation"].values
    if len(values) < FEWEST_SAMPLES or (values[:SAMPLES_FOR_NOISE] != values[0]).any():
        return  # as most do: all need not be looked at
    if not values.any() or np.ptp(values, axis=0).any():
        return
    if np.abs(q @ q[0]).min() < np.cos(0.5 * TURNED):
        what = "the wrench never changes, although the sensor turns"
        fix = "is the sensor connected, and are these its columns?"
        raise InputError(what, recording.source, fix)


def has_noise(values: Array) -> Mask:
    """Which channels (6,) of a wrench (K, 6) have noise."""
    second, fourth = (
        column_medians(np.abs(np.diff(values[:SAMPLES_FOR_NOISE], order, axis=0)))
        / gain**0.5
        for order, gain in ((2, 6.0), (4, 70.0))
    )
    return np.asarray(fourth > NOISY * np.maximum(second, 1e-300))


def still_pose_message(recording: Recording) -> Message | None:
    """A warning of poses that are the same in all samples, as of a sensor at rest or a
    stream that stopped; None if they change."""
    q = recording["orientation"].values
    if len(q) < FEWEST_SAMPLES or (q != q[0]).any():
        return None
    p = recording["position"].values if recording.has("position") else q
    what = "orientation" if (p != p[0]).any() else "pose"
    text = f"the {what} never changes in {len(q)} samples: did the sensor stand still, or its stream stop?"
    return warning("pose-constant", text)


def _equal(one: Array, other: Array) -> bool:
    """Whether two channels (K,) are the same; most differ in their first samples."""
    first = slice(SAMPLES_FOR_NOISE)
    return np.array_equal(one[first], other[first]) and np.array_equal(one, other)


def quantisation_message(recording: Recording) -> Message | None:
    """Message on the steps of force and torque if they exceed the noise, else None."""
    wrench = recording["wrench"].values
    steps = _steps(wrench)
    if not steps.any():
        return None
    changes = np.sqrt(np.var(wrench, axis=0).reshape(2, 3).mean(axis=1))
    shares = _rounding_error(steps) / np.maximum(changes, 1e-300)
    if not shares.max() > NOTICED_SHARE:
        return None
    sizes = " and ".join(
        f"{step:.2g} {unit}"
        for step, unit in zip(steps.max(axis=1), ("N", "N m"), strict=True)
        if step
    )
    hidden = shares > HIDING_SHARE
    size = "larger than its noise"
    if hidden.any():
        size = f"hardly less than the {'torque' if hidden[1] else 'force'} changes"
    what = f"the wrench is recorded in steps of {sizes}, {size}: log more digits"
    say = warning if shares.max() > LARGEST_SHARE else note
    say = error if hidden.any() else say
    return say("wrench-quantised", what)


def rounding_error(wrench: Array) -> Array:
    """(2,) standard deviation of the rounding error of force [N] and torque [N m] of a
    wrench (K, 6): uniform over each step that exceeds the noise."""
    return _rounding_error(_steps(wrench))


def _rounding_error(steps: Array) -> Array:
    """(2,) standard deviation of the rounding error of force [N] and torque [N m], from the
    steps (2, 3) of their channels."""
    return np.sqrt(np.mean(np.square(steps), axis=1) / 12.0)


def _steps(wrench: Array) -> Array:
    """(2, 3) steps of the channels of force and torque."""
    return np.reshape([step_beyond_noise(values) for values in wrench.T], (2, 3))


def step_beyond_noise(values: Array) -> float:
    """Step of which all values (K,) are multiples, up to a constant; zero if there is
    none, or noise spans several steps."""
    if len(values) < 4:
        return 0.0
    with np.errstate(over="ignore", invalid="ignore"):  # values of any size
        noise = noise_of_channel(values)
        # all have no larger a step than some, and most wrenches end here
        for count in sorted({min(SAMPLES_FOR_NOISE, len(values)), len(values)}):
            levels = distinct(values[:count])
            step = float(np.diff(levels).min(initial=np.inf))
            if not noise < 0.5 * step:
                return 0.0
        if len(levels) < 2:
            return 0.0
        multiples = (levels - levels[0]) / step
        uneven = np.abs(multiples - np.round(multiples)).max()
    return step if uneven < ROUNDING else 0.0


def noise_of_channel(values: Array) -> float:
    """Standard deviation of the noise in values (K,), from at most `SAMPLES_FOR_NOISE`
    places."""
    middle = np.arange(1, len(values) - 1, -(-len(values) // SAMPLES_FOR_NOISE))
    bend = values[middle - 1] - 2.0 * values[middle] + values[middle + 1]
    # the median of |x| is 0.6745 standard deviations
    return median(np.abs(bend)) / (0.6745 * 6.0**0.5)
