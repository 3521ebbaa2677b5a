"""Cells: wrench and motion averaged over a tenth of a second, in which changes of the
object are searched for; and their partition into intervals in each of which one body
and one bias explain the wrench best.

The normal equations of an interval are differences of cumulative sums, so all intervals
are fitted together in closed form. The partition of least cost is found by dynamic
programming (Jackson et al., IEEE Signal Processing Letters 12, 2005). The cost of an
interval is minus twice the log-likelihood of its residuals, whose variance is that of
this interval alone: in a contact it is larger.
"""

from dataclasses import replace
from functools import cached_property

import numpy as np

from hefting.core.spatial import (
    Array,
    Indices,
    Mask,
    column_medians,
    immutable,
    median,
    runs_of,
)
from hefting.ingest.blocks import medians
from hefting.ingest.fit import Fit
from hefting.ingest.model import REGRESSOR_BY_FEATURE, Model, Problem
from hefting.ingest.outliers import Outliers, no_outliers
from hefting.ingest.path import WORLD_AXES_COLUMNS
from hefting.ingest.samples import Samples

CELL_DURATION = 0.1
"""[s] Duration of a cell: short beside the half second to which a change is found, long
beside the correlation time of a sensor's noise."""
MOST_CELLS = 600
"""Largest number of cells; in recordings of more than a minute they last
longer."""
SHORTEST_CONTACT = 0.7
"""[s] Shorter contacts are left out, as found by the robust fit; longer ones are
searched for anew."""
SPIKE = 12.0
"""Distance from the median of a cell, in median distances, above which a block is left
out: eight standard deviations."""
LARGEST_SPREAD = 2.0
"""Factor by which errors of the motion widen a residual, from which on it is left out."""
LARGEST_PARAMETERS = np.array((30.0,) + (5.0,) * 3 + (2.0,) * 6)
"""[kg, kg m (3), kg m² (6)] Standard deviations of the parameters' prior, wide enough
to decide only what the motion leaves open."""
LARGEST_BIAS = np.repeat((50.0, 5.0), 3)
"""[N (3), N m (3)] Standard deviations of the bias's prior."""
UNKNOWNS = 16
"""Unknowns of an interval: ten parameters and a bias."""
MOST_BOUNDS, FARTHEST_BOUNDS = 60, 5
"""Number of places between which intervals are compared, and cells between two of them
where they are more; changes are then moved to the best cell."""
SHORTEST_INTERVAL = 0.8
"""[s] Shortest interval: five equations for each unknown."""
FEWEST_CELLS = 8
SMALLEST_VARIANCE = 0.5
"""Lower bound of the variance of residuals, over that of the noise, in the cost."""
COST_OF_INTERVAL = 60.0
"""Cost of another interval, in addition to `UNKNOWNS` times the log of the number of
equations."""
COST_OF_SKIPPED_CELL = 25.0
"""Cost of a cell that is in no interval."""
LONGEST_TRANSITION = 0.3
"""[s] Longest time between two bodies."""

Interval = tuple[int, int]


@immutable
class Cells:
    """Averages over M cells in order of time; cells without a good sample are left
    out."""

    time: Array
    """(M,) [s] mean of the samples' times"""
    first: Array
    """(M,) [s] of the first sample"""
    last: Array
    """(M,) [s] of the last sample"""
    features: Array
    """(M, 12) of the motion, see `hefting.ingest.model`"""
    axes: Array
    """(M, 9) rotation from world to sensor axes, by rows"""
    wrench: Array
    """(M, 6) as recorded [N, N m]"""
    scale: Array
    """(2,) noise of the averages of force [N] and torque [N m], by which they are
    whitened"""

    def __len__(self) -> int:
        return len(self.time)

    @property
    def unit(self) -> Array:
        """(6,) `scale` of each channel."""
        return np.repeat(self.scale, 3)

    @cached_property
    def regressor(self) -> Array:
        """(M, 6, 10) whitened."""
        A = self.features @ REGRESSOR_BY_FEATURE.reshape(len(REGRESSOR_BY_FEATURE), -1)
        return A.reshape(-1, 6, 10) / self.unit[:, None]

    @cached_property
    def whitened(self) -> Array:
        """(M, 6) wrench."""
        return self.wrench / self.unit

    @cached_property
    def interval(self) -> float:
        """[s] Median time from one cell to the next."""
        return median(np.diff(self.time))


