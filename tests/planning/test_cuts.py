"""Clearances as limits, linear about a motion."""

import numpy as np

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
