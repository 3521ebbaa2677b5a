"""OLS from motion arrays, against Pinocchio's body regressor and NumPy's least
squares."""

import numpy as np
import pinocchio as pin

from benchmarks.problem import wielded
from benchmarks.report import Row, Section, faster
from benchmarks.timing import Party, compare
from hefting import OLS
from hefting.core.measurements import Measurements
from hefting.core.spatial import Array

FROM_PINOCCHIO = [0, 1, 2, 3, 4, 5, 7, 6, 8, 9]
"""Pinocchio has Ixx Ixy Iyy Ixz Iyz Izz, the project Jxx Jxy Jxz Jyy Jyz Jzz."""


def pinocchio_rows(arrays: tuple[Array, ...]) -> tuple[Array, Array]:
    """Regressors (K, 6, 10), columns in Pinocchio's order, and wrenches (K, 6), as a
    user of Pinocchio finds them: by a loop over the samples."""
    _, g, a, w, alpha, force, torque = arrays
    A, origin_at_rest = np.empty((len(a), 6, 10)), np.zeros(3)
    for k in range(len(a)):
        A[k] = pin.bodyRegressor(
            pin.Motion(origin_at_rest, w[k]), pin.Motion(a[k] - g[k], alpha[k])
        )
    return A, np.hstack((force, torque))


def with_pinocchio(arrays: tuple[Array, ...]) -> Array:
    """Ten parameters (10,): those rows, then least squares."""
    A, b = pinocchio_rows(arrays)
    solution = np.linalg.lstsq(A.reshape(-1, 10), b.ravel(), rcond=None)[0]
    return solution[FROM_PINOCCHIO]


def against_pinocchio(samples: int, rounds: int) -> Section:
    """Both from the same arrays of motion and wrench."""
    z = wielded(3500)[:samples]
    motion = (
        z.gravity,
        z.linear_acceleration,
        z.angular_velocity,
        z.angular_acceleration,
    )
    arrays = (z.time, *motion, z.force, z.torque)
    times = compare(
        {
            "pinocchio": Party(lambda _: with_pinocchio(arrays), calls=2),
            "hefting": Party(
                lambda _: OLS(intervals=False).fit(Measurements(*arrays)), calls=5
            ),
        },
        rounds,
    )
    theirs, ours = times["pinocchio"], times["hefting"]
    difference = np.abs(ours.results[-1].parameters.vector - theirs.results[-1]).max()
    return Section(
        f"OLS, {samples:,} samples",
        (
            Row("Pinocchio's regressor, NumPy's lstsq", theirs),
            faster("Hefting: OLS().fit(Measurements(...))", ours, theirs, 1.0),
            Row(
                "largest difference of a parameter",
                figure=float(difference),
                at_most=1e-9,
            ),
        ),
    )
