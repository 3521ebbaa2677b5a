"""Scales of PMD's norms, by Newton's step on their inverses."""

import numpy as np
import pytest

from hefting.estimators.cone import _secular


def problem(seed: int):
    rng = np.random.default_rng(seed)
    s = 10.0 ** rng.uniform(-1.0, 1.0, 3)
    A = rng.normal(size=(3, 6))
    G = A @ A.T / np.outer(s, s)
    norms = rng.uniform(0.8, 1.2, 3)
    return s, norms, G


@pytest.mark.parametrize("seed", range(5))
def test_a_step_solves_the_equations_of_the_norms_that_are_free(seed):
    """G ds = n² (n - 1); a norm that vanishes has its scale at the floor, and the others
    allow for that."""
    s, norms, G = problem(seed)
    right = norms**2 * (norms - 1.0)
    free = s + np.linalg.solve(G, right)
    floor = 1e-7
    expected = np.clip(free, 1e-4 * s, 20.0 * s)
    if (free > floor).all():
        np.testing.assert_allclose(_secular(s, norms, G, floor), expected)
    # small steps to a floor that is near
    norms[1], floor = 0.0, 0.9 * s[1]
    s[[0, 2]] += 2.0 * floor
    right = norms**2 * (norms - 1.0)
    part = np.ix_((0, 2), (0, 2))
    held = floor - s[1]
    step = np.linalg.solve(G[part], right[[0, 2]] - G[[0, 2], 1] * held)
    expected = np.array((s[0] + step[0], floor, s[2] + step[1]))
    if (expected[[0, 2]] > floor).all():
        expected = np.clip(expected, 1e-4 * s, 20.0 * s)
        np.testing.assert_allclose(_secular(s, norms, G, floor), expected)


def test_scales_below_the_floor_are_held_there_and_the_others_found_anew():
    s, norms = np.array((1.0, 1.0, 1.0)), np.array((0.5, 0.99, 0.99))
    G = np.array(((0.1, 0.01, 0.02), (0.01, 0.2, 0.01), (0.02, 0.01, 0.3)))
    floor = 0.5
    right = norms**2 * (norms - 1.0)
    assert (s + np.linalg.solve(G, right))[0] < floor
    rest = slice(1, 3)
    step = np.linalg.solve(G[rest, rest], right[rest] - G[rest, 0] * (floor - 1.0))
    expected = np.append(floor, 1.0 + step)
    np.testing.assert_allclose(_secular(s, norms, G, floor), expected)
    # no scale grows by more than twenty, nor falls below a ten thousandth
    tiny = 1e-6 * np.eye(3)
    np.testing.assert_allclose(_secular(s, 1.0 + norms, tiny, 1e-9), 20.0)
    np.testing.assert_allclose(_secular(s, norms, tiny, 1e-9), 1e-4, rtol=1e-6)
