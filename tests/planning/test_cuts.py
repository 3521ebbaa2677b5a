"""Clearances as limits, linear about a motion."""

from dataclasses import replace
from typing import NamedTuple

import numpy as np
from problems import problem

from hefting.planning.optimise import FIRST_WEIGHT, STRIDE, Search, random_motion
from hefting.planning.problem import NEAR, Cuts


class Ball:
    """A point at joint positions themselves, beside a ball of 0.5 m."""

    def clearance(self, q):
        return np.linalg.norm(q, axis=1) - 0.5


def test_they_are_the_clearance_and_its_slope_where_it_is_near():
    rng = np.random.default_rng(0)
    q = rng.normal(size=(40, 3))
    q *= (rng.uniform(0.4, 0.7, 40) / np.linalg.norm(q, axis=1))[:, None]
    cuts = Cuts.of(Ball(), q)
    np.testing.assert_allclose(cuts.at(q), Ball().clearance(q))
    near = Ball().clearance(q) < NEAR
    assert 5 < near.sum() < 35
    moved = q + 1e-4 * rng.normal(size=q.shape)
    # second order: 2e-4 times 2e-4, or the step of 1e-4, over a radius of 0.4
    change = np.abs(cuts.at(moved) - Ball().clearance(moved))
    assert change[near].max() < 3e-7
    np.testing.assert_array_equal(cuts.slope[~near], 0.0)


class Post(NamedTuple):
    """A ball of joint positions about `middle` (n,)."""

    middle: np.ndarray
    radius: float

    def clearance(self, q):
        return 0.3 * (np.linalg.norm(q - self.middle, axis=1) - self.radius)


def test_a_motion_is_pushed_out_of_what_it_goes_through():
    own = problem(duration=2.0)
    x = random_motion(own, np.random.default_rng(0))
    best = Search(own, x, None).rounds(3, 20)
    path = own.basis.states(own.start, best.x).position
    post = Post(path[30], 0.5 * np.linalg.norm(path[30] - own.start))
    after = replace(best, space=post, multipliers={}, weight=FIRST_WEIGHT).rounds(5, 20)
    q = own.basis.states(own.start, after.x).position
    assert post.clearance(path).min() < -0.05
    assert post.clearance(q).min() > 0.0


def test_rounds_beside_obstacles_go_less_and_less_far():
    """As far as clearances are linear: a penalty 16 times as large halves it twice."""
    own = problem(duration=2.0)
    x = random_motion(own, np.random.default_rng(0))
    for factor in (1.0, 16.0):
        search = Search(own, x, None, weight=factor * FIRST_WEIGHT)
        beside = replace(search, space=Post(own.start, -1.0))
        most = STRIDE / factor**0.5
        assert np.abs(search.next(60).x - x).max() > most
        assert np.abs(beside.next(60).x - x).max() <= most + 1e-9
