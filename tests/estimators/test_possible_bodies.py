"""Possible bodies: the mixture against draws from what it stands for."""

from dataclasses import replace

import numpy as np
import pytest

from hammers import shape
from hefting.core.inertia import InertialParameters
from hefting.core.spatial import vector_to_tensor
from hefting.estimators.geo import thickened
from hefting.estimators.possible_bodies import (
    MASS_STD,
    NEAR_BODY_FREEDOMS,
    PART_STDS,
    WITHIN_PART_STDS,
    PossibleBodies,
    _com_derivative,
    _gradients,
)
from hefting.shapes import Shape


def test_bodies_near_another_have_the_moments_of_a_wishart_distribution():
    """Pseudo-inertia G W G', W Wishart of nu degrees of freedom and mean 1: mean and
    covariance of the ten parameters over 200,000 draws."""
    body, nu = thickened(shape().homogeneous), 12.0
    found = PossibleBodies.near(InertialParameters(3.0 * body.vector))
    j = list(NEAR_BODY_FREEDOMS).index(nu)
    G = np.linalg.cholesky(body.pseudo_inertia / body.mass)
    X = np.random.default_rng(1).normal(size=(200_000, 4, int(nu))) / nu**0.5
    P = G @ (X @ X.transpose(0, 2, 1)) @ G.T
    S = P[:, :3, :3]
    J = np.trace(S, axis1=1, axis2=2)[:, None, None] * np.eye(3) - S
    i, k = np.triu_indices(3)
    draws = np.column_stack((P[:, 3, 3], P[:, :3, 3], J[:, i, k]))
    covariance = found.spread[j] @ found.spread[j].T
    covariance -= MASS_STD**2 * np.outer(found.means[j], found.means[j])
    size = np.sqrt(covariance.diagonal())
    # standard errors of 200,000 draws: 0.2 % of a deviation, 0.5 % of a variance
    np.testing.assert_allclose(
        (draws.mean(axis=0) - found.means[j]) / size, 0, atol=0.01
    )
    np.testing.assert_allclose(
        (np.cov(draws.T) - covariance) / np.outer(size, size), 0.0, atol=0.03
    )


def test_a_mixture_adds_up_and_allows_for_any_body():
    near = PossibleBodies.near(thickened(shape().homogeneous))
    either = near.or_any(np.zeros(3))
    anywhere = PossibleBodies.any(np.zeros(3))
    boxed = PossibleBodies.in_box(thickened(shape().homogeneous))
    for bodies in (near, either, anywhere, boxed, PossibleBodies.in_shape(shape())):
        assert np.exp(bodies.log_weight).sum() == pytest.approx(1.0)
        np.testing.assert_allclose(bodies.means[:, 0], 1.0)
    assert len(either.means) > len(near.means)
    np.testing.assert_array_equal(either.means[: len(near.means)], near.means)


def test_any_body_is_where_it_is_said_to_be():
    center = np.array((0.1, -0.2, 0.3))
    for mean in PossibleBodies.any(center).means:
        body = InertialParameters(mean)
        np.testing.assert_allclose(body.center_of_mass, center)
        moments = np.diag(body.inertia_at_com)
        np.testing.assert_allclose(moments, moments[0])


def test_the_com_s_derivative_against_differences():
    c, step = np.array((0.1, -0.2, 0.3)), 1e-6
    J = vector_to_tensor(np.array((3.0, 0.1, -0.2, 2.0, 0.3, 1.0)))

    def vector(at):
        return InertialParameters.from_com(1.0, at, J).vector

    differences = [
        (vector(c + step * unit) - vector(c - step * unit)) / (2.0 * step)
        for unit in np.eye(3)
    ]
    # rounding over the step
    np.testing.assert_allclose(_com_derivative(c), np.array(differences).T, atol=1e-9)


def test_parts_are_those_of_the_homogeneous_body_and_each_varies_by_itself():
    rng = np.random.default_rng(2)
    whole = replace(shape(), labels=rng.integers(3, size=shape().n))
    _, part = np.unique(whole.labels, return_inverse=True)
    shares = np.zeros((whole.n, 3))
    shares[np.arange(whole.n), part] = whole.volumes
    shares /= shares.sum(axis=0)
    found = PossibleBodies.of_parts(whole, shares)
    np.testing.assert_allclose(
        found.means,
        np.tile(whole.homogeneous.vector, (len(found.means), 1)),
        atol=1e-12,
    )
    # a change of one part's mass is within the mixture's span: F F' sees it
    change = whole.cell_matrix @ shares[:, 0]
    for F in found.spread:
        explained = F @ np.linalg.lstsq(F, change, rcond=1e-12)[0]
        # the points are the solid to a thousandth of its size
        np.testing.assert_allclose(explained, change, atol=1e-3 * np.abs(change).max())


@pytest.mark.parametrize("height", [0.1, 0.3, 0.7])
def test_a_part_in_a_plane_has_no_gradient_across_it(height):
    """Beside it all points are where they are on average but for rounding, of which
    nothing must be made: the same whatever rounding makes of the mean."""
    masses = np.linspace(0.1, 0.3, 9)
    sides = np.random.default_rng(3).uniform(0.0, 0.07, (9, 2))
    sides[0] = 0.0
    flat = Shape(np.column_stack((sides, np.full(9, height))), masses)
    across = _gradients(flat, masses[:, None])[:, 2]
    np.testing.assert_array_equal(across, 0.0)


@pytest.mark.parametrize("volumes", [True, False])
def test_parts_together_are_the_whole(volumes):
    """Of members that differ by what a part's mass varies the covariances do by C C',
    whose columns sum to the homogeneous body: so does C (C C')^+ of it by their number.
    Points are that body nearly only, to a hundredth here."""
    rng = np.random.default_rng(4)
    whole = shape()
    if not volumes:
        whole = Shape(whole.positions, np.full(whole.n, 1.0 / whole.n))
    part = rng.integers(4, size=whole.n)
    shares = (part[:, None] == np.arange(4)) * rng.uniform(0.5, 1.5, (whole.n, 1))
    shares /= shares.sum(axis=0)
    F = PossibleBodies.of_parts(whole, shares).spread
    wide, narrow = (i * len(WITHIN_PART_STDS) for i in (1, 0))
    apart = F[wide] @ F[wide].T - F[narrow] @ F[narrow].T
    apart /= PART_STDS[1] ** 2 - PART_STDS[0] ** 2
    mean = whole.homogeneous.vector / whole.homogeneous.mass
    size = np.sqrt(apart.diagonal())
    inverse = np.linalg.pinv(apart / np.outer(size, size), rcond=1e-9, hermitian=True)
    assert (mean / size) @ inverse @ (mean / size) == pytest.approx(4.0, rel=1e-4)
    # the masses of the parts are shares of the volume
    v = np.ones(whole.n) if whole.volumes is None else whole.volumes
    share = np.array([v[part == k].sum() for k in range(4)]) / v.sum()
    assert apart[0, 0] == pytest.approx(float(share @ share), rel=1e-3)
