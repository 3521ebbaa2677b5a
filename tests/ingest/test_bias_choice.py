"""A bias that the motion cannot tell from the object's weight."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from hefting import identify
from hefting.core.spatial import STANDARD_GRAVITY

COUNT = 600
MASS, COM = 1.2, np.array((0.02, 0.08, 0.07))


def at_rest(bias):
    """A sensor that stands still with an object, turned a little from the vertical."""
    rng = np.random.default_rng(5)
    turn = Rotation.from_rotvec((0.2, 0.1, 0.0))
    force = turn.inv().apply((0.0, 0.0, -MASS * STANDARD_GRAVITY[2]))
    wrench = np.concatenate((force, np.cross(COM, force))) + bias
    shaken = Rotation.from_rotvec(5e-5 * rng.normal(size=(COUNT, 3)))
    return {
        "time": 0.01 * np.arange(COUNT),
        "position": 2e-5 * rng.normal(size=(COUNT, 3)),
        "orientation": turn * shaken,
        "wrench": wrench + rng.normal(size=(COUNT, 6)) * np.repeat((0.1, 0.005), 3),
    }


@pytest.mark.parametrize("direction", [(1.0, 0.0, 0.3), (0.0, -1.0, 1.0)])
def test_one_that_shows_across_gravity_leaves_no_mass_to_be_used(direction):
    bias = 5.0 * np.array((*direction, 0.0, 0.0, 0.0)) / np.linalg.norm(direction)
    found = identify(**at_rest(bias))
    (message,) = [m for m in found.warnings if m.code == "bias-undetermined"]
    assert message.severity == "error"
    assert "turn the sensor to other orientations" in message
    assert found.verdict.level == "do not use"


def test_without_one_the_mass_is_right():
    found = identify(**at_rest(np.zeros(6)))
    (message,) = [m for m in found.warnings if m.code == "bias-unknown"]
    assert message.severity == "warning"
    low, high = found.interval("mass")
    assert low < MASS < high
    assert found.verdict.level == "usable with care"
