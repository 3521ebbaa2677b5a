"""RTLS: against total least squares on every sample, and its bias where the
accelerations are noisy."""

from dataclasses import replace

import numpy as np
import pytest

from hefting.core.errors import InputError, NotIdentifiableError
from hefting.core.measurements import Measurements, Noise
from hefting.core.regressor import full_regressor
from hefting.core.spatial import PARAMETERS
from hefting.estimators import OLS, RTLS
from hefting.estimators.rtls import column_levels
from random_problems import random_body, random_motion, with_wrench

WRENCH = Noise(force=0.1, torque=0.005)
NOISE = Noise(
    force=0.1, torque=0.005, linear_acceleration=0.05, angular_acceleration=0.5
)
BIAS = np.array((1.0, -2.0, 3.0, 0.1, -0.2, 0.3))


@pytest.fixture
def z() -> Measurements:
    rng = np.random.default_rng(1)
    clean = with_wrench(random_motion(rng, 200), random_body(rng), BIAS)
    return replace(clean.with_noise(NOISE, 2), noise=None)


# the oracle: all samples, the singular vector itself


def rows(z: Measurements, noise: Noise | None):
    """Regressor (6 K, 10), columns of a bias (6 K, 6) and wrench (6 K,) of all samples,
    whitened and weighted."""
    weight = np.ones(len(z)) if z.weights is None else np.sqrt(z.weights)
    scale = (
        np.ones(6)
        if noise is None
        else np.repeat((1 / noise.force, 1 / noise.torque), 3)
    )
    scale = scale * weight[:, None]
    A = full_regressor(replace(z, weights=None)) * scale[:, :, None]
    C = np.eye(6) * scale[:, :, None]
    return A.reshape(-1, 10), C.reshape(-1, 6), (z.wrench * scale).ravel()


def levels_by_simulation(noise: Noise) -> np.ndarray:
    """Root-mean-square error (10,) of the whitened regressor's columns, from 20,000
    noisy samples at rest."""
    still = random_motion(np.random.default_rng(3), 20_000, speed=0.0)
    noisy = still.with_noise(replace(noise, force=0.0, torque=0.0), 4)
    scale = np.repeat((1 / noise.force, 1 / noise.torque), 3)
    error = (full_regressor(noisy) - full_regressor(still)) * scale[:, None]
    return np.sqrt(np.mean(error**2, axis=(0, 1)))


def total_least_squares(A, exact, b, levels):
    """Mixed total least squares: parameters (10,), those of the exact columns, the
    squared singular value."""
    Q = np.linalg.qr(exact)[0] if exact.shape[1] else exact
    stacked = np.column_stack((A / levels, b))
    _, S, V = np.linalg.svd(stacked - Q @ (Q.T @ stacked), full_matrices=False)
    parameters = -V[-1, :10] / V[-1, 10] / levels
    others = (
        np.linalg.lstsq(exact, b - A @ parameters, rcond=None)[0]
        if exact.shape[1]
        else np.zeros(0)
    )
    return parameters, others, S[-1] ** 2


def quotient(A, exact, b, levels, parameters, others) -> float:
    """What total least squares minimises: |residual|² / (1 + |D phi|²)."""
    residual = A @ parameters + exact @ others - b
    return residual @ residual / (1 + np.sum((levels * parameters) ** 2))


def assert_agrees(found, A, exact, b, levels, free_bias: bool):
    expected, others, square = total_least_squares(A, exact, b, levels)
    size, lengths = np.linalg.norm(b), np.linalg.norm(A, axis=0)
    # double precision times the conditioning of the columns, far below
    np.testing.assert_allclose(
        found.parameters.vector * lengths, expected * lengths, atol=1e-8 * size
    )
    if free_bias:
        np.testing.assert_allclose(found.bias, others, atol=1e-8 * np.abs(others).max())
    else:
        assert found.bias is None
    certificate = found.certificate
    own = quotient(A, exact, b, levels, found.parameters.vector, others)
    # squares of rounding
    assert certificate.objective == pytest.approx(own, rel=1e-8, abs=1e-24 * size**2)
    assert certificate.objective == pytest.approx(square, rel=1e-8, abs=1e-24 * size**2)
    assert certificate.bound <= square * (1 + 1e-10) + 1e-24 * size**2
    assert certificate.bound <= certificate.objective
    assert certificate.gap <= 1e-10 * square + 1e-24 * size**2


