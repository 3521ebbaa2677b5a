"""What is worth a search for mistakes: residuals that are no white noise, and for some
that a function of the motion explains them."""

from dataclasses import replace

import numpy as np
import pytest
from benchmarks.given import Given, correct
from benchmarks.mistaken import mistakes

from given_cases import case_of
from hefting.core.measurements import Measurements
from hefting.core.recording import Stream
from hefting.core.regressor import full_regressor
from hefting.core.spatial import interpolated, rotation_by
from hefting.ingest.model import tangents_of
from hefting.ingest.rivals import (
    LARGE_EXPLANATIONS,
    LINEAR_EXPLANATIONS,
    judge,
    units,
    wrench_compensated,
)
from hefting.ingest.rivals import judge as judging
from hefting.ingest.rivals.case import Case
from hefting.ingest.rivals.evidence import (
    NEGLIGIBLE_UNEXPLAINED,
    Fitted,
    LinearPart,
    correlation,
    fit_rows,
    is_hopeless,
    linear_step,
    missing,
)
from hefting.ingest.rivals.explanation import (
    Explanation,
    as_given,
    explained_by_motion,
)
from hefting.ingest.rivals.judge import (
    POSSIBLE_EVIDENCE,
    _is_named,
    _is_white,
    _is_worth_a_search,
    _more_candidates,
    _promising,
    evidence,
)
from hefting.ingest.rivals.small_mistakes import _small_mistakes


@pytest.fixture(scope="module")
def case() -> Case:
    return case_of(correct(0))


def with_residuals(fitted: Fitted, memory: float) -> Fitted:
    """The fit with residuals of first order."""
    rng = np.random.default_rng(3)
    noise = rng.normal(size=fitted.residual.shape)
    for k in range(1, noise.shape[1]):
        noise[:, k] += memory * noise[:, k - 1]
    size = np.repeat(fitted.scale, 3, axis=1)[:, None]
    return replace(fitted, residual=noise * size, weights=np.ones_like(fitted.weights))


@pytest.mark.parametrize(("memory", "white"), [(0.0, True), (0.7, False)])
def test_noise_of_first_order_is_not_white(case, memory, white):
    """Samples that count as one are (1 + r) / (1 - r): 1 and 5.7, told from 1.5 on."""
    fitted = with_residuals(as_given(case).fitted, memory)
    assert correlation(fitted) == pytest.approx(
        (1.0 + memory) / (1.0 - memory), rel=0.3
    )
    assert _is_white(fitted) is white


def test_coloured_residuals_that_noise_does_not_explain_are_worth_a_search(case):
    """Small as they are against the wrench's changes, and like no small mistake."""
    fitted = as_given(case).fitted.of_best()
    worse = replace(fitted, likelihood=fitted.likelihood - 5.0)
    assert not _is_worth_a_search(case, with_residuals(worse, 0.0), 0.01)
    assert not _is_worth_a_search(case, with_residuals(fitted, 0.6), 0.01)
    assert _is_worth_a_search(case, with_residuals(worse, 0.6), 0.01)
    assert _is_worth_a_search(case, with_residuals(fitted, 0.0), 0.11)


@pytest.mark.parametrize(("above", "worth"), [(0.99, False), (1.01, True)])
def test_what_a_small_mistake_would_explain_is_worth_a_search(
    case, above, worth, monkeypatch
):
    """Though it leaves little, and residuals that are white."""
    fitted = with_residuals(as_given(case).fitted.of_best(), 0.0)
    monkeypatch.setattr(judging, "score", lambda *_: above * judging.CLEAR_SCORE)
    assert _is_worth_a_search(case, fitted, 0.01) is worth


LINEAR_MISTAKES = {
    "turned about z": "30°",
    "axis flipped": "all torques",
    "unit of torque": "N cm",
    "torque about the TCP": "150 mm",
    "base tilted": "15°",
    "compensated wrench": "60% of the payload",
    "gain of one axis": "10%",
    "time": "half as fast",
}


@pytest.mark.parametrize("name", LINEAR_MISTAKES)
def test_no_mistake_that_is_linear_in_the_motion_explains_more_than_free_channels(name):
    """The likelihood of any linear functions, less 0.01 for what reweighting leaves."""
    mistake = next(
        each
        for each in mistakes()
        if each.name == name and each.strength == LINEAR_MISTAKES[name]
    )
    case = case_of(mistake.make(correct(0), np.random.default_rng(1)))
    *_, (free, _) = explained_by_motion(case)
    found = [explain(case) for explain in LINEAR_EXPLANATIONS]
    likelihoods = [each.likelihood for each in found if each is not None]
    assert max(likelihoods) < free.likelihood[free.best] + 0.01


