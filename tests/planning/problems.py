"""Problems of planning that several tests share."""

import numpy as np

from hefting.core.accuracy import Accuracy
from hefting.core.inertia import InertialParameters
from hefting.core.measurements import MotionNoise, Noise
from hefting.planning.information import Information, noise_covariance
from hefting.planning.kinematics import Chain
from hefting.planning.limits import Constraints, Limits
from hefting.planning.problem import GRID, Basis, Objective, Problem, pieces_of
from hefting.simulation.arm import PANDA

BODY = InertialParameters.from_com(
    0.8, (0.01, -0.02, 0.08), np.diag((0.004, 0.003, 0.002))
)
NOISE = Noise(0.1, 0.005)
MOTION_NOISE = MotionNoise(0.01, 0.03, 0.15)


def box_corners(sides=(0.12, 0.1, 0.2), centre=(0.0, 0.0, 0.1)):
    signs = np.array(np.meshgrid(*[(-1, 1)] * 3)).reshape(3, -1).T
    return np.vstack((np.zeros(3), np.array(centre) + 0.5 * signs * sides))


def limits_of(arm, **others):
    return Limits(
        np.array(arm.robot.limits),
        np.array(arm.joint_speeds),
        np.full(arm.n, 5.0),
        np.full(arm.n, 100.0),
        **others,
    )


def problem(arm=PANDA, duration=4.0, asked=None, walls=(), **others):
    S = noise_covariance(NOISE, MOTION_NOISE, BODY.vector, 100.0)
    return Problem(
        Chain.of(arm.robot, np.array((0.0, 0.0, -9.81))),
        Basis.of(duration, pieces_of(duration), GRID),
        np.array(arm.start),
        np.diag(np.repeat((1e-2, 1.0, 1e2), (1, 3, 6))),
        Information.of(S, 100.0),
        Objective.of(BODY, Accuracy.parse(asked) if asked else None),
        Constraints.of(limits_of(arm, **others), box_corners(), BODY.vector, walls),
    )
