"""Errors of the sensor that more samples do not lessen, and the noise as least squares
leaves it."""

from dataclasses import replace

import numpy as np
import pytest

from estimators.test_bayes_streamed import WHITE, coloured, noisy, shape
from hammers import exact
from hefting.core.errors import InputError, NotIdentifiableError
from hefting.core.measurements import Measurements, Noise
from hefting.core.regressor import FULL_MAP, MOTION, features
from hefting.core.sensor_accuracy import SensorAccuracy
from hefting.core.spatial import Array
from hefting.estimators import OLS, Bayes
from hefting.estimators.bayes.colour import first_order
from hefting.estimators.bayes.groups import Groups
from hefting.estimators.bayes.sensor_errors import (
    IN_STEP_RATIO,
    InStep,
    slow_variances,
)
from hefting.shapes import Shape


def groups(seed: int) -> tuple[Groups, list[Array], list[Array]]:
    """Three groups of random samples: as `Groups`, and their regressors and wrenches
    one by one."""
    rng = np.random.default_rng(seed)
    z = noisy(seed, 90, WHITE)
    rows = features(z)[rng.permutation(90)].reshape(3, 30, -1)
    factors = [np.linalg.qr(part, mode="r") for part in rows]
    regressors = [(part[:, MOTION] @ FULL_MAP).reshape(30, 6, 10) for part in rows]
    return Groups.of(factors, [30.0] * 3, None), regressors, list(rows)


@pytest.mark.parametrize("seed", range(3))
def test_in_step_errors_are_random_mixtures_of_the_wrench(seed):
    """Against every entry of the 36 of M one by one, on the samples themselves."""
    rng = np.random.default_rng([7, seed])
    found, regressors, _ = groups(seed)
    W, whole = np.diag(rng.uniform(0.5, 20.0, 6)), rng.normal(size=10)
    coloured_noise, gain = rng.uniform(0.1, 5.0, 3), rng.uniform(0.0, 0.1, 3)
    step = InStep.of(found.whitened(W), found.counts, whole)
    ours = step.of_each(coloured_noise, gain)
    for A, variance, error, each in zip(
        regressors, coloured_noise, gain, ours, strict=True
    ):
        A = W @ A
        w = A @ whole
        expected = np.zeros((10, 10))
        size = IN_STEP_RATIO * variance * 30.0 / np.sum(w * w)
        for c in range(6):
            for d in range(6):
                x = A[:, c].T @ w[:, d]
                expected += size * np.outer(x, x)
        x = np.einsum("kci,kc->i", A, w)
        expected += error**2 * np.outer(x, x)
        scale = np.sqrt(expected.diagonal())
        # rounding of the factors
        np.testing.assert_allclose(
            each / np.outer(scale, scale), expected / np.outer(scale, scale), atol=1e-9
        )


def test_slow_errors_follow_the_load_and_spare_a_bias_that_is_excluded():
    free = slow_variances(0.01, 400.0, 200.0, 6, free_bias=True)
    np.testing.assert_allclose(free, 0.04 * first_order(np.exp(-1.0 / 50.0), 7))
    fixed = slow_variances(0.01, 400.0, 200.0, 6, free_bias=False)
    np.testing.assert_array_equal(fixed, [*free[:-1], 0.0])
    assert not slow_variances(0.0, 400.0, 200.0, 6, True).any()


def test_a_sensor_s_error_widens_the_intervals_by_its_size():
    """The mass's by about as much of it: its sensor is half a percent off."""
    z = noisy(5, 1000, WHITE)
    widths = []
    for error in (0.0, 0.005, 0.02):
        estimate = Bayes(shape(), sensor_accuracy=SensorAccuracy(error)).fit(z)
        widths.append(float(estimate.covariance[0, 0]) ** 0.5)  # type: ignore[index]
    assert widths[0] < widths[1] < widths[2]
    mass = Bayes(shape()).fit(z).parameters.mass
    # it lasts a quarter of the record: some four independent errors, on a wrench that
    # turns
    assert 0.1 * 0.02 < widths[2] / mass < 0.02


def widened(z: Measurements, factor: float) -> Bayes:
    """Bayes, its noise's deviation a `factor` of the true one."""
    noise = replace(WHITE, force=factor * WHITE.force, torque=factor * WHITE.torque)
    return Bayes(shape(), noise=noise)


