"""OLS: against least squares on every sample, and its covariance against simulation."""

from dataclasses import replace

import numpy as np
import pytest

from hefting.core.errors import InputError, NotIdentifiableError
from hefting.core.measurements import Measurements, Noise
from hefting.core.regressor import full_regressor
from hefting.core.spatial import PARAMETERS, WRENCH
from hefting.estimators import OLS
from hefting.estimators.quadratic import ScaledSVD
from random_problems import random_body, random_motion, with_wrench

NOISE = Noise(force=0.1, torque=0.005)
BIAS = np.array((1.0, -2.0, 3.0, 0.1, -0.2, 0.3))


def every_sample(z: Measurements, free_bias: bool, noise: Noise | None):
    """The rows and right-hand side of all samples, whitened."""
    weight = np.ones(len(z)) if z.weights is None else np.sqrt(z.weights)
    A = full_regressor(replace(z, weights=None))
    if free_bias:
        A = np.concatenate((A, np.broadcast_to(np.eye(6), (len(z), 6, 6))), axis=2)
    scale = (
        np.ones(6)
        if noise is None
        else np.repeat((1 / noise.force, 1 / noise.torque), 3)
    )
    A = A * weight[:, None, None] * scale[:, None]
    b = z.wrench * weight[:, None] * scale
    return A.reshape(-1, A.shape[2]), b.ravel()


@pytest.fixture
def z() -> Measurements:
    rng = np.random.default_rng(1)
    return with_wrench(
        random_motion(rng, 200), random_body(rng), BIAS, rng, NOISE.force, NOISE.torque
    )


@pytest.mark.parametrize("bias", ["none", "estimate"])
def test_recovers_noise_free_parameters(bias):
    rng = np.random.default_rng(2)
    for mass, size in ((1e-3, 0.01), (1.0, 0.1), (50.0, 1.0)):
        body = random_body(rng, mass, size, size)
        z = with_wrench(
            random_motion(rng, 100, speed=3.0),
            body,
            BIAS if bias == "estimate" else 0.0,
        )
        found = OLS(bias).fit(z)
        column = np.linalg.norm(full_regressor(z).reshape(-1, 10), axis=0)
        # conditioning of the scaled columns, about ten, times rounding of the wrench,
        # the bias included
        error = np.abs(found.parameters.vector - body.vector) * column
        assert error.max() < 1e-12 * np.linalg.norm(z.wrench)
        assert found.warnings == ()
        assert (found.samples, found.duration) == (100, pytest.approx(0.99))
        if bias == "estimate":
            np.testing.assert_allclose(found.bias, BIAS, atol=1e-12)
        else:
            assert found.bias is None


@pytest.mark.parametrize("bias", ["none", "estimate"])
@pytest.mark.parametrize("noise", [None, NOISE])
@pytest.mark.parametrize("weighted", [False, True])
def test_equals_least_squares_on_every_sample(z, bias, noise, weighted):
    if weighted:
        z = replace(z, weights=np.random.default_rng(3).uniform(size=len(z)))
    A, b = every_sample(z, bias == "estimate", noise)
    expected, (square,), *_ = np.linalg.lstsq(A, b, rcond=None)
    found = OLS(bias, noise, intervals=False).fit(z)
    solution = np.concatenate(
        (found.parameters.vector, [] if found.bias is None else found.bias)
    )
    scale = np.linalg.norm(A, axis=0)
    np.testing.assert_allclose(
        solution * scale, expected * scale, atol=1e-9 * np.linalg.norm(b)
    )
    covariance = np.linalg.inv(A.T @ A)[:10, :10]
    if noise is None:
        covariance *= square / (A.shape[0] - A.shape[1])
    std = np.sqrt(covariance.diagonal())
    np.testing.assert_allclose(
        found.covariance / np.outer(std, std),
        covariance / np.outer(std, std),
        atol=1e-9,
    )
    assert found.certificate.objective == pytest.approx(square, rel=1e-9)
    assert found.certificate.bound <= found.certificate.objective
    assert found.certificate.gap < 1e-12 * square


def test_streaming_merging_and_batch_agree(z):
    estimator = OLS("estimate", NOISE)
    batch = estimator.fit(z)
    single = estimator.start()
    for k in range(len(z)):
        single = estimator.update(single, z[k : k + 1])
    halves = [estimator.update(estimator.start(), z[i::2]) for i in (0, 1)]
    scale = np.sqrt(batch.covariance.diagonal())
    both = [estimator.merge(*p, one_bias=True) for p in (halves, halves[::-1])]
    for state in (single, *both):
        found = estimator.estimate(state)
        # rounding, far below one standard deviation
        np.testing.assert_allclose(
            found.parameters.vector / scale, batch.parameters.vector / scale, atol=1e-9
        )
        np.testing.assert_allclose(found.bias, batch.bias, atol=1e-10)
        assert (found.samples, found.duration) == (batch.samples, batch.duration)


# covariance


@pytest.mark.parametrize("noise", [None, NOISE])
def test_covariance_is_that_of_repeated_experiments(noise):
    """400 noisy wrenches on one motion.

    The errors' squared Mahalanobis distances are chi² of 10, so their mean over 400
    runs is 10 with a standard error of sqrt(20/400) = 0.22; bounds are four of them.
    Without known levels the noise has one level for all six rows.
    """
    rng = np.random.default_rng(4)
    levels = Noise(0.05, 0.05) if noise is None else noise
    clean = with_wrench(random_motion(rng, 60), random_body(rng), BIAS)
    truth = OLS("estimate").fit(clean).parameters.vector
    distances, errors, covariances = [], [], []
    for _ in range(400):
        force, torque = (
            v + s * rng.normal(size=v.shape)
            for v, s in ((clean.force, levels.force), (clean.torque, levels.torque))
        )
        estimator = OLS("estimate", noise, intervals=False)
        found = estimator.fit(replace(clean, force=force, torque=torque))
        error = found.parameters.vector - truth
        errors.append(error)
        covariances.append(found.covariance)
        distances.append(error @ np.linalg.solve(found.covariance, error))
    assert np.mean(distances) == pytest.approx(10.0, abs=0.9)
    ratio = np.std(errors, axis=0) / np.sqrt(np.mean(covariances, axis=0).diagonal())
    # each is known to 1/sqrt(800) = 3.5 %; four of them
    np.testing.assert_allclose(ratio, 1.0, atol=0.15)


