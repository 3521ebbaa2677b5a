"""Likelihood of Bayes: covariance of residuals, and agreement with least squares where
the motion is exact."""

from dataclasses import replace

import numpy as np
import pytest

from hammers import exact, noisy, shape
from hefting.core.measurements import Noise
from hefting.core.regressor import full_regressor, predict_wrench
from hefting.estimators import OLS, Bayes
from hefting.estimators.bayes.likelihood import Equations, motion_effect
from hefting.estimators.bayes.samples import Samples
from hefting.simulation import hammer


@pytest.mark.parametrize("free_bias", [False, True])
def test_residuals_have_the_covariance_of_a_sample(free_bias):
    """About their mean where a bias is free, which takes one of eight samples; about
    zero where it is not."""
    z = noisy(3, 8, Noise(0.1, 0.005))
    samples = Samples.of(OLS().update(OLS().start(), z), free_bias)
    phi = 0.9 * hammer().parameters.vector
    r = z.wrench - predict_wrench(z, phi)
    expected = np.cov(r.T) if free_bias else r.T @ r / 8
    np.testing.assert_allclose(
        samples.residual_covariance(phi, spent=0.0), expected, rtol=1e-7, atol=1e-12
    )


def test_a_rough_mass_is_force_over_acceleration():
    """In step with it, or by its size beyond the noise, or three deviations of the
    noise; signs do not matter."""
    z, mass = exact(50), hammer().parameters.mass
    still = replace(
        z, angular_velocity=0.0 * z.gravity, angular_acceleration=0.0 * z.gravity
    )
    felt = still.linear_acceleration - still.gravity

    def rough(force, std):
        filled = replace(still, force=force, torque=0.0 * force)
        return Samples.of(OLS().update(OLS().start(), filled), False).mass_scale(std)

    assert rough(mass * felt, 0.0) == pytest.approx(mass, rel=1e-9)
    assert rough(-mass * felt, 0.0) == pytest.approx(mass, rel=1e-9)
    across = np.cross(felt, (0.3, -0.5, 0.8))
    assert rough(across, 0.0) == pytest.approx(
        np.linalg.norm(across) / np.linalg.norm(felt), rel=1e-9
    )
    # of 150 numbers' squares, 0.09 each are noise
    less = (np.sum(across**2) - 150 * 0.09) ** 0.5
    assert rough(across, 0.3) == pytest.approx(less / np.linalg.norm(felt), rel=1e-9)
    assert rough(0.01 * felt, 0.5) == pytest.approx(
        1.5 / np.linalg.norm(felt), rel=1e-9
    )


def test_the_likelihood_is_weighted_least_squares_where_the_motion_is_exact():
    z = noisy(1, 200, Noise(0.1, 0.005))
    samples = Samples.of(
        Bayes(shape()).update(Bayes(shape()).start(), z), free_bias=False
    )
    S = np.diag(np.repeat((0.01, 2.5e-5), 3))
    found = Equations.of(samples, hammer().parameters.vector, S, None).white()
    A, W = full_regressor(z), np.linalg.inv(S)
    np.testing.assert_allclose(
        found.precision, np.einsum("kia,ij,kjb->ab", A, W, A), rtol=1e-9, atol=1e-9
    )
    np.testing.assert_allclose(
        found.shift, np.einsum("kia,ij,kj->a", A, W, z.wrench), rtol=1e-9, atol=1e-7
    )


def test_a_free_bias_is_that_of_weighted_least_squares():
    z = noisy(2, 300, Noise(0.1, 0.005))
    offset = np.array((1.0, -2.0, 3.0))
    z = replace(z, force=z.force + offset, torque=z.torque - 0.1 * offset)
    state = OLS().update(OLS().start(), z)
    samples = Samples.of(state, free_bias=True)
    S = np.diag(np.repeat((0.01, 2.5e-5), 3))
    found = Equations.of(samples, hammer().parameters.vector, S, None).white()
    theirs = OLS("estimate", noise=S).estimate(state)
    phi = np.linalg.solve(found.precision, found.shift)
    deviation = np.sqrt(theirs.covariance.diagonal())
    np.testing.assert_allclose(
        (phi - theirs.parameters.vector) / deviation, 0.0, atol=1e-6
    )
    np.testing.assert_allclose(samples.bias(phi), theirs.bias, atol=1e-6)
    np.testing.assert_allclose(
        np.linalg.inv(found.precision), theirs.covariance, rtol=1e-5, atol=1e-15
    )


def test_noise_of_the_motion_neither_biases_nor_goes_unnoticed():
    """Over 400 recordings the corrected equations hold on average, and scatter as V
    says."""
    phi, S_k = hammer().parameters.vector, np.repeat((0.05**2, 0.5**2), 3)
    E = motion_effect(phi)
    S = np.diag(np.repeat((0.01, 2.5e-5), 3)) + (E * S_k) @ E.T
    squares, errors = [], []
    for seed in range(400):
        samples = Samples.of(
            OLS().update(OLS().start(), noisy(seed, 60)), free_bias=False
        )
        found = Equations.of(samples, phi, S, S_k).white()
        error = found.shift - found.precision @ phi
        squares.append(
            error @ np.linalg.pinv(found.precision, rcond=1e-13, hermitian=True) @ error
        )
    # chi² of ten degrees at the truth: 10, to 0.22 on average over 400; four deviations
    assert np.mean(squares) == pytest.approx(10.0, abs=0.9)
    for seed in range(60):
        samples = Samples.of(OLS().update(OLS().start(), noisy(seed)), free_bias=False)
        both = (Equations.of(samples, phi, S, given).white() for given in (S_k, None))
        errors.append(
            [np.linalg.solve(each.precision, each.shift) - phi for each in both]
        )
    # without the correction the inertia is attenuated: by many standard errors, which
    # with it are few
    t = np.mean(errors, axis=0) / (np.std(errors, axis=0) / 60**0.5)
    assert np.abs(t[0]).max() < 4.5
    assert np.abs(t[1, [4, 7, 9]]).max() > 10.0


def test_effect_of_accelerations_on_the_wrench():
    """E by finite differences of the wrench itself."""
    phi, z = hammer().parameters.vector, exact(5)
    E = motion_effect(phi)
    for q, name in enumerate(("linear_acceleration", "angular_acceleration")):
        for axis in range(3):
            moved = replace(z, **{name: getattr(z, name) + np.eye(3)[axis]})
            change = predict_wrench(moved, phi) - predict_wrench(z, phi)
            np.testing.assert_allclose(
                change, np.tile(E[:, 3 * q + axis], (5, 1)), atol=1e-12
            )
