"""What is wrong with times that do not increase, and what to do about it."""

import numpy as np

from hefting.core.magnitudes import SMALLEST_INTERVAL
from hefting.core.spatial import Array, Indices

ROUNDED_SHARE = 0.1
"""Share of samples with the same time as the one before, above which times were
rounded, not messages logged twice."""
SAMPLES_SET_BACK = 10
"""Number of samples earlier than one before, above which a clock was set back, not a
few rows out of order."""
FEW_STEPS_BACK = 0.01
"""Share of backward steps up to which the parts between them are in order."""
UNEVEN = 0.5
"""Least ratio of a clock's smallest step to its median, for rounded times, whose steps
are alike."""


def in_order(time: Array) -> Indices:
    """Indices of samples in order of `time` (N,) [s], each time once: of times that
    differ by rounding the first."""
    order = np.argsort(time, kind="stable")
    steps = np.diff(time[order], prepend=-np.inf)
    return order[steps >= SMALLEST_INTERVAL]


def _are_rounded(steps: Array) -> bool:
    """Whether times of which many repeat have even steps otherwise."""
    forward = steps[steps > 0.0]
    return not len(forward) or forward.min() > UNEVEN * np.median(forward)


def explain_times(time: Array, at: int, row: int) -> tuple[str, str]:
    """What is said of the sample after `at`, whose time is not beyond that of `at`, and
    what to do.

    Parameters
    ----------
    time : (K,) [s].
    at : index of the last sample before the first fault.
    row : number of its row.
    """
    before, now = time[at : at + 2]
    steps = np.diff(time)
    if before < now:
        what = f"is {now - before:.1g} s after that of row {row}"
        if np.median(steps) < SMALLEST_INTERVAL:
            return what, "check the unit of time"
        return what, "they are equal but for rounding: keep one of the two rows"
    if before == now:
        what, repeats = f"repeats that of row {row}", int((steps == 0.0).sum())
        if repeats > ROUNDED_SHARE * len(steps) and repeats > 1:
            many = f"{repeats} of {len(steps)} do: "
            forward = steps[steps > 0.0]
            step = np.median(forward) if len(forward) else len(time) / 250.0
            lasted = time[-1] - time[0] + step
            given = (
                "or give the rate in the column map that hefting map LOG writes, "
                f"time = {{ rate = {len(time) / lasted:.3g} }} [Hz]"
            )
            if _are_rounded(steps):
                return what, (
                    f"{many}write times with more digits, those since 1970 above all, "
                    f"{given}"
                )
            return what, (
                f"{many}they seem to be times of arrival, several at once: write the "
                f"sender's, {given}"
            )
        return what, "keep one of the two rows"
    what, back = f"is before {before:.9g} s of row {row}", steps < 0.0
    behind = int((time[at + 1 :] < before).sum())
    if behind >= SAMPLES_SET_BACK and back.sum() <= max(
        1.0, FEW_STEPS_BACK * len(steps)
    ):
        return what, (
            "the clock was set back there, or another recording begins: cut the log in "
            "two, and give both"
        )
    return what, "sort the rows by time"