def cells_of(
    samples: Samples, problem: Problem, fit: Fit, outliers: Outliers, offset: float
) -> Cells | None:
    """Cells of a recording, at a clock offset [s]; None where the motion is not known.

    Parameters
    ----------
    samples : the wrench as recorded.
    problem : the blocks that were fitted.
    fit : their fit; its motion is used where it has the same offset.
    outliers : samples that the fit rejected. Spikes and saturated samples are left out,
        and short contacts.
    offset : by which the wrench is late [s].
    """
    wrench, kept = _blocks(samples, problem, outliers)
    model = fit.model
    if offset != fit.offset:
        fixed = replace(problem, free_offset=False, free_gravity=False)
        model = Model.at(fixed, offset, fit.gravity)
    kept = kept & model.reading.known & (fit.spread < LARGEST_SPREAD)
    if not kept.any():
        return None
    kept = _without_spikes(problem.time, wrench, kept)
    time = problem.time[kept]
    axes = model.reading.value[kept][:, WORLD_AXES_COLUMNS]
    starts = _starts(time)
    count = np.diff(np.append(starts, len(time)))
    values = np.hstack((time[:, None], model.features[kept], axes, wrench[kept]))
    mean = np.add.reduceat(values, starts, axis=0) / count[:, None]
    return Cells(
        mean[:, 0],
        time[starts],
        time[starts + count - 1],
        mean[:, 1:13],
        mean[:, 13:22],
        mean[:, 22:],
        np.ones(2),
    )


def _starts(time: Array) -> Indices:
    """First block of each cell, from blocks at `time` (B,) [s]."""
    width = max(CELL_DURATION, float(np.ptp(time)) / MOST_CELLS)
    return np.flatnonzero(np.diff(np.floor((time - time[0]) / width), prepend=-1.0))


def _without_spikes(time: Array, wrench: Array, kept: Mask) -> Mask:
    """Mask (B,) of the `kept` blocks whose wrench is near the median of their cell; the
    robust fit leaves some spikes where it fits badly."""
    starts = _starts(time[kept])
    sizes = np.diff(np.append(starts, int(kept.sum())))

    def usual(values: Array) -> Array:
        return np.repeat(medians(values, starts), sizes, axis=0)

    apart = np.abs(wrench[kept] - usual(wrench[kept]))
    spread = np.maximum(usual(apart), column_medians(apart))
    good = kept.copy()
    good[kept] = (apart <= SPIKE * spread).all(axis=1)
    return good


def _blocks(
    samples: Samples, problem: Problem, outliers: Outliers
) -> tuple[Array, Mask]:
    """The blocks' wrench (B, 6) without spikes, saturated samples and short contacts,
    and the mask (B,) of blocks that still have samples."""
    thinned = len(outliers.contact) != len(samples.time)
    if thinned or not outliers.rejected.any():
        return problem.wrench, np.ones(len(problem.time), dtype=bool)
    left_out = outliers.spike | outliers.saturation
    for begin, end in runs_of(outliers.contact):
        if samples.time[end - 1] - samples.time[begin] < SHORTEST_CONTACT:
            left_out[begin:end] = True
    blocks = samples.blocks(replace(no_outliers(len(left_out)), spike=left_out))
    return blocks.wrench, blocks.count > 0.0


def has_long_contact(samples: Samples, outliers: Outliers) -> bool:
    """Whether a rejected contact lasts `SHORTEST_CONTACT` or more."""
    return any(
        samples.time[end - 1] - samples.time[begin] >= SHORTEST_CONTACT
        for begin, end in runs_of(outliers.contact)
    )


class Intervals:
    """Least squares of one body and a bias in any interval of M cells."""

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
        """(P,) costs of the intervals of cells from `begin` (P,) to before `end` (P,)."""
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
    """Intervals of least total cost in order, each (first cell, cell after its last); a few
    cells at a change may be in none."""
    M = len(cells)
    shortest = max(FEWEST_CELLS, int(np.ceil(SHORTEST_INTERVAL / cells.interval)))
    if 2 * shortest > M:
        return [(0, M)]
    fits = Intervals(cells)
    most_skipped = max(1, int(LONGEST_TRANSITION / cells.interval + 0.5))
    step = min(max(1, -(-M // MOST_BOUNDS)), FARTHEST_BOUNDS)
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
    """The intervals between `places` (P,) of least cost, by dynamic programming.

    An interval costs its entry of `table` (P, P) and the `penalty`. Between two intervals
    up to `most_skipped` cells may be skipped, each at `COST_OF_SKIPPED_CELL`.
    """
    P = len(places)
    # least cost up to each place if an interval ends there, and where that one begins
    closed, begin_of = np.full(P, np.inf), np.zeros(P, dtype=int)
    # least cost up to each place if one begins there, and where the one before ends
    opened, end_before = np.full(P, np.inf), np.zeros(P, dtype=int)
    closed[0] = opened[0] = 0.0
    for j in range(1, P):
        costs = opened[:j] + table[:j, j] + penalty
        begin_of[j] = int(np.argmin(costs))
        closed[j] = costs[begin_of[j]]
        skipped = places[j] - places[: j + 1]
        costs = closed[: j + 1] + COST_OF_SKIPPED_CELL * skipped
        costs[skipped > most_skipped] = np.inf
        end_before[j] = int(np.argmin(costs))
        opened[j] = costs[end_before[j]]
    found, end = [], P - 1
    while end > 0:
        begin = int(begin_of[end])
        found.append((int(places[begin]), int(places[end])))
        end = int(end_before[begin])
    return found[::-1]


def _moved(
    fits: Intervals, intervals: list[Interval], reach: int, shortest: int
) -> list[Interval]:
    """The intervals with each change, and the cells skipped at it, moved by up to `reach`
    cells to where the two intervals beside it cost least."""
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