@pytest.mark.parametrize("bias", ["none", "estimate"])
@pytest.mark.parametrize("noise", [None, NOISE])
@pytest.mark.parametrize("weighted", [False, True])
def test_equals_the_singular_vector_of_every_sample(z, bias, noise, weighted):
    if weighted:
        z = replace(z, weights=np.random.default_rng(5).uniform(size=len(z)))
    A, C, b = rows(z, noise)
    levels = np.ones(10) if noise is None else column_levels(noise)
    exact = C if bias == "estimate" else C[:, :0]
    found = RTLS(bias, noise).fit(z)
    assert_agrees(found, A, exact, b, levels, bias == "estimate")
    assert (found.samples, found.duration, found.warnings) == (
        200,
        pytest.approx(1.99),
        (),
    )


@pytest.mark.parametrize(
    "noise",
    [
        NOISE,
        replace(NOISE, linear_acceleration=0.0),
        replace(NOISE, angular_acceleration=0.0),
    ],
)
def test_column_levels_are_those_of_the_accelerations_noise(noise):
    """Each is the mean of at least 20,000 squares, so known to 1/sqrt(40,000) = 0.5 %;
    five of them."""
    np.testing.assert_allclose(
        column_levels(noise), levels_by_simulation(noise), rtol=0.025, atol=1e-12
    )


@pytest.mark.parametrize("bias", ["none", "estimate"])
def test_without_noise_in_a_column_it_is_exact(z, bias):
    """Linear accelerations alone leave the columns of the inertia exact, and no noise
    at all leaves them all."""
    noise = replace(WRENCH, linear_acceleration=0.05)
    A, C, b = rows(z, noise)
    levels = column_levels(noise)
    np.testing.assert_array_equal(levels[4:], 0.0)
    exact = np.hstack((A[:, 4:], C)) if bias == "estimate" else A[:, 4:]
    Q = np.linalg.qr(exact)[0]
    stacked = np.column_stack((A[:, :4] / levels[:4], b))
    V = np.linalg.svd(stacked - Q @ (Q.T @ stacked), full_matrices=False)[2]
    first = -V[-1, :4] / V[-1, 4] / levels[:4]
    others = np.linalg.lstsq(exact, b - A[:, :4] @ first, rcond=None)[0]
    found = RTLS(bias, noise).fit(z).parameters.vector * np.linalg.norm(A, axis=0)
    expected = np.concatenate((first, others[:6])) * np.linalg.norm(A, axis=0)
    np.testing.assert_allclose(found, expected, atol=1e-8 * np.linalg.norm(b))


@pytest.mark.parametrize("bias", ["none", "estimate"])
def test_without_noise_of_the_accelerations_it_is_least_squares(z, bias):
    expected, found = OLS(bias, WRENCH).fit(z), RTLS(bias, WRENCH).fit(z)
    scale = np.sqrt(expected.covariance.diagonal())
    np.testing.assert_allclose(
        found.parameters.vector / scale, expected.parameters.vector / scale, atol=1e-8
    )
    if bias == "estimate":
        np.testing.assert_allclose(found.bias, expected.bias, atol=1e-9)
    assert found.certificate.objective == pytest.approx(
        expected.certificate.objective, rel=1e-9
    )
    # and the limit is reached smoothly: the columns' noise enters by its square
    near = RTLS(
        bias, replace(WRENCH, linear_acceleration=1e-6, angular_acceleration=1e-6)
    ).fit(z)
    np.testing.assert_allclose(
        near.parameters.vector / scale, expected.parameters.vector / scale, atol=1e-6
    )


