"""Stretches of samples: nothing is lost, however they come, and there are few."""

import numpy as np
import pytest

from hefting.core.regressor import FEATURES
from hefting.estimators.time_record import (
    FIRST_STRETCH_LENGTH,
    MOST_STRETCHES,
    Stretches,
)


def rows(count: int, seed: int = 1) -> np.ndarray:
    return np.random.default_rng(seed).normal(size=(count, FEATURES))


def squares(factors) -> np.ndarray:
    """(22, 22) R'R of all factors together."""
    return sum((R.T @ R for R in factors), np.zeros((FEATURES, FEATURES)))


def assert_whole(stretches: Stretches, given: np.ndarray) -> None:
    """Of all samples, once each."""
    for factors, count in (
        ((*stretches.factors, stretches.open_factor), stretches.open_count),
        ((part[0] for part in stretches.parts), 0),
    ):
        found = squares(factors)
        np.testing.assert_allclose(found, given.T @ given, atol=1e-9)  # of 1e4
        if count:
            assert sum(stretches.counts) + count == len(given)
    if len(stretches.parts):
        assert sum(part[1] for part in stretches.parts) == len(given)
    assert len(stretches.factors) <= MOST_STRETCHES


@pytest.mark.parametrize("piece", [7, 64, 100, 5000])
@pytest.mark.parametrize("count", [90, 511, 512, 1000, 4097])
def test_samples_in_pieces_are_in_stretches_of_one_length(count, piece):
    given, stretches = rows(count), Stretches()
    for first in range(0, count, piece):
        stretches = stretches.fold(given[first : first + piece])
    assert_whole(stretches, given)
    assert set(stretches.counts) <= {stretches.length}
    assert stretches.open_count < stretches.length
    doublings = stretches.length / FIRST_STRETCH_LENGTH
    assert np.log2(doublings) == int(np.log2(doublings))
    # as many as there may be, or half of them
    assert len(stretches.counts) >= MOST_STRETCHES / 2 or doublings == 1.0
    # each stretch holds the samples in their order
    length = stretches.length
    for k, R in enumerate(stretches.factors):
        own = given[k * length : (k + 1) * length]
        np.testing.assert_allclose(R.T @ R, own.T @ own, atol=1e-9)


@pytest.mark.parametrize("counts", [(10, 20), (500, 70), (64, 64), (1000, 3000)])
def test_merged_stretches_hold_the_samples_of_both(counts):
    given = [rows(count, seed) for seed, count in enumerate(counts)]
    merged = Stretches().fold(given[0]).merge(Stretches().fold(given[1]))
    assert_whole(merged, np.concatenate(given))
    assert len(merged.counts) < MOST_STRETCHES
    assert merged.open_count == 0


def test_weights_are_of_squares():
    given = rows(300)
    scaled = Stretches().fold(given).scaled(4.0)
    assert_whole(scaled, 2.0 * given)