def test_units_explain_no_more_than_models_of_which_they_are_special_cases(case):
    """The likelihood of each, less 0.01 for what reweighting leaves."""
    motion = case.motion_as_found
    freed = fit_rows(case, wrench_compensated.freed(case, motion))
    for unit in units.RATIOS:
        fitted = fit_rows(case, units._with_time_in(case, unit)(motion))
        assert fitted.likelihood[0] < freed.likelihood[0] + 0.01
    maps = units._maps_of_two_moments()
    freed = fit_rows(case, units._with_maps(case, maps, motion))
    for ratio in (0.1, 0.3, 3.0, 10.0):
        fitted = fit_rows(case, units._with_torque_in(case, ratio)(motion))
        assert fitted.likelihood[0] < freed.likelihood[0] + 0.01


@pytest.mark.parametrize(("memory", "looked_at"), [(0.0, []), (0.9, [63])])
def test_mistakes_are_first_looked_for_in_some_of_averages_that_are_alike(
    case, memory, looked_at
):
    """Of noise whose correlation is 19 samples in every fourth of 250."""
    seen: list[int] = []

    def explain(case: Case) -> Explanation | None:
        seen.append(len(case.time))

    given = as_given(case)
    coloured = replace(given, fitted=with_residuals(given.fitted, memory))
    promising = _promising(case, coloured, (explain,))
    assert seen == looked_at
    assert promising == (() if looked_at else (explain,))


def with_a_push(given: Given, size: float) -> Given:
    """With a force that comes and goes twice a second, whatever the sensor does."""
    wrench = given.recording["wrench"]
    push = np.sin(2.0 * np.pi * 2.0 * wrench.time + 3.0 * np.sin(0.7 * wrench.time))
    values = wrench.values + size * push[:, None] * (1.0, -0.5, 0.7, 0.1, 0.1, -0.05)
    streams = {**given.recording.streams, "wrench": Stream(wrench.time, values)}
    return replace(given, recording=replace(given.recording, streams=streams))


@pytest.mark.parametrize("pushed", [True, False])
def test_mistakes_are_not_looked_for_where_no_function_of_the_motion_explains_enough(
    pushed, monkeypatch
):
    mistake = next(each for each in mistakes() if each.name == "turned about z")
    turned = mistake.make(correct(0), np.random.default_rng(1))
    case = case_of(with_a_push(correct(0), 3.0) if pushed else turned)
    asked = []
    fakes = [lambda case, x=x: asked.append(x) for x in LINEAR_EXPLANATIONS]
    monkeypatch.setattr(judge, "EXPLANATIONS", ())
    monkeypatch.setattr(judge, "LINEAR_EXPLANATIONS", tuple(fakes))
    monkeypatch.setattr(judge, "LARGE_EXPLANATIONS", ())
    assert judge.judge_one(case).named is None
    assert bool(asked) is not pushed


@pytest.mark.parametrize(("effect", "told"), [(None, True), (3.1, True), (2.9, False)])
def test_a_mistake_of_less_than_three_deviations_is_not_told(case, effect, told):
    """Whatever its likelihood; one whose size has no deviation is told by that alone."""
    given = as_given(case)
    nothing_left = replace(given.fitted, likelihood=given.fitted.likelihood + 10.0)
    other = replace(given, code="other", fitted=nothing_left, effect=effect)
    assert evidence(case, given, other) > POSSIBLE_EVIDENCE
    assert _is_named(case, given, other) is told


