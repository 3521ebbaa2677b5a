"""Kinematics of planning against the forward recursion of `hefting.robots`, and its
gradient against differences."""

import numpy as np
import pytest

from hefting.planning.kinematics import Chain, TipGradient
from hefting.robots.joint_motion import JointMotion
from hefting.simulation.arm import PANDA, UR5E, XARM7

GRAVITY = np.array((0.3, -0.2, -9.7))
ARMS = {"ur5e": UR5E, "panda": PANDA, "xarm7": XARM7}


def random_joints(arm, seed=0, K=7):
    rng = np.random.default_rng(seed)
    q, dq, ddq = rng.normal(size=(3, K, arm.n))
    return JointMotion(np.arange(K) / K, q, dq, 3.0 * ddq)


@pytest.mark.parametrize("name", ARMS)
def test_it_is_the_motion_of_the_robots_forward_recursion(name):
    arm = ARMS[name]
    joints = random_joints(arm)
    tip = (
        Chain.of(arm.robot, GRAVITY)
        .forward(joints.position, joints.velocity, joints.acceleration)
        .motion
    )
    exact = arm.motion(joints)
    world = {
        "angular_velocity": exact.angular_velocity,
        "velocity": exact.linear_velocity,
        "angular_acceleration": exact.angular_acceleration,
        "acceleration": exact.linear_acceleration - GRAVITY,
    }
    for field, vectors in world.items():
        own = np.einsum("kji,kj->ik", exact.rotation, vectors)
        # rounding, of accelerations of some 100 m/s²
        np.testing.assert_allclose(getattr(tip, field), own, atol=1e-11)
    np.testing.assert_allclose(tip.position.T, exact.position, atol=1e-13)
    np.testing.assert_allclose(
        np.moveaxis(tip.rotation, 2, 0), exact.rotation, atol=1e-13
    )


@pytest.mark.parametrize("name", ARMS)
def test_its_gradient_is_that_of_differences(name):
    arm = ARMS[name]
    joints = random_joints(arm, 1)
    chain = Chain.of(arm.robot, GRAVITY)
    rng = np.random.default_rng(2)
    K = len(joints.time)
    weights = rng.normal(size=(4, 3, K))
    place, corner = rng.normal(size=(2, 3))
    normal = rng.normal(size=(3, K))

    def value(q, dq, ddq):
        tip = chain.forward(q, dq, ddq).motion
        found = sum((w * x).sum() for w, x in zip(weights, tip[:4], strict=True))
        at = tip.position + np.einsum("ijk,j->ik", tip.rotation, corner)
        return found + (normal * at).sum() + place @ tip.position @ np.ones(K)

    given = joints.position, joints.velocity, joints.acceleration
    passed = chain.forward(*given)
    R = passed.motion.rotation
    push = np.einsum("jik,jk->ik", R, normal)
    pull = np.einsum("jik,j->ik", R, place)
    turn = np.cross(corner, push, axisb=0, axisc=0)
    found = passed.back(TipGradient(*weights, push + pull, turn))
    step = 1e-6
    for kind in range(3):
        for k, j in ((0, 0), (3, arm.n - 2), (6, arm.n - 1), (2, 2)):
            up, down = ([x.copy() for x in given] for _ in range(2))
            up[kind][k, j] += step
            down[kind][k, j] -= step
            slope = (value(*up) - value(*down)) / (2.0 * step)
            # rounding of 1e-13 over the step, of slopes of up to 1e3
            assert found[kind][k, j] == pytest.approx(slope, rel=1e-6, abs=1e-5)
