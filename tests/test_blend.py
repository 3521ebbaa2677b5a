"""Blend and what is built on it: both models, the quadratic of all samples, against dense matrices of every sample."""

from dataclasses import replace

import numpy as np
import pytest

from hefting.errors import InputError
from hefting.estimators import GEO, OLS, PMD, Estimator
from hefting.estimators.blend import MODELS, Blend, model_weight, require_model
from hefting.estimators.quadratic import Quadratic, ScaledSVD, stacked_factor, whitening
from hefting.inertia import InertialParameters
from hefting.measurements import Measurements, Noise
from hefting.regressor import full_model_weight, full_regressor, reduced_regressor
from hefting.shapes import PointMasses
from random_problems import random_body, random_motion, with_wrench

ROUNDING = 1e-11
"""Of sums over 60 samples and orthogonal transformations of them, 1e-14, times the conditioning of the regressor's
scaled columns, about ten, and a margin."""
BIAS = np.array((3.0, -7.0, 11.0, 0.5, -1.0, 2.0))
K = 60


@pytest.fixture(scope="module")
def z() -> Measurements:
    """Slow and fast samples, of unequal weight, with a bias."""
    rng = np.random.default_rng(51)
    motion = random_motion(rng, K)
    speed = 10.0 ** rng.uniform(-1.0, 0.5, (K, 1))
    motion = replace(
        motion,
        linear_acceleration=speed * motion.linear_acceleration,
        angular_velocity=speed * motion.angular_velocity,
        angular_acceleration=speed * motion.angular_acceleration,
        weights=rng.uniform(0.2, 2.0, K),
    )
    return with_wrench(motion, random_body(rng), BIAS, rng, 0.1, 0.005)


@pytest.fixture(scope="module")
def covariance() -> np.ndarray:
    """Correlated wrench noise of 0.1 N and 0.005 N m."""
    rng = np.random.default_rng(52)
    scale = np.repeat((0.1, 0.005), 3)
    return np.cov(rng.normal(size=(6, 20))) * np.outer(scale, scale)


@pytest.fixture(scope="module")
def shape() -> PointMasses:
    return PointMasses(np.random.default_rng(53).uniform(-0.1, 0.2, (56, 3)))


WEIGHTS = {
    "reduced": 0.0,
    "full": 1.0,
    "half": 0.5,
    "arrays": np.random.default_rng(54).uniform(size=K),
    "zeros and ones": (np.arange(K) % 2).astype(float),
}
weights = pytest.mark.parametrize("w", WEIGHTS.values(), ids=WEIGHTS)


def dense(z: Measurements, w: np.ndarray | float, free_bias: bool, S: np.ndarray | None = None):
    """Rows [D(1-w) Ã; D(w) A] (12 K, 10) and right-hand side (12 K,), whitened; bias columns first where it is free."""
    root = np.ones(K) if z.weights is None else np.sqrt(z.weights)
    W = np.eye(6) if S is None else np.linalg.inv(np.linalg.cholesky(S))
    plain = replace(z, weights=None)
    columns, right = [], []
    for share, A in (
        (1.0 - np.broadcast_to(w, K), reduced_regressor(plain)),
        (np.broadcast_to(w, K), full_regressor(plain)),
    ):
        if free_bias:
            A = np.concatenate((np.broadcast_to(np.eye(6), (K, 6, 6)), A), axis=2)
        scale = (share * root)[:, None, None] * W
        columns.append((scale @ A).reshape(6 * K, -1))
        right.append((scale @ z.wrench[:, :, None]).ravel())
    return np.vstack(columns), np.concatenate(right)


def levels_of(noise: Noise | np.ndarray | None) -> np.ndarray | None:
    return np.diag(np.repeat((noise.force, noise.torque), 3)) ** 2 if isinstance(noise, Noise) else noise


# Blend


@weights
def test_squared_residuals_are_those_of_all_rows(z, w):
    """At any parameters and any bias, by the virtual samples of both models."""
    blend, rng = Blend.of(z, w), np.random.default_rng(55)
    rows, right = dense(z, w, free_bias=True)
    for _ in range(5):
        unknowns = rng.normal(size=16)
        r = rows @ unknowns - right
        total = 0.0
        for moments, regressor in ((blend.reduced, blend.reduced.reduced), (blend.full, blend.full.full)):
            part = regressor @ unknowns[6:] + moments.ones[:, None] * unknowns[:6] - moments.wrench
            total += float(np.sum(part**2))
        assert total == pytest.approx(r @ r, rel=ROUNDING)


