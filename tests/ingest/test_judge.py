"""What is worth a search for mistakes: residuals that are no white noise."""

from dataclasses import replace

import numpy as np
import pytest
from benchmarks.given import correct

from given_cases import case_of
from hefting.ingest.rivals.case import Case
from hefting.ingest.rivals.evidence import Fitted, correlation
from hefting.ingest.rivals.explanation import as_given
from hefting.ingest.rivals.judge import _is_white, _is_worth_a_search


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
