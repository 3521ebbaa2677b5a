"""Arms and what their joints can do: against a maker's URDF, limits of angle and of
speed."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from arms import mounted
from hefting.core.errors import InputError
from hefting.robots import Robot
from hefting.simulation import (
    UR5,
    XARM7,
    Arm,
    JointMotion,
    random_smooth,
    sinusoids,
    stop_and_go,
)

XARM7_JOINTS = (
    ((0, 0, 0.267), 0), ((0, 0, 0), -1), ((0, -0.293, 0), 1), ((0.0525, 0, 0), 1),
    ((0.0775, -0.3425, 0), 1), ((0, 0, 0), 1), ((0.076, 0.097, 0), -1),
)  # fmt: skip
"""Origins of the xArm 7's joints as its maker's URDF has them: xyz [m], and roll in
quarter turns."""

MOTIONS = {
    "sinusoids": lambda arm, **more: sinusoids(8.0, 100.0, 1.5, arm, **more),
    "random": lambda arm, **more: random_smooth(8.0, 100.0, 1.5, 4, arm, **more),
    "stop and go": lambda arm, **more: stop_and_go(
        8.0, 100.0, 0.5, 1.2, 4, arm, **more
    ),
}

SLIDING = (
    '<robot name="r"><link name="a"/><link name="b"/><link name="c"/><link name="d"/>'
    '<joint name="turn" type="continuous"><parent link="a"/><child link="b"/>'
    '<origin xyz="0.1 0 0.2" rpy="0.3 0 0"/><axis xyz="0 0 1"/></joint>'
    '<joint name="slide" type="prismatic"><parent link="b"/><child link="c"/>'
    '<origin xyz="0 0.2 0" rpy="0 0.4 0"/><axis xyz="1 0 0"/>'
    '<limit lower="-1" upper="1"/></joint>'
    '<joint name="wrist" type="continuous"><parent link="c"/><child link="d"/>'
    '<origin xyz="0 0 0.1" rpy="1 0 0"/><axis xyz="0 1 0"/>'
    '<mimic joint="turn" multiplier="-2" offset="0.1"/></joint></robot>'
)
"""An arm that turns, slides, and turns the other way, twice as far as at first."""


def urdf(path, limits=None):
    links = '<link name="link0"/>'
    for i, (xyz, quarter) in enumerate(XARM7_JOINTS, 1):
        low, high = limits[i - 1] if limits else XARM7.robot.limits[i - 1]
        links += (
            f'<link name="link{i}"/><joint name="joint{i}" type="revolute"><parent link="link{i - 1}"/>'
            f'<child link="link{i}"/><origin xyz="{xyz[0]} {xyz[1]} {xyz[2]}" rpy="{quarter * np.pi / 2!r} 0 0"/>'
            f'<axis xyz="0 0 1"/><limit lower="{low!r}" upper="{high!r}"/></joint>'
        )
    path.write_text(f'<robot name="xarm7">{links}</robot>')
    return path


def test_the_xarm7_is_its_makers(tmp_path):
    robot = Robot.from_urdf(urdf(tmp_path / "xarm7.urdf"), "link7")
    q = np.random.default_rng(1).uniform(-3.0, 3.0, (50, 7))
    motion = XARM7.motion(JointMotion(np.arange(50.0), q, 0 * q, 0 * q))
    position, orientation = robot.poses(q)
    # rounding over seven links
    np.testing.assert_allclose(motion.position, position, atol=1e-14)
    turn = Rotation.from_matrix(motion.rotation).inv() * Rotation.from_quat(orientation)
    # half of double precision: an angle from a quaternion's real part
    assert turn.magnitude().max() < 1e-7


def test_any_arm_by_urdf_moves_alike(tmp_path):
    """The same chain from a URDF, from the same start, makes the same motion."""
    arm = Arm.from_urdf(urdf(tmp_path / "xarm7.urdf"), "link7", start=XARM7.start)
    joints = random_smooth(3.0, 50.0, 1.0, 2, arm)
    np.testing.assert_allclose(
        joints.position, random_smooth(3.0, 50.0, 1.0, 2, XARM7).position, atol=1e-9
    )
    for ours, theirs in zip(
        vars(arm.motion(joints)).values(),
        vars(XARM7.motion(joints)).values(),
        strict=True,
    ):
        np.testing.assert_allclose(ours, theirs, atol=1e-12)
    assert Arm.from_urdf(tmp_path / "xarm7.urdf", "link7").start[3] == pytest.approx(
        (3.927 - 0.19198) / 2
    )


def test_the_angular_velocity_alone_is_that_of_the_motion(tmp_path):
    """To the last bit, also past a joint that slides and one that mimics another."""
    path = tmp_path / "sliding.urdf"
    path.write_text(SLIDING)
    sliding = Arm.from_urdf(path, "d")
    assert [screw.slides for screw in sliding.robot.screws] == [False, True, False]
    for arm in (UR5, XARM7, sliding):
        rng = np.random.default_rng(2)
        values = rng.uniform(-1.0, 1.0, (3, 20, arm.n))
        joints = JointMotion(np.arange(20) / 100.0, *values)
        found = arm.angular_velocity(joints)
        np.testing.assert_array_equal(found, arm.motion(joints).angular_velocity)
        with pytest.raises(InputError, match=f"but the arm has {arm.n}"):
            arm.angular_velocity(JointMotion(np.arange(20.0), *values[:, :, 1:]))


def test_arms_that_cannot_be(tmp_path):
    path = urdf(tmp_path / "xarm7.urdf")
    with pytest.raises(InputError, match="no joint moves 'link0'"):
        Arm.from_urdf(path, "link0")
    with pytest.raises(
        InputError, match="2 joint positions to start from, but 7 joints"
    ):
        Arm.from_urdf(path, "link7", start=(0.0, 0.0))
    at_limits = [(-1.0, 1.0)] * 7
    arm = Arm.from_urdf(
        urdf(tmp_path / "stuck.urdf", at_limits), "link7", start=[1.0] * 7
    )
    with pytest.raises(InputError, match="no joint of the arm can turn"):
        sinusoids(1.0, 50.0, 1.0, arm)


@pytest.mark.parametrize("motion", MOTIONS)
@pytest.mark.parametrize("arm", [UR5, XARM7], ids=("ur5", "xarm7"))
def test_joints_stay_within_their_limits(arm, motion, tmp_path):
    assert not arm.exceeded(MOTIONS[motion](arm))
    narrow = [(-0.2, 0.3)] * 7
    stiff = Arm.from_urdf(urdf(tmp_path / "narrow.urdf", narrow), "link7")
    joints = MOTIONS[motion](stiff)
    assert not stiff.exceeded(joints)
    used = np.ptp(joints.position, axis=0)[-3:]
    assert (used > 0.1).all()  # but they do move: half a radian is theirs
    assert (joints.position >= -0.2 - 1e-12).all()
    assert (joints.position <= 0.3 + 1e-12).all()


def test_what_an_arm_cannot_do_is_told():
    lines = UR5.exceeded(sinusoids(8.0, 100.0, 4.0))
    assert len(lines) == 2
    assert "joint6 turns at up to 4.1" in lines[1]
    q = np.zeros((2, 7))
    q[1, 3] = -0.5
    (line,) = XARM7.exceeded(JointMotion([0.0, 1.0], q, 0 * q, 0 * q))
    assert line == "joint4 turns from -0.50 to 0.00 rad, outside its -0.19 to 3.93 rad"


@pytest.mark.parametrize("motion", MOTIONS)
@pytest.mark.parametrize("arm", [UR5, XARM7], ids=("ur5", "xarm7"))
def test_the_speed_limit_is_kept_and_used(arm, motion):
    """ISO 10218: never above 0.25 m/s, and not needlessly far below."""
    free, kept = MOTIONS[motion](arm), MOTIONS[motion](arm, speed_limit=0.1)
    assert arm.motion(free).linear_speed().max() > 0.12
    fastest = arm.motion(kept).linear_speed().max()
    assert fastest <= 0.1
    # stop-and-go slows all moves by what the fastest of the unhurried plan needs, which
    # may not come to pass
    assert fastest > (0.05 if motion == "stop and go" else 0.0998)
    high = MOTIONS[motion](arm, speed_limit=50.0)
    np.testing.assert_array_equal(high.position, free.position)
    with pytest.raises(InputError, match="speed limit must be positive"):
        MOTIONS[motion](arm, speed_limit=0.0)


def test_the_papers_linear_speeds_are_those_of_a_point_beyond_the_flange():
    """0.14 to 0.54 m/s go with 1 to 4 rad/s at a point 115 mm out along the flange's
    axis, within 3.5 %."""
    for angular, linear in (
        (1.0, 0.14),
        (1.5, 0.2),
        (2.0, 0.27),
        (3.0, 0.41),
        (4.0, 0.54),
    ):
        joints = sinusoids(35.0, 60.0, angular)
        motion = UR5.motion(joints)
        assert motion.linear_speed((0.0, 0.0, 0.115)).mean() == pytest.approx(
            linear, rel=0.035
        )
        assert mounted(UR5, 0.115).motion(joints).mean_speeds[1] == pytest.approx(
            motion.linear_speed((0.0, 0.0, 0.115)).mean(), rel=1e-12
        )
        # at the flange itself it is half of that
        assert motion.mean_speeds[1] < 0.55 * linear
