"""Limits: what a URDF says, what it leaves out, and what is refused."""

import re

import numpy as np
import pytest

from hefting.core.errors import InputError
from hefting.planning.limits import ACCELERATION, JERK, Limits
from hefting.robots.robot import Robot
from hefting.simulation.torque_scenario import TORQUE_ARMS


@pytest.fixture
def urdf(tmp_path):
    path = tmp_path / "arm.urdf"
    path.write_text(TORQUE_ARMS["panda"].urdf)
    return path


def limits_of(path, **others):
    return Limits.from_urdf(path, Robot.from_urdf(path, "flange"), **others)


def test_positions_and_speeds_are_those_of_the_urdf(urdf):
    arm = TORQUE_ARMS["panda"].arm
    own = limits_of(urdf)
    np.testing.assert_array_equal(own.position, arm.robot.limits)
    np.testing.assert_array_equal(own.speed, arm.joint_speeds)
    assert set(own.acceleration) == {ACCELERATION}
    assert set(own.jerk) == {JERK}
    assert own.corner_speed == 0.25


def test_what_no_urdf_has_may_be_given_of_all_or_of_each(urdf):
    own = limits_of(urdf, acceleration=2.0, jerk=np.arange(1.0, 8.0))
    assert own.acceleration.tolist() == [2.0] * 7
    assert own.jerk.tolist() == list(range(1, 8))


@pytest.mark.parametrize(
    ("pattern", "by", "said"),
    [
        (r' velocity="[^"]*"', "", "no limit of its speed"),
        (r"<limit [^>]*/>", "", "no lower and upper limit"),
        (r'lower="[^"]*" upper="[^"]*"', 'lower="1" upper="1"', "make it fixed"),
        (r'velocity="[^"]*"', 'velocity="0"', "no limit of its speed"),
        (r'type="revolute"', 'type="prismatic"', "slides.*make it fixed"),
    ],
)
def test_a_limit_that_is_missing_is_named(urdf, pattern, by, said):
    urdf.write_text(re.sub(pattern, by, urdf.read_text(), count=1))
    with pytest.raises(InputError, match=said) as error:
        limits_of(urdf)
    assert "joint 'joint1'" in str(error.value)


def mimicking(urdf, limit, multiplier=-2.0):
    """The arm with a joint beside it that mimics its second one, 0.2 rad on."""
    other = f"""<link name="bar"/><joint name="bar" type="revolute">
      <parent link="{Robot.from_urdf(urdf, "flange").root}"/><child link="bar"/>{limit}
      <mimic joint="joint2" multiplier="{multiplier}" offset="0.2"/></joint></robot>"""
    urdf.write_text(urdf.read_text().replace("</robot>", other))
    return limits_of(urdf)


def test_limits_of_what_mimics_a_joint_are_kept_too(urdf):
    before = limits_of(urdf)
    own = mimicking(urdf, '<limit lower="-0.2" upper="0.6" velocity="0.5"/>')
    np.testing.assert_allclose(own.position[1], (-0.2, 0.2))
    assert own.speed[1] == 0.25
    others = np.arange(7) != 1
    np.testing.assert_array_equal(own.position[others], before.position[others])
    np.testing.assert_array_equal(own.speed[others], before.speed[others])


def test_wide_limits_of_what_mimics_change_nothing(urdf):
    before = limits_of(urdf)
    own = mimicking(urdf, '<limit lower="-9" upper="9" velocity="90"/>')
    np.testing.assert_array_equal(own.position, before.position)
    np.testing.assert_array_equal(own.speed, before.speed)


def test_a_mimicking_joint_that_leaves_no_room_is_named(urdf):
    with pytest.raises(InputError, match=r"joint 'bar': .*no room to 'joint2'"):
        mimicking(urdf, '<limit lower="8" upper="9" velocity="1"/>')


def test_a_joint_that_turns_without_end_has_no_range(urdf):
    text = urdf.read_text().replace('type="revolute"', 'type="continuous"', 1)
    urdf.write_text(text)
    assert np.isinf(limits_of(urdf).position[0]).all()


@pytest.mark.parametrize(
    "wrong",
    [
        {"acceleration": -1.0},
        {"acceleration": [1.0, 2.0]},
        {"jerk": np.nan},
        {"corner_speed": 0.0},
        {"force": -3.0},
    ],
)
def test_what_is_no_limit_is_refused(urdf, wrong):
    with pytest.raises(InputError, match=f"`{next(iter(wrong))}`: is not a positive"):
        limits_of(urdf, **wrong)
