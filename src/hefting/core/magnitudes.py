"""Magnitudes: the largest values that a quantity can have in any recording, shape or
estimate.

Each is far beyond what a robot can hold, do or measure, in whatever unit it was written
by mistake, and small enough that products of a few of them are finite. They are checked
once, where a value enters.
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