def test_streaming_merging_and_batch_agree(z):
    estimator = RTLS("estimate", NOISE)
    batch = estimator.fit(z)
    single = estimator.start()
    for k in range(len(z)):
        single = estimator.update(single, z[k : k + 1])
    halves = [estimator.update(estimator.start(), z[i::2]) for i in (0, 1)]
    scale = np.sqrt(OLS("estimate", NOISE).fit(z).covariance.diagonal())
    both = [estimator.merge(*p, one_bias=True) for p in (halves, halves[::-1])]
    for state in (single, *both):
        found = estimator.estimate(state)
        # rounding, far below one standard deviation
        np.testing.assert_allclose(
            found.parameters.vector / scale, batch.parameters.vector / scale, atol=1e-8
        )
        np.testing.assert_allclose(found.bias, batch.bias, atol=1e-9)
        assert (found.samples, found.duration) == (batch.samples, batch.duration)


@pytest.mark.parametrize("bias", ["none", "estimate"])
@pytest.mark.parametrize("noise", [None, NOISE])
def test_recovers_noise_free_parameters(bias, noise):
    rng = np.random.default_rng(6)
    for mass, size in ((1e-3, 0.01), (1.0, 0.1), (50.0, 1.0)):
        body = random_body(rng, mass, size, size)
        z = with_wrench(
            random_motion(rng, 100, speed=3.0),
            body,
            BIAS if bias == "estimate" else 0.0,
        )
        A, _, b = rows(z, noise)
        found = RTLS(bias, noise).fit(z)
        # conditioning of the unscaled columns, about a hundred, times rounding of the
        # wrench, the bias included
        error = np.abs(found.parameters.vector - body.vector) * np.linalg.norm(
            A, axis=0
        )
        assert error.max() < 1e-11 * np.linalg.norm(b)
        assert found.warnings == ()
        assert (
            0.0
            <= found.certificate.bound
            <= found.certificate.objective
            <= 1e-22 * (b @ b)
        )
        if bias == "estimate":
            np.testing.assert_allclose(found.bias, BIAS, atol=1e-10)


# what the motion leaves open


@pytest.mark.parametrize("bias", ["none", "estimate"])
@pytest.mark.parametrize(
    "noise", [None, NOISE, WRENCH, replace(WRENCH, linear_acceleration=0.05)]
)
def test_at_rest_the_inertia_is_undetermined(bias, noise):
    """Also where some columns are exact and vanish: they may not take equations from
    the others."""
    rng = np.random.default_rng(7)
    body = random_body(rng)
    z = with_wrench(
        random_motion(rng, 20, speed=0.0),
        body,
        BIAS if bias == "estimate" else 0.0,
        rng,
        1e-6,
        1e-6,
    )
    found = RTLS(bias, noise).fit(z)
    assert len(found.warnings) == 1
    assert found.warnings[0].split("determine ")[1].split(":")[0].split(", ") == list(
        PARAMETERS[4:]
    )
    # rounding of ten newtons
    np.testing.assert_allclose(found.parameters.vector[4:], 0.0, atol=1e-12)
    # noise of a micronewton against ten newtons for each kilogram
    np.testing.assert_allclose(found.parameters.vector[:4], body.vector[:4], atol=1e-6)
    A, C, b = rows(z, noise)
    others = np.linalg.lstsq(C, b - A @ found.parameters.vector, rcond=None)[0] * (
        bias == "estimate"
    )
    levels = np.ones(10) if noise is None else column_levels(noise)
    own = quotient(A, C, b, levels, found.parameters.vector, others)
    # differences of tens of newtons, to rounding
    assert found.certificate.objective == pytest.approx(own, rel=1e-6)


