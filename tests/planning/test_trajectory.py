"""Trajectories: at rest at both ends, smooth between."""

import numpy as np
import pytest

from hefting.planning.problem import Basis, pieces_of

RNG = np.random.default_rng(0)


@pytest.fixture
def trajectory():
    basis = Basis.of(4.0, pieces_of(4.0), 30.0)
    return basis.trajectory(np.array((0.3, -1.0)), RNG.normal(size=(basis.free, 2)))


def test_it_rests_at_both_ends(trajectory):
    ends = trajectory.at([-1.0, 0.0, 4.0, 9.0])
    np.testing.assert_array_equal(ends.position[:2], [(0.3, -1.0)] * 2)
    np.testing.assert_array_equal(ends.position[2], ends.position[3])
    # rounding of coefficients of some 1e3 rad/s²
    np.testing.assert_allclose(ends.velocity, 0.0, atol=1e-10)
    np.testing.assert_allclose(ends.acceleration, 0.0, atol=1e-9)


def test_each_derivative_is_that_of_the_one_before(trajectory):
    time, h = np.linspace(0.1, 3.9, 57), 1e-4
    before, own, after = (trajectory.at(time + d) for d in (-h, 0.0, h))
    # central differences leave h² / 6 of a third derivative of up to 1e5
    for lower, upper in (("position", "velocity"), ("velocity", "acceleration")):
        slope = (getattr(after, lower) - getattr(before, lower)) / (2.0 * h)
        np.testing.assert_allclose(slope, getattr(own, upper), atol=1e-3)
    slope = (after.acceleration - before.acceleration) / (2.0 * h)
    np.testing.assert_allclose(slope, trajectory.jerk(time), rtol=1e-3, atol=0.5)


def test_the_basis_has_the_trajectory_on_its_grid():
    basis = Basis.of(3.0, pieces_of(3.0), 20.0)
    start, x = np.array((0.5, 0.0, 1.0)), RNG.normal(size=(basis.free, 3))
    states, own = basis.states(start, x), basis.trajectory(start, x)
    time = np.linspace(0.0, 3.0, 61)
    at = own.at(time)
    np.testing.assert_allclose(states.position, at.position, atol=1e-12)
    np.testing.assert_allclose(states.speed, at.velocity, atol=1e-10)
    np.testing.assert_allclose(states.acceleration, at.acceleration, atol=1e-9)
    np.testing.assert_allclose(states.jerk, own.jerk(time), atol=1e-7)


def test_samples_hold_start_and_end(trajectory):
    motion = trajectory.sampled(100.0)
    assert len(motion.time) == 401
    assert motion.time[[0, -1]].tolist() == [0.0, 4.0]


def test_repeated_it_goes_there_and_back(trajectory):
    T, often = trajectory.duration, trajectory.repeated(3)
    time = np.linspace(0.0, 3.0 * T, 301)
    there = time % (2.0 * T)
    there = np.where(there > T, 2.0 * T - there, there)
    own, one = often.at(time), trajectory.at(there)
    np.testing.assert_allclose(own.position, one.position, atol=1e-9)
    np.testing.assert_allclose(own.acceleration, one.acceleration, atol=1e-7)
    assert often.duration == pytest.approx(3.0 * T)
