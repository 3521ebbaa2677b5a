"""Magnitudes: the largest values that a quantity can have in any recording, shape or
estimate.

Each is far beyond what a robot can hold, do or measure, in whatever unit it was written
by mistake, and small enough that products of a few of them are finite. They are checked
once, where a value enters. And what is wrong with times that do not increase.
"""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from hefting.core.errors import InputError

LARGEST: dict[str, float] = {
    "position": 1e8,
    "linear_velocity": 1e8,
    "angular_velocity": 1e8,
    "linear_acceleration": 1e10,
    "angular_acceleration": 1e10,
    "joint_positions": 1e8,
    "joint_velocities": 1e8,
    "joint_torques": 1e10,
    "joint_currents": 1e10,
    "wrench": 1e10,
    "gyroscope": 1e8,
    "accelerometer": 1e10,
    "linear_accelerometer": 1e10,
}
"""Largest absolute value of each stream of a recording but the orientation, whose norm
is one, in the units of `hefting.core.recording.Recording`. Wrenches in millinewtons and positions in nanometres
or in a geographic projection are below."""

LARGEST_TIME = 1e12
"""Largest absolute time of a sample [s]: 30,000 years; times since 1970 are 1.7e9."""

SMALLEST_INTERVAL = 1e-12
"""Smallest time between two samples of a stream [s]; sensors take 1e-5 s at least."""

LARGEST_CELL = 1e30
"""Largest absolute number of a log's cell or message, whatever it means and in whatever
unit: its square is finite. Nanoseconds since 1970 are 1.7e18."""

LARGEST_GRAVITY = 1e4
"""Largest length of gravity's vector [m/s²]; that of the Sun is 274."""

SMALLEST_GRAVITY = 1e-9
"""Smallest largest component of gravity [m/s²]: a hundredth of what a space station
has at its quietest."""

LARGEST_DISTANCE = 1e6
"""Largest coordinate of an object's pose in the sensor frame [m]."""

SMALLEST_LENGTH, LIGHTEST_OBJECT = 1e-9, 1e-12
"""Smallest side [m] and mass [kg] relative to which errors are given."""

SMALLEST_MASS = 1e-30
"""Smallest absolute mass of an estimate that is not zero [kg]: what is divided by it
stays finite."""

LARGEST_PARAMETER = 1e12
"""Largest absolute number of an estimate or a truth, in SI units: masses, moments,
inertia, bias and residual."""

LARGEST_VARIANCE = 1e30
"""Largest absolute entry of an estimate's covariance that is not infinite, in SI
units: beyond the square of `LARGEST_PARAMETER`."""


def too_large(values: NDArray[Any], largest: float) -> bool:
    """Whether an absolute value is above `largest`; `values` are finite, not empty."""
    return bool(values.max() > largest or values.min() < -largest)


def check_magnitude(
    values: NDArray[Any], largest: float, what: str, where: object = None
) -> None:
    """`InputError` for finite numbers of which one is above `largest`; `what` names
    them, `where` the file or argument."""
    if values.size and too_large(values, largest):
        worst = float(np.abs(values).max())
        raise InputError(
            f"{what} of {worst:.4g} cannot be: more than {largest:.0e}",
            where,
            "check the numbers and their units",
        )


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


def in_order(time: NDArray[Any]) -> NDArray[Any]:
    """Indices of samples in order of `time` (N,) [s], each time once: of times that
    differ by rounding the first."""
    order = np.argsort(time, kind="stable")
    steps = np.diff(time[order], prepend=-np.inf)
    return order[steps >= SMALLEST_INTERVAL]


def _are_rounded(steps: NDArray[Any]) -> bool:
    """Whether times of which many repeat have even steps otherwise."""
    forward = steps[steps > 0.0]
    return not len(forward) or forward.min() > UNEVEN * np.median(forward)


def explain_times(time: NDArray[Any], at: int, row: int) -> tuple[str, str]:
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
