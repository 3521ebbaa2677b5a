"""The quadratic of all samples, its whitening and its scaled SVD, against dense
matrices of every sample."""

from dataclasses import replace

import numpy as np
import pytest

from blend_problem import (
    ROUNDING,
    K,
    correlated_noise,
    dense,
    random_shape,
    weighted_samples,
    weights,
)
from hefting.core.errors import InputError
from hefting.core.inertia import InertialParameters
from hefting.core.measurements import Measurements, Noise
from hefting.estimators import GEO, OLS
from hefting.estimators.quadratic import Quadratic, ScaledSVD, whitening
from hefting.estimators.sample_state import SampleState
from hefting.shapes import Shape
from random_problems import random_body, random_motion, with_wrench


@pytest.fixture(scope="module")
def z() -> Measurements:
    return weighted_samples()


@pytest.fixture(scope="module")
def covariance() -> np.ndarray:
    return correlated_noise()


@pytest.fixture(scope="module")
def shape() -> Shape:
    return random_shape()


def levels_of(noise: Noise | np.ndarray | None) -> np.ndarray | None:
    return (
        np.diag(np.repeat((noise.force, noise.torque), 3)) ** 2
        if isinstance(noise, Noise)
        else noise
    )


# Quadratic

NOISES = {"none": None, "levels": Noise(0.1, 0.005), "covariance": "covariance"}


@weights
@pytest.mark.parametrize("kind", NOISES)
@pytest.mark.parametrize("free_bias", [False, True])
def test_quadratic_is_the_projection_of_all_rows(z, covariance, w, kind, free_bias):
    """Its square at any parameters is that of all rows, with the best bias; `bias` is
    the best bias."""
    noise = covariance if kind == "covariance" else NOISES[kind]
    S = levels_of(noise)
    q = Quadratic.of(SampleState.of(z, w), noise, free_bias)
    rows, right = dense(z, w, free_bias, S)
    rng = np.random.default_rng(58)
    for vector in (np.zeros(10), *(random_body(rng).vector for _ in range(3))):
        r = rows[:, -10:] @ vector - right
        beta = q.bias(vector)
        if free_bias:
            C = rows[:, :6]
            best = np.linalg.lstsq(C, -r, rcond=None)[0]
            assert beta is not None
            np.testing.assert_allclose(beta, best, atol=1e-10 * np.abs(best).max())
            r = r + C @ best
        else:
            assert beta is None
        # what is left of a wrench that the bias mostly explains is rounded like the
        # whole
        assert q.square(vector) == pytest.approx(
            r @ r, rel=ROUNDING, abs=ROUNDING * float(right @ right)
        )
        assert np.sum((q.A @ vector - q.b) ** 2) == pytest.approx(
            q.square(vector), rel=1e-14
        )
    assert q.size == pytest.approx(np.sqrt(q.square(np.zeros(10))), rel=1e-14)
    seen = 6 * free_bias + (4 if isinstance(w, float) and w == 0.0 else 10)
    expected = np.linalg.lstsq(rows[:, :seen], right, rcond=None)[0][6 * free_bias :]
    length = np.linalg.norm(rows, axis=0)[6 * free_bias :]
    wrong = (q.least_squares() - np.pad(expected, (0, 10 - len(expected)))) * length
    assert np.abs(wrong).max() < ROUNDING * np.linalg.norm(right)


def test_the_measured_mass_is_positive_whatever_is_measured(z, shape):
    homogeneous = shape.homogeneous.vector
    assert Quadratic.of(SampleState.of(z), None, True).measured_mass(
        homogeneous
    ) == pytest.approx(OLS("estimate").fit(z).parameters.mass, rel=ROUNDING)
    zero = replace(z, force=np.zeros((K, 3)), torque=np.zeros((K, 3)))
    upward = with_wrench(z, InertialParameters(-homogeneous))
    weightless = replace(
        zero, gravity=np.zeros((K, 3)), linear_acceleration=np.zeros((K, 3))
    )
    for case in (zero, upward, weightless):
        assert Quadratic.of(SampleState.of(case)).measured_mass(homogeneous) > 0.0


def test_without_samples_the_quadratic_is_zero():
    for free_bias in (False, True):
        q = Quadratic.of(SampleState.empty(), None, free_bias)
        assert q.square(np.ones(10)) == 0.0
        bias = q.bias(np.ones(10))
        assert bias is None or not bias.any()


# whitening


def test_whitening_makes_the_covariance_one(covariance):
    for noise in (Noise(0.1, 0.005), covariance, 1e-9 * covariance, 1e9 * covariance):
        W, S = whitening(noise), levels_of(noise)
        assert W is not None
        assert S is not None
        np.testing.assert_allclose(W @ S @ W.T, np.eye(6), atol=1e-10)
    assert whitening(None) is None
    far_apart = np.diag((1e8, 1.0, 1.0, 1e-8, 1.0, 1.0))  # units, not definiteness
    np.testing.assert_allclose(
        np.asarray(whitening(far_apart)),
        np.diag(far_apart.diagonal() ** -0.5),
        rtol=1e-12,
    )


