"""Unconstrained least squares: against weighted least squares of all rows, and limits
of what it says from both sides."""

from dataclasses import replace

import numpy as np
import pytest

from hefting.core.measurements import Noise
from hefting.core.regressor import full_regressor
from hefting.core.spatial import PARAMETERS
from hefting.estimators.sample_state import SampleState
from hefting.ingest.free_fit import FreeFit, fit_freely, lever, residuals
from random_problems import random_body, random_motion, with_wrench

BIAS = np.array((1.0, -2.0, 3.0, 0.1, -0.2, 0.1))


def problem(K: int = 80, force: float = 0.3, torque: float = 0.02):
    rng = np.random.default_rng(3)
    return with_wrench(
        random_motion(rng, K), random_body(rng), BIAS, rng, force, torque
    )


@pytest.mark.parametrize("free_bias", [False, True])
def test_it_is_least_squares_weighted_by_its_own_residuals(free_bias):
    """Twice: of the first fit's, then of the second's."""
    z = problem()
    A = full_regressor(z)
    if free_bias:
        A = np.concatenate((A, np.tile(np.eye(6), (80, 1, 1))), axis=2)
    unknowns = A.shape[2]
    scale = np.ones(2)
    for _ in range(2):
        solution, _ = weighted(A, z.wrench, scale)
        left = (z.wrench - A @ solution).reshape(-1, 2, 3)
        # unknowns are taken from force and torque alike
        count = 3.0 * 80 - unknowns / 2.0
        scale = np.sqrt(np.square(left).sum(axis=(0, 2)) / count)
    solution, covariance = weighted(A, z.wrench, scale)
    inflation = np.linspace(0.5, 3.0, 16)
    found = fit_freely(z, free_bias, inflation)
    np.testing.assert_allclose((found.noise.force, found.noise.torque), scale)
    np.testing.assert_allclose(found.vector, solution[:10], rtol=1e-8)
    ratio = np.sqrt(np.maximum(inflation, 1.0))[:unknowns]
    np.testing.assert_allclose(
        found.covariance, covariance * np.outer(ratio, ratio), rtol=1e-6, atol=1e-18
    )
    np.testing.assert_array_equal(found.inflation, np.maximum(inflation, 1.0))
    assert found.autocorrelation == pytest.approx(found.inflation[:10].mean())
    left = residuals(z, found.vector, found.bias)
    np.testing.assert_allclose(left, z.wrench - A @ solution, atol=1e-9)
    if free_bias:
        np.testing.assert_allclose(found.bias, solution[10:], rtol=1e-8)
        std = np.sqrt(found.covariance.diagonal()[10:])
        np.testing.assert_allclose(found.bias_t, found.bias / std)
    else:
        assert found.bias is None
        assert not found.bias_t.any()


def weighted(A, wrench, scale):
    rows = (A / np.repeat(scale, 3)[:, None]).reshape(-1, A.shape[2])
    solution = np.linalg.lstsq(rows, (wrench / np.repeat(scale, 3)).ravel())[0]
    return solution, np.linalg.inv(rows.T @ rows)


@pytest.mark.parametrize("size", [1.0, 1e-3])
def test_exact_wrenches_have_a_billionth_of_their_size_as_noise(size):
    """Root mean square of all channels; of nothing, of one newton."""
    z = problem(force=0.0, torque=0.0)
    z = replace(z, force=size * z.force, torque=size * z.torque)
    noise = fit_freely(z, True).noise
    least = 1e-9 * np.sqrt(np.mean(z.wrench**2))
    assert (noise.force, noise.torque) == pytest.approx((least, least), rel=1e-6)
    nothing = replace(z, force=0.0 * z.force, torque=0.0 * z.torque)
    noise = fit_freely(nothing, True).noise
    assert (noise.force, noise.torque) == (1e-9, 1e-9)


def test_one_sample_is_fitted_and_leaves_the_noise_of_its_size():
    z = problem(K=80)[:1]
    noise = fit_freely(z, False).noise
    least = 1e-9 * np.sqrt(np.mean(z.wrench**2))
    assert (noise.force, noise.torque) == pytest.approx((least, least), rel=1e-6)


def fit_with(std, mass: float = 2.0, bias=None, bias_std: float = 1.0) -> FreeFit:
    """With standard deviations of the parameters and of the bias."""
    own = np.broadcast_to(std, 10)
    if bias is not None:
        own = np.append(own, np.full(6, bias_std))
    return FreeFit(
        np.append(mass, np.zeros(9)), bias, np.diag(own**2), Noise(), np.ones(16)
    )


