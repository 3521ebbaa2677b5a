"""Cells: wrench and motion averaged over a tenth of a second, in which changes of the
object are looked for."""

from dataclasses import replace
from functools import cached_property

import numpy as np

from hefting.core.immutable import immutable
from hefting.core.spatial import Array, Indices, Mask, median, runs_of
from hefting.ingest.blocks import medians
from hefting.ingest.fit import Fit
from hefting.ingest.model import REGRESSOR_BY_FEATURE, Model, Problem
from hefting.ingest.outliers import Outliers, no_outliers
from hefting.ingest.path import WORLD_AXES_COLUMNS
from hefting.ingest.samples import Samples

CELL_DURATION = 0.1
"""[s] Duration of a cell: short beside the half second to which a change is to be
found, long beside the time over which a sensor's noise is correlated."""
MOST_CELLS = 300
"""Largest number of cells; those of recordings of more than half a minute last
longer."""
SHORTEST_CONTACT = 0.7
"""[s] Shorter contacts are left out, as the robust fit found them; whether a longer one
is a contact is decided anew."""
SPIKE = 12.0
"""Distance from the median of a cell, in median distances, above which a block is left
out: eight standard deviations."""


@immutable
class Cells:
    """Averages over M cells, in order of time; cells without a good sample are left
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
    """(2,) noise of the averages of force [N] and torque [N m]: the unit of whitened
    values"""

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
    kept = kept & model.reading.known
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
    """First block of each cell, of blocks at `time` (B,) [s]."""
    width = max(CELL_DURATION, float(np.ptp(time)) / MOST_CELLS)
    return np.flatnonzero(np.diff(np.floor((time - time[0]) / width), prepend=-1.0))


def _without_spikes(time: Array, wrench: Array, kept: Mask) -> Mask:
    """A mask (B,) of the blocks kept whose wrench is not far from the median of their
    cell, of which the robust fit leaves some where it fits badly."""
    starts = _starts(time[kept])
    sizes = np.diff(np.append(starts, int(kept.sum())))

    def usual(values: Array) -> Array:
        return np.repeat(medians(values, starts), sizes, axis=0)

    apart = np.abs(wrench[kept] - usual(wrench[kept]))
    spread = np.maximum(usual(apart), np.median(apart, axis=0))
    good = kept.copy()
    good[kept] = (apart <= SPIKE * spread).all(axis=1)
    return good


def _blocks(
    samples: Samples, problem: Problem, outliers: Outliers
) -> tuple[Array, Mask]:
    """The blocks' wrench (B, 6) without spikes, saturated samples and short contacts,
    and a mask (B,) of those with a sample left."""
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
    """Whether a contact was rejected that lasts `SHORTEST_CONTACT` or more."""
    return any(
        samples.time[end - 1] - samples.time[begin] >= SHORTEST_CONTACT
        for begin, end in runs_of(outliers.contact)
    )
