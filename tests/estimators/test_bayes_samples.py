"""What Bayes makes of samples before any prior, and how its noise and passes go on to
more of them: closed forms, and limits from both sides."""

from dataclasses import replace
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest
from scipy.optimize import brentq

from hammers import shape
from hefting.core.measurements import MotionNoise
from hefting.core.regressor import full_regressor
from hefting.estimators import Bayes
from hefting.estimators.bayes import mixture as mixture_module
from hefting.estimators.bayes.colour import Colour, response_errors
from hefting.estimators.bayes.likelihood import Equations, Likelihood
from hefting.estimators.bayes.mixture import Mixture, _factored
from hefting.estimators.bayes.noise_found import (
    MotionErrors,
    NoiseFound,
    inflation_of,
)
from hefting.estimators.bayes.passes import Pass, Passes
from hefting.estimators.bayes.posterior import doubtful_shape, warnings_of
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


# noise


def noise_of(samples: Samples, phi, **more) -> NoiseFound:
    R = samples.residual_covariance(phi)
    equations = Equations.of(samples, phi, R, None)
    return NoiseFound(equations, R, False, 1.0, 1.0, phi, **more)


def colour_of(noise, white: bool = False) -> Colour:
    some = np.ones(3)
    return Colour(noise, 2.0, np.ones(4), 0.5, some, some, 1.0, white, False)


def test_noise_holds_where_residuals_are_at_most_a_tenth_larger():
    """Squared, in any channel."""
    samples = samples_of(problem(), True)
    phi = samples.least_squares
    found = noise_of(samples, phi)
    assert found.holds_for(samples)
    for factor, holds in ((1.0 / 1.09, True), (1.0 / 1.11, False)):
        R = found.residual_covariance.copy()
        R[4, 4] *= factor
        assert replace(found, residual_covariance=R).holds_for(samples) is holds


@pytest.mark.parametrize("K", [30, 120])
def test_noise_of_more_samples_has_errors_of_the_sensor_that_grow_with_them(K):
    """As the score does, squared; of fewer they stay as they are. Coloured noise grows
    by that of white noise, times its autocorrelation."""
    z, motion = problem(120), MotionErrors(None, 1.0)
    fewer, more = samples_of(z[:60]), samples_of(z[:K])
    phi = fewer.least_squares
    sensor = 0.1 * np.eye(10)
    noise = 3.0 * np.eye(10)
    found = noise_of(fewer, phi, sensor=sensor, colour=colour_of(noise))
    other = found.of_more(more, phi, motion)
    G, before = other.equations.G, found.equations.G
    growth = np.trace(G) / np.trace(before)
    assert (growth > 1.5) == (K == 120)
    np.testing.assert_allclose(other.sensor, max(growth, 1.0) ** 2 * sensor)
    np.testing.assert_allclose(other.colour.noise, noise + 2.0 * (G - before))
    plain = noise_of(fewer, phi).of_more(more, phi, motion)
    assert plain.sensor is None
    assert plain.colour is None
    assert plain.autocorrelation == 1.0
    assert found.autocorrelation == 2.0


def test_the_likelihood_is_that_of_all_that_is_noise():
    """H V^-1 H about the same parameters, whatever V; the inflation is of V."""
    samples = samples_of(problem(), True)
    phi = samples.least_squares
    white = noise_of(samples, phi)
    G, h = white.equations.G, white.equations.h
    noise, sensor = 2.0 * G + np.eye(10), 0.3 * G
    for found, V in (
        (white, G),
        (noise_of(samples, phi, colour=colour_of(noise, white=True)), G),
        (noise_of(samples, phi, colour=colour_of(noise)), noise),
        (noise_of(samples, phi, sensor=sensor), G + sensor),
        (
            noise_of(samples, phi, sensor=sensor, colour=colour_of(noise)),
            noise + sensor,
        ),
    ):
        for inflation in (1.0, 3.0):
            told = found.likelihood(inflation)
            half = np.linalg.solve(inflation * V, np.column_stack((G, h)))
            expected = G @ half
            size = np.sqrt(expected[:, :10].diagonal())
            np.testing.assert_allclose(
                told.precision / np.outer(size, size),
                expected[:, :10] / np.outer(size, size),
                atol=1e-6,
            )
            np.testing.assert_allclose(
                told.shift / size, expected[:, 10] / size, rtol=1e-5, atol=1e-6
            )
        np.testing.assert_array_equal(
            found.likelihood().precision, found.likelihood(1.0).precision
        )


def test_errors_of_the_motion_last_for_their_memory_over_the_interval():
    state = cast(Any, SimpleNamespace(duration=1.0, samples=101))
    errors = MotionErrors.of(MotionNoise(0.2, 3.0, 0.05), state)
    np.testing.assert_allclose(errors.variances, np.repeat((0.04, 9.0), 3))
    assert errors.memory == pytest.approx(5.0)
    assert errors.white is None
    short = MotionErrors.of(MotionNoise(0.2, 0.0, 0.005), state)
    assert short.memory == 1.0
    assert short.white is short.variances
    for none in (None, MotionNoise(0.0, 0.0, 0.05)):
        assert MotionErrors.of(none, state).variances is None
    one = cast(Any, SimpleNamespace(duration=0.0, samples=1))
    assert MotionErrors.of(MotionNoise(0.2, 3.0, 0.05), one).memory == 1.0
    assert (inflation_of(3.0), inflation_of(3.1)) == (1.0, 3.1)


