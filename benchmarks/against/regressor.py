"""Pinocchio's body regressor with NumPy's least squares."""

import numpy as np

from benchmarks.against.ours import BARE
from benchmarks.against.party import Answer, Party, Task
from benchmarks.least_squares import FROM_PINOCCHIO, pinocchio_rows
from hefting.core.inertia import InertialParameters


def identify(task: Task, _: None) -> Answer:
    """Rows in a loop over the samples, divided by the noise of force and torque."""
    z, noise = task.z, task.noise
    levels = np.repeat((noise.force, noise.torque), 3)
    arrays = (
        z.time,
        z.gravity,
        z.linear_acceleration,
        z.angular_velocity,
        z.angular_acceleration,
        z.force,
        z.torque,
    )
    A, b = pinocchio_rows(arrays)
    solution = np.linalg.lstsq(
        (A / levels[:, None]).reshape(-1, 10), (b / levels).ravel(), rcond=None
    )[0]
    return Answer(InertialParameters(solution[FROM_PINOCCHIO]))


def parties() -> list[Party]:
    """The one there is."""
    return [
        Party(
            "Pinocchio + lstsq",
            identify,
            beside=f"Hefting OLS{BARE}",
            peer=True,
            method="Pinocchio",
            calls=3,
        )
    ]
