"""Projection: the non-negative masses at given points whose parameters are nearest to
given ones, in the metric of a covariance

    minimise  w/2 |M m - phi|²_C + ½ sum (m_i - m0 v_i)² / (m0² v_i)    over m >= 0,   |x|²_C = x'C^-1 x

with w = `DISTANCE_WEIGHT`.

The second term, negligible compared with the first, selects the most uniform of all
distributions with the same parameters. The dual problem has ten unknowns for any number
of points: with z = w C^-1 (phi - M m), m = max(m0 v + m0² v M'z, 0). A semismooth
Newton method finds z, for a small w first: where phi is far from all bodies it would
hardly advance from zero. From the z of a like problem it most often takes one step.
"""

from typing import NamedTuple

import numpy as np

from hefting.core.lapack import lapack
from hefting.core.spatial import Array
from hefting.estimators.quadratic import nonnegative_least_squares

DISTANCE_WEIGHT = 1e4
"""Weight w of the distance from the parameters, relative to the evenness of the mass
distribution."""
SMALL_WEIGHT = 30.0
"""Smaller w whose solution is the start of the final one. In 473 projections of the
tests Newton's method misses `DUAL_TOLERANCE` 41 times without it and 28 times with it,
always within `RELATIVE_DUAL_TOLERANCE`."""
MOST_DUAL_STEPS = 40
"""Largest number of Newton steps on each dual problem."""
MOST_LENGTHS = 20
"""Largest number of step lengths that are tried."""
LENGTH_TOLERANCE = 1e-3
"""Error of the length of a step."""
DUAL_TOLERANCE = 1e-6
"""Largest entry of the dual's gradient at convergence: error of the parameters in
standard deviations."""
RELATIVE_DUAL_TOLERANCE = 1e-5
"""The same as a share of the distance to the parameters, with which rounding grows."""
NEGLIGIBLE_DUAL_CHANGE = 1e-13
"""Relative change of the dual objective that is attributed to rounding."""
SMALLEST_SHARE = 1e-9
"""Diagonal that keeps the dual equations invertible, relative to their diagonal."""


class Projection(NamedTuple):
    """The non-negative point masses nearest to given parameters."""

    masses: Array
    """(n,) [kg]"""
    distance: float
    """squared Mahalanobis distance of their parameters from the given ones"""
    dual: Array | None
    """(10,) z for 1 kg at each point, a start for a similar search; None if Newton's
    method did not converge"""


def projected(
    phi: Array,
    covariance: Array,
    points: Array,
    shares: Array,
    mass: float,
    dual: Array | None = None,
) -> Projection:
    """The non-negative point masses whose parameters are nearest to phi.

    Parameters
    ----------
    phi : (10,) parameters.
    covariance : (10, 10) C, the metric.
    points : (10, n) M, the parameters of 1 kg at each point.
    shares : (n,) v, the shares of the volume; they sum to one.
    mass : m0 > 0 [kg].
    dual : (10,) of a like problem, which saves time.
    """
    scale = np.sqrt(covariance.diagonal())
    scale = np.where(scale > 0.0, scale, 1.0)
    M = points * (mass / scale[:, None])
    C = covariance / np.outer(scale, scale)
    target = phi / scale
    even = np.maximum(shares, 1e-9)
    found = None
    if dual is not None:
        found = _from_dual(C, target, M, even, dual * (scale / mass))
    if found is None:
        z, _, _ = _solve_dual(_metric(C, SMALL_WEIGHT), target, M, even, np.zeros(10))
        found = _from_dual(C, target, M, even, z)
    if found is not None:
        z, m, distance = found
        return Projection(np.asarray(mass * m), distance, z * (mass / scale))
    metric = _metric(C, DISTANCE_WEIGHT)
    masses = _nearest(M, target, metric)
    off = M @ masses - target
    distance = off @ np.linalg.lstsq(DISTANCE_WEIGHT * metric, off, rcond=1e-12)[0]
    return Projection(mass * masses, float(distance), None)


