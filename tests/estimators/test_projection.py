"""Projection of parameters on possible bodies, against non-negative least squares."""

import numpy as np
import pytest

from hammers import counted_lengths, shape
from hefting.core.inertia import InertialParameters
from hefting.estimators.bayes import projection
from hefting.estimators.bayes.mixture import prior_mixture
from hefting.estimators.bayes.prior import Prior
from hefting.estimators.bayes.projection import projected


@pytest.mark.parametrize("seed", range(6))
def test_the_projection_is_that_of_non_negative_least_squares(seed):
    from scipy.optimize import nnls

    rng, prior = np.random.default_rng(seed), Prior.of(shape())
    masses = rng.exponential(size=shape().n) * (rng.random(shape().n) < 0.3)
    phi = prior.cells @ masses * (1.0 + 0.05 * rng.normal(size=10))
    scale = np.abs(phi) * 10.0 ** rng.uniform(-3, -1, 10)
    root = (
        scale[:, None]
        * np.linalg.qr(rng.normal(size=(10, 10)))[0]
        * rng.uniform(0.3, 1.0, 10)
    )
    found, distance, _ = projected(
        phi, root @ root.T, prior.cells, prior.shares, float(phi[0])
    )
    W = np.linalg.inv(root)
    _, least = nnls(W @ prior.cells, W @ phi, maxiter=10_000)
    assert (found >= 0.0).all()
    off = W @ (prior.cells @ found - phi)
    # the evenness counts for a ten thousandth
    assert float(off @ off) <= least**2 * (1.0 + 1e-3) + 0.05
    assert distance == pytest.approx(float(off @ off), rel=2e-3, abs=1e-5)


def test_parameters_far_from_every_body_are_projected_by_newtons_method(monkeypatch):
    """Which the most even masses are found by; its way from zero would fail in four of
    these forty."""

    def not_needed(*_):
        raise AssertionError("Newton's method did not converge")

    monkeypatch.setattr(projection, "_nearest", not_needed)
    rng, prior = np.random.default_rng(5), Prior.of(shape())
    mixture = prior_mixture(prior, 0.7, False)
    F = np.linalg.cholesky(mixture.covariance)
    for _ in range(40):
        turn = np.linalg.qr(rng.normal(size=(10, 10)))[0]
        root = F @ turn * 10.0 ** rng.uniform(-1.0, 0.0, 10)
        phi = mixture.mean + 10.0 * root @ rng.normal(size=10)
        covariance = root @ root.T
        projection.projected(phi, covariance, prior.cells, prior.shares, 0.7)


def test_where_newtons_method_fails_the_distance_is_still_that_of_the_covariance(
    monkeypatch,
):
    monkeypatch.setattr(projection, "_from_dual", lambda *_: None)
    rng, prior = np.random.default_rng(8), Prior.of(shape())
    mixture = prior_mixture(prior, 0.7, False)
    F = np.linalg.cholesky(mixture.covariance)
    phi = mixture.mean + 3.0 * F @ rng.normal(size=10)
    found = projection.projected(
        phi, mixture.covariance, prior.cells, prior.shares, 0.7
    )
    assert found.dual is None
    off = np.linalg.solve(F, prior.cells @ found.masses - phi)
    # the metric is kept invertible by 1e-14 of it
    assert found.distance == pytest.approx(float(off @ off), rel=1e-4)


def test_a_projection_that_begins_with_that_of_a_like_body_is_the_same():
    """Also where it begins with that of a body that has nothing to do with it."""
    rng, prior = np.random.default_rng(6), Prior.of(shape())
    mixture = prior_mixture(prior, 0.7, False)
    C = 0.01 * mixture.covariance
    F = np.linalg.cholesky(C)
    points = (prior.cells, prior.shares)
    for far in (0.1, 1.0, 10.0, 1000.0):
        phi = mixture.mean + far * F @ rng.normal(size=10)
        near = phi + 0.1 * F @ rng.normal(size=10)
        other = mixture.mean - 10.0 * F @ rng.normal(size=10)
        whole = projected(phi, C, *points, 0.7)
        for begin in (near, other):
            dual = projected(begin, C, *points, 0.8).dual
            found = projected(phi, C, *points, 0.7, dual)
            # as near as the search for it goes on: 1e-6 deviations, and 1e-5 of how
            # many the body is away
            tolerance = 1e-5 * (1.0 + whole.distance**0.5)
            off = np.linalg.solve(F, prior.cells @ (found.masses - whole.masses))
            assert np.abs(off).max() < tolerance
            assert found.distance == pytest.approx(whole.distance, rel=1e-4, abs=1e-8)


