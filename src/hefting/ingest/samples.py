"""Wrench samples as recorded, and which of them a fit to their blocks does not
explain."""

import numpy as np

from hefting.core.immutable import immutable
from hefting.core.spatial import Array, interpolated
from hefting.ingest.blocks import Blocks
from hefting.ingest.fit import Fit
from hefting.ingest.model import Problem
from hefting.ingest.outliers import Outliers, find_odd_poses, find_outliers

FEWEST_SAMPLES_FOR_OUTLIERS = 40
"""Number of samples below which no sample is rejected."""
FEWEST_POSES_FOR_OUTLIERS = 12
"""Number of static poses below which no pose is rejected."""
SAMPLES_AT_A_TIME = 200_000
"""Number of samples of a long recording in which outliers are found together; it bounds
the memory."""


@immutable
class Samples:
    """Wrench samples as recorded."""

    time: Array
    """(K,) [s]"""
    wrench: Array
    """(K, 6) [N, N m]"""
    static: bool
    """whether they are poses without time"""
    smooth: bool
    """whether they may be averaged over blocks"""

    def blocks(self, outliers: Outliers | None = None) -> Blocks:
        """Blocks of all samples, or of the inliers."""
        return Blocks.of(
            self.time,
            self.wrench,
            None if outliers is None else ~outliers.rejected,
            self.smooth,
        )

    @property
    def enough(self) -> bool:
        """Whether there are enough of them to find outliers."""
        return len(self.time) >= (
            FEWEST_POSES_FOR_OUTLIERS if self.static else FEWEST_SAMPLES_FOR_OUTLIERS
        )


def find_outliers_of_fit(samples: Samples, problem: Problem, fit: Fit) -> Outliers:
    """Samples that a fit to their blocks does not explain."""
    changes = _wrench_changes(problem)
    predicted = problem.wrench - fit.residual
    if samples.static:
        return find_odd_poses(samples.wrench, predicted, changes)
    if problem.blocks.starts is None:
        return find_outliers(
            samples.time,
            samples.wrench,
            predicted,
            fit.spread,
            fit.known,
            fit.scale,
            changes,
        )
    return _find_outliers_between_blocks(samples, problem, fit, changes)


def find_outliers_piecewise(samples: Samples, problem: Problem, fit: Fit) -> Outliers:
    """Samples that a fit to some blocks does not explain, of a recording of any
    length."""
    changes, parts = _wrench_changes(problem), []
    for start in range(0, len(samples.time), SAMPLES_AT_A_TIME):
        part = slice(start, start + SAMPLES_AT_A_TIME)
        piece = Samples(
            samples.time[part], samples.wrench[part], samples.static, samples.smooth
        )
        parts.append(_find_outliers_between_blocks(piece, problem, fit, changes))
    return Outliers(
        *(
            np.concatenate([getattr(o, name) for o in parts])
            for name in ("contact", "spike", "saturation")
        )
    )


def _find_outliers_between_blocks(
    samples: Samples, problem: Problem, fit: Fit, changes: Array
) -> Outliers:
    """Outliers among samples between the blocks of a fit, whose prediction is
    interpolated linearly."""
    predicted = problem.wrench - fit.residual
    columns = np.column_stack((predicted, fit.spread, fit.known))
    at_samples = interpolated(samples.time, problem.time, columns)
    steps = np.diff(problem.time)
    half_interval = 0.5 * float(np.median(steps)) if len(steps) else 0.0
    first, last = problem.time[0] - half_interval, problem.time[-1] + half_interval
    known = (
        (at_samples[:, 7] > 1.0 - 1e-9)
        & (samples.time >= first)
        & (samples.time <= last)
    )
    scale = fit.scale * problem.blocks.mean_count**0.5
    return find_outliers(
        samples.time,
        samples.wrench,
        at_samples[:, :6],
        at_samples[:, 6],
        known,
        scale,
        changes,
    )


def _wrench_changes(problem: Problem) -> Array:
    """(2,) standard deviation of force [N] and torque [N m], the norm of their three
    components."""
    spread = np.std(problem.wrench - np.median(problem.wrench, axis=0), axis=0)
    return np.linalg.norm(spread.reshape(2, 3), axis=1)
