"""Cells: wrench and motion averaged over a tenth of a second, in which changes of the
object are looked for."""

from dataclasses import dataclass, replace

import numpy as np

from hefting.core.spatial import Array, Mask
from hefting.ingest.fit import Fit
from hefting.ingest.model import REGRESSOR_BY_FEATURE, Model, Problem
from hefting.ingest.outliers import Outliers
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
SENSOR_ERROR = 0.005
"""Error of a good sensor as a share of the wrench's changes, which averaging does not
lessen."""
MEDIAN_OF_NORMAL = 0.6745
"""Median size of a standard normal number."""


@dataclass(frozen=True, eq=False)
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
    """(2,) noise of the averages of force [N] and torque [N m], from the differences of
    neighbours, and no less than the error of a good sensor"""

    def __len__(self) -> int:
        return len(self.time)

    @property
    def regressor(self) -> Array:
        """(M, 6, 10) in units of `scale`."""
        A = (self.features @ REGRESSOR_BY_FEATURE.reshape(len(REGRESSOR_BY_FEATURE), -1))
        return A.reshape(-1, 6, 10) / np.repeat(self.scale, 3)[:, None]

    @property
    def whitened(self) -> Array:
        """(M, 6) wrench in units of `scale`."""
        return self.wrench / np.repeat(self.scale, 3)

    @property
    def interval(self) -> float:
        """[s] Median time from one cell to the next."""
        return float(np.median(np.diff(self.time)))

    def __getitem__(self, rows: slice | Mask) -> "Cells":
        arrays = {
            name: getattr(self, name)[rows]
            for name in ("time", "first", "last", "features", "axes", "wrench")
        }
        return replace(self, **arrays)


def cells_of(
    samples: Samples, problem: Problem, fit: Fit, outliers: Outliers, offset: float
) -> Cells | None:
    """Cells of a recording, at a clock offset [s]; None where there are too few.

    Parameters
    ----------
    samples : the wrench as recorded.
    problem : the blocks that were fitted.
    fit : their fit; its motion is used where it has the same offset.
    outliers : samples that the fit rejected. Spikes and saturated samples are left out,
        and short contacts.
    offset : by which the wrench is late [s].
    """
    blocks, kept = _blocks(samples, problem, outliers)
    model = fit.model
    if offset != fit.offset:
        fixed = replace(problem, free_offset=False, free_gravity=False)
        model = Model.at(fixed, offset, fit.gravity)
    kept = kept & model.reading.known
    if not kept.any():
        return None
    time = problem.time[kept]
    width = max(CELL_DURATION, float(np.ptp(time)) / MOST_CELLS)
    starts = np.flatnonzero(
        np.diff(np.floor((time - time[0]) / width), prepend=-1.0)
    )
    count = np.diff(np.append(starts, len(time)))
    values = np.hstack(
        (
            time[:, None],
            model.features[kept],
            model.reading.value[kept][:, WORLD_AXES_COLUMNS],
            blocks[kept],
        )
    )
    mean = np.add.reduceat(values, starts, axis=0) / count[:, None]
    cells = Cells(
        mean[:, 0],
        time[starts],
        time[starts + count - 1],
        mean[:, 1:13],
        mean[:, 13:22],
        mean[:, 22:],
        np.ones(2),
    )
    return replace(cells, scale=_scale(cells))


def _blocks(
    samples: Samples, problem: Problem, outliers: Outliers
) -> tuple[Array, Mask]:
    """The blocks' wrench (B, 6) without spikes, saturated samples and short contacts,
    and a mask (B,) of those with a sample left."""
    left_out = outliers.spike | outliers.saturation
    left_out = left_out | _short_runs(outliers.contact, samples.time)
    thinned = len(left_out) != len(samples.time)
    if thinned or not outliers.rejected.any():
        return problem.wrench, np.ones(len(problem.time), dtype=bool)
    none = np.zeros(len(left_out), dtype=bool)
    blocks = samples.blocks(Outliers(none, left_out, none))
    return blocks.wrench, blocks.count > 0.0


def _short_runs(mask: Mask, time: Array) -> Mask:
    """The runs of a mask (K,) that last less than `SHORTEST_CONTACT`."""
    edges = np.flatnonzero(np.diff(mask.astype(int), prepend=0, append=0))
    short = np.zeros(len(mask), dtype=bool)
    for begin, end in zip(edges[::2], edges[1::2], strict=True):
        if time[end - 1] - time[begin] < SHORTEST_CONTACT:
            short[begin:end] = True
    return short


def _scale(cells: Cells) -> Array:
    """(2,) see `Cells.scale`."""
    # third differences are free of all that changes slowly
    apart = np.diff(cells.wrench, n=3, axis=0) / np.sqrt(20.0)
    sizes = np.median(np.abs(apart).reshape(-1, 2, 3), axis=(0, 2)) / MEDIAN_OF_NORMAL
    changes = np.linalg.norm(np.std(cells.wrench, axis=0).reshape(2, 3), axis=1)
    whole = float(np.linalg.norm(cells.wrench.reshape(-1, 3), axis=1).max())
    return np.maximum(
        np.hypot(sizes, SENSOR_ERROR * changes), max(1e-9 * whole, 1e-12)
    )