def test_a_projection_takes_fewer_steps_from_that_of_a_like_body(monkeypatch):
    steps = counted_lengths(monkeypatch)
    rng, prior = np.random.default_rng(7), Prior.of(shape())
    masses = rng.exponential(size=shape().n) * (rng.random(shape().n) < 0.3)
    phi = prior.cells @ masses
    C = np.diag((0.01 * phi) ** 2)
    dual = projected(phi, C, prior.cells, prior.shares, phi[0]).dual
    alone, steps[0] = steps[0], 0
    phi = phi * (1.0 + 1e-4 * rng.normal(size=10))
    projected(phi, C, prior.cells, prior.shares, phi[0], dual)
    assert steps[0] < 0.5 * alone


@pytest.mark.parametrize("seed", range(8))
def test_the_projection_is_the_most_even_of_its_parameters(seed):
    """By its optimality: what the masses are more or less than even is linear in each
    point's parameters, and where that would leave less than nothing there is
    nothing."""
    rng, prior = np.random.default_rng(seed), Prior.of(shape())
    masses = prior.shares * rng.exponential(size=shape().n) ** (1 + seed % 4)
    phi = prior.cells @ (masses * (rng.random(shape().n) < (1.0, 0.5, 0.3)[seed % 3]))
    root = np.diag(1e-3 * np.abs(phi)) @ np.linalg.qr(rng.normal(size=(10, 10)))[0]
    found, _, _ = projected(
        phi, root @ root.T, prior.cells, prior.shares, float(phi[0])
    )
    more, held = found / (phi[0] * prior.shares) - 1.0, found > 0.0
    M = (prior.cells / np.abs(phi)[:, None]).T
    z = np.linalg.lstsq(M[held], more[held], rcond=None)[0]
    # as near as the search for it goes on
    np.testing.assert_allclose(M[held] @ z, more[held], atol=1e-6)
    assert (M[~held] @ z <= -1.0 + 1e-6).all()


def test_the_projection_of_the_even_body_is_even():
    prior = Prior.of(shape())
    phi = 2.0 * prior.mean
    std = 1e-3 * np.repeat(
        (2.0, np.abs(phi[1:4]).max(), np.abs(phi[4:]).max()), (1, 3, 6)
    )
    found, distance, _ = projected(phi, np.diag(std**2), prior.cells, prior.shares, 2.0)
    np.testing.assert_allclose(found, 2.0 * prior.shares, rtol=1e-6)
    assert distance < 1e-9


def test_the_projection_leaves_out_what_is_certain_to_be_nothing():
    """Points in a plane: what they have no part in is known without error, and asks
    nothing of them."""
    rng = np.random.default_rng(0)
    points = np.column_stack((rng.uniform(-0.1, 0.2, (30, 2)), np.zeros(30)))
    cells = np.column_stack(
        [InertialParameters.from_points(p[None], [1.0]).vector for p in points]
    )
    phi = cells @ rng.exponential(size=30)
    std = 0.01 * np.abs(phi)  # zero for mc_z, Jxz and Jyz
    assert (std == 0.0).sum() == 3
    found, distance, _ = projected(
        phi, np.diag(std**2), cells, np.full(30, 1.0 / 30.0), float(phi[0])
    )
    np.testing.assert_allclose(cells @ found, phi, atol=1e-4 * np.abs(phi).max())
    assert distance < 1e-4