def undetermined(found) -> set[str]:
    return {
        PARAMETERS[i] for i in np.flatnonzero(np.isinf(found.covariance.diagonal()))
    }


def assert_apart(covariance: np.ndarray) -> None:
    """What is open says nothing of the rest, nor the rest of it."""
    free = np.isinf(covariance.diagonal())
    assert free.any()
    assert (covariance[np.ix_(free, ~free)] == 0.0).all()
    assert (covariance[np.ix_(~free, free)] == 0.0).all()


def test_at_rest_the_inertia_is_undetermined():
    rng = np.random.default_rng(5)
    body = random_body(rng)
    still = with_wrench(random_motion(rng, 20, speed=0.0), body, BIAS, rng, 1e-6, 1e-6)
    for bias in ("none", "estimate"):
        z = (
            still
            if bias == "estimate"
            else replace(
                still, force=still.force - BIAS[:3], torque=still.torque - BIAS[3:]
            )
        )
        found = OLS(bias).fit(z)
        assert undetermined(found) == set(PARAMETERS[4:])
        assert_apart(found.covariance)
        assert len(found.warnings) == 1
        assert all(name in found.warnings[0] for name in PARAMETERS[4:])
        assert "m," not in found.warnings[0].split("determine")[1].split(":")[0]
        # rounding of ten newtons
        np.testing.assert_allclose(found.parameters.vector[4:], 0.0, atol=1e-12)
        # noise of a micronewton against ten newtons for each kilogram
        np.testing.assert_allclose(
            found.parameters.vector[:4], body.vector[:4], atol=1e-6
        )
        assert np.isfinite(found.covariance[:4, :4]).all()
        assert found.std["mass"] == pytest.approx(np.sqrt(found.covariance[0, 0]))
        assert np.isfinite(found.std["center_of_mass"]).all()


def test_one_orientation_beside_a_bias_determines_nothing():
    rng = np.random.default_rng(6)
    body = random_body(rng)
    one = random_motion(rng, 1, speed=0.0)[np.zeros(30, dtype=int)]
    z = with_wrench(one, body, BIAS, rng, 1e-6, 1e-6)
    found = OLS("estimate", intervals=False).fit(z)
    assert undetermined(found) == set(PARAMETERS)
    for name in (*PARAMETERS, *(f"bias {w}" for w in WRENCH)):
        assert name in found.warnings[0]
    alone = OLS(intervals=False).fit(with_wrench(one, body))
    assert "m" not in undetermined(alone)  # without a bias gravity gives the mass
    # and two combinations of the moments
    assert {"mcx", "mcy", "mcz"} <= undetermined(alone)


def test_residual_variance_counts_what_the_data_determine():
    """One orientation beside a bias: of ten + six unknowns the data fix six, so 6 K - 6
    degrees remain."""
    rng = np.random.default_rng(7)
    one = random_motion(rng, 1, speed=0.0)[np.zeros(3, dtype=int)]
    z = with_wrench(one, random_body(rng), 0.0, rng, 0.1, 0.1)
    found = OLS(intervals=False).fit(z)  # m and two moments: 3 of 10
    A, b = every_sample(z, False, None)
    residual = b - A @ np.linalg.lstsq(A, b, rcond=1e-9)[0]
    rank = np.linalg.matrix_rank(A)
    assert rank == 3
    expected = residual @ residual / (18 - rank) / (A[:, 0] @ A[:, 0])
    projected = A[:, 0] - A[:, 1:4] @ np.linalg.lstsq(A[:, 1:4], A[:, 0], rcond=1e-9)[0]
    assert np.allclose(projected, A[:, 0])  # force rows and torque rows do not mix
    assert found.covariance[0, 0] == pytest.approx(expected, rel=1e-9)


# input


def test_no_samples():
    with pytest.raises(NotIdentifiableError, match="no samples"):
        OLS().estimate(OLS().start())


def test_hyperparameters_are_checked():
    with pytest.raises(InputError, match="bias model"):
        OLS(bias="some")  # type: ignore[arg-type]
    for noise in (Noise(), Noise(0.1, 0.0), Noise(-0.1, 0.1), Noise(np.nan, 0.1)):
        with pytest.raises(InputError, match="noise"):
            OLS(noise=noise)


def test_the_bound_is_what_a_wrong_solution_lacks(monkeypatch):
    """A solution off by a thousandth: the certificate's bound is still the optimum, to
    rounding, and the gap shows."""
    rng = np.random.default_rng(1)
    z = with_wrench(random_motion(rng, 50), random_body(rng), 0.0, rng, 0.1, 0.005)
    right, solve = OLS().fit(z).certificate, ScaledSVD.solve
    monkeypatch.setattr(ScaledSVD, "solve", lambda self, b: 0.999 * solve(self, b))
    wrong = OLS().fit(z).certificate
    assert wrong.objective > 1.001 * right.objective
    assert wrong.bound == pytest.approx(right.objective, rel=1e-9)
