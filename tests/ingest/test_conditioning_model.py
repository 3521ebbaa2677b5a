"""The linear model of conditioning, its normal equations, covariance and weights, against
what they stand for."""

from dataclasses import replace

import numpy as np
import pytest

from disturbances import GRAVITY, disturbed
from hefting.ingest.blocks import Blocks
from hefting.ingest.drift import HatFunctions
from hefting.ingest.fit import Start, gauss_newton, motion_weights
from hefting.ingest.model import Model, Problem, solve, tangents_of
from hefting.ingest.path import path_of
from hefting.ingest.uncertainty import estimate_uncertainty
from hefting.motion import sample_weights, smooth_poses
from hefting.simulation import UR5, random_smooth, simulate, wield

pytestmark = pytest.mark.usefixtures("same_poses")


def problem(seed=0, **changes):
    d = disturbed("clean", 1.5, seed)
    wrench = d.recording["wrench"]
    settings = {"free_offset": True, "free_gravity": True, "knots": (1,)} | changes
    return d, Problem(
        path_of(d.recording), Blocks.of(wrench.time, wrench.values), **settings
    )


def test_columns_are_the_derivatives_of_the_prediction():
    d, p = problem()
    phi, h = d.body.vector, 1e-4

    fixed = replace(p, free_offset=False, free_gravity=False)

    def predicted(offset, gravity):
        return Model.at(fixed, offset, gravity).predict(phi)

    model = Model.at(p, 0.02, GRAVITY)
    inside = slice(20, -20)  # whole stencils
    columns = model.columns(phi)[inside]
    by_offset = (predicted(0.02 + h, GRAVITY) - predicted(0.02 - h, GRAVITY)) / (2 * h)
    # two steps, 0.1 and 2 ms, of signals up to 10 rad/s: (0.002 * 10)² / 6
    np.testing.assert_allclose(
        columns[:, :, 10], by_offset[inside], atol=2e-4 * np.abs(by_offset).max()
    )
    for i, tangent in enumerate(tangents_of(GRAVITY)):
        change = (
            predicted(0.02, GRAVITY + h * tangent)
            - predicted(0.02, GRAVITY - h * tangent)
        ) / (2 * h)
        # linear
        np.testing.assert_allclose(columns[:, :, 11 + i], change[inside], atol=1e-9)


def test_normal_equations_against_dense_least_squares():
    d, p = problem()
    phi, rng = d.body.vector, np.random.default_rng(0)
    model = Model.at(p, 0.0, GRAVITY)
    columns = model.columns(phi)
    assert columns.shape[2] == 13  # parameters, offset, two of gravity's direction
    weights = rng.random(len(p.time))
    levels = np.array((0.1, 0.01))
    hats = HatFunctions.over(p.time, 3)
    found, scale = solve(model, phi, weights, levels, hats), np.repeat(levels, 3)
    bias = np.einsum("kn,cd->kcnd", hats.combine(np.eye(3)), np.eye(6)).reshape(
        len(p.time), 6, 18
    )
    root = np.sqrt(weights)[:, None] / scale
    A = (np.concatenate((columns, bias), axis=2) * root[:, :, None]).reshape(-1, 31)
    expected, *_ = np.linalg.lstsq(A, (p.wrench * root).ravel(), rcond=None)
    np.testing.assert_allclose(
        np.concatenate((found.core, found.bias.ravel())), expected, rtol=1e-7, atol=1e-9
    )
    np.testing.assert_allclose(found.inverse @ (A.T @ A), np.eye(31), atol=1e-6)
    assert not found.undetermined.any()


@pytest.mark.parametrize("correlation", [0.0, 0.9])
def test_covariance_is_that_of_the_noises_colour(correlation):
    """Against B G B' of the noise's own covariance, averaged over realisations of it on
    one motion."""
    from scipy.linalg import toeplitz
    from scipy.signal import lfilter

    d, p = problem(free_gravity=False)
    exact = path_of(
        simulate(UR5.motion(random_smooth(10.4, 100.0, 1.0, 0)), d.body, exact=True)
    )
    assert exact is not None
    # no errors of the motion
    p, found = replace(p, path=replace(exact, bandwidth=np.inf)), []
    clean = wield(UR5.motion(random_smooth(10.4, 100.0, 1.0, 0)), d.body).wrench
    start = Start(
        d.body.vector,
        0.0,
        GRAVITY,
        np.array((0.1, 0.005)),
        p.time[:1],
        np.zeros((1, 6)),
    )
    for seed in range(6):
        white = np.random.default_rng(seed).normal(size=clean.shape)
        noise = lfilter(
            [np.sqrt(1.0 - correlation**2)], [1.0, -correlation], white, axis=0
        )
        blocks = replace(p.blocks, wrench=clean + np.repeat((0.1, 0.005), 3) * noise)
        fit = gauss_newton(replace(p, blocks=blocks), start, 1, steps=3)
        found.append(estimate_uncertainty(fit).covariance.diagonal()[:11])
    G = toeplitz(correlation ** np.arange(len(p.time)))
    bias = np.broadcast_to(np.eye(6), (len(p.time), 6, 6))
    B = (
        np.concatenate((fit.columns, bias), axis=2)
        / np.repeat((0.1, 0.005), 3)[:, None]
    )
    H = np.linalg.inv(np.einsum("kcp,kcq->pq", B, B))
    expected = (H @ sum(B[:, c].T @ G @ B[:, c] for c in range(6)) @ H).diagonal()[:11]
    ratio = np.mean(found, axis=0) / expected
    # from a few dozen independent powers, six times
    assert np.all((ratio > 0.7) & (ratio < 1.3))


def test_weights_are_those_of_the_estimators():
    """On average one; the largest residuals are expected where the motion is least
    certain."""
    d, p = problem()
    seen = p.path.at(p.time)
    motion = smooth_poses(d.recording).poses.at(p.time)
    weights, spread = motion_weights(
        d.body.vector, seen, p.path.bandwidth, p.time, np.array((0.1, 0.005))
    )
    expected = sample_weights(d.body.vector, motion, 0.1, 0.005)
    np.testing.assert_allclose(weights, expected / expected.mean(), rtol=1e-9)
    assert np.ptp(weights) > 0.1
    assert np.argmax(spread) == np.argmin(weights)
