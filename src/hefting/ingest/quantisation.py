"""Steps of a wrench that was recorded coarsely."""

import numpy as np

from hefting.core.messages import Message, note, warning
from hefting.core.recording import Recording
from hefting.core.spatial import Array

NOTICED_SHARE = 0.005
"""Error of rounding over the wrench's changes from which on it is told."""
LARGEST_SHARE = 0.05
"""The same from which on the answer is in doubt: the residuals are then no noise that
more samples lessen."""
ROUNDING = 1e-3
"""Deviation from whole steps, in steps, that counts as none."""


def quantisation_message(recording: Recording) -> Message | None:
    """What is said of the steps of force and torque, if they exceed the noise."""
    wrench = recording["wrench"].values
    shares, steps = np.zeros(2), np.zeros(2)
    for i, channels in enumerate((wrench[:, :3], wrench[:, 3:])):
        each = np.array([step_beyond_noise(values) for values in channels.T])
        changes = np.sqrt(np.mean(np.var(channels, axis=0)))
        steps[i] = each.max()
        # an error that is uniform over a step
        shares[i] = np.sqrt(np.mean(each**2) / 12.0) / max(float(changes), 1e-300)
    if not shares.max() > NOTICED_SHARE:
        return None
    sizes = " and ".join(
        f"{step:.2g} {unit}"
        for step, unit in zip(steps, ("N", "N m"), strict=True)
        if step
    )
    what = (
        f"the wrench is recorded in steps of {sizes}, larger than its noise: log more "
        "digits"
    )
    say = warning if shares.max() > LARGEST_SHARE else note
    return say("wrench-quantised", what)


def step_beyond_noise(values: Array) -> float:
    """Step of which all values (K,) are multiples, but for a constant; zero where there
    is none, or where noise spans several steps."""
    levels = np.unique(values)
    if len(levels) < 2 or len(values) < 4:
        return 0.0
    with np.errstate(over="ignore", invalid="ignore"):  # values of any size
        step = float(np.diff(levels).min())
        multiples = (levels - levels[0]) / step
        uneven = np.abs(multiples - np.round(multiples)).max()
    if not uneven < ROUNDING:
        return 0.0
    bend = values[:-2] - 2.0 * values[1:-1] + values[2:]
    # the median of |x| is 0.6745 standard deviations
    noise = float(np.median(np.abs(bend))) / (0.6745 * 6.0**0.5)
    return step if noise < 0.5 * step else 0.0
