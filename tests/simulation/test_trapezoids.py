"""Trapezoid moves: limits kept, derivatives that belong together, rests."""

import numpy as np
import pytest

from hefting.core.errors import InputError
from hefting.simulation import UR5, trapezoids


@pytest.mark.parametrize(
    ("speed", "acceleration"), [(0.6, 1.2), (2.0, 8.0), (9.0, 2.0)]
)
def test_speed_and_acceleration_are_those_of_the_fastest_joint(speed, acceleration):
    joints = trapezoids(20.0, 1000.0, speed, acceleration, seed=1)
    fastest = np.abs(joints.velocity).max(axis=1)
    change = np.abs(joints.acceleration).max(axis=1)
    assert fastest.max() <= speed * (1 + 1e-9)  # rounding
    moving = change > 1e-9
    np.testing.assert_allclose(change[moving], acceleration, rtol=1e-9)
    if speed < 5.0:  # else no move is long enough
        assert fastest.max() == pytest.approx(speed)
    assert (fastest == 0.0).mean() > 0.05  # rests
    assert (np.abs(joints.position - UR5.start) <= np.radians(60.0) + 1e-9).all()


def test_positions_are_the_integral_of_velocities_and_accelerations():
    joints = trapezoids(6.0, 1000.0, 1.0, 3.0, seed=2)
    dt = 1e-3
    for value, rate in (
        (joints.position, joints.velocity),
        (joints.velocity, joints.acceleration),
    ):
        whole = value[0] + np.cumsum(0.5 * (rate[1:] + rate[:-1]) * dt, axis=0)
        # the trapezoidal rule misses half a step of 3 rad/s² at each of some 30 jumps
        np.testing.assert_allclose(value[1:], whole, atol=30 * 0.5 * 3.0 * dt)


def test_same_seed_same_moves():
    one, other = (trapezoids(3.0, seed=s).position for s in (1, 2))
    np.testing.assert_array_equal(one, trapezoids(3.0, seed=1).position)
    assert not np.array_equal(one, other)


@pytest.mark.parametrize("name", ["duration", "rate", "speed", "acceleration"])
def test_numbers_must_be_positive(name):
    with pytest.raises(InputError, match=name):
        trapezoids(**{name: 0.0})