def test_weights_of_zero_and_one_leave_the_other_model_alone(z):
    assert Blend.of(z, 0.0).full.samples == 0
    assert Blend.of(z, 1.0).reduced.samples == 0
    for scalar, array in ((0.0, np.zeros(K)), (1.0, np.ones(K)), (0.3, np.full(K, 0.3))):
        a, b = stacked_factor(Blend.of(z, scalar)), stacked_factor(Blend.of(z, array))
        np.testing.assert_allclose(a.T @ a, b.T @ b, atol=1e-13 * np.abs(a.T @ a).max())


@weights
def test_samples_and_duration(z, w):
    assert Blend.empty().samples == 0
    assert Blend.empty().duration == 0.0
    blend = Blend.of(z, w)
    assert (blend.samples, blend.duration) == (K, z.time[-1] - z.time[0])
    part = w if np.ndim(w) == 0 else np.asarray(w)[:20]
    rest = w if np.ndim(w) == 0 else np.asarray(w)[20:]
    for both in (
        Blend.of(z[:20], part).fold(z[20:], rest),
        Blend.of(z[20:], rest).merge(Blend.of(z[:20], part)),
        Blend.empty().merge(blend).merge(Blend.empty()),
    ):
        assert (both.samples, both.duration) == (blend.samples, blend.duration)
        a, b = stacked_factor(both), stacked_factor(blend)
        np.testing.assert_allclose(a.T @ a, b.T @ b, atol=1e-13 * np.abs(b.T @ b).max())


def test_folding_changes_nothing_that_was(z):
    blend = Blend.of(z[:20], 0.5)
    before = stacked_factor(blend).copy()
    blend.fold(z[20:], 0.5)
    blend.merge(Blend.of(z[20:], 0.5))
    np.testing.assert_array_equal(stacked_factor(blend), before)


def test_model_weight(z):
    assert model_weight(z, "full", 300.0) == 1.0
    assert model_weight(z, "reduced", 300.0) == 0.0
    w = model_weight(z, "blended", 10.0)
    np.testing.assert_array_equal(w, full_model_weight(z, 10.0))
    assert 0.0 < np.min(w) < 0.1
    assert np.max(w) > 0.9
    assert set(MODELS) == {"full", "reduced", "blended"}


@pytest.mark.parametrize(
    ("model", "c1", "message"),
    [("half", 300.0, "unknown model 'half'; use full, reduced, blended"), ("Full", 300.0, "unknown model")]
    + [("blended", c1, "c1 must be positive") for c1 in (0.0, -1.0, np.inf, np.nan)],
)
def test_unknown_models_and_impossible_c1_are_refused(shape, model, c1, message):
    makers = (
        lambda: require_model(model, c1),
        lambda: OLS(model=model, c1=c1),
        lambda: GEO(shape, model=model, c1=c1),
        lambda: PMD(shape, model=model, c1=c1),
    )
    for make in makers:
        with pytest.raises(InputError, match=message) as caught:
            make()
        assert "\n" not in str(caught.value)


# models of OLS, GEO and PMD


@pytest.mark.parametrize("model", MODELS)
@pytest.mark.parametrize("noise", [None, "covariance"])
@pytest.mark.parametrize("bias", ["none", "estimate"])
def test_ols_is_dense_least_squares_of_both_models(z, covariance, model, noise, bias):
    S = None if noise is None else covariance
    w = {"full": 1.0, "reduced": 0.0, "blended": full_model_weight(z, 10.0)}[model]
    rows, right = dense(z, w, bias == "estimate", S)
    n = 6 if bias == "estimate" else 0
    seen = n + (4 if model == "reduced" else 10)
    expected, *_ = np.linalg.lstsq(rows[:, :seen], right, rcond=None)
    found = OLS(bias, S, model, c1=10.0).fit(z)
    vector = np.pad(expected[n:], (0, 16 - 6 - len(expected[n:])))
    length = np.linalg.norm(rows, axis=0)  # a parameter's error by the wrench it makes
    wrong = (found.parameters.vector - vector) * length[n:]
    assert np.abs(wrong).max() < ROUNDING * np.linalg.norm(right)
    r = rows[:, :seen] @ expected - right
    assert found.certificate is not None
    assert found.certificate.objective == pytest.approx(r @ r, rel=1e-9)
    if n:
        np.testing.assert_allclose(np.asarray(found.bias), expected[:6], atol=1e-9)
    else:
        assert found.bias is None