@pytest.mark.parametrize("rho", [0.0, 0.95])
def test_wider_intervals_never_move_a_mass_that_is_determined(rho):
    """By a tenth of their deviation, whatever widens them: noise that is claimed larger,
    and a poorer sensor."""
    z = noisy(3, 1000, WHITE) if rho == 0.0 else coloured(3, rho)
    sure = Bayes(shape(), sensor_accuracy="0%").fit(z)
    others = [
        Bayes(shape(), sensor_accuracy=SensorAccuracy(error)).fit(z)
        for error in (0.002, 0.01, 0.05)
    ]
    if rho == 0.0:
        others += [widened(z, factor).fit(z) for factor in (1.0, 3.0)]
    for other in others:
        std = float(other.covariance[0, 0]) ** 0.5  # type: ignore[index]
        assert abs(other.parameters.mass - sure.parameters.mass) < 0.1 * max(
            std,
            float(sure.covariance[0, 0]) ** 0.5,  # type: ignore[index]
        )
    assert others[2].covariance[0, 0] > 4.0 * sure.covariance[0, 0]  # type: ignore[index]


def test_a_wrong_shape_does_not_explain_its_misfit_as_noise():
    """The noise is what least squares leaves: the same for a shape 30 cm aside."""
    z = coloured(4, 0.9)
    right, wrong = shape(), shape()
    pose = np.array(wrong.pose)
    pose[0, 3] += 0.3
    wrong = Shape(
        wrong.positions + np.array((0.3, 0.0, 0.0)), volumes=wrong.volumes, pose=pose
    )
    found = []
    for each in (right, wrong):
        estimator = Bayes(each)
        found.append(estimator.posterior(estimator.update(estimator.start(), z)))
    # the autocorrelation, on which the covariance depends, settles to a percent
    np.testing.assert_allclose(
        found[0].residual_covariance.diagonal(),
        found[1].residual_covariance.diagonal(),
        rtol=0.02,
    )
    np.testing.assert_allclose(found[0].variances, found[1].variances, rtol=0.05)


@pytest.mark.parametrize("seed", range(3))
def test_a_mass_lost_in_the_noise_is_an_answer_all_the_same(seed):
    """A gram in noise of half a newton, a wrench of the wrong sign, and no weights: an
    interval that is wider than nothing, or an error that says why."""
    loud = Noise(0.5, 0.02)
    still = exact(60)
    light = replace(still, force=1e-3 * still.force, torque=1e-3 * still.torque)
    for z in (light.with_noise(loud, seed), opposite(noisy(seed, 150, WHITE))):
        for bias in ("none", "estimate"):
            estimate = Bayes(bias=bias).fit(replace(z, noise=None))
            assert estimate.intervals is not None
            low, high = estimate.intervals["mass"]
            assert 0.0 <= low < high
            assert low <= estimate.parameters.mass <= high
            assert np.isfinite(estimate.parameters.vector).all()
    with pytest.raises(NotIdentifiableError, match="weight"):
        Bayes().fit(replace(still, weights=np.zeros(60)))


def opposite(z: Measurements) -> Measurements:
    """The wrench of the other sign."""
    return replace(z, force=-z.force, torque=-z.torque)


def test_weights_found_in_the_residuals_are_no_given_noise():
    """`identify` weighs by the level of the residuals; the intervals allow for errors of
    a real sensor all the same."""
    z = noisy(6, 1000, WHITE)
    found = OLS(noise=WHITE, noise_found=True).fit(z)
    told, untold = OLS(noise=WHITE).fit(z), OLS().fit(z)
    widths = [np.ptp(e.intervals["mass"]) for e in (found, told, untold)]  # type: ignore[index]
    assert widths[0] > 1.3 * widths[1]
    assert 0.5 < widths[0] / widths[2] < 1.5


def test_what_is_no_error_of_a_sensor_is_refused():
    for method in (Bayes, OLS):
        for wrong in (-1.0, float("nan"), "much", True):
            with pytest.raises(InputError, match="as in"):
                method(sensor_accuracy=wrong)
        with pytest.raises(InputError, match="ten finite parameters"):
            method(carried=np.zeros(3))
        with pytest.raises(InputError, match="positive semidefinite"):
            method(systematic=-1e-3 * np.eye(10))
        method(sensor_accuracy=SensorAccuracy(np.float32(0.01)))
