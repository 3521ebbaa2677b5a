"""Gauss-Newton's weights and steps, against closed forms and limits from both sides."""

from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest

from hefting.ingest.fit import _offset_step, _stepped_gravity, weight_blocks
from hefting.ingest.model import Layout, tangents_of


def blocks(count, known=None, floor=1e-9):
    """A problem of exact motion, and its reading."""
    count = np.asarray(count, dtype=float)
    B = len(count)
    problem = SimpleNamespace(
        blocks=SimpleNamespace(
            time=0.01 * np.arange(B),
            count=count,
            mean_count=count[count > 0.0].mean(),
        ),
        path=SimpleNamespace(bandwidth=np.inf),
        floor=np.full(2, floor),
    )
    known = np.ones(B, dtype=bool) if known is None else known
    return cast(Any, problem), cast(Any, SimpleNamespace(known=known))


def residuals(B, force=2.0, torque=0.1):
    """All of one size, the root mean square of its axes."""
    x = np.random.default_rng(1).normal(size=(B, 2, 3))
    x *= 3.0**0.5 / np.linalg.norm(x, axis=2, keepdims=True)
    return (x * np.array((force, torque))[:, None]).reshape(B, 6)


def test_blocks_weigh_by_their_samples_where_the_motion_is_known():
    """And the scale is the root mean square that goes with them."""
    count = np.array((10, 10, 5, 0, 15, 10))
    known = np.array((True, False, True, True, True, True))
    problem, reading = blocks(count, known)
    left = np.random.default_rng(2).normal(size=(6, 6)) * np.repeat((2.0, 0.1), 3)
    weights, scale, spread = weight_blocks(
        problem, reading, np.zeros(10), left, np.ones(2), robust=False
    )
    np.testing.assert_allclose(weights, known * count / 10.0)
    square = np.average(np.square(left), axis=0, weights=weights)
    np.testing.assert_allclose(scale, np.sqrt(square.reshape(2, 3).mean(axis=1)))
    np.testing.assert_array_equal(spread, 1.0)
    problem.floor = np.array((1e3, 0.0))
    _, scale, _ = weight_blocks(
        problem, reading, np.zeros(10), left, np.ones(2), robust=False
    )
    assert scale[0] == 1e3


def test_residuals_of_their_scale_weigh_one_and_outliers_hardly():
    """Student's weights of three degrees of freedom and six channels: 9 / (3 + d), of a
    distance of six one; such a scale stays as it is."""
    problem, reading = blocks(np.full(400, 10.0))
    left, scale = residuals(400), np.array((2.0, 0.1))

    def weighted(residual, of=scale):
        return weight_blocks(problem, reading, np.zeros(10), residual, of, robust=True)

    weights, found, _ = weighted(left)
    np.testing.assert_allclose(weights, 1.0)
    np.testing.assert_allclose(found, scale)
    # in whatever unit, and from a scale twice too large, nearer after two steps
    weights, found, _ = weighted(left, 2.0 * scale)
    assert (found < 1.5 * scale).all()
    assert (found > scale).all()
    far = left.copy()
    far[7] *= 100.0
    weights, found, _ = weighted(far)
    distance = np.square(far[7] / np.repeat(scale, 3)).sum()
    # the scale rose a little by the outlier after the first of two steps
    assert weights[7] == pytest.approx(9.0 / (3.0 + distance), rel=0.05)
    assert weights[8] == pytest.approx(1.0, abs=0.02)
    np.testing.assert_allclose(found, scale, rtol=0.02)
    # of half as many samples a distance counts half
    problem.blocks.count = np.where(np.arange(400) == 3, 5.0, 10.0)
    weights, _, _ = weighted(left)
    assert weights[3] == pytest.approx(0.5 * 9.0 / (3.0 + 3.0), rel=0.01)


def solved(*core):
    return cast(Any, SimpleNamespace(core=np.append(np.zeros(10), core)))


def test_an_offset_moves_by_twenty_milliseconds_at_most_and_within_bounds():
    both = Layout.of(free_offset=True, free_gravity=True)
    far = (-1.0, 1.0)
    for step, taken in ((0.013, 0.013), (0.03, 0.02), (-0.03, -0.02)):
        found = _offset_step(0.5, solved(step, 0, 0), both, far)
        assert found == pytest.approx(taken)
    assert _offset_step(0.09, solved(0.02, 0, 0), both, (-0.1, 0.1)) == pytest.approx(
        0.01
    )
    assert _offset_step(-0.1, solved(-0.01, 0, 0), both, (-0.1, 0.1)) == 0.0
    held = Layout.of(free_offset=False, free_gravity=True)
    assert _offset_step(0.5, solved(0.01, 0), held, far) == 0.0


def test_gravity_moves_by_three_metres_a_second_squared_along_each_tangent_at_most():
    g = np.array((0.0, 1.0, -9.0))
    layout = Layout.of(free_offset=False, free_gravity=True)
    for change, taken in (((1.0, -2.0), (1.0, -2.0)), ((5.0, -4.0), (3.0, -3.0))):
        found = _stepped_gravity(g, solved(*change), layout)
        expected = g + np.array(taken) @ tangents_of(g)
        expected *= np.linalg.norm(g) / np.linalg.norm(expected)
        np.testing.assert_allclose(found, expected)
    held = Layout.of(free_offset=True, free_gravity=False)
    assert _stepped_gravity(g, solved(0.1), held) is g