@pytest.mark.parametrize("bias", ["none", "estimate"])
def test_reduced_ols_leaves_the_inertia_open(z, bias):
    found = OLS(bias, model="reduced").fit(z)
    assert found.covariance is not None
    assert np.isinf(found.covariance.diagonal()).tolist() == [False] * 4 + [True] * 6
    (warning,) = found.warnings
    assert warning.startswith("the motion does not determine Jxx, Jxy, Jxz, Jyy, Jyz, Jzz:")
    assert OLS(bias, model="full").fit(z).warnings == ()


@pytest.mark.parametrize("model", MODELS)
def test_geo_is_least_squares_where_its_prior_hardly_pulls(z, shape, covariance, model):
    """On noise-free samples of a body that can exist; mass and centre of mass alone, where gravity alone is used."""
    rng = np.random.default_rng(56)
    body = InertialParameters.from_points(shape.positions, 0.02 * rng.exponential(size=56))
    static = replace(z, **{name: np.zeros((K, 3)) for name in ("linear_acceleration", "angular_velocity")})
    static = replace(static, angular_acceleration=np.zeros((K, 3)))
    exact = with_wrench(static if model == "reduced" else z, body)
    if model == "blended":  # both models agree only at rest: part of the samples
        still = np.arange(K) % 2 == 0
        arrays = {n: np.where(still[:, None], 0.0, getattr(z, n)) for n in ("linear_acceleration", "angular_velocity")}
        arrays["angular_acceleration"] = np.where(still[:, None], 0.0, z.angular_acceleration)
        exact = with_wrench(replace(z, **arrays), body)
    c1 = 1e-6 if model == "blended" else 300.0  # what moves counts fully
    found = GEO(shape, gamma=1e-6, noise=covariance, model=model, c1=c1).fit(exact)
    length = np.linalg.norm(dense(exact, 1.0, False, covariance)[0], axis=0)
    seen = slice(0, 4 if model == "reduced" else 10)
    wrong = (found.parameters.vector - body.vector)[seen] * length[seen]
    # the prior's pull, 1e-6 times a slope of about one a column, against curvature of length²
    assert np.abs(wrong).max() < 1e-3


def test_geo_blended_is_the_minimum_of_the_dense_objective(z, shape, covariance):
    z, w = replace(z, force=z.force - BIAS[:3], torque=z.torque - BIAS[3:]), full_model_weight(z, 10.0)
    rows, right = dense(z, w, False, covariance)
    geo = GEO(shape, gamma=30.0, noise=covariance, model="blended", c1=10.0)
    found = geo.fit(z)
    least, *_ = np.linalg.lstsq(rows, right, rcond=None)
    P0 = InertialParameters(least[0] * shape.homogeneous.vector).pseudo_inertia

    def objective(vector: np.ndarray) -> float:
        r, P = rows @ vector - right, InertialParameters(vector).pseudo_inertia
        if np.linalg.eigvalsh(P)[0] <= 0.0:
            return np.inf
        X = np.linalg.solve(P0, P)
        return float(r @ r + 30.0 * (np.trace(X) - np.linalg.slogdet(X)[1] - 4.0))

    best = objective(found.parameters.vector)
    assert found.certificate is not None
    assert found.certificate.objective == pytest.approx(best, rel=1e-9)
    rng = np.random.default_rng(57)
    length = np.linalg.norm(rows, axis=0)
    for size in (1e-2, 1e-1):  # changes of the whitened wrench: the objective rises by their squares
        for _ in range(20):
            step = rng.normal(size=10)
            assert objective(found.parameters.vector + size * step / np.linalg.norm(step) / length) > best


@pytest.mark.parametrize("bias", ["none", "estimate"])
@pytest.mark.parametrize(("model", "c1"), [("full", 1e-9), ("reduced", 1e12)])
def test_pmd_full_and_reduced_are_the_limits_of_c1(z, shape, bias, model, c1):
    alone = PMD(shape, bias=bias, model=model).fit(z)
    limit = PMD(shape, c1=c1, bias=bias).fit(z)
    assert alone.certificate is not None
    assert alone.certificate.converged
    # the solver's gap of 3e-7 on masses that lambda alone tells apart; 1 - w and w vanish to 1e-9
    np.testing.assert_allclose(alone.point_masses, limit.point_masses, atol=1e-5 * alone.parameters.mass)
    other = PMD(shape, c1=10.0, bias=bias).fit(z)
    assert np.abs(other.parameters.vector - alone.parameters.vector).max() > 1e-3 * alone.parameters.mass