def dual_of(masses: Array, points: Array, shares: Array) -> Array | None:
    """(10,) `Projection.dual` from the masses (n,) that a projection found over points
    (10, n) with shares (n,) of the volume: positive masses are m0 v (1 + M'z). None if
    z is undetermined."""
    total = float(masses.sum())
    if not total > 0.0:
        return None
    weighted = points * (shares * (masses > 0.0))
    J = weighted @ points.T
    scale = 1.0 / np.sqrt(np.maximum(J.diagonal(), 1e-300))
    left = points @ (masses / total) - weighted.sum(axis=1)
    J *= np.outer(scale, scale)
    J.ravel()[::11] += SMALLEST_SHARE  # cells in a plane leave some of z open
    _, z, failed = lapack.dposv(J, left * scale)
    return None if failed else z * scale


def _metric(C: Array, weight: float) -> Array:
    """C/w, kept invertible."""
    metric = C / weight
    metric.ravel()[::11] += 1e-14
    return metric


def _from_dual(
    C: Array, target: Array, M: Array, even: Array, z: Array
) -> tuple[Array, Array, float] | None:
    """The dual z, the masses (n,) in units of m0 and their squared distance, by
    Newton's method from z (10,); None if it does not converge."""
    metric = _metric(C, DISTANCE_WEIGHT)
    z, error, m = _solve_dual(metric, target, M, even, z)
    distance = float(z @ metric @ z) / DISTANCE_WEIGHT
    if error < DUAL_TOLERANCE + RELATIVE_DUAL_TOLERANCE * distance**0.5:
        return z, m, distance
    return None


def _solve_dual(
    C: Array, target: Array, M: Array, even: Array, z: Array
) -> tuple[Array, float, Array]:
    """Newton's method from z (10,): z, the largest entry of the gradient, and the
    masses (n,) in units of m0. The dual is ½ z'Cz - z'phi + ½ sum max(1 + M'z, 0)² v.
    """
    for _ in range(MOST_DUAL_STEPS):
        slack = 1.0 + z @ M
        shares = even * (slack > 0.0)
        m = shares * slack
        linear = C @ z - target
        gradient = linear + M @ m
        error = float(np.abs(gradient).max())
        if error < DUAL_TOLERANCE:
            return z, error, m
        J = C + (M * shares) @ M.T
        _, step, failed = lapack.dposv(J, gradient)
        if failed:
            step = np.linalg.lstsq(J, gradient, rcond=1e-15)[0]
        descent = float(gradient @ step)
        if not descent > 0.0:
            break
        length = _length(
            slack, step @ M, even, float(step @ linear), float(step @ C @ step)
        )
        z = z - length * step
        if length * descent < NEGLIGIBLE_DUAL_CHANGE * (1.0 + abs(z @ target)):
            break
    m = even * np.maximum(1.0 + z @ M, 0.0)
    return z, float(np.abs(C @ z - target + M @ m).max()), m


def _length(
    slack: Array, change: Array, even: Array, slope: float, curvature: float
) -> float:
    """The length t of a step that minimises the dual along it, whose derivative there is

        -slope + t curvature - sum v_i c_i max(s_i - t c_i, 0)

    with s_i the slack of a point and c_i its change. That is piecewise linear and
    increasing: Newton's method finds its root, kept between those t where it was seen
    to be negative and positive.
    """
    weighted = even * change
    t, low, high = 1.0, 0.0, np.inf
    for _ in range(MOST_LENGTHS):
        left = slack - t * change
        active = np.where(left > 0.0, weighted, 0.0)
        derivative = t * curvature - slope - active @ left
        low, high = (t, high) if derivative < 0.0 else (low, t)
        found = t - float(derivative / (curvature + active @ change))
        before, t = t, found if low <= found <= high else 0.5 * (low + high)
        if abs(t - before) <= LENGTH_TOLERANCE:
            break
    return t


def _nearest(M: Array, target: Array, C: Array) -> Array:
    """Masses (n,) by non-negative least squares, without the term of evenness, where
    rounding prevents the convergence of Newton's method."""
    values, vectors = np.linalg.eigh(C)
    W = (vectors / np.sqrt(np.maximum(values, 1e-12 * values[-1]))).T
    scale = float(np.abs(W @ target).max()) or 1.0
    return nonnegative_least_squares(W @ M / scale, W @ target / scale)
