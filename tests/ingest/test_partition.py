"""Partition of cells: the least cost of all, and how far changes are moved."""

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

from changing_cells import random_cells
from hefting.ingest.changes import cells as module
from hefting.ingest.changes.cells import Intervals, _cheapest, _moved, partition


@pytest.mark.parametrize("seed", range(6))
def test_the_cheapest_intervals_are_those_of_all_that_there_are(seed):
    """Of six places, whose distances differ, by trying all; a skipped cell costs 25."""
    rng = np.random.default_rng(seed)
    places = np.array((0, 2, 3, 7, 9, 10))
    table = np.full((6, 6), np.inf)
    upper = np.triu_indices(6, 1)
    table[upper] = 400.0 * rng.random(len(upper[0]))
    penalty, most = 30.0, 2

    def divisions(start: int):
        """All lists of intervals from a place to the last one."""
        for end in range(start + 1, 6):
            if end == 5:
                yield [(start, end)]
            for begin in range(end, 5):
                if places[begin] - places[end] <= most:
                    yield from ([(start, end), *rest] for rest in divisions(begin))

    def cost(division):
        gaps = places[division[0][0]] + sum(
            places[b[0]] - places[a[1]] for a, b in pairwise(division)
        )
        return sum(table[i] + penalty for i in division) + 25.0 * gaps

    # cells before the first interval may be skipped as well
    whole = [each for first in (0, 1) for each in divisions(first)]
    best = min(whole, key=cost)
    expected = [(int(places[a]), int(places[b])) for a, b in best]
    assert _cheapest(places, table, penalty, most) == expected


@pytest.mark.parametrize(
    ("divided", "reach", "end"),
    [(30, 10, 40), (90, 10, 80), (30, 40, 60), (90, 40, 60), (59, 1, 60), (61, 1, 60)],
)
def test_a_change_is_moved_to_its_cell_as_far_as_it_may(divided, reach, end):
    """Another body from cell 60 of 120 on; a cell of the other may be left out."""
    cells = random_cells(np.random.default_rng(1), 120, change=60)
    one, other = _moved(Intervals(cells), [(0, divided), (divided, 120)], reach, 8)
    assert one == (0, end)
    assert other in ((end, 120), (end + (end < 60), 120))


@pytest.mark.parametrize(("change", "end"), [(5, 8), (115, 112)])
def test_no_interval_is_moved_to_be_shorter_than_the_shortest(change, end):
    cells = random_cells(np.random.default_rng(2), 120, change=change)
    moved = _moved(Intervals(cells), [(0, 60), (60, 120)], 120, 8)
    assert moved == [(0, end), (end, 120)]
    kept = _moved(Intervals(cells), [(0, 5), (5, 12)], 3, 8)
    assert kept == [(0, 5), (5, 12)]


def spoilt(interval: float, count: int):
    """Two bodies, and between them so many cells of neither."""
    rng = np.random.default_rng(3)
    cells = random_cells(rng, 58)
    cells.wrench[30:] *= -10.0
    cells.wrench[30 - count : 30] += 1e3 * rng.normal(size=(count, 6))
    return replace(cells, time=interval * np.arange(58))


@pytest.mark.parametrize(
    ("interval", "most"), [(0.1, 3), (0.19, 2), (0.7, 1), (0.59, 1), (0.08, 4)]
)
def test_cells_of_no_body_last_for_three_tenths_of_a_second_or_are_one(
    interval, most, monkeypatch
):
    """Before changes are moved, by which a few more may be left out."""
    monkeypatch.setattr(module, "_moved", lambda fits, intervals, *_: intervals)
    found = partition(spoilt(interval, most))
    assert (found[0][1], found[-1][0]) == (30 - most, 30)
    more = partition(spoilt(interval, most + 1))
    assert all(b[0] - a[1] <= most for a, b in pairwise(more))


@pytest.mark.parametrize(
    ("interval", "fewest"), [(0.101, 8), (0.051, 16), (0.3, 8), (0.03, 27)]
)
def test_intervals_have_eight_cells_and_last_eight_tenths_of_a_second(interval, fewest):
    """Else there is one for all."""
    rng = np.random.default_rng(4)
    for M in (2 * fewest - 1, 2 * fewest):
        cells = random_cells(rng, M)
        cells.wrench[fewest:] *= -10.0  # of another body and bias
        cells = replace(cells, time=interval * np.arange(M))
        two = [(0, fewest), (fewest, M)]
        assert partition(cells) == (two if 2 * fewest == M else [(0, M)])
