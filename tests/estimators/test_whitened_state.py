"""Equations of unit noise are a state like any other: the estimators find from them
what they find from the samples that they were made of."""

import numpy as np
import pytest

import hefting
from hefting.core.errors import InputError
from hefting.core.measurements import Noise
from hefting.estimators.joint_state import WhitenedState
from hefting.estimators.quadratic import Quadratic, stacked_factor
from hefting.simulation.arm import UR5
from hefting.simulation.joints import random_smooth
from hefting.simulation.wield import wield

NOISE = Noise(0.1, 0.005)
BOX = "box:-0.1,0.1,-0.1,0.1,0,0.2"
BODY = hefting.InertialParameters.from_com(
    0.9, [0.01, -0.02, 0.09], np.diag([2e-3, 2.2e-3, 1e-3])
)


@pytest.fixture(scope="module")
def measurements():
    motion = UR5.motion(random_smooth(6.0, 100.0, seed=3))
    exact = wield(motion, BODY)
    rng = np.random.default_rng(0)
    noise = rng.standard_normal((len(exact), 6)) * np.repeat((0.1, 0.005), 3)
    return hefting.Measurements(
        exact.time,
        exact.gravity,
        exact.linear_acceleration,
        exact.angular_velocity,
        exact.angular_acceleration,
        exact.force + noise[:, :3],
        exact.torque + noise[:, 3:],
    )


def whitened(state) -> WhitenedState:
    factor = stacked_factor(state, NOISE, False)
    return WhitenedState(factor, state.samples, state.duration)


@pytest.mark.parametrize("name", ["OLS", "LMI", "GEO", "Bayes"])
def test_same_estimate_as_from_the_samples(measurements, name):
    shape = {"shape": hefting.load_shape(BOX)} if name in ("GEO", "Bayes") else {}
    method = getattr(hefting, name)(noise=NOISE, **shape)
    state = method.update(method.start(), measurements)
    want, found = method.estimate(state), method.estimate(whitened(state))
    # Bayes stops its passes at 2 % of variances, far below its intervals; the others
    # solve the same problem to rounding
    tolerance = 0.05 if name == "Bayes" else 1e-5
    scale = np.sqrt(want.covariance.diagonal())
    off = (found.parameters.vector - want.parameters.vector) / scale
    assert np.abs(off).max() < tolerance
    std = np.sqrt(found.covariance.diagonal()) / scale
    if name in ("OLS", "Bayes"):
        np.testing.assert_allclose(std, 1.0, atol=0.02)
    low, high = found.interval("mass")
    assert low < BODY.mass < high


def test_pmd_takes_the_equations_in_their_own_unit(measurements):
    """The full model's equations, unweighted, are PMD's own."""
    method = hefting.PMD(hefting.load_shape(BOX), model="full")
    state = method.update(method.start(), measurements)
    factor = stacked_factor(state, None, False)
    own = WhitenedState(factor / 0.1, state.samples, state.duration, noise=0.1)
    want, found = method.estimate(state), method.estimate(own)
    np.testing.assert_allclose(
        found.parameters.vector, want.parameters.vector, rtol=1e-4, atol=1e-7
    )


def test_they_are_stacked_not_merged(measurements):
    method = hefting.OLS()
    state = whitened(method.update(method.start(), measurements))
    with pytest.raises(InputError, match="stack"):
        method.merge(state, state)


def test_stacked_equations_are_those_of_all_samples(measurements):
    ols = hefting.OLS(noise=NOISE)
    parts = [ols.update(ols.start(), measurements[k::2]) for k in (0, 1)]
    both = whitened(parts[0]).stacked(whitened(parts[1]))
    want = Quadratic.of(ols.update(ols.start(), measurements), NOISE)
    # rounding
    np.testing.assert_allclose(
        Quadratic.of(both).least_squares(), want.least_squares(), rtol=1e-9, atol=1e-12
    )
    assert both.samples == len(measurements)


def test_information_without_some_directions(measurements):
    """Equations of a singular likelihood see what it sees, and nothing else."""
    rng = np.random.default_rng(1)
    A = rng.standard_normal((6, 10)) * 10.0 ** rng.uniform(-3, 3, 10)
    A[:, 4] = 0.0
    b = rng.standard_normal(6)
    state = WhitenedState.of_information(A.T @ A, A.T @ b, 6, 1.0)
    R = state.factor
    # of numbers over six decades, by rounding of their squares
    scale = np.sqrt((A * A).sum(axis=0)) + 1e-30
    np.testing.assert_allclose(
        (R[:, :10].T @ R[:, :10]) / np.outer(scale, scale),
        (A.T @ A) / np.outer(scale, scale),
        atol=1e-9,
    )
    np.testing.assert_allclose(
        R[:, :10].T @ R[:, 10] / scale, A.T @ b / scale, atol=1e-5
    )


def test_the_mass_stands_alone_in_the_last_equation(measurements):
    ols = hefting.OLS(noise=NOISE)
    state = whitened(ols.update(ols.start(), measurements))
    last = state.mass_last[-1]
    np.testing.assert_array_equal(last[1:10], 0.0)
    mass = ols.estimate(state).mass
    # rounding
    assert last[10] / last[0] == pytest.approx(mass, rel=1e-9)


def test_no_more_samples_are_folded(measurements):
    ols = hefting.OLS()
    state = whitened(ols.update(ols.start(), measurements))
    with pytest.raises(InputError, match="found already"):
        ols.update(state, measurements)
    with pytest.raises(InputError, match="finite factor"):
        WhitenedState(np.zeros((10, 10)), 1, 1.0)


def test_equations_of_a_likelihood_have_unit_noise_unless_another_is_given():
    P = np.diag(np.arange(1.0, 11.0))
    assert WhitenedState.of_information(P, np.ones(10), 6, 1.0).noise == 1.0
    assert WhitenedState.of_information(P, np.ones(10), 6, 1.0, 0.3).noise == 0.3
