"""What joint torques tell: by Pinocchio's regressor, and its gradient by differences."""

from dataclasses import replace

import numpy as np
import pytest
from benchmarks.torques_simulated import dynamics_of
from problems import problem

from hefting.core.spatial import STANDARD_GRAVITY
from hefting.planning.information import JointInformation
from hefting.planning.kinematics import Chain
from hefting.planning.optimise import lagrangian
from hefting.simulation.torque_scenario import TORQUE_ARMS
from hefting.torques.runs import FRICTION_CHANGE, OFFSET_CHANGE
from hefting.torques.samples import STICTION_SPEED

pytest.importorskip("pinocchio")

ARMS = "ur5e", "panda", "xarm7"


def of_torques(name, asked=None):
    arm = TORQUE_ARMS[name].arm
    noise = np.geomspace(0.1, 0.05, arm.n)
    own = problem(arm, asked=asked)
    chain = Chain.of(arm.robot, np.array(STANDARD_GRAVITY))
    return replace(own, chain=chain, information=JointInformation(noise, 100.0))


@pytest.mark.parametrize("name", ARMS)
@pytest.mark.parametrize("asked", [None, "mass=1%,com=2mm,inertia=20%"])
def test_the_gradient_is_that_of_differences(name, asked):
    own = of_torques(name, asked)
    rng = np.random.default_rng(0)
    x = 0.3 * rng.normal(size=own.size)
    none = {k: np.zeros_like(g) for k, g in own.look(x).excesses().items()}

    def value(x):
        return lagrangian(own.look(x), none, 1e-9, {})

    _, slope = value(x)
    for _ in range(6):
        way = rng.normal(size=own.size)
        step = 1e-7
        difference = (value(x + step * way)[0] - value(x - step * way)[0]) / (2 * step)
        # the weights are a steep function of the speed: errors of the third order are
        # below 1e-5 of the slope; rounding is 1e-13 over the step
        assert slope @ way.ravel() == pytest.approx(difference, rel=1e-4, abs=1e-5)


@pytest.mark.parametrize("name", ARMS)
def test_the_information_is_that_of_pinocchios_torques(name):
    """Rows of all instants, each joint with changes of offset and friction as unknowns
    that are known to their standard deviations; least squares by normal equations."""
    own, dynamics = of_torques(name), dynamics_of(name)
    x = 0.3 * np.random.default_rng(1).normal(size=own.size)
    look = own.look(x)
    q, dq, ddq, _ = look.states
    Y = dynamics.regressor(q, dq, ddq)[..., -10:] @ dynamics.payload
    ratio = (dq / STICTION_SPEED) ** 8
    root = np.sqrt(own.duration * 100.0 / len(q) * ratio / (1.0 + ratio))
    expected = np.zeros((10, 10))
    for j, std in enumerate(own.information.noise):
        changes = np.column_stack((np.ones(len(q)), np.sign(dq[:, j])))
        rows = root[:, j, None] * np.hstack((Y[:, j], changes)) / std
        known = np.diag((1.0 / (OFFSET_CHANGE * std), 1.0 / (FRICTION_CHANGE * std)))
        rows = np.vstack((rows, np.hstack((np.zeros((2, 10)), known))))
        b, u = rows[:, :10], rows[:, 10:]
        left = b - u @ np.linalg.lstsq(u, b, rcond=None)[0]
        expected += left.T @ left
    # rounding
    np.testing.assert_allclose(
        look.after - own.known, expected, atol=1e-9 * np.abs(expected).max()
    )