def test_small_mistakes_have_the_derivatives_of_the_wrench(case):
    """By differences: of a turn of the sensor, of gains, of a tilt and of a weight that
    is missing, of a lever, of a clock, of what pulls, and of parameters that change."""
    fitted = as_given(case).fitted.of_best()
    phi = fitted.solution[0, :10]
    motion = case.motion_as_found
    fitted = replace(fitted, rows=replace(fitted.rows, known=known_of(case, motion)))
    columns, groups = _small_mistakes(case, fitted)
    K, rows = len(case.time), motion.features(case.gravity)[0]
    w = as_wrench(rows, phi)
    sizes = [part.stop - part.start for part in groups]
    assert sizes[:4] == [3, 6, 2, 4]
    assert sizes[-6:] == [3, 1, 1, 4, 4, 4]
    assert [part.start for part in groups] == [0, *np.cumsum(sizes)[:-1]]
    assert groups[-1].stop == columns.shape[2]
    turn, gains, tilt, weight = (columns[:, :, part] for part in groups[:4])
    lever, rate, late, spring, hanging, change = (
        columns[:, :, part] for part in groups[-6:]
    )
    step = 1e-6
    for i, e in enumerate(np.eye(3)):
        R = rotation_by(step * e)
        turned = (w.reshape(K, 2, 3) @ R.T - w.reshape(K, 2, 3)).reshape(K, 6) / step
        np.testing.assert_allclose(np.abs(turn[:, :, i]), np.abs(turned), atol=1e-4)
    np.testing.assert_allclose(gains, w[:, :, None] * np.eye(6))
    g = np.linalg.norm(case.gravity)
    towards = g * tangents_of(case.gravity)
    still, *tilted = (
        as_wrench(motion.features(e)[0], phi) for e in (np.zeros(3), *towards)
    )
    expected = np.stack([each - still for each in tilted], axis=2) / g
    np.testing.assert_allclose(tilt, expected, atol=1e-9)
    held = as_at_rest(motion.axes[0] @ case.gravity)
    np.testing.assert_allclose(weight, held[:, :, :4], atol=1e-12)
    whole = as_regressor(rows)
    np.testing.assert_allclose(lever[:, :3], whole[:, :3, 1:4], atol=1e-12)
    assert not lever[:, 3:].any()
    slope = np.gradient(w, case.time, axis=0)
    np.testing.assert_allclose(late[:, :, 0], slope, atol=1e-9)
    since = (case.time - case.time.mean())[:, None]
    np.testing.assert_allclose(rate[:, :, 0], since * slope, atol=1e-9)
    position = case.recording["position"]
    at = interpolated(case.time - case.offset, position.time, position.values)
    at = at - at.mean(axis=0)
    length = np.zeros_like(at)
    length[:, 2] = at[:, 2] - at[:, 2].min()
    for found, pull in ((spring, at), (hanging, length)):
        force = np.einsum("kij,kj->ki", motion.axes[0], pull)
        by_place = [np.cross(arm, force) for arm in np.eye(3)]
        np.testing.assert_allclose(found[:, :3, 0], force, atol=1e-12)
        np.testing.assert_allclose(found[:, 3:, 1:], np.stack(by_place, 2), atol=1e-12)
        assert not found[:, 3:, 0].any()
        assert not found[:, :3, 1:].any()
    drifting = since[:, :, None] * whole[:, :, :4]
    np.testing.assert_allclose(change, drifting, atol=1e-9)


def known_of(case, motion):
    """Rows of the case's motion at its offset, and of its bias."""
    bias = case.bias_functions[None]
    return np.concatenate((motion.features(case.gravity), bias), axis=2)


def as_regressor(features):
    """(K, 6, 10) by a regressor of measurements with these features (K, 12)."""
    K, none = len(features), np.zeros((len(features), 3))
    held = Measurements(
        0.01 * np.arange(K), none, features[:, :3], none, features[:, 3:6], none, none
    )
    # products of angular velocity are linear in the features: added by each
    A = full_regressor(held)
    for i, j, k in ((0, 0, 6), (0, 1, 7), (0, 2, 8), (1, 1, 9), (1, 2, 10), (2, 2, 11)):
        A = A + features[:, k, None, None] * by_product(i, j)
    return A


def by_product(i, j):
    """(6, 10) what the product of two components of angular velocity adds."""

    def of(w):
        one, none = np.array(w, dtype=float)[None], np.zeros((1, 3))
        return full_regressor(
            Measurements(np.zeros(1), none, none, one, none, none, none)
        )[0]

    e = np.eye(3)
    if i == j:
        return of(e[i])
    return of(e[i] + e[j]) - of(e[i]) - of(e[j])


def as_wrench(features, phi):
    return as_regressor(features) @ phi


def as_at_rest(gravity):
    K, none = len(gravity), np.zeros((len(gravity), 3))
    held = Measurements(0.01 * np.arange(K), gravity, none, none, none, none, none)
    return full_regressor(held)


