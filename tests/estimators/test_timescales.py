"""Time scales: laws of the orthonormal Haar transform."""

import numpy as np
import pytest

from hefting.core.regressor import FEATURES
from hefting.estimators.timescales import TimeScales


def samples(count: int, seed: int = 0) -> np.ndarray:
    return np.random.default_rng(seed).normal(size=(count, FEATURES))


def grams(scales: TimeScales) -> list[np.ndarray]:
    return [factor.T @ factor for factor in scales.factors]


@pytest.mark.parametrize("count", [1, 2, 3, 5, 7, 21, 64, 100])
def test_closed_they_hold_all_but_the_total(count):
    """Parseval: the squares of all contrasts and of the total are those of the samples;
    there is a contrast for each sample but one."""
    x = samples(count)
    closed = TimeScales().fold(x).closed()
    total = x.sum(axis=0)
    expected = x.T @ x - np.outer(total, total) / count
    found = sum(grams(closed), np.zeros((FEATURES, FEATURES)))
    np.testing.assert_allclose(found, expected, atol=1e-12 * count)  # rounding
    assert sum(closed.counts) == count - 1


def test_in_parts_they_are_those_of_the_whole():
    x = samples(100)
    whole, parts = TimeScales().fold(x), TimeScales()
    for part in np.split(x, [1, 2, 5, 40, 41]):
        parts = parts.fold(part)
    assert parts.counts == whole.counts
    for one, other in zip(grams(parts), grams(whole), strict=True):
        np.testing.assert_allclose(one, other, atol=1e-12)


@pytest.mark.parametrize("level", range(4))
def test_a_change_after_every_block_stands_at_the_level_of_its_blocks(level):
    """Of 2^level samples each: 64 samples of one and minus one."""
    wave = np.resize(np.repeat((1.0, -1.0), 2**level), 64)
    x = np.outer(wave, np.arange(1.0, FEATURES + 1.0))
    energy = [float(np.trace(gram)) for gram in grams(TimeScales().fold(x))]
    assert energy[level] == pytest.approx(float(np.sum(x**2)))
    del energy[level]
    np.testing.assert_allclose(energy, 0.0, atol=1e-9)


def test_a_constant_has_no_details():
    x = np.tile(samples(1), (37, 1))
    for gram in grams(TimeScales().fold(x).closed()):
        np.testing.assert_allclose(gram, 0.0, atol=1e-12)


@pytest.mark.parametrize(
    ("count", "level", "details"),
    # 1,024 samples have 1,024 / 2^(level + 1) at each; sixteen and one differ over four
    [(1025, 5, 16 + 1), (17, 2, 2 + 1), (5, 1, 1 + 1), (4096 + 1, 6, 32 + 1)],
)
def test_blocks_of_unequal_length_are_compared_between_their_levels(
    count, level, details
):
    """At that of the geometric mean of their lengths."""
    closed = TimeScales().fold(samples(count)).closed()
    assert closed.counts[level] == details


def test_a_weight_is_that_of_squares():
    scales = TimeScales().fold(samples(7))
    more = scales.scaled(4.0).closed()
    for one, other in zip(grams(more), grams(scales.closed()), strict=True):
        np.testing.assert_allclose(one, 4.0 * other, atol=1e-12)
