"""Outliers of the wrench: contacts, which last over several cells; single spikes; and
saturated samples."""

from dataclasses import replace

import numpy as np

from hefting.core.spatial import (
    Array,
    Indices,
    Mask,
    immutable,
    median,
    runs_of,
    squared_lengths,
)

CELL_DURATION = 0.05
"""[s] Duration of a cell. Contacts are found as sequences of cells."""
FEWEST_SAMPLES_PER_CELL = 4
"""Smallest average number of samples in a cell; slow sensors' cells last longer."""
AVERAGED_CELLS = (1, 4)
"""Cells over which residuals are averaged: 1 for short contacts, 4 for weak ones."""
CONTACT_PEAK = 7.0
"""Normalised residual that a contact reaches at least once. The length of six standard
normal components exceeds 7 once in 10⁸ times."""
CONTACT_EDGE = 4.0
"""Normalised residual above which a contact lasts. The length of six standard normal
components exceeds 4 once in 70 times."""
SPIKE_RESIDUAL = 7.0
"""Normalised residual above which a single sample is a spike; see `CONTACT_PEAK`."""
MEDIAN_LENGTH_OF_THREE = 1.538
"""Median length of a vector of three standard normal components."""
NEIGHBOURING_CELLS = 11
"""Number of cells whose median is the usual spread about a sample."""
SENSOR_ERROR_SHARE = 0.04
"""Error of an imperfect sensor, as a share of the wrench's changes, up to which
residuals are no outliers."""
SENSOR_DELAY = 0.003
"""[s] Error of an imperfect sensor, in units of the wrench's rate of change: sensors
lag and ring."""
ROWS_FOR_MEDIAN = 20_000
"""Most rows from which a median is taken, to a hundredth of a standard deviation."""
SMALLEST_SPREAD = 1e-12
"""[N, N m] Lower bound on the spread of residuals, against division by zero."""
LARGEST_OUTLIER_SHARE = 0.6
"""Share of outliers above which none is rejected: then the model is wrong."""
FEWEST_SATURATED_SAMPLES = 5
"""Number of samples at the extreme value of a channel from which on that may be the
sensor's limit."""


@immutable
class Outliers:
    """Masks of the rejected samples, by cause."""

    contact: Mask
    """(K,)"""
    spike: Mask
    saturation: Mask

    @property
    def rejected(self) -> Mask:
        """(K,) all outliers."""
        return self.contact | self.spike | self.saturation

    def union(self, other: "Outliers") -> "Outliers":
        """The outliers of both sets; a contact takes precedence over a spike."""
        contact = self.contact | other.contact
        return Outliers(
            contact,
            (self.spike | other.spike) & ~contact,
            self.saturation | other.saturation,
        )


def no_outliers(K: int) -> Outliers:
    """No outliers among K samples."""
    none = np.zeros(K, dtype=bool)
    return Outliers(none, none, none)


def find_outliers(
    time: Array,
    wrench: Array,
    predicted: Array,
    spread: Array,
    known: Mask,
    scale: Array,
    changes: Array,
) -> Outliers:
    """Outliers of K samples.

    Parameters
    ----------
    time : (K,) [s].
    wrench, predicted : (K, 6) measured and predicted [N, N m].
    spread : (K,) factor by which the motion's errors widen a residual.
    known : (K,) where the prediction is valid.
    scale : (2,) usual residual of force [N] and torque [N m].
    changes : (2,) standard deviation of force [N] and torque [N m].
    """
    limit = saturated(wrench, predicted, np.repeat(scale, 3)) & known
    known = known & ~limit
    r = (wrench - predicted) / spread[:, None]
    r[~known] = np.nan
    width = max(CELL_DURATION, FEWEST_SAMPLES_PER_CELL * median(np.diff(time)))
    cell = np.cumsum(np.diff(np.floor((time - time[0]) / width), prepend=0.0) > 0.0)
    floor = _imperfection(time, predicted, cell, changes)
    medians, samples = _cell_medians(r, cell)
    contact = np.zeros(len(medians), dtype=bool)
    for span in AVERAGED_CELLS:
        left = (samples > 0) & ~contact
        average = _running(
            np.where(left[:, None], medians, 0.0), left.astype(float), span
        )
        size = _length(average, _spread(average[left], floor))
        contact |= _contact_cells(np.where(left, size, 0.0))
    # its start and end
    contact |= np.concatenate((contact[1:], [False])) | np.concatenate(
        ([False], contact[:-1])
    )
    apart = r - medians.take(cell, axis=0)
    apart[~known] = 0.0
    least = _spread(apart[known], floor)
    usual = np.maximum(_nearby(apart, cell), least).take(cell, axis=0)
    spike = _length(apart, usual) > SPIKE_RESIDUAL
    touched = contact[cell]
    if np.mean(touched | spike) > LARGEST_OUTLIER_SHARE:
        return replace(no_outliers(len(time)), saturation=limit)
    return Outliers(touched & known, spike & ~touched & known, limit)


def find_odd_poses(wrench: Array, predicted: Array, changes: Array) -> Outliers:
    """Static poses (K,) whose wrench (K, 6) is far from the predicted one (K, 6);
    `changes` (2,) as for `find_outliers`."""
    none, r = no_outliers(len(wrench)), wrench - predicted
    odd = _length(r, _spread(r, SENSOR_ERROR_SHARE * changes)) > SPIKE_RESIDUAL
    return none if np.mean(odd) > LARGEST_OUTLIER_SHARE else replace(none, spike=odd)


