"""Stop and go: what the poses tell, how the arm moves between them."""

import numpy as np
import pytest
from problems import problem

from hefting.core.spatial import rotation_matrices
from hefting.planning.tours import Tour, best_tour, minimum_jerk, timed
from hefting.robots.joint_motion import sensor_motion
from hefting.simulation.arm import PANDA

ASKED = "mass=1%,com=2mm"
GRAVITY = np.array((0.0, 0.0, -9.81))


def anywhere(q):
    return True


@pytest.fixture(scope="module")
def tour():
    own, rng = problem(duration=10.0, asked=ASKED), np.random.default_rng(0)
    found = best_tour(own, rng, anywhere, steps=150)
    assert found is not None
    return found


def test_moves_are_of_minimum_jerk_between_rests():
    """The quintic that Flash and Hogan found, and its derivatives by differences."""
    rng = np.random.default_rng(1)
    poses = rng.uniform(-1, 1, (3, 4))
    motion = Tour(poses, np.array([0.7, 1.1]), 0.5).trajectory()
    assert motion.duration == pytest.approx(3.3)
    u = np.linspace(0.0, 1.0, 101)
    way = minimum_jerk(u)[0][:, None]
    first = motion.at(0.5 + 0.7 * u)
    # both are polynomials of degree five: rounding alone
    np.testing.assert_allclose(
        first.position, poses[0] + way * (poses[1] - poses[0]), atol=1e-12
    )
    second = motion.at(1.7 + 1.1 * u)
    np.testing.assert_allclose(
        second.position, poses[1] + way * (poses[2] - poses[1]), atol=1e-12
    )
    ends = (0.0, 0.5), (1.2, 1.7), (2.8, 3.3)
    still = motion.at(np.concatenate([np.linspace(*each, 20) for each in ends]))
    np.testing.assert_allclose(still.velocity, 0.0, atol=1e-9)
    np.testing.assert_allclose(still.acceleration, 0.0, atol=1e-7)


def test_ways_and_their_speed_agree():
    u, h = np.linspace(0.1, 0.9, 9), 1e-5
    way, speed = minimum_jerk(u)
    assert way[[0, -1]].sum() == pytest.approx(1.0)  # the same from both ends
    after, before = minimum_jerk(u + h), minimum_jerk(u - h)
    # central differences, h² times the third derivative, at most 60
    np.testing.assert_allclose((after[0] - before[0]) / (2 * h), speed, atol=1e-8)


def test_limits_are_kept_on_a_grid_of_1_khz(tour):
    limits = problem().constraints.limits
    trajectory = tour.trajectory()
    time = np.linspace(0.0, trajectory.duration, 10_001)
    motion = trajectory.at(time)
    low, high = limits.position.T
    assert ((motion.position >= low) & (motion.position <= high)).all()
    assert (np.abs(motion.velocity) <= limits.speed).all()
    assert (np.abs(motion.acceleration) <= limits.acceleration).all()
    assert (np.abs(trajectory.jerk(time)) <= limits.jerk).all()
    sensor = sensor_motion(PANDA.robot, motion)
    corners = problem().constraints.corners
    fastest = max(sensor.linear_speed(corner).max() for corner in corners)
    # and it uses them
    assert 0.9 * limits.corner_speed < fastest <= limits.corner_speed


def test_the_whole_time_is_used(tour):
    assert tour.trajectory().duration == pytest.approx(10.0)
    np.testing.assert_array_equal(tour.poses[0], problem().start)


def test_poses_turn_gravity_more_than_random_ones_that_take_as_long(tour):
    """What mass and COM take from rests: the spread of gravity in sensor axes, weighed
    by the time at rest. Of tours through random poses that fit the time."""

    def spread(each):
        orientation = PANDA.robot.poses(each.poses)[1]
        directions = GRAVITY @ rotation_matrices(orientation)
        own = np.linalg.eigvalsh(np.cov(directions.T, bias=True))
        return each.rest * len(each.poses) * own[1]

    rng, others = np.random.default_rng(2), []
    own = problem(duration=10.0, asked=ASKED)
    while len(others) < 60:
        step = rng.uniform(0.05, 1.0)
        poses = own.start + step * rng.normal(size=(len(tour.poses), 7))
        poses[0] = own.start
        each = timed(own, np.clip(poses, *own.constraints.limits.position.T))
        if each is not None:
            others.append(spread(each))
    assert spread(tour) > np.max(others)


def test_the_same_seed_gives_the_same_tour():
    own = problem(duration=6.0, asked=ASKED)
    first, second = (
        best_tour(own, np.random.default_rng(3), anywhere, steps=30) for _ in range(2)
    )
    np.testing.assert_array_equal(first.poses, second.poses)


def test_poses_and_moves_stay_where_it_is_free():
    own = problem(duration=8.0, asked=ASKED)
    column, most = 3, own.start[3] + 0.1

    def is_free(q):
        return bool((q[:, column] < most).all())

    tour = best_tour(own, np.random.default_rng(4), is_free, steps=100)
    time = np.linspace(0.0, 8.0, 801)
    assert tour.trajectory().at(time).position[:, column].max() < most + 1e-9
    blocked = best_tour(own, np.random.default_rng(4), lambda q: False, steps=5)
    assert blocked is None


def test_too_short_a_time_has_no_tour():
    own = problem(duration=1.0, asked=ASKED)
    far = own.start + np.array([[0.0], [1.0], [-1.0]]) * 0.3
    assert timed(own, far) is None