@pytest.mark.parametrize("model", MODELS)
def test_states_hold_only_what_the_model_needs(z, shape, model):
    estimators: tuple[Estimator, ...] = (OLS(model=model), GEO(shape, model=model), PMD(shape, model=model))
    for estimator in estimators:
        state = estimator.update(estimator.start(), z)
        assert (state.full.samples > 0) == (model != "reduced")
        assert (state.reduced.samples > 0) == (model != "full")


# Quadratic


NOISES = {"none": None, "levels": Noise(0.1, 0.005), "covariance": "covariance"}


@weights
@pytest.mark.parametrize("kind", NOISES)
@pytest.mark.parametrize("free_bias", [False, True])
def test_quadratic_is_the_projection_of_all_rows(z, covariance, w, kind, free_bias):
    """Its square at any parameters is that of all rows, with the best bias; `bias` is the best bias."""
    noise = covariance if kind == "covariance" else NOISES[kind]
    S = levels_of(noise)
    q = Quadratic.of(Blend.of(z, w), noise, free_bias)
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
        # what is left of a wrench that the bias mostly explains is rounded like the whole
        assert q.square(vector) == pytest.approx(r @ r, rel=ROUNDING, abs=ROUNDING * float(right @ right))
        assert np.sum((q.A @ vector - q.b) ** 2) == pytest.approx(q.square(vector), rel=1e-14)
    assert q.size == pytest.approx(np.sqrt(q.square(np.zeros(10))), rel=1e-14)
    seen = 6 * free_bias + (4 if isinstance(w, float) and w == 0.0 else 10)
    expected = np.linalg.lstsq(rows[:, :seen], right, rcond=None)[0][6 * free_bias :]
    length = np.linalg.norm(rows, axis=0)[6 * free_bias :]
    wrong = (q.least_squares() - np.pad(expected, (0, 10 - len(expected)))) * length
    assert np.abs(wrong).max() < ROUNDING * np.linalg.norm(right)


def test_the_measured_mass_is_positive_whatever_is_measured(z, shape):
    homogeneous = shape.homogeneous.vector
    assert Quadratic.of(Blend.of(z), None, True).measured_mass(homogeneous) == pytest.approx(
        OLS("estimate").fit(z).parameters.mass, rel=ROUNDING
    )
    zero = replace(z, force=np.zeros((K, 3)), torque=np.zeros((K, 3)))
    upward = with_wrench(z, InertialParameters(-homogeneous))
    weightless = replace(zero, gravity=np.zeros((K, 3)), linear_acceleration=np.zeros((K, 3)))
    for case in (zero, upward, weightless):
        assert Quadratic.of(Blend.of(case)).measured_mass(homogeneous) > 0.0


def test_without_samples_the_quadratic_is_zero():
    for free_bias in (False, True):
        q = Quadratic.of(Blend.empty(), None, free_bias)
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
    np.testing.assert_allclose(np.asarray(whitening(far_apart)), np.diag(far_apart.diagonal() ** -0.5), rtol=1e-12)


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
    for make in (lambda: whitening(noise), lambda: OLS(noise=noise), lambda: GEO(shape, noise=noise)):
        with pytest.raises(InputError, match=message) as caught:
            make()
        assert "\n" not in str(caught.value)


# ScaledSVD


def test_scaled_svd_solves_in_any_units():
    rng = np.random.default_rng(59)
    A, b = rng.normal(size=(20, 5)), rng.normal(size=20)
    svd = ScaledSVD.of(A)
    np.testing.assert_allclose((svd.U * svd.S) @ svd.V * svd.scale, A, atol=1e-14)
    np.testing.assert_allclose(svd.solve(b), np.linalg.lstsq(A, b, rcond=None)[0], atol=1e-13)
    assert len(svd.open) == 0
    assert svd.kernel.shape == (0, 5)
    units = 10.0 ** np.array((-5.0, -3.0, 0.0, 4.0, 5.0))  # no column is as short as what rounding leaves
    np.testing.assert_allclose(ScaledSVD.of(A * units).solve(b) * units, svd.solve(b), rtol=1e-10)


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
    np.testing.assert_allclose(x * svd.scale, np.linalg.pinv(scaled, rcond=1e-9) @ b, atol=1e-13)  # the shortest
    nothing = ScaledSVD.of(np.zeros((20, 5)))
    assert nothing.open.tolist() == [0, 1, 2, 3, 4]
    assert not nothing.solve(b).any()


def test_what_rounding_leaves_of_a_column_does_not_count():
    """A turn about an axis that the sensor's is within rounding: what is 1e-17 there must not tell of inertia."""
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
    np.testing.assert_allclose(found[1].parameters.vector, found[0].parameters.vector, atol=1e-9)
