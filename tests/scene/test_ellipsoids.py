"""Ellipsoids that are drawn: equal inertia, and the region that holds the COM."""

from dataclasses import replace

import numpy as np
import pytest
import trimesh
from scipy.stats import chi2, norm

from hefting.core.estimate import Estimate
from hefting.core.inertia import InertialParameters
from hefting.scene import Ellipsoid, com_region, uniform_ellipsoid
from hefting.scene.surface import CHI95, Z95
from hefting.simulation import hammer

UNPHYSICAL = InertialParameters.from_com(
    0.5, (0.0, 0.1, 0.0), np.diag((1e-3, 1e-3, 5e-3))
)


def estimate_with(covariance, **more):
    return Estimate(
        "test", hammer().parameters, samples=100, covariance=covariance, **more
    )


def intervals_of(center_half):
    """Of a COM within `center_half` (3,) above, and half of it below."""
    body, half = hammer().parameters, np.array(center_half)
    return {
        "mass": np.array((0.9, 1.1)) * body.mass,
        "center_of_mass": body.center_of_mass + np.array((-half, 0.5 * half)),
        "inertia_at_com": np.array((body.inertia_at_com, body.inertia_at_com)),
    }


def random_covariance(seed):
    """Of all ten parameters, correlated, each known to about a percent."""
    factor = np.random.default_rng(seed).normal(size=(10, 10))
    scale = 0.01 * np.maximum(np.abs(hammer().parameters.vector), 1e-3)
    return (factor @ factor.T) * np.outer(scale, scale) / 10.0


def test_the_factors_are_those_of_the_normal_distribution():
    assert pytest.approx(np.sqrt(chi2.ppf(0.95, 3)), rel=1e-12) == CHI95
    assert pytest.approx(norm.ppf(0.975), rel=1e-12) == Z95


def test_a_solid_of_that_form_has_the_bodys_inertia():
    """Oracle: the moments that trimesh integrates over a mesh of the ellipsoid."""
    rng = np.random.default_rng(3)
    turn = np.linalg.qr(rng.normal(size=(3, 3)))[0]
    square = np.array((0.05, 0.1, 0.2)) ** 2
    J = (turn * (2.0 / 5.0 * (square.sum() - square))) @ turn.T
    body = InertialParameters.from_com(2.0, (0.1, 0.2, 0.3), J)
    found = uniform_ellipsoid(body)
    assert found is not None
    ball = trimesh.creation.icosphere(subdivisions=4)
    solid = trimesh.Trimesh(
        ball.vertices @ found.half_axes.T + found.center, ball.faces
    )
    solid.fix_normals()
    solid.density = 2.0 / solid.volume
    # the mesh is inscribed: its sides are off by 1 - cos of half an edge, 0.1 %
    np.testing.assert_allclose(solid.moment_inertia, J, atol=3e-3 * J.max())
    np.testing.assert_allclose(solid.center_mass, body.center_of_mass, atol=1e-9)
    assert uniform_ellipsoid(UNPHYSICAL) is None


def test_the_shadow_touches_every_tangent():
    """Farthest point of the outline in any direction d of the view: sqrt(d'Qd), Q = A
    A'."""
    rng = np.random.default_rng(4)
    ellipsoid = Ellipsoid(rng.normal(size=3), rng.normal(size=(3, 3)))
    Q = ellipsoid.half_axes @ ellipsoid.half_axes.T
    np.testing.assert_allclose(ellipsoid.reach, np.sqrt(Q.diagonal()), rtol=1e-12)
    for i, j in ((0, 1), (2, 1), (0, 2)):
        outline = ellipsoid.shadow(i, j) - ellipsoid.center[[i, j]]
        for angle in np.linspace(0.0, np.pi, 7):
            d = np.array((np.cos(angle), np.sin(angle)))
            reach = np.sqrt(d @ Q[np.ix_((i, j), (i, j))] @ d)
            # one of 120 points is within 1.5° of the farthest, in the ellipse's
            # parameter: 1 - cos 1.5°
            assert (outline @ d).max() == pytest.approx(reach, rel=4e-4)


@pytest.mark.parametrize("seed", range(3))
def test_the_region_holds_the_com_of_95_in_100_draws(seed):
    estimate = estimate_with(random_covariance(seed))
    region = com_region(estimate)
    assert region is not None
    draws = np.random.default_rng(seed).multivariate_normal(
        estimate.parameters.vector, estimate.covariance, 20_000
    )
    places = draws[:, 1:4] / draws[:, :1] - region.center
    inside = np.linalg.norm(np.linalg.solve(region.half_axes, places.T), axis=0) <= 1.0
    # three standard deviations of the share of 20,000 are 0.5 %; the quotient of two
    # normal variables of a percent is off from the linearised one by less
    assert inside.mean() == pytest.approx(0.95, abs=0.008)


def test_the_region_is_as_wide_as_the_intervals():
    """Intervals may hold errors that the covariance does not."""
    half = np.array((0.003, 0.001, 0.02))
    intervals = intervals_of(half)
    for covariance in (random_covariance(5), None, np.full((10, 10), np.inf)):
        region = com_region(estimate_with(covariance, intervals=intervals))
        assert region is not None
        np.testing.assert_allclose(region.reach, half * CHI95 / Z95, rtol=1e-9)


def test_there_is_no_region_where_the_com_is_open_or_nothing_is_known():
    open_ = intervals_of((1e-3, np.inf, 1e-3))
    assert com_region(estimate_with(None)) is None
    assert com_region(estimate_with(random_covariance(1), intervals=open_)) is None
    covariance = random_covariance(2)
    covariance[3, :] = covariance[:, 3] = np.inf
    assert com_region(estimate_with(covariance)) is None
    assert com_region(replace(estimate_with(None), intervals=None)) is None


def test_principal_half_axes_make_the_same_ellipsoid():
    """Of half-axes that are not perpendicular, and of a flat one: A A' is the same, and
    the axes are a rotation."""
    rng = np.random.default_rng(6)
    flat = rng.normal(size=(3, 3)) @ np.diag((1.0, 1.0, 0.0))
    for half_axes in (*rng.normal(size=(10, 3, 3)), flat, np.zeros((3, 3))):
        lengths, turn = Ellipsoid(np.zeros(3), half_axes).principal
        assert (np.diff(lengths) <= 0.0).all()
        np.testing.assert_allclose(turn @ turn.T, np.eye(3), atol=1e-14)
        assert np.linalg.det(turn) == pytest.approx(1.0, abs=1e-12)
        own = (turn * lengths**2) @ turn.T
        np.testing.assert_allclose(own, half_axes @ half_axes.T, atol=1e-13)
