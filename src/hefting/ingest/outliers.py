"""Samples no body explains: contacts, by what the residual does for a while; spikes, alone; saturation."""

from dataclasses import dataclass

import numpy as np

from hefting.core.spatial import Array, Indices, Mask

CELL = 0.05
"""s, of a cell, of which contacts are made"""
FEWEST = 4
"""samples a cell has at least, on average"""
SPANS = (1, 4)
"""cells averaged, to see what is short and what is weak"""
CORE, EDGE = 7.0, 4.0
"""Length of the residual of six channels over their robust spread: a contact reaches the first and lasts while
beyond the second. Of six normal ones it exceeds 4 once in 70 times, 7 once in 10⁸."""
SPIKE = 7.0
MEDIAN_LENGTH = 1.538
"""of three normal components"""
NEIGHBOURS = 11
"""cells by which the usual spread at a place is judged"""
FLOOR = 0.04
"""Of the wrench's changes: an imperfect sensor errs as much, and is not an outlier for that."""
TIMING = 0.003
"""s of its rate of change, likewise: sensors lag and ring."""
PLENTY = 20_000
"""Rows that tell a median to a hundredth of a standard deviation."""
LEAST = 1e-12
"""N, N m: no wrench is known better."""
MOST = 0.6
"""Of all samples: beyond, it is the model that is wrong, not they."""
SATURATED = 5
"""samples at one extreme value, further from it than any other: a sensor at its limit"""


@dataclass(frozen=True, eq=False)
class Outliers:
    """Which samples are left out, and why."""

    contact: Mask
    """(K,)"""
    spike: Mask
    saturation: Mask

    @property
    def rejected(self) -> Mask:
        """(K,) any of them."""
        return self.contact | self.spike | self.saturation

    def union(self, other: "Outliers") -> "Outliers":
        """With those of another."""
        contact = self.contact | other.contact
        return Outliers(contact, (self.spike | other.spike) & ~contact, self.saturation | other.saturation)


def no_outliers(K: int) -> Outliers:
    """None of K samples."""
    none = np.zeros(K, dtype=bool)
    return Outliers(none, none, none)


def find_outliers(
    time: Array, wrench: Array, predicted: Array, spread: Array, known: Mask, scale: Array, changes: Array
) -> Outliers:
    """Outliers among K samples of wrench (K, 6), as predicted, where that is `known` (K,).

    `spread` (K,) is how much larger than usual a residual may be, for the motion's errors; `scale` (2,) the usual
    residual of force and torque, `changes` (2,) how much these change.
    """
    limit = saturated(wrench, predicted, np.repeat(scale, 3)) & known
    known = known & ~limit
    r = np.where(known[:, None], wrench - predicted, np.nan) / spread[:, None]
    width = max(CELL, FEWEST * float(np.median(np.diff(time))))
    cell = np.cumsum(np.diff(np.floor((time - time[0]) / width), prepend=0.0) > 0.0)
    floor = _imperfection(time, predicted, cell, changes)
    medians, samples = _cell_medians(r, cell)
    contact = np.zeros(len(medians), dtype=bool)
    for span in SPANS:
        left = (samples > 0) & ~contact
        average = _running(np.where(left[:, None], medians, 0.0), left.astype(float), span)
        size = _length(average, np.maximum(_spread(average[left]), floor))
        contact |= _lasting(np.where(left, size, 0.0))
    contact |= np.concatenate((contact[1:], [False])) | np.concatenate(([False], contact[:-1]))  # it comes and goes
    apart = np.nan_to_num(r - medians[cell])
    usual = np.maximum(_nearby(apart, cell), np.maximum(_spread(apart[known]), floor[cell]))
    spike = _length(apart, usual) > SPIKE
    touched = contact[cell]
    if np.mean(touched | spike) > MOST:
        none = np.zeros(len(time), dtype=bool)
        return Outliers(none, none, limit)
    return Outliers(touched & known, spike & ~touched & known, limit)


def find_odd_poses(wrench: Array, predicted: Array, changes: Array) -> Outliers:
    """Static poses (K,), each by itself, with a wrench (K, 6) far from what the others predict."""
    none = np.zeros(len(wrench), dtype=bool)
    r = wrench - predicted
    odd = _length(r, np.maximum(_spread(r), FLOOR * changes)) > SPIKE
    return Outliers(none, none if np.mean(odd) > MOST else odd, none)


