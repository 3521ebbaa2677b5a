"""What Bayes makes of samples before any prior, its mixture and its projection: closed
forms, and limits from both sides."""

from dataclasses import replace
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest
from scipy.optimize import brentq

from hammers import shape
from hefting.core.regressor import full_regressor
from hefting.core.spatial import tensor_to_vector
from hefting.estimators import Bayes
from hefting.estimators.bayes import mixture as mixture_module
from hefting.estimators.bayes.likelihood import Likelihood
from hefting.estimators.bayes.mixture import (
    INTERVAL_QUANTITIES,
    Mixture,
    _factored,
    shaped,
)
from hefting.estimators.bayes.prior import Prior
from hefting.estimators.bayes.projection import _length, dual_of, projected
from hefting.estimators.bayes.samples import Samples
from hefting.estimators.sample_state import SampleState
from random_problems import random_body, random_motion, with_wrench

BIAS = np.array((1.0, -2.0, 3.0, 0.1, -0.2, 0.1))


def problem(K: int = 60, seed: int = 3):
    rng = np.random.default_rng(seed)
    return with_wrench(random_motion(rng, K), random_body(rng), BIAS, rng, 0.3, 0.02)


def samples_of(z, free_bias: bool = False) -> Samples:
    return Samples.of(SampleState.of(z), free_bias)


def made(f=0.0, d=0.0, K: float = 20.0, pace: float = 0.01) -> Samples:
    """One virtual sample with a force and an acceleration along z."""
    b, at = np.zeros((1, 6)), np.zeros((1, 3))
    b[0, 2], at[0, 2] = f, d
    none = np.zeros((1, 6))
    floor = np.repeat((1e-6, 1e-8), 3)
    whole = np.zeros((1, 6, 10))
    return Samples(whole, b, K, at, floor, whole, none, np.ones(1), pace)


@pytest.mark.parametrize(
    ("f", "d", "noise", "mass"),
    [
        (20.0, 10.0, 0.0, 2.0),
        (-20.0, 10.0, 0.0, 2.0),  # of the other sign: by its size
        (20.0, 10.0, 2.0, 2.0),  # noise of 20 samples is taken from the size alone
        (-20.0, 10.0, 2.0, (400.0 - 3.0 * 20.0 * 4.0) ** 0.5 / 10.0),
        (-20.0, 10.0, 5.0, 1.5),  # below the noise: three deviations of it
        (1.0, 0.0, 0.0, 1e6),
        (0.0, 10.0, 0.0, 1e-9),
    ],
)
def test_a_rough_mass_is_the_largest_of_what_tells_of_it(f, d, noise, mass):
    assert made(f, d).mass_scale(noise) == pytest.approx(mass)


def test_samples_are_those_of_least_squares():
    """Of forces and torques weighed by their size; residuals, biases and loads are those
    of all rows."""
    z = problem()
    A, wrench = full_regressor(z), z.wrench
    free = samples_of(z, True)
    A0, w0 = A - A.mean(axis=0), wrench - wrench.mean(axis=0)
    sizes = np.sqrt(np.square(w0).reshape(-1, 2, 3).sum(axis=(0, 2)))
    unit = np.repeat(1.0 / sizes, 3)
    rows = (A0 * unit[:, None]).reshape(-1, 10)
    phi = np.linalg.lstsq(rows, (w0 * unit).ravel())[0]
    np.testing.assert_allclose(free.least_squares, phi, rtol=1e-6)
    assert pytest.approx(59.0) == free.K
    left = w0 - A0 @ phi
    expected = left.T @ left / (59.0 - 10.0 / 6.0)
    np.testing.assert_allclose(free.least_residual, expected, rtol=1e-5)
    # equations that are spent are at most three quarters
    some = free.residual_covariance(phi, spent=300.0)
    np.testing.assert_allclose(some, left.T @ left / (0.25 * 59.0), rtol=1e-5)
    np.testing.assert_allclose(
        free.bias(phi), (wrench - A @ phi).mean(axis=0), atol=1e-9
    )
    W = np.diag(np.arange(1.0, 7.0))
    load = np.sum((W @ (A.mean(axis=0) @ phi)) ** 2)
    assert free.constant_load(W, phi) == pytest.approx(load)
    size = np.sqrt(np.square(wrench).reshape(-1, 2, 3).mean(axis=(0, 2)))
    np.testing.assert_allclose(free.floor, 1e-6 * np.repeat(size, 3))
    assert free.pace == pytest.approx(z.time[-1] / 59.0)
    given = samples_of(z)
    assert pytest.approx(60.0) == given.K
    np.testing.assert_allclose(given.A_mean[0], A.mean(axis=0), atol=1e-9)


