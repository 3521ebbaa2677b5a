"""Curves and their thinning: peaks stay, and so does the wrench that was measured."""

from dataclasses import replace

import numpy as np
import pytest

from hefting.core.estimate import Estimate
from hefting.core.measurements import NOISE_LEVELS
from hefting.scene import Ellipsoid, gaps_between, thinned, wrench_curves
from hefting.simulation import UR5, hammer, sinusoids, wield


@pytest.mark.parametrize("curves", [1, 3, 6])
@pytest.mark.parametrize("count", [1, 2, 1_999, 2_000, 2_001, 50_000, 1_000_003])
def test_no_peak_is_lost(curves, count):
    values = np.random.default_rng(count).normal(size=(count, curves))
    chosen = thinned(values)
    assert len(chosen) <= 2_000
    assert (np.diff(chosen) > 0).all()
    assert {0, count - 1} <= set(chosen.tolist())
    assert np.array_equal(values[chosen].max(axis=0), values.max(axis=0))
    assert np.array_equal(values[chosen].min(axis=0), values.min(axis=0))


def test_short_curves_are_left_alone():
    assert np.array_equal(thinned(np.zeros(1_500)), np.arange(1_500))


def test_what_is_not_finite_is_passed_over():
    values = np.full(10_000, np.nan)
    values[[17, 5_000]] = -3.0, 7.0
    assert {17, 5_000} <= set(thinned(values, 100).tolist())


def test_every_part_of_a_long_curve_is_there():
    """At most two parts' length apart: a screen shows no empty place."""
    chosen = thinned(np.sin(np.arange(100_000) / 50.0))
    parts = (2_000 - 2) // 2
    assert np.diff(chosen).max() <= 2 * -(-100_000 // parts)


def test_gaps_between_shown_samples():
    time = np.concatenate((np.arange(100.0), 200.0 + np.arange(50.0)))
    assert gaps_between(time, np.arange(150)).tolist() == [100]
    # wherever the samples beside the gap are left out
    assert gaps_between(time, np.array((3, 90, 110, 140))).tolist() == [2]
    assert gaps_between(np.arange(100.0), np.array((0, 7, 99))).tolist() == []
    assert gaps_between(np.zeros(1), np.array((0,))).tolist() == []


@pytest.fixture(scope="module")
def measurements():
    motion = UR5.motion(sinusoids(2.0, 50.0, 1.0))
    clean = wield(motion, hammer().parameters)
    return clean.with_noise(NOISE_LEVELS["moderate"], seed=1)


def test_the_residual_is_what_a_bias_and_the_body_leave(measurements):
    bias = np.array((1.0, -2.0, 0.5, 0.1, 0.2, -0.3))
    estimate = Estimate(
        "OLS", hammer().parameters, samples=100, duration=2.0, bias=bias
    )
    motion = UR5.motion(sinusoids(2.0, 50.0, 1.0))
    exact = wield(motion, hammer().parameters).wrench
    curves = wrench_curves(measurements, estimate, start=-1.0)
    assert curves.time == pytest.approx(measurements.time + 1.0)
    # accelerations are noisy in `measurements`, so that their wrench differs by noise
    assert np.std(curves.predicted - bias - exact) < 0.2
    assert curves.residual == pytest.approx(curves.measured - curves.predicted)
    rms = np.sqrt(np.mean(curves.residual[:, 3:] ** 2))
    assert curves.rms(3) == pytest.approx(rms)


def test_static_poses_are_counted_from_one(measurements):
    estimate = Estimate("OLS", hammer().parameters, samples=100)
    curves = wrench_curves(measurements, replace(estimate, duration=None))
    assert curves.static
    assert curves.time[[0, -1]].tolist() == [1.0, float(len(measurements))]


def test_triangles_of_an_ellipsoid_are_its_surface():
    rng = np.random.default_rng(4)
    turn = np.linalg.qr(rng.normal(size=(3, 3)))[0]
    turn *= np.linalg.det(turn)
    ellipsoid = Ellipsoid(rng.normal(size=3), turn * np.array((0.01, 0.05, 0.2)))
    vertices, faces = ellipsoid.triangles(rings=24)
    on_ball = np.linalg.solve(ellipsoid.half_axes, (vertices - ellipsoid.center).T)
    assert np.linalg.norm(on_ball, axis=0) == pytest.approx(1.0, abs=1e-12)
    # closed: each edge belongs to two triangles, once in either direction
    edges = np.vstack([faces[:, [i, (i + 1) % 3]] for i in range(3)])
    directed = set(map(tuple, edges.tolist()))
    assert len(directed) == len(edges)
    assert {(b, a) for a, b in directed} == directed
    a, b, c = (vertices[faces[:, k]] - ellipsoid.center for k in range(3))
    volume = np.einsum("ij,ij->i", a, np.cross(b, c)).sum() / 6.0
    # outwards, and of 24 rings smaller than the ellipsoid by about one percent
    whole = 4.0 / 3.0 * np.pi * 0.01 * 0.05 * 0.2
    assert volume == pytest.approx(whole, rel=0.02)
    assert volume < whole
