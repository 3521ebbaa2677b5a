"""Wrench samples as recorded, and those that a fit to their blocks does not explain.

Among a few static poses one is odd if the sensor was touched in it, or its orientation
was written down wrongly. Each pose is predicted from the others by least squares. With
r its residual and S the covariance of r by the residuals of the others, r' S^-1 r / 6
has about the F distribution if all poses are right.
"""

from dataclasses import replace

import numpy as np

from hefting.core.spatial import (
    Array,
    column_medians,
    immutable,
    interpolated,
    median,
    squared_lengths,
)
from hefting.ingest.blocks import Blocks
from hefting.ingest.fit import Fit
from hefting.ingest.model import REGRESSOR_BY_FEATURE, Problem
from hefting.ingest.outliers import Outliers, find_odd_poses, find_outliers, no_outliers

FEWEST_SAMPLES_FOR_OUTLIERS = 40
"""Number of samples below which no sample is rejected."""
FEWEST_POSES_FOR_OUTLIERS = 12
"""Number of static poses below which no pose is rejected."""
SAMPLES_AT_A_TIME = 200_000
"""Number of samples of a long recording in which outliers are found together, to bound
the memory."""
FEWEST_POSES = 6
"""Least number of poses for one to be left out: mass, COM and bias need 3 others."""
ODD = 50.0
"""r' S^-1 r / 6 above which a pose is odd. It is at most 12 in 400 right simulated sets
of 6 to 11 poses, 13 in 1,200 choices of a real sensor's, and 45 in 2,800 with a mistake
in all poses. For a pose touched with 9 N or turned by 40° it is at least 53; with 3 N
it is above 65 in all but a twentieth of a real sensor's, turned by 20° above 30."""
SMALLEST_ERROR = 0.003
"""Share of the wrench's changes up to which a residual is the sensor's error."""
REWEIGHTINGS = 4
"""Number of times that force and torque are weighted by their residuals."""


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
    """whether blocks of them may be averaged"""

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
        """Whether they suffice to find outliers."""
        return len(self.time) >= (
            FEWEST_POSES_FOR_OUTLIERS if self.static else FEWEST_SAMPLES_FOR_OUTLIERS
        )


def find_outliers_of_fit(samples: Samples, problem: Problem, fit: Fit) -> Outliers:
    """Outliers of a fit to blocks of the samples."""
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
    """Outliers of a fit to some blocks of a recording of any length."""
    changes, parts = _wrench_changes(problem), []
    for start in range(0, len(samples.time), SAMPLES_AT_A_TIME):
        part = slice(start, start + SAMPLES_AT_A_TIME)
        piece = Samples(
            samples.time[part], samples.wrench[part], samples.static, samples.smooth
        )
        parts.append(_find_outliers_between_blocks(piece, problem, fit, changes))
    masks = zip(*(vars(outliers).values() for outliers in parts), strict=True)
    return Outliers(*map(np.concatenate, masks))


def _find_outliers_between_blocks(
    samples: Samples, problem: Problem, fit: Fit, changes: Array
) -> Outliers:
    """Outliers among samples between the blocks of a fit, whose prediction is
    interpolated linearly."""
    predicted = problem.wrench - fit.residual
    columns = np.column_stack((predicted, fit.spread, fit.known))
    at_samples = interpolated(samples.time, problem.time, columns)
    steps = np.diff(problem.time)
    half_interval = 0.5 * median(steps) if len(steps) else 0.0
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
    """(2,) standard deviation of force [N] and torque [N m] vectors."""
    spread = np.std(problem.wrench - column_medians(problem.wrench), axis=0)
    return np.linalg.norm(spread.reshape(2, 3), axis=1)


def find_odd_pose(samples: Samples, fit: Fit) -> Outliers:
    """Mask of the pose that the others contradict most, if significantly."""
    none = no_outliers(len(samples.time))
    if not samples.static or len(samples.time) < FEWEST_POSES:
        return none
    oddness = _oddness(fit.model.features[:, :3], samples.wrench)
    spike = np.zeros(len(oddness), dtype=bool)
    spike[np.argmax(oddness)] = oddness.max() > ODD
    return replace(none, spike=spike)


def _oddness(specific_force: Array, wrench: Array) -> Array:
    """(K,) r' S^-1 r / 6 of each pose, from a - g (K, 3) in sensor axes [m/s²] and
    wrenches (K, 6) with a bias."""
    K = len(wrench)
    body = np.einsum("kx,xcp->kcp", specific_force, REGRESSOR_BY_FEATURE[:3, :, :4])
    A = np.concatenate((body, np.broadcast_to(np.eye(6), (K, 6, 6))), axis=2)
    changes = squared_lengths(wrench - wrench.mean(axis=0)).mean(axis=0) / 3.0
    floor = np.maximum(SMALLEST_ERROR**2 * changes, 1e-300)
    found = np.empty(K)
    for k in range(K):
        others = np.arange(K) != k
        variance = np.maximum(changes, floor)
        for _ in range(REWEIGHTINGS):
            unit = np.repeat(np.sqrt(variance), 3)
            X = (A[others] / unit[:, None]).reshape(-1, A.shape[2])
            y = (wrench[others] / unit).ravel()
            solution = np.linalg.lstsq(X, y, rcond=None)[0]
            left = squared_lengths(wrench[others] - A[others] @ solution).sum(axis=0)
            freedoms = 3.0 * (K - 1) - 0.5 * A.shape[2]
            variance = np.maximum(left / freedoms, floor)
        unit = np.repeat(np.sqrt(variance), 3)
        X = (A[others] / unit[:, None]).reshape(-1, A.shape[2])
        own = A[k] / unit[:, None]
        r = (wrench[k] - A[k] @ solution) / unit
        S = np.eye(6) + own @ np.linalg.pinv(X.T @ X) @ own.T
        found[k] = r @ np.linalg.solve(S, r) / 6.0
    return found