def test_a_little_torque_has_a_thousandth_of_the_forces_as_its_size():
    """And the other way round."""
    z = problem()
    none = replace(z, torque=1e-9 * z.torque)
    size = np.sqrt(np.mean(np.square(z.force)))
    np.testing.assert_allclose(samples_of(none).floor[3:], 1e-9 * size)


def test_noise_is_that_of_the_residuals_and_of_channels_that_are_alike():
    """As if it had been seen in twelve samples beside; of those, some are spent and some
    are like others."""
    samples, rng = made(K=100.0), np.random.default_rng(1)
    R = rng.normal(size=(6, 6))
    R = R @ R.T
    levels = np.diag(np.repeat(R.diagonal().reshape(2, 3).mean(axis=1), 3))
    for time in (1.0, 4.0, 1000.0):
        K = max(100.0 / time - 10.0 / 6.0 - 6.0, 0.0)
        expected = (K * R + 12.0 * levels) / (K + 12.0) + np.diag(samples.floor**2)
        np.testing.assert_allclose(samples.noise_left(R, time), expected)


@pytest.mark.parametrize(("pace", "unproven"), [(0.49, True), (0.5, False)])
def test_few_samples_may_have_the_error_of_a_poor_sensor(pace, unproven):
    """The same in all, of 5 % of the wrench; in separate poses it is not the same."""
    samples = made(K=15.0, pace=pace)
    share = 0.25 * 15.0 * unproven
    expected = share * np.diag((0.05 * 1e6 * samples.floor) ** 2)
    np.testing.assert_allclose(samples.unproven(20), expected)
    assert not samples.unproven(15).any()


# mixture


@pytest.mark.parametrize(
    ("precise", "fails"), [(1.0, False), (1e6, False), (1.0, True)]
)
def test_members_are_factored(precise, fails, monkeypatch):
    """R of I + F'Lambda F, F R^-T and R^-1 F' left: without eigenvalues where they are
    well-conditioned, and the same where Cholesky's method fails beyond them."""
    cholesky = np.linalg.cholesky

    def factor_alone(M):
        if M.shape[1] > 10:
            raise np.linalg.LinAlgError
        return cholesky(M)

    def not_needed(*_):
        raise AssertionError("Cholesky's method did not do")

    if fails:
        monkeypatch.setattr(np.linalg, "cholesky", factor_alone)
    else:
        monkeypatch.setattr(mixture_module, "_cholesky", not_needed)
    rng = np.random.default_rng(2)
    F = rng.normal(size=(3, 10, 10))
    A = rng.normal(size=(20, 10))
    precision, left = precise * A.T @ A, rng.normal(size=(3, 10))
    log_det, half, y = _factored(F, precision, left)
    M = np.eye(10) + F.transpose(0, 2, 1) @ precision @ F
    np.testing.assert_allclose(log_det, 0.5 * np.linalg.slogdet(M)[1])
    for j in range(3):
        R = np.linalg.cholesky(M[j])
        np.testing.assert_allclose(half[j] @ R.T, F[j], atol=1e-7)
        np.testing.assert_allclose(R @ y[j], F[j].T @ left[j], atol=1e-7)