def test_a_mass_is_open_within_three_deviations_of_zero():
    for std, open_ in ((0.66, False), (0.67, True), (np.inf, True)):
        for mass in (2.0, -2.0):
            fit = fit_with(std, mass)
            assert fit.mass_is_open is open_
            assert fit.mass_t == pytest.approx(mass / std)
    assert fit_with(np.inf).autocorrelation == 1.0


def test_parameters_are_open_by_the_size_of_the_object():
    """A third of the mass, the mass times half of the size, or times a twelfth of its
    square; of 2 kg and 0.3 m."""
    limits = np.array([2.0 / 3.0] + [0.3] * 3 + [0.015] * 6)
    for i, name in enumerate(PARAMETERS):
        std = 0.99 * limits
        assert fit_with(std).open_parameters(0.3) == ()
        for other in (1.01 * limits[i], np.inf):
            std[i] = other
            assert fit_with(std, -2.0).open_parameters(0.3) == (name,)


@pytest.mark.parametrize("channel", [0, 5])
def test_a_bias_is_significant_from_three_deviations_of_one_channel_on(channel):
    bias = np.zeros(6)
    for size, told in ((2.9, False), (3.1, True), (-2.9, False), (-3.1, True)):
        bias[channel] = 0.2 * size
        assert fit_with(0.1, bias=bias, bias_std=0.2).bias_is_significant is told
        # not where it cannot be told from the weight
        assert not fit_with(1.0, bias=bias, bias_std=0.2).bias_is_significant
        assert not fit_with(0.1, bias=bias, bias_std=np.inf).bias_is_significant
    assert not fit_with(0.1).bias_is_significant


def test_less_a_tool_the_parameters_are_fewer_and_no_better_known():
    fit = fit_with(0.1, bias=BIAS, bias_std=0.3)
    tool, covariance = np.arange(10.0), np.diag(np.arange(10.0))
    left = fit.less(tool, covariance)
    np.testing.assert_array_equal(left.vector, fit.vector - tool)
    expected = np.append(0.01 + np.arange(10.0), np.full(6, 0.09))
    np.testing.assert_allclose(left.covariance, np.diag(expected))
    np.testing.assert_array_equal(fit.less(tool, None).covariance, fit.covariance)
    assert fit.covariance[9, 9] == pytest.approx(0.01)
    back = fit.flipped()
    np.testing.assert_array_equal(back.vector, -fit.vector)
    np.testing.assert_array_equal(back.bias, -BIAS)
    assert fit_with(0.1).flipped().bias is None


@pytest.mark.parametrize("free_bias", [False, True])
def test_the_lever_is_the_distance_of_the_com_and_shows_a_unit_of_torque(free_bias):
    """By gravity alone, so of a sensor that rests; beside a bias where gravity turns by
    0.03 of its size."""
    rng = np.random.default_rng(5)
    body = random_body(rng)
    z = with_wrench(random_motion(rng, 50, speed=0.0), body, BIAS * free_bias)
    distance = np.linalg.norm(body.center_of_mass)
    assert lever(SampleState.of(z), free_bias) == pytest.approx(distance, rel=1e-6)
    milli = SampleState.of(replace(z, torque=1e3 * z.torque))
    assert lever(milli, free_bias) == pytest.approx(1e3 * distance, rel=1e-6)
    nothing = replace(z, force=0.0 * z.force, torque=0.0 * z.torque)
    assert lever(SampleState.of(nothing), free_bias) == 0.0
    for turn, told in ((0.031, True), (0.029, False)):
        # a swing about x whose root mean square is that along y
        angle = np.arcsin(
            turn * 2.0**0.5 * np.sin(np.linspace(0, 2 * np.pi, 50, False))
        )
        swing = 9.81 * np.stack((0 * angle, np.sin(angle), -np.cos(angle)), axis=1)
        rests = with_wrench(
            replace(random_motion(rng, 50, speed=0.0), gravity=swing),
            body,
            BIAS * free_bias,
        )
        found = lever(SampleState.of(rests), free_bias)
        assert (found > 0.0) == (told or not free_bias)


@pytest.mark.parametrize("free_bias", [False, True])
@pytest.mark.parametrize("speed", [0.3, 10.0])
def test_accelerations_do_not_make_the_lever_longer(speed, free_bias):
    """They are what gravity leaves: of 10 m/s² and rad/s² levers of up to 80 times the
    distance had been found, and right recordings were refused for the unit of torque.

    Of exact wrenches, so the tolerance is that of rounding.
    """
    for seed in range(40):
        rng = np.random.default_rng(seed)
        body = random_body(rng)
        z = with_wrench(random_motion(rng, 50, speed), body, BIAS * free_bias)
        distance = np.linalg.norm(body.center_of_mass)
        assert lever(SampleState.of(z), free_bias) <= distance * (1.0 + 1e-9)
