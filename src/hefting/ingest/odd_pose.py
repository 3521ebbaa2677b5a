"""An odd pose among a few static ones: the sensor was touched in it, or its orientation was
written down wrongly.

Every pose is predicted from the others by least squares. With r its residual and S the
covariance of r, by the residuals that the others leave, r' S^-1 r / 6 is about as large
as a variable of the F distribution where all poses are right. Among many poses outliers
are found without that (`hefting.ingest.outliers`).
"""

from dataclasses import replace

import numpy as np

from hefting.core.spatial import Array, squared_lengths
from hefting.ingest.fit import Fit
from hefting.ingest.model import REGRESSOR_BY_FEATURE
from hefting.ingest.outliers import Outliers, no_outliers
from hefting.ingest.samples import Samples

FEWEST_POSES = 6
"""Fewest poses of which one may be left out: mass, COM and bias need three of the others."""
ODD = 50.0
"""r' S^-1 r / 6 from which on a pose is odd. Of 400 right simulated sets of 6 to 11 poses it
is at most 12, of 1,200 choices of a real sensor's 13, of 2,800 with a mistake in all poses
45. Of a pose that was touched with 9 N or turned by 40° it is at least 53; with 3 N it is
above 65 in all but a twentieth of a real sensor's, turned by 20° above 30."""
SMALLEST_ERROR = 0.003
"""Share of the wrench's changes below which what a pose leaves is the sensor's error."""
REWEIGHTINGS = 4
"""Times that force and torque are weighted by what they leave."""


def find_odd_pose(samples: Samples, fit: Fit) -> Outliers:
    """The pose that the others contradict most, where they do."""
    none = no_outliers(len(samples.time))
    if not samples.static or len(samples.time) < FEWEST_POSES:
        return none
    oddness = _oddness(fit.model.features[:, :3], samples.wrench)
    spike = np.zeros(len(oddness), dtype=bool)
    spike[np.argmax(oddness)] = oddness.max() > ODD
    return replace(none, spike=spike)


def _oddness(specific_force: Array, wrench: Array) -> Array:
    """(K,) r' S^-1 r / 6 of each pose, from a - g (K, 3) in sensor axes [m/s²] and wrenches
    (K, 6) with a bias."""
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