def test_a_covariance_is_symmetric_but_for_rounding(covariance):
    """Of its largest entry: the smallest are rounding themselves."""
    nearly = covariance.copy()
    nearly[0, 1] += 1e-10 * np.abs(covariance).max()
    assert np.isfinite(np.asarray(whitening(nearly))).all()


ASYMMETRIC = np.eye(6)
ASYMMETRIC[0, 1] = 0.5
CROSSED = np.eye(6)
CROSSED[0, 1] = CROSSED[1, 0] = 2.0
BAD = {
    "asymmetric": (ASYMMETRIC, "symmetric matrix"),
    "indefinite": (CROSSED, "not positive definite"),
    "negative": (-np.eye(6), "not positive definite"),
    "singular": (np.diag((1.0, 1.0, 1.0, 1.0, 1.0, 0.0)), "not positive definite"),
    "zero": (np.zeros((6, 6)), "not positive definite"),
    "small": (np.eye(3), "symmetric matrix"),
    "flat": (np.ones(6), "symmetric matrix"),
    "NaN": (np.diag((1.0, 1.0, 1.0, 1.0, 1.0, np.nan)), "symmetric matrix"),
    "infinite": (np.diag((1.0, 1.0, 1.0, 1.0, 1.0, np.inf)), "symmetric matrix"),
    "text": ("loud", "not numbers"),
    "ragged": ([[1.0], [1.0, 2.0]], "not numbers"),
    "exact": (Noise(), "must be positive"),
    "exact torque": (Noise(force=0.1), "must be positive"),
}


@pytest.mark.parametrize(("noise", "message"), BAD.values(), ids=BAD)
def test_bad_noise_is_refused_in_one_line(shape, noise, message):
    for make in (
        lambda: whitening(noise),
        lambda: OLS(noise=noise),
        lambda: GEO(shape, noise=noise),
    ):
        with pytest.raises(InputError, match=message) as caught:
            make()
        assert "\n" not in str(caught.value)


# ScaledSVD


def test_scaled_svd_solves_in_any_units():
    rng = np.random.default_rng(59)
    A, b = rng.normal(size=(20, 5)), rng.normal(size=20)
    svd = ScaledSVD.of(A)
    np.testing.assert_allclose((svd.U * svd.S) @ svd.V * svd.scale, A, atol=1e-14)
    np.testing.assert_allclose(
        svd.solve(b), np.linalg.lstsq(A, b, rcond=None)[0], atol=1e-13
    )
    assert len(svd.open) == 0
    assert svd.kernel.shape == (0, 5)
    # no column is as short as what rounding leaves
    units = 10.0 ** np.array((-5.0, -3.0, 0.0, 4.0, 5.0))
    np.testing.assert_allclose(
        ScaledSVD.of(A * units).solve(b) * units, svd.solve(b), rtol=1e-10
    )


def test_scaled_svd_names_what_is_open():
    rng = np.random.default_rng(60)
    A, b = rng.normal(size=(20, 5)), rng.normal(size=20)
    A[:, 1] = 0.0
    A[:, 4] = -3.0 * A[:, 2]
    svd = ScaledSVD.of(A)
    assert svd.open.tolist() == [1, 2, 4]
    assert svd.kernel.shape == (2, 5)
    np.testing.assert_allclose(svd.kernel / svd.scale @ A.T, 0.0, atol=1e-14)
    x = svd.solve(b)
    assert abs(x[1]) < 1e-13
    scaled = A / svd.scale
    # the shortest
    np.testing.assert_allclose(
        x * svd.scale, np.linalg.pinv(scaled, rcond=1e-9) @ b, atol=1e-13
    )
    nothing = ScaledSVD.of(np.zeros((20, 5)))
    assert nothing.open.tolist() == [0, 1, 2, 3, 4]
    assert not nothing.solve(b).any()


def test_what_rounding_leaves_of_a_column_does_not_count():
    """A turn about an axis that the sensor's is within rounding: what is 1e-17 there
    must not tell of inertia."""
    rng = np.random.default_rng(61)
    body = random_body(rng)
    motion, found = random_motion(rng, K), []
    for rest in (0.0, 1e-17):
        axis = np.array((rest, rest, 1.0))
        about = replace(
            motion,
            angular_velocity=motion.angular_velocity * axis,
            angular_acceleration=motion.angular_acceleration * axis,
        )
        noisy = with_wrench(about, body, 0.0, np.random.default_rng(62), 0.1, 0.005)
        found.append(OLS().fit(noisy))
    assert found[1].warnings == found[0].warnings != ()
    np.testing.assert_allclose(
        found[1].parameters.vector, found[0].parameters.vector, atol=1e-9
    )