def test_a_gain_of_a_time_scale_is_what_errors_of_the_motion_do_not_explain():
    """White ones attenuate all alike; what is beyond chance fades towards slower scales
    by the third root of a half, but for scales that bound it."""
    signal = np.array((1e6, 0.0, 1e4, 1e2))
    information = np.zeros((4, 10, 10))
    information[:, 0, 0] = signal
    phi = np.eye(10)[0]

    def errors(score, details=0.0):
        scores = np.zeros((4, 10))
        scores[:, 0] = score
        found = cast(Any, SimpleNamespace(information=information, scores=scores))
        return response_errors(found, np.ones(4), np.full(4, details), phi)

    fade = 0.5 ** (1.0 / 3.0)
    assert not errors(np.zeros(4)).any()
    shown = 0.1 * (1.0 - 12.0 / 1e4) ** 0.5
    for sign in (1.0, -1.0):
        found = errors(sign * np.array((1e5, 0.0, 0.0, 0.0)))
        expected = (shown, fade * shown, 0.02, fade * 0.02, fade**2 * 0.02)
        np.testing.assert_allclose(found, expected)
    # by chance a gain of 12 squared deviations is seen
    assert not errors((3.4e3, 0.0, 0.0, 0.0)).any()
    assert errors((3.5e3, 0.0, 0.0, 0.0))[0] > 0.0
    # the same of each detail is attenuation, and what is added to it no gain
    attenuated = -np.array((1e5, 1e5, 1e5, 1e5))
    assert not errors(attenuated, 1e3).any()
    assert errors(-attenuated, 1e3)[3] > 0.1


# passes


def test_a_posterior_has_a_centre_from_a_tenth_of_the_prior_s_mass_on():
    com = np.zeros(3)
    center = cast(Any, Pass.__dict__["center"]).func
    for mass, told in ((0.19, False), (0.21, True), (-1.0, False)):
        mean = np.append(mass, np.full(9, 0.1))
        found = SimpleNamespace(mixture=SimpleNamespace(mean=mean), scale=2.0, com=com)
        expected = np.full(3, 0.1 / mass) if told else com
        np.testing.assert_array_equal(center(found), expected)


def test_the_prior_s_mass_is_near_the_rough_one():
    """A fifth to twice as much."""
    passes = cast(Any, SimpleNamespace(rough_mass=2.0))
    for mass, scale in ((0.1, 0.4), (-1.0, 0.4), (0.5, 0.5), (3.9, 3.9), (9.0, 4.0)):
        assert Passes._scale(passes, np.full(10, mass)) == pytest.approx(scale)


# mixture


@pytest.mark.parametrize("precise", [1.0, 1e6])
def test_members_are_factored_without_eigenvalues(precise, monkeypatch):
    """Where they are well-conditioned: R of I + F'Lambda F, F R^-T and R^-1 F' left."""

    def not_needed(*_):
        raise AssertionError("Cholesky's method did not do")

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
            found.covariances[j], np.linalg.inv(P), rtol=1e-4, atol=1e-8
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
    from hefting.estimators.state_likelihood import _divided_by

    method = Bayes(shape())
    state = method.update(method.start(), problem(300))
    one, other = _divided_by(1.0, state), _divided_by(4.0, state)
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


def posterior(**more: Any):
    """Of a kilogram known to 1 %, of which nothing is in doubt."""
    return cast(
        Any,
        SimpleNamespace(
            **{
                "noise_known": True,
                "contradicted": False,
                "coloured": False,
                "excess": 1.0,
                "disagreement": 0.0,
                "response": 0.0,
                "mixture": SimpleNamespace(mean=np.ones(10), mass_std=0.01),
                "settled": True,
                "shape_known": True,
                "misfit": 0.0,
                "scale_doubts": (),
                "bias": None,
            }
            | more
        ),
    )


@pytest.mark.parametrize(
    ("doubt", "distance", "code"),
    [
        ({}, 0.0, None),
        ({"noise_known": False}, 0.0, "noise-unknown"),
        ({"contradicted": True, "excess": 4.0}, 0.0, "noise-exceeds-claim"),
        ({"coloured": True}, 0.0, "noise-coloured"),
        ({"disagreement": 2.9}, 0.0, None),
        ({"disagreement": 3.1}, 0.0, "stretches-disagree"),
        ({"response": 0.0070}, 0.0, None),
        ({"response": 0.0072}, 0.0, "response-uneven"),
        ({"settled": False}, 0.0, "shape-not-found"),
        ({"misfit": 99.0, "shape_known": False}, 0.0, None),
        ({"misfit": 101.0}, 0.0, "shape-contradicts-wrench"),
        ({"misfit": 101.0, "shape_known": False}, 0.0, "shape-contradicts-wrench"),
    ],
)
def test_a_posterior_s_doubts_have_their_thresholds(doubt, distance, code):
    """An uneven response counts as the larger part of the mass's deviation, squared."""
    told = [m.code for m in warnings_of(posterior(**doubt), distance)]
    assert told == ([code] if code else [])


def test_a_shape_is_doubtful_by_both_distances_together():
    assert doubtful_shape(posterior(misfit=12.0), 7.9) == 0.0
    assert doubtful_shape(posterior(misfit=12.0), 8.1) == pytest.approx(20.1)
    for more in (
        {"shape_known": False},
        {"contradicted": True},
        {"coloured": True},
        {"disagreement": 3.1},
    ):
        assert doubtful_shape(posterior(misfit=12.0, **more), 30.0) == 0.0
