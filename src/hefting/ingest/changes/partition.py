"""Partition: consecutive intervals of cells, in each of which one body beside one bias
explains the wrench best.

The normal equations of an interval are differences of cumulative sums, so all intervals
are fitted together in closed form. The partition of least cost is found by dynamic
programming (Jackson et al., IEEE Signal Processing Letters 12, 2005). The cost of an
interval is minus twice the log-likelihood of its residuals, whose variance is that of
this interval alone: in a contact it is larger.
"""

import numpy as np

from hefting.core.spatial import Array, Indices
from hefting.ingest.changes.cells import Cells

LARGEST_PARAMETERS = np.array((30.0,) + (5.0,) * 3 + (2.0,) * 6)
"""[kg, kg m (3), kg m² (6)] Standard deviations of the parameters' prior, so wide that
it decides only what the motion leaves open."""
LARGEST_BIAS = np.repeat((50.0, 5.0), 3)
"""[N (3), N m (3)] Standard deviations of the bias's prior."""
UNKNOWNS = 16
"""Unknowns of an interval: ten parameters and a bias."""
MOST_BOUNDS = 60
"""Largest number of places between which intervals are compared; the changes are then
moved to the best cell."""
SHORTEST_INTERVAL = 0.8
"""[s] Shortest interval: five equations for each unknown."""
FEWEST_CELLS = 8
"""Fewest cells of an interval."""
SMALLEST_VARIANCE = 0.5
"""Variance of a residual in units of the noise below which less is no better."""
COST_OF_INTERVAL = 60.0
"""Cost of another interval beside `UNKNOWNS` times the logarithm of the number of
equations."""
COST_OF_SKIPPED_CELL = 25.0
"""Cost of a cell in no interval."""
LONGEST_TRANSITION = 0.3
"""[s] Longest time between one body and the next."""

Interval = tuple[int, int]


class Intervals:
    """Fits of one body beside a bias to intervals of M cells."""

    def __init__(self, cells: Cells) -> None:
        unit = np.repeat(cells.scale, 3)
        bias = np.broadcast_to(np.diag(1.0 / unit), (len(cells), 6, 6))
        rows = np.concatenate(
            (cells.regressor, bias, cells.whitened[:, :, None]), axis=2
        ).reshape(-1, 2, 3, UNKNOWNS + 1)
        grams = np.einsum("mgci,mgcj->mgij", rows, rows)
        self.sums = np.concatenate((np.zeros_like(grams[:1]), np.cumsum(grams, axis=0)))
        self.ridge = np.diag(np.concatenate((LARGEST_PARAMETERS, LARGEST_BIAS)) ** -2.0)

    def cost(self, begin: Indices, end: Indices) -> Array:
        """(P,) of the intervals of cells from `begin` (P,) to before `end` (P,)."""
        grams = self.sums[end] - self.sums[begin]
        q = UNKNOWNS
        normal = grams.sum(axis=1)
        solution = np.linalg.solve(normal[:, :q, :q] + self.ridge, normal[:, :q, q:])[
            :, :, 0
        ]
        square = (
            grams[:, :, q, q]
            - 2.0 * np.einsum("pgi,pi->pg", grams[:, :, :q, q], solution)
            + np.einsum("pi,pgij,pj->pg", solution, grams[:, :, :q, :q], solution)
        )
        equations = 3.0 * (end - begin)[:, None]
        variance = square / np.maximum(equations - 0.5 * q, 0.25 * equations)
        return np.sum(
            equations * np.log(np.maximum(variance, SMALLEST_VARIANCE)), axis=1
        )


def partition(cells: Cells) -> list[Interval]:
    """Intervals of least cost, each of cells from its first to before its second number,
    in order; cells at a change may be in none."""
    M = len(cells)
    shortest = max(FEWEST_CELLS, int(np.ceil(SHORTEST_INTERVAL / cells.interval)))
    if 2 * shortest > M:
        return [(0, M)]
    fits = Intervals(cells)
    most_skipped = max(1, int(LONGEST_TRANSITION / cells.interval + 0.5))
    step = max(1, -(-M // MOST_BOUNDS))
    places = np.unique(np.append(np.arange(0, M, step), M))
    begin, end = np.triu_indices(len(places), 1)
    long_enough = places[end] - places[begin] >= shortest
    begin, end = begin[long_enough], end[long_enough]
    table = np.full((len(places), len(places)), np.inf)
    table[begin, end] = fits.cost(places[begin], places[end])
    penalty = UNKNOWNS * np.log(6.0 * M) + COST_OF_INTERVAL
    intervals = _cheapest(places, table, penalty, most_skipped)
    for _ in range(2):
        intervals = _moved(fits, intervals, step + most_skipped, shortest)
    return intervals


def _cheapest(
    places: Indices, table: Array, penalty: float, most_skipped: int
) -> list[Interval]:
    """The intervals between `places` (P,) whose costs (P, P), each with the penalty, and
    with those of the cells skipped between them, have the least sum."""
    P = len(places)
    best, came = np.full(P, np.inf), np.zeros(P, dtype=int)
    opened, skipped_from = np.full(P, np.inf), np.zeros(P, dtype=int)
    best[0] = opened[0] = 0.0
    for j in range(1, P):
        costs = opened[:j] + table[:j, j] + penalty
        came[j] = int(np.argmin(costs))
        best[j] = costs[came[j]]
        skipped = places[j] - places[: j + 1]
        since = best[: j + 1] + COST_OF_SKIPPED_CELL * skipped
        since[(skipped > most_skipped)] = np.inf
        skipped_from[j] = int(np.argmin(since))
        opened[j] = since[skipped_from[j]]
    found, j = [], P - 1
    while j > 0:
        i = int(came[j])
        found.append((int(places[i]), int(places[j])))
        j = int(skipped_from[i])
    return found[::-1]


def _moved(
    fits: Intervals, intervals: list[Interval], reach: int, shortest: int
) -> list[Interval]:
    """The intervals with each change, and the cells skipped there, within `reach` cells
    where the two intervals beside it cost least."""
    found = list(intervals)
    for i in range(len(found) - 1):
        (first, end), (begin, last) = found[i], found[i + 1]
        skipped = np.arange(begin - end + 2)
        at = np.arange(
            max(first + shortest, end - reach), min(last - shortest, end + reach) + 1
        )
        ends, gaps = (x.ravel() for x in np.meshgrid(at, skipped))
        fits_in = ends + gaps <= last - shortest
        ends, begins = ends[fits_in], (ends + gaps)[fits_in]
        if not len(ends):
            continue
        costs = fits.cost(np.full(len(ends), first), ends)
        costs += fits.cost(begins, np.full(len(ends), last))
        k = int(np.argmin(costs + COST_OF_SKIPPED_CELL * (begins - ends)))
        found[i], found[i + 1] = (first, int(ends[k])), (int(begins[k]), last)
    return found