def _imperfection(time: Array, predicted: Array, cell: Indices, changes: Array) -> Array:
    """(C, 2) what a good sensor may get wrong of force and torque in each cell."""
    rate = np.gradient(predicted, time, axis=0).reshape(-1, 2, 3)
    square = np.sum(rate * rate, axis=2)
    mean = np.column_stack([np.bincount(cell, column) for column in square.T]) / np.bincount(cell)[:, None]
    return np.sqrt((FLOOR * changes) ** 2 + TIMING**2 * mean)


def saturated(wrench: Array, predicted: Array, scale: Array) -> Mask:
    """Samples (K,) at which the sensor was at its limit, or would have been but for noise.

    A channel has a limit where `SATURATED` samples or more share its extreme value and the prediction (K, 6) goes
    well beyond it; `scale` (6,) is the spread of the residuals.
    """
    out = np.zeros(len(wrench), dtype=bool)
    for c in range(6):
        for side in (1.0, -1.0):
            y, p = side * wrench[:, c], side * predicted[:, c]
            limit = y.max()
            at = y == limit
            if at.sum() >= SATURATED and np.sum(p[at] - limit > 5.0 * scale[c]) >= SATURATED:
                out |= p > limit - 3.0 * scale[c]
                out |= at
    return out


def _cell_medians(r: Array, cell: Indices) -> tuple[Array, Array]:
    """Medians (C, d) of the samples r (K, d) known in each cell, and their number (C,)."""
    order = np.arange(len(cell)) - np.concatenate(([0], np.flatnonzero(np.diff(cell)) + 1))[cell]
    table = np.full((cell[-1] + 1, int(order.max()) + 1, r.shape[1]), np.nan)
    table[cell, order] = r
    table = np.sort(table, axis=1)  # NaN last
    n = np.sum(np.isfinite(table[:, :, 0]), axis=1)
    rows = np.arange(len(table))
    low, high = table[rows, np.maximum(n - 1, 0) // 2], table[rows, np.minimum(n // 2, table.shape[1] - 1)]
    return np.where((n > 0)[:, None], 0.5 * (low + high), 0.0), n


def _running(values: Array, weights: Array, span: int) -> Array:
    """Averages (C, 6) over `span` cells about each."""
    if span == 1:
        return values
    kernel = np.ones(span)

    def total(x: Array) -> Array:
        return np.convolve(x, kernel)[span // 2 : span // 2 + len(x)]

    count = np.maximum(total(weights), 1.0)
    return np.column_stack([total(column) / count for column in values.T])


def _spread(values: Array) -> Array:
    """(2,) robust standard deviations of force and torque, of `PLENTY` rows at most."""
    if not len(values):
        return np.zeros(2)
    values = values[:: -(-len(values) // PLENTY)]
    return 1.4826 * np.median(np.abs(values.reshape(-1, 2, 3)).transpose(1, 0, 2).reshape(2, -1), axis=1)


def _length(values: Array, scale: Array) -> Array:
    """(C,) length of residuals (C, 6) over the spreads (2,) of force and torque."""
    return np.sqrt(np.sum((values / np.repeat(np.maximum(scale, LEAST), 3, axis=-1)) ** 2, axis=1))


def _nearby(apart: Array, cell: Indices) -> Array:
    """(K, 2) robust spread of force and torque about each sample: it shakes more while it moves."""
    square = apart * apart
    size = np.sqrt(np.column_stack((square[:, :3].sum(axis=1), square[:, 3:].sum(axis=1))))
    typical = _cell_medians(size, cell)[0] / MEDIAN_LENGTH
    return _running_median(typical)[cell]


def _running_median(values: Array) -> Array:
    """Medians (C, 2) of `NEIGHBOURS` cells about each, mirrored at the ends."""
    half = NEIGHBOURS // 2
    mirrored = np.pad(values, ((half, half), (0, 0)), mode="symmetric")
    windows = np.lib.stride_tricks.sliding_window_view(mirrored, NEIGHBOURS, axis=0)
    return np.partition(windows, half, axis=2)[:, :, half]


def _lasting(size: Array) -> Mask:
    """Runs of cells beyond `EDGE` that reach `CORE` somewhere."""
    beyond = size > EDGE
    begins = np.flatnonzero(np.diff(beyond.astype(int), prepend=0) == 1)
    if not len(begins):
        return beyond
    run = np.cumsum(np.isin(np.arange(len(size)), begins)) - 1
    peak = np.zeros(len(begins))
    np.maximum.at(peak, run[beyond], size[beyond])
    return beyond & (peak[np.maximum(run, 0)] > CORE)
