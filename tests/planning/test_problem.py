"""The objective and the limits of planning, and their gradients."""

from dataclasses import replace

import numpy as np
import pytest
from problems import BODY, MOTION_NOISE, NOISE, problem

from hefting.core.regressor import full_regressor
from hefting.planning.information import noise_covariance
from hefting.planning.optimise import lagrangian
from hefting.planning.problem import Cuts
from hefting.planning.space import HalfSpace
from hefting.robots.joint_motion import JointMotion
from hefting.simulation.arm import PANDA, UR5E
from hefting.simulation.wield import wield

WALLS = tuple(HalfSpace.parse(text) for text in ("z>=0.6", "-0.6,0,0.8>=-0.2"))


@pytest.mark.parametrize("arm", [PANDA, UR5E], ids=["panda", "ur5e"])
@pytest.mark.parametrize("asked", [None, "mass=1%,com=2mm,inertia=20%"])
def test_the_gradient_is_that_of_differences(arm, asked):
    own = problem(arm, asked=asked, walls=WALLS, force=8.0, torque=0.5)
    rng = np.random.default_rng(0)
    x = 0.3 * rng.normal(size=own.size)
    position = own.look(x).states.position
    near = rng.uniform(-0.02, 0.03, len(position))
    cuts = Cuts(position, near, rng.normal(size=position.shape))
    own = replace(own, cuts=cuts)
    multipliers = {k: rng.random(g.shape) for k, g in own.look(x).excesses().items()}

    def value(x):
        return lagrangian(own.look(x), multipliers, 30.0, {"corner": 0.05})

    _, slope = value(x)
    for _ in range(6):
        way = rng.normal(size=own.size)
        # the penalty's second derivative jumps: third-order errors are no smaller
        step = 1e-6
        difference = (value(x + step * way)[0] - value(x - step * way)[0]) / (2 * step)
        assert slope @ way.ravel() == pytest.approx(difference, rel=1e-5, abs=1e-4)


def test_the_information_is_the_sum_over_the_samples_of_what_mujocos_log_would_hold():
    """By regressors of `hefting.core.regressor` along the recursion of
    `hefting.robots`, less their mean."""
    own = problem()
    x = 0.2 * np.random.default_rng(1).normal(size=own.size)
    look = own.look(x)
    time = np.linspace(0.0, own.duration, len(look.states.position))
    motion = PANDA.motion(JointMotion(time, *look.states[:3]))
    A = full_regressor(wield(motion, BODY, own.chain.gravity))
    A = A - A.mean(axis=0)
    S = noise_covariance(NOISE, MOTION_NOISE, BODY.vector, 100.0)
    S_inverse = np.linalg.inv(S)
    expected = np.einsum("kip,ij,kjq->pq", A, S_inverse, A) * 400.0 / len(time)
    np.testing.assert_allclose(
        look.after - own.known, expected, atol=1e-9 * np.abs(expected).max()
    )


def test_a_joint_that_turns_without_end_is_bounded_by_nothing():
    own = problem().constraints
    ends = own.limits.position.copy()
    ends[0] = -np.inf, np.inf
    with np.errstate(invalid="raise"):
        (middle, half), *_ = replace(
            own, limits=replace(own.limits, position=ends)
        ).joint_scales
    assert (middle[0], half[0]) == (0.0, np.inf)
    np.testing.assert_allclose(middle[1:] + half[1:], ends[1:, 1])
