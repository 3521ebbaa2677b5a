"""The non-negative mass distribution nearest to given parameters, in the metric of their covariance.

    minimise  `FAITH`/2 |M m - phi|²_C + ½ sum (m_i - m0 v_i)² / (m0² v_i)    over m >= 0,   |x|²_C = x'C^-1 x

The second term, negligible beside the first, chooses among all distributions of the same parameters the most even. Its
dual has ten unknowns, whatever the number of points: with z = C^-1 (phi - M m) `FAITH`, m = max(m0 v + m0² v M'z, 0);
a semismooth Newton method finds z.
"""

import numpy as np

from hefting.core.lapack import lapack
from hefting.core.spatial import Array

FAITH = 1e4
MAX_STEPS = 40
CLOSE = 1e-6
"""Standard deviations by which the answer may miss the nearest distribution."""
ROUNDING = 1e-13
"""Relative change of the objective that is none."""


def projected(phi: Array, covariance: Array, points: Array, shares: Array, mass: float) -> tuple[Array, float]:
    """Masses (n,) >= 0, and their squared distance from phi in that metric.

    `points` M (10, n) are the parameters of 1 kg at each point, `shares` v (n,) sum to one, `mass` m0 > 0 [kg].
    """
    scale = np.sqrt(covariance.diagonal())
    scale = np.where(scale > 0.0, scale, 1.0)
    M = points * (mass / scale[:, None])
    C = covariance / np.outer(scale, scale) / FAITH
    C.ravel()[::11] += 1e-14
    target = phi / scale
    even = np.maximum(shares, 1e-9)

    def dual(z: Array) -> tuple[float, Array, Array]:
        """Value, gradient and masses [m0]: ½ z'Cz - z'phi + ½ sum max(1 + M'z, 0)² v."""
        t = np.maximum(1.0 + z @ M, 0.0)
        m = even * t
        Cz = C @ z
        return float(0.5 * (z @ Cz) - z @ target + 0.5 * (t @ m)), Cz - target + M @ m, m

    z = np.zeros(10)
    value, gradient, m = dual(z)
    for _ in range(MAX_STEPS):
        active = m > 0.0
        J = C + (M[:, active] * even[active]) @ M[:, active].T
        _, step, failed = lapack.dposv(J, gradient)
        if failed:
            step = np.linalg.lstsq(J, gradient, rcond=1e-15)[0]
        slope, length = float(gradient @ step), 1.0
        while True:
            trial = dual(z - length * step)
            enough = value - 1e-4 * length * slope + ROUNDING * (1.0 + abs(value))
            if trial[0] <= enough or length < 1e-6:
                break
            length *= 0.5
        z = z - length * step
        value, gradient, m = trial
        if np.abs(gradient).max() < CLOSE or length < 1e-6:
            break
    if np.abs(gradient).max() < CLOSE:
        return mass * m, float(z @ C @ z) / FAITH
    m = _nearest(M, target, C)
    off = M @ m - target
    return mass * m, float(off @ np.linalg.lstsq(FAITH * C, off, rcond=1e-12)[0])


def _nearest(M: Array, target: Array, C: Array) -> Array:
    """The same without regard to how even they are: non-negative least squares, for when rounding stops Newton."""
    from scipy.optimize import nnls

    values, vectors = np.linalg.eigh(C)
    W = (vectors / np.sqrt(np.maximum(values, 1e-12 * values[-1]))).T
    scale = float(np.abs(W @ target).max()) or 1.0
    return nnls(W @ M / scale, W @ target / scale, maxiter=100 * M.shape[1])[0]
