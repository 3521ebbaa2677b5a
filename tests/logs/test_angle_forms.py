"""Three numbered angles: a rotation vector, or roll, pitch and yaw."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from hefting.logs.orientations import form_of_angles

TIME = np.linspace(0.0, 10.0, 1000)
WIDE, NARROW = 0.4, 0.02


def smooth(amplitude: float, around: Rotation) -> Rotation:
    turns = amplitude * np.sin(np.outer(TIME, (0.7, 1.1, 1.3)) + np.arange(3.0))
    return Rotation.from_rotvec(turns) * around


TOOL_DOWN = Rotation.from_euler("x", np.pi)
"""Where roll, and the rotation vector, begin again at the other end."""


def test_roll_pitch_yaw_that_pass_half_a_turn_are_told():
    angles = smooth(WIDE, TOOL_DOWN).as_euler("xyz")
    assert np.abs(np.diff(angles, axis=0)).max() > 6.0
    assert form_of_angles(angles)[0] == "rpy"


@pytest.mark.parametrize("around", [TOOL_DOWN, Rotation.identity()])
@pytest.mark.parametrize("amplitude", [WIDE, NARROW])
def test_a_rotation_vector_stays_one(around, amplitude):
    angles = smooth(amplitude, around).as_rotvec()
    assert form_of_angles(angles) == ("rotation-vector", "")


def test_in_degrees_they_are_roll_pitch_and_yaw_unless_these_would_jump():
    turns = smooth(WIDE, Rotation.identity())
    for angles in (turns.as_euler("xyz"), turns.as_rotvec()):  # neither jumps
        assert form_of_angles(angles, in_degrees=True) == ("rpy", "in degrees")
    upright = smooth(WIDE, Rotation.from_euler("y", np.pi / 2)).as_rotvec()
    assert form_of_angles(upright, in_degrees=True)[0] == "rpy"


def test_what_jumps_by_either_form_is_taken_for_the_usual_one():
    angles = Rotation.random(100, random_state=0).as_euler("xyz")
    assert form_of_angles(angles) == ("rotation-vector", "")


def test_too_few_rows_tell_nothing():
    for angles in (np.zeros((1, 3)), np.full((9, 3), np.nan)):
        assert form_of_angles(angles) == ("rotation-vector", "")
