"""What is worth a search for mistakes: residuals that are no white noise, and for some
that a function of the motion explains them."""

from dataclasses import replace

import numpy as np
import pytest
from benchmarks.given import Given, correct
from benchmarks.mistaken import mistakes

from given_cases import case_of
from hefting.core.recording import Stream
from hefting.ingest.rivals import LINEAR_EXPLANATIONS, judge
from hefting.ingest.rivals.case import Case
from hefting.ingest.rivals.evidence import Fitted, correlation
from hefting.ingest.rivals.explanation import as_given, explained_by_motion
from hefting.ingest.rivals.judge import (
    POSSIBLE_EVIDENCE,
    _is_told,
    _is_white,
    _is_worth_a_search,
    evidence,
)


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
    assert correlation(fitted, fitted.best) == pytest.approx(
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
    free = explained_by_motion(case)
    found = [explain(case) for explain in LINEAR_EXPLANATIONS]
    likelihoods = [each.likelihood for each in found if each is not None]
    assert max(likelihoods) < free.likelihood[free.best] + 0.01


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
    assert judge.judge(case).named is None
    assert bool(asked) is not pushed


@pytest.mark.parametrize(("effect", "told"), [(None, True), (3.1, True), (2.9, False)])
def test_a_mistake_of_less_than_three_deviations_is_not_told(case, effect, told):
    """Whatever its likelihood; one whose size has no deviation is told by that alone."""
    given = as_given(case)
    nothing_left = replace(given.fitted, likelihood=given.fitted.likelihood + 10.0)
    other = replace(given, code="other", fitted=nothing_left, effect=effect)
    assert evidence(case, given, other) > POSSIBLE_EVIDENCE
    assert _is_told(case, given, other) is told