def test_one_orientation_is_the_shortest_solution():
    """Of one sample all solutions fit; the shortest is that of the pseudo-inverse."""
    rng = np.random.default_rng(8)
    z = with_wrench(random_motion(rng, 1), random_body(rng))
    A, _, b = rows(z, None)
    found = RTLS().fit(z)
    np.testing.assert_allclose(
        found.parameters.vector, np.linalg.pinv(A) @ b, atol=1e-12
    )
    assert "does not determine" in found.warnings[0]


def test_one_orientation_beside_a_bias_determines_nothing():
    rng = np.random.default_rng(9)
    one = random_motion(rng, 1, speed=0.0)[np.zeros(30, dtype=int)]
    for noise in (None, NOISE, WRENCH):
        found = RTLS("estimate", noise).fit(
            with_wrench(one, random_body(rng), BIAS, rng, 1e-6, 1e-6)
        )
        assert all(name in found.warnings[0] for name in PARAMETERS)
        # no rounding taken for a measurement
        assert np.abs(found.parameters.vector).max() < 10.0


def test_no_samples():
    with pytest.raises(NotIdentifiableError, match="no samples"):
        RTLS().estimate(RTLS().start())


def test_no_finite_solution():
    """A large wrench that no parameters explain in part: changing the regressor to
    nothing is cheaper."""
    rng = np.random.default_rng(10)
    z = random_motion(rng, 40)
    A, _, _ = rows(z, None)
    noise = 1e4 * rng.normal(size=len(A))
    for _ in range(2):  # twice, or rounding is explained
        noise -= A @ np.linalg.lstsq(A, noise, rcond=None)[0]
    wrench = noise.reshape(-1, 6)
    with pytest.raises(NotIdentifiableError, match="no finite solution"):
        RTLS().fit(replace(z, force=wrench[:, :3], torque=wrench[:, 3:]))


# why there is such a method


def test_noise_in_the_accelerations_biases_it_less():
    """Forty runs of 2,000 samples, accelerations as noisy as they are large.

    Noise in a column attenuates its parameter by the share it has of the column's
    square, a half for the inertia; total least squares is consistent with the right
    levels. What its mean is off by must then be chance, five standard errors at the
    most, and least squares' at least twenty.
    """
    rng = np.random.default_rng(11)
    noise = Noise(
        force=0.1, torque=0.005, linear_acceleration=0.3, angular_acceleration=1.0
    )
    body = random_body(rng)
    clean = with_wrench(random_motion(rng, 2000), body)
    errors = {"OLS": [], "RTLS": []}
    for seed in range(40):
        noisy = clean.with_noise(noise, [12, seed])
        for estimator in (OLS(noise=noise), RTLS(noise=noise)):
            errors[estimator.name].append(
                estimator.fit(noisy).parameters.vector - body.vector
            )
    bias = {name: np.mean(values, axis=0) for name, values in errors.items()}
    standard = np.std(errors["RTLS"], axis=0) / np.sqrt(40)
    inertia = np.linalg.norm(bias["OLS"][4:]), np.linalg.norm(bias["RTLS"][4:])
    print(f"bias of the inertia: OLS {inertia[0]:.4f}, RTLS {inertia[1]:.4f} kg m²")
    assert (np.abs(bias["RTLS"]) < 5 * standard).all()
    assert np.abs(bias["OLS"] / standard).max() > 20
    assert inertia[1] < 0.1 * inertia[0]


# input


def test_hyperparameters_are_checked():
    with pytest.raises(InputError, match="bias model"):
        RTLS(bias="some")  # type: ignore[arg-type]
    wrong = [Noise(), Noise(0.1, 0.0), Noise(-0.1, 0.1), Noise(np.nan, 0.1)]
    wrong += [
        Noise(0.1, 0.1, -0.1),
        Noise(0.1, 0.1, 0.0, np.nan),
        Noise(0.1, 0.1, np.inf),
        np.eye(6),
    ]
    for noise in wrong:
        with pytest.raises(InputError, match="noise"):
            RTLS(noise=noise)  # type: ignore[arg-type]
