"""Time scales: laws of the orthonormal Haar transform."""

import numpy as np
import pytest

from hefting.core.regressor import FEATURES
from hefting.estimators.timescales import TimeScales, autocorrelation_time


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


def test_merged_no_detail_spans_two_records_and_the_later_one_goes_on():
    """Of records of unequal length, whichever is the longer."""
    one, other, more = samples(21, 1), samples(70, 2), samples(13, 3)
    for first, second in ((one, other), (other, one)):
        a, b = TimeScales().fold(first), TimeScales().fold(second)
        both, end = a.merge(b).fold(more), b.fold(more)
        J = len(both.factors)
        counts = np.zeros(J, dtype=int)
        expected = np.zeros((J, FEATURES, FEATURES))
        for each in (a, end):
            counts[: len(each.counts)] += each.counts
            expected[: len(each.factors)] += grams(each)
        assert both.counts == tuple(counts)
        np.testing.assert_allclose(grams(both), expected, atol=1e-11)


def by_definition(series: np.ndarray) -> float:
    """One and twice the sum of the correlations at lags before the first below 0.05,
    of lags up to half of the length; on average over what is not constant."""
    times = []
    for x in (series - series.mean(axis=0)).T:
        if not x.any():
            continue
        n = len(x)
        rho = [float(x[k:] @ x[: n - k]) / float(x @ x) for k in range(n // 2)]
        below = [k for k, r in enumerate(rho) if r < 0.05]
        times.append(1.0 + 2.0 * sum(rho[1 : below[0] if below else len(rho)]))
    return max(1.0, float(np.mean(times)))


def test_the_autocorrelation_time_is_that_of_its_definition():
    """Of noise, of what is slow, and of what is not even over half of the series."""
    rng = np.random.default_rng(4)
    walk = np.cumsum(rng.normal(size=(101, 2)), axis=0)
    late = np.arange(60) >= 59
    peaks = 1.0 * late + late[::-1] + 0.9 * (np.arange(60) % 24 == 6)
    slow = np.linspace(-1.0, 1.0, 50)[:, None] ** np.array((1, 3))
    humps = np.abs(np.cos(np.arange(64) * np.pi / 32.0))[:, None] + 0.3
    flat = np.column_stack((walk[:, 0], np.full(101, 3.0)))
    spread = np.r_[np.ones(10), np.zeros(30), 2.0 * np.ones(4), np.zeros(10)]
    for series in (
        rng.normal(size=(200, 3)),
        walk,
        slow,
        humps,
        flat,
        peaks[:, None],
        spread[:, None],
        np.sort(rng.exponential(size=(40, 2)), axis=0),
    ):
        expected = by_definition(series)
        assert autocorrelation_time(series) == pytest.approx(expected, rel=1e-9)
    assert autocorrelation_time(walk[:7]) == 1.0
    assert autocorrelation_time(walk[:8]) == pytest.approx(by_definition(walk[:8]))
    assert autocorrelation_time(np.ones((20, 2))) == 1.0
    turns = np.resize((1.0, -1.0), 40)[:, None]
    assert autocorrelation_time(turns) == 1.0
    # correlations that never fall below a twentieth up to half of the length
    held = np.r_[np.ones(3), np.zeros(94), np.ones(3)][:, None]
    assert autocorrelation_time(held) == pytest.approx(by_definition(held))
    # a period of nearly the whole record is never below a twentieth before a third
    arc = (np.arange(90) % 30 < 28)[:, None] * np.linspace(1.0, 3.0, 90)[:, None] ** 3
    assert autocorrelation_time(arc) == pytest.approx(by_definition(arc), rel=1e-9)