def test_a_posterior_mixture_is_that_of_each_gaussian():
    """Mean and covariance by Bayes' law, weights by the evidence of each."""
    rng = np.random.default_rng(3)
    A = rng.normal(size=(15, 10))
    precision, shift = A.T @ A, rng.normal(size=10)
    spread = rng.normal(size=(2, 10, 10))
    prior = cast(
        Any,
        SimpleNamespace(
            mean=rng.normal(size=10),
            spread=spread,
            log_weight=np.log((0.3, 0.7)),
            offsets=rng.normal(size=(2, 10)),
        ),
    )
    found = Mixture.of(prior, 2.0, Likelihood(precision, shift, np.eye(6)))
    log = []
    for j in range(2):
        C, m = 4.0 * spread[j] @ spread[j].T, 2.0 * (prior.mean + prior.offsets[j])
        P = np.linalg.inv(C) + precision
        mean = np.linalg.solve(P, np.linalg.solve(C, m) + shift)
        np.testing.assert_allclose(found.means[j], mean, rtol=1e-5, atol=1e-6)
        np.testing.assert_allclose(
            found.factors[j] @ found.factors[j].T,
            np.linalg.inv(P),
            rtol=1e-4,
            atol=1e-8,
        )
        own = mean @ P @ mean - m @ np.linalg.solve(C, m)
        own -= np.linalg.slogdet(P)[1] + np.linalg.slogdet(C)[1]
        log.append(np.log((0.3, 0.7)[j]) + 0.5 * own)
    weights = np.exp(log - max(log))
    np.testing.assert_allclose(found.weights, weights / weights.sum(), rtol=1e-5)


# projection


@pytest.mark.parametrize("seed", range(4))
def test_a_dual_is_told_by_the_masses_that_it_makes(seed):
    rng, prior = np.random.default_rng(seed), Prior.of(shape())
    masses = prior.shares * rng.exponential(size=len(prior.shares))
    phi = prior.cells @ masses
    std = np.diag((1e-3 * np.abs(phi)) ** 2)
    found = projected(phi, std, prior.cells, prior.shares, float(phi[0]))
    total = found.masses.sum()
    z = dual_of(found.masses, prior.cells, prior.shares)
    even = prior.shares * np.maximum(1.0 + z @ prior.cells, 0.0)
    held = found.masses > 0.0
    # what keeps the equations invertible is 1e-9 of them, of a condition of 1e4
    np.testing.assert_allclose(even[held], (found.masses / total)[held], rtol=1e-3)
    assert dual_of(np.zeros(len(masses)), prior.cells, prior.shares) is None
    assert dual_of(-masses, prior.cells, prior.shares) is None


@pytest.mark.parametrize("seed", range(8))
def test_the_length_of_a_step_is_where_the_dual_is_least(seed):
    """To a thousandth, by the root of its derivative."""
    rng = np.random.default_rng(seed)
    slack, change = rng.normal(1.0, 1.0, 50), rng.normal(size=50)
    even = rng.uniform(size=50)
    curvature = 10.0 ** rng.uniform(-2.0, 2.0)

    def derivative(t, slope=0.0):
        left = np.maximum(slack - t * change, 0.0)
        return t * curvature - slope - (even * change) @ left

    slope = 10.0 ** rng.uniform(-1.0, 2.0) - derivative(0.0) * (-1.0)
    slope = max(slope, derivative(0.0) + 0.1)
    root = brentq(lambda t: derivative(t, slope), 0.0, 1e6)
    assert _length(slack, change, even, slope, curvature) == pytest.approx(
        root, abs=2e-3
    )


def test_a_state_of_averages_weighs_as_its_samples():
    """Divided by a weight, moments and time record alike."""
    from hefting.estimators.state_likelihood import _of_all_samples

    method = Bayes(shape())
    state = method.update(method.start(), problem(300))
    one, other = _of_all_samples(state, 1.0), _of_all_samples(state, 4.0)
    for name in ("full", "record"):
        assert getattr(other, name) is not None
    np.testing.assert_allclose(
        other.full.factor.T @ other.full.factor,
        0.25 * one.full.factor.T @ one.full.factor,
        rtol=1e-9,
        atol=1e-9,
    )
    for mine, whole in zip(other.record.complete, one.record.complete, strict=True):
        for a, b in zip(mine.factors, whole.factors, strict=True):
            np.testing.assert_allclose(a.T @ a, 0.25 * b.T @ b, atol=1e-9)
        assert mine.counts == whole.counts


def test_sixteen_numbers_are_those_of_their_quantities():
    """Tensors by their six entries."""
    ends = np.arange(1.0, 17.0) + np.array((0.0, 20.0))[:, None]
    found = shaped(ends)
    for name, part in INTERVAL_QUANTITIES.items():
        own = [
            tensor_to_vector(end) if np.ndim(end) == 2 else np.atleast_1d(end)
            for end in found[name]
        ]
        np.testing.assert_array_equal(own, ends[:, part])