def test_a_step_beside_linear_unknowns_is_that_of_all_together(case):
    """Weighted least squares of the residual by all columns; also where some of the
    linear ones are the same."""
    fitted = as_given(case).fitted.of_best()
    rng = np.random.default_rng(4)
    K = len(case.time)
    weights = rng.uniform(0.5, 2.0, (1, K))
    fitted = replace(fitted, weights=weights, scale=np.array([[0.5, 0.02]]))
    columns = rng.normal(size=(K, 6, 2))
    A = np.einsum("kz,zcp->kcp", fitted.rows.known[0], fitted.rows.maps)
    unit = np.sqrt(weights[0])[:, None] / np.repeat((0.5, 0.02), 3)
    rows = np.concatenate((A, columns), axis=2) * unit[:, :, None]
    rows = rows.reshape(6 * K, -1)
    left = (fitted.residual[0] * unit).ravel()
    whole = np.linalg.lstsq(rows, left, rcond=1e-12)[0]
    S, g = LinearPart.of(fitted).beside(columns)
    np.testing.assert_allclose(np.linalg.solve(S, g), whole[-2:], rtol=1e-4, atol=1e-9)
    inverse = np.linalg.pinv(rows.T @ rows, rcond=1e-13)[-2:, -2:]
    np.testing.assert_allclose(np.linalg.inv(S), inverse, rtol=1e-4)
    step = linear_step(fitted, columns)
    np.testing.assert_allclose(step.change, whole[-2:], rtol=1e-4, atol=1e-9)
    np.testing.assert_allclose(
        step.covariance, inverse * correlation(fitted), rtol=1e-4
    )
    part = LinearPart.of(fitted)
    assert part.square == pytest.approx(left @ left)
    maps = np.concatenate((fitted.rows.maps, fitted.rows.maps), axis=2)
    twice = LinearPart.of(replace(fitted, rows=replace(fitted.rows, maps=maps)))
    assert np.linalg.eigvalsh(twice.normal)[0] > 1e-12
    np.testing.assert_allclose(twice.beside(columns)[0], S, rtol=1e-5, atol=1e-5)


def test_a_mistake_is_hopeless_that_leaves_nine_tenths(case):
    """Or, where little is missing, twice as much as counts as nothing."""
    fitted = as_given(case).fitted.of_best()
    noise = fitted.likelihood + missing(case, fitted)

    def leaves(share):
        return replace(fitted, likelihood=noise - share)

    assert missing(case, leaves(1.5)) == pytest.approx(1.5)
    assert not is_hopeless(case, leaves(8.9), leaves(10.0))
    assert is_hopeless(case, leaves(9.1), leaves(10.0))
    assert not is_hopeless(case, leaves(0.59), leaves(0.1))
    assert is_hopeless(case, leaves(0.61), leaves(0.1))


def test_a_mistake_that_gives_up_some_samples_is_not_told(case):
    """However likely the others become: of hard braking between the poses accelerations a
    fifth as large had explained all but that."""
    given = as_given(case)
    likelier = given.fitted.likelihood + 10.0
    for share, told in ((0.5, True), (1.5, False)):
        residual = given.fitted.residual.copy()
        # a hundredth of the samples, whose mean square is so much of all as given
        size = np.mean(
            np.square(residual[given.fitted.best] / np.repeat(case.floor, 3))
        )
        few = residual[given.fitted.best, ::100]
        few += (100.0 * share * size) ** 0.5 * np.repeat(case.floor, 3)
        fitted = replace(given.fitted, likelihood=likelier, residual=residual)
        assert _is_named(case, given, replace(given, fitted=fitted)) is told


def test_mistakes_that_leave_much_are_not_looked_for_where_noise_explains_all(case):
    """A light object's noise of 0.13 N, whose colour the averages keep, had been a wrench in
    the axes of the robot's base."""
    given = as_given(case)
    assert missing(case, given.fitted) < NEGLIGIBLE_UNEXPLAINED
    likelihood = given.fitted.likelihood - 10.0
    left = replace(given, fitted=replace(given.fitted, likelihood=likelihood))
    for explanation, searched in ((given, False), (left, True)):
        candidates = _more_candidates(case, explanation, 0.5, ())
        assert set(LARGE_EXPLANATIONS) <= set(candidates) or not searched
        assert not set(LARGE_EXPLANATIONS) & set(candidates) or searched


@pytest.mark.parametrize("drifts_too", [True, False])
def test_another_mistake_beside_a_freer_drift_is_told_if_it_accounts_for_all(
    drifts_too, monkeypatch
):
    """Half of a payload in slow motion beside a bent drift had been *good*: a cable explained
    most of the drift."""
    pushed = with_a_push(correct(0), 3.0 if drifts_too else 0.0)
    wrench = pushed.recording["wrench"]
    bend = np.abs(wrench.time - wrench.time.mean())[:, None] * np.full(6, 0.5)
    streams = {
        **pushed.recording.streams,
        "wrench": Stream(wrench.time, wrench.values + bend),
    }
    case = case_of(
        replace(pushed, recording=replace(pushed.recording, streams=streams))
    )
    given = as_given(case)

    def found(case: Case, candidates: object) -> judging.Judged:
        code = "payload" if case.more_knots else "cable"
        other = replace(given, code=code)
        return judging.Judged(0.1, other, given, certain=True, whole=True)

    monkeypatch.setattr(judging, "_judge", found)
    named = judging._judge_beside_drift(case, ()).named
    # beside a drift that explains all of it there is nothing to account for
    assert (None if named is None else named.code) == (
        "payload" if drifts_too else None
    )
