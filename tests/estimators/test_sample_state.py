"""The state of both models, and OLS, GEO and PMD on it, against dense matrices of every
sample."""

from dataclasses import replace

import numpy as np
import pytest

from blend_problem import (
    BIAS,
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
from hefting.core.measurements import Measurements
from hefting.core.regressor import full_model_weight
from hefting.estimators import GEO, HPS, OLS, PMD, Bayes, Estimator
from hefting.estimators.quadratic import stacked_factor
from hefting.estimators.sample_state import (
    MODELS,
    SampleState,
    model_weight,
    require_model,
)
from hefting.shapes import Shape
from random_problems import with_wrench


@pytest.fixture(scope="module")
def z() -> Measurements:
    return weighted_samples()


@pytest.fixture(scope="module")
def covariance() -> np.ndarray:
    return correlated_noise()


@pytest.fixture(scope="module")
def shape() -> Shape:
    return random_shape()


# SampleState


@weights
def test_squared_residuals_are_those_of_all_rows(z, w):
    """At any parameters and any bias, by the virtual samples of both models."""
    blend, rng = SampleState.of(z, w), np.random.default_rng(55)
    rows, right = dense(z, w, free_bias=True)
    for _ in range(5):
        unknowns = rng.normal(size=16)
        r = rows @ unknowns - right
        total = 0.0
        for moments, regressor in (
            (blend.reduced, blend.reduced.reduced),
            (blend.full, blend.full.full),
        ):
            part = (
                regressor @ unknowns[6:]
                + moments.ones[:, None] * unknowns[:6]
                - moments.wrench
            )
            total += float(np.sum(part**2))
        assert total == pytest.approx(r @ r, rel=ROUNDING)


def test_weights_of_zero_and_one_leave_the_other_model_alone(z):
    assert SampleState.of(z, 0.0).full.samples == 0
    assert SampleState.of(z, 1.0).reduced.samples == 0
    for scalar, array in (
        (0.0, np.zeros(K)),
        (1.0, np.ones(K)),
        (0.3, np.full(K, 0.3)),
    ):
        a = stacked_factor(SampleState.of(z, scalar))
        b = stacked_factor(SampleState.of(z, array))
        np.testing.assert_allclose(a.T @ a, b.T @ b, atol=1e-13 * np.abs(a.T @ a).max())


@weights
def test_samples_and_duration(z, w):
    assert SampleState.empty().samples == 0
    assert SampleState.empty().duration == 0.0
    blend = SampleState.of(z, w)
    assert (blend.samples, blend.duration) == (K, z.time[-1] - z.time[0])
    part = w if np.ndim(w) == 0 else np.asarray(w)[:20]
    rest = w if np.ndim(w) == 0 else np.asarray(w)[20:]
    for both in (
        SampleState.of(z[:20], part).fold(z[20:], rest),
        SampleState.of(z[20:], rest).merge(SampleState.of(z[:20], part), one_bias=True),
        SampleState.empty().merge(blend).merge(SampleState.empty()),
    ):
        assert (both.samples, both.duration) == (blend.samples, blend.duration)
        a, b = stacked_factor(both), stacked_factor(blend)
        np.testing.assert_allclose(a.T @ a, b.T @ b, atol=1e-13 * np.abs(b.T @ b).max())


def test_folding_changes_nothing_that_was(z):
    blend = SampleState.of(z[:20], 0.5)
    before = stacked_factor(blend).copy()
    blend.fold(z[20:], 0.5)
    blend.merge(SampleState.of(z[20:], 0.5), one_bias=True)
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
    [
        ("half", 300.0, "unknown model 'half'; use full, reduced, blended"),
        ("Full", 300.0, "unknown model"),
    ]
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
    assert warning.startswith(
        "the motion does not determine Jxx, Jxy, Jxz, Jyy, Jyz, Jzz:"
    )
    assert OLS(bias, model="full").fit(z).warnings == ()


@pytest.mark.parametrize("model", MODELS)
def test_geo_is_least_squares_where_its_prior_hardly_pulls(z, shape, covariance, model):
    """On noise-free samples of a body that can exist; mass and centre of mass alone,
    where gravity alone is used."""
    rng = np.random.default_rng(56)
    body = InertialParameters.from_points(
        shape.positions, 0.02 * rng.exponential(size=56)
    )
    static = replace(
        z,
        **{
            name: np.zeros((K, 3))
            for name in ("linear_acceleration", "angular_velocity")
        },
    )
    static = replace(static, angular_acceleration=np.zeros((K, 3)))
    exact = with_wrench(static if model == "reduced" else z, body)
    if model == "blended":  # both models agree only at rest: part of the samples
        still = np.arange(K) % 2 == 0
        arrays = {
            n: np.where(still[:, None], 0.0, getattr(z, n))
            for n in ("linear_acceleration", "angular_velocity")
        }
        arrays["angular_acceleration"] = np.where(
            still[:, None], 0.0, z.angular_acceleration
        )
        exact = with_wrench(replace(z, **arrays), body)
    c1 = 1e-6 if model == "blended" else 300.0  # what moves counts fully
    found = GEO(shape, gamma=1e-6, noise=covariance, model=model, c1=c1).fit(exact)
    length = np.linalg.norm(dense(exact, 1.0, False, covariance)[0], axis=0)
    seen = slice(0, 4 if model == "reduced" else 10)
    wrong = (found.parameters.vector - body.vector)[seen] * length[seen]
    # the prior's pull, 1e-6 times a slope of about one a column, against curvature of
    # length²
    assert np.abs(wrong).max() < 1e-3


def test_geo_blended_is_the_minimum_of_the_dense_objective(z, shape, covariance):
    z, w = (
        replace(z, force=z.force - BIAS[:3], torque=z.torque - BIAS[3:]),
        full_model_weight(z, 10.0),
    )
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
    # changes of the whitened wrench: the objective rises by their squares
    for size in (1e-2, 1e-1):
        for _ in range(20):
            step = rng.normal(size=10)
            assert (
                objective(
                    found.parameters.vector
                    + size * step / np.linalg.norm(step) / length
                )
                > best
            )


@pytest.mark.parametrize("bias", ["none", "estimate"])
@pytest.mark.parametrize(("model", "c1"), [("full", 1e-9), ("reduced", 1e12)])
def test_pmd_full_and_reduced_are_the_limits_of_c1(z, shape, bias, model, c1):
    alone = PMD(shape, bias=bias, model=model).fit(z)
    limit = PMD(shape, c1=c1, bias=bias).fit(z)
    assert alone.certificate is not None
    assert alone.certificate.converged
    # the solver's gap of 3e-7 on masses that lambda alone tells apart; 1 - w and w
    # vanish to 1e-9
    np.testing.assert_allclose(
        alone.point_masses, limit.point_masses, atol=1e-5 * alone.parameters.mass
    )
    other = PMD(shape, c1=10.0, bias=bias).fit(z)
    assert (
        np.abs(other.parameters.vector - alone.parameters.vector).max()
        > 1e-3 * alone.parameters.mass
    )


@pytest.mark.parametrize("model", MODELS)
def test_states_hold_only_what_the_model_needs(z, shape, model):
    estimators: tuple[Estimator, ...] = (
        OLS(model=model),
        GEO(shape, model=model),
        PMD(shape, model=model),
    )
    for estimator in estimators:
        state = estimator.update(estimator.start(), z)
        assert (state.full.samples > 0) == (model != "reduced")
        assert (state.reduced.samples > 0) == (model != "full")


def test_a_state_is_empty_until_it_has_seen_a_sample(z):
    """One that a method leaves out counts as seen: its recording has a bias."""
    shape = replace(random_shape(), labels=np.zeros(random_shape().n, dtype=int))
    none = HPS(shape, max_acceleration=1e-9, max_angular_acceleration=1e-9)
    for estimator, chosen in ((OLS(), len(z)), (none, 0)):
        start = estimator.start()
        assert start.is_empty
        seen = estimator.update(start, z)
        assert seen.samples == chosen
        assert not seen.is_empty
        assert start.merge(seen).samples == seen.merge(start).samples == chosen
        with pytest.raises(InputError, match="a wrench bias of its own"):
            seen.merge(seen)


def test_a_systematic_errors_covariance_is_positive(shape):
    C = np.eye(10)
    C[0, 1] = C[1, 0] = 1.1  # a correlation above one
    with pytest.raises(InputError, match="positive semidefinite"):
        Bayes(shape, systematic=C)