def _imperfection(
    time: Array, predicted: Array, cell: Indices, changes: Array
) -> Array:
    """(C, 2) error of an imperfect sensor in force [N] and torque [N m] by cell."""
    square = squared_lengths(np.gradient(predicted.T.copy(), time, axis=1).T)
    mean = (
        np.column_stack([np.bincount(cell, column) for column in square.T])
        / np.bincount(cell)[:, None]
    )
    return np.sqrt((SENSOR_ERROR_SHARE * changes) ** 2 + SENSOR_DELAY**2 * mean)


def saturated(wrench: Array, predicted: Array, scale: Array) -> Mask:
    """Mask (K,) of the samples at which the sensor is at its limit, or would be without
    noise.

    A channel has a limit where at least `FEWEST_SATURATED_SAMPLES` samples share its
    extreme value and the prediction (K, 6) exceeds it by five times `scale` (6,), the
    spread of the residuals; or where no other value is shared so often.
    """
    out = np.zeros(len(wrench), dtype=bool)
    for c in range(6):
        channel = np.ascontiguousarray(wrench[:, c])
        for side, extreme in ((1.0, channel.max()), (-1.0, channel.min())):
            at = channel == extreme
            shared = np.count_nonzero(at)
            some = FEWEST_SATURATED_SAMPLES <= shared <= 0.5 * len(channel)
            if not (some and extreme):
                continue
            y, p, limit = side * channel, side * predicted[:, c], side * extreme
            if np.sum(p[at] - limit > 5.0 * scale[c]) >= FEWEST_SATURATED_SAMPLES:
                out |= p > limit - 3.0 * scale[c]
                out |= at
            elif _never_rests(y[~at & (y > y.min())]):
                out |= at
    return out


def _never_rests(values: Array) -> bool:
    """Whether values (K,) differ, and none is shared by as many samples as a limit is,
    as in a wrench without noise or in coarse steps."""
    _, counts = np.unique(values, return_counts=True)
    return len(counts) > 1 and bool(counts.max() < FEWEST_SATURATED_SAMPLES)


def _cell_medians(r: Array, cell: Indices) -> tuple[Array, Array]:
    """Medians (C, d) of known samples r (K, d) in each cell, and their number (C,)."""
    order = (
        np.arange(len(cell))
        - np.concatenate(([0], np.flatnonzero(np.diff(cell)) + 1))[cell]
    )
    table = np.full((cell[-1] + 1, r.shape[1], int(order.max()) + 1), np.nan)
    table[cell, :, order] = r
    table.sort(axis=2)  # NaN last
    n = np.sum(np.isfinite(table[:, 0]), axis=1)
    rows = np.arange(len(table))
    low = table[rows, :, np.maximum(n - 1, 0) // 2]
    high = table[rows, :, np.minimum(n // 2, table.shape[2] - 1)]
    return np.where((n > 0)[:, None], 0.5 * (low + high), 0.0), n


def _running(values: Array, weights: Array, span: int) -> Array:
    """Averages (C, 6) over `span` cells about each cell."""
    if span == 1:
        return values
    kernel = np.ones(span)

    def total(x: Array) -> Array:
        return np.convolve(x, kernel)[span // 2 : span // 2 + len(x)]

    count = np.maximum(total(weights), 1.0)
    return np.column_stack([total(column) / count for column in values.T])


def _spread(values: Array, least: Array) -> Array:
    """(2,) robust standard deviations of force and torque, from at most
    `ROWS_FOR_MEDIAN` rows of residuals (K, 6); or (..., 2) the `least` where that is
    larger."""
    if not len(values):
        return least
    values = values[:: -(-len(values) // ROWS_FOR_MEDIAN)]
    sizes = 1.4826 * np.abs(values.reshape(-1, 2, 3)).transpose(1, 0, 2).reshape(2, -1)
    # where most are below it no median need be found
    below = sizes <= least.reshape(-1, 2).min(axis=0)[:, None]
    if 2 * np.count_nonzero(below, axis=1).min() > sizes.shape[1]:
        return least
    return np.maximum([median(each) for each in sizes], least)


def _length(values: Array, scale: Array) -> Array:
    """(C,) length of residuals (C, 6) over standard deviations (2,)."""
    square = squared_lengths(values) * np.maximum(scale, SMALLEST_SPREAD) ** -2.0
    return np.sqrt(square[:, 0] + square[:, 1])


def _nearby(apart: Array, cell: Indices) -> Array:
    """(C, 2) robust spread of force and torque in the cells about each, which is larger
    while the arm moves."""
    size = np.sqrt(squared_lengths(apart))
    typical = _cell_medians(size, cell)[0] / MEDIAN_LENGTH_OF_THREE
    return _running_median(typical)


def _running_median(values: Array) -> Array:
    """(C, 2) medians of `NEIGHBOURING_CELLS` cells about each, mirrored at the ends."""
    half = NEIGHBOURING_CELLS // 2
    mirrored = np.pad(values, ((half, half), (0, 0)), mode="symmetric")
    windows = np.lib.stride_tricks.sliding_window_view(
        mirrored, NEIGHBOURING_CELLS, axis=0
    )
    return np.partition(windows, half, axis=2)[:, :, half]


def _contact_cells(size: Array) -> Mask:
    """(C,) cells in contact: runs above `CONTACT_EDGE` whose largest normalised
    residual, of `size` (C,), exceeds `CONTACT_PEAK`."""
    touched = np.zeros(len(size), dtype=bool)
    for begin, end in runs_of(size > CONTACT_EDGE):
        touched[begin:end] = size[begin:end].max() > CONTACT_PEAK
    return touched
