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
SAMPLES_FOR_NOISE = 5000
"""Samples that tell the noise well enough: to 2 %."""


def quantisation_message(recording: Recording) -> Message | None:
    """What is said of the steps of force and torque, if they exceed the noise."""
    wrench = recording["wrench"].values
    shares, steps = np.zeros(2), np.zeros(2)
    for i, channels in enumerate((wrench[:, :3], wrench[:, 3:])):
        each = np.array([step_beyond_noise(values) for values in channels.T])
        if not each.any():
            continue
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
    if len(values) < 4:
        return 0.0
    with np.errstate(over="ignore", invalid="ignore"):  # values of any size
        noise = _noise(values)
        # all have no larger a step than some, and most wrenches end here
        for count in sorted({min(SAMPLES_FOR_NOISE, len(values)), len(values)}):
            levels = np.unique(values[:count])
            step = float(np.diff(levels).min(initial=np.inf))
            if not noise < 0.5 * step:
                return 0.0
        if len(levels) < 2:
            return 0.0
        multiples = (levels - levels[0]) / step
        uneven = np.abs(multiples - np.round(multiples)).max()
    return step if uneven < ROUNDING else 0.0


def _noise(values: Array) -> float:
    """Standard deviation of the noise in values (K,), of `SAMPLES_FOR_NOISE` places at
    most."""
    middle = np.arange(1, len(values) - 1, -(-len(values) // SAMPLES_FOR_NOISE))
    bend = values[middle - 1] - 2.0 * values[middle] + values[middle + 1]
    # the median of |x| is 0.6745 standard deviations
    return float(np.median(np.abs(bend))) / (0.6745 * 6.0**0.5)
