"""Nearest: the non-negative mass distribution nearest to the posterior mean, over cells
or voxels, where the shape most likely is; in the metric of the covariance

    minimise  w/2 |M m - phi|²_C + ½ sum (m_i - m0 v_i)² / (m0² v_i)    over m >= 0,   |x|²_C = x'C^-1 x

with w = `DISTANCE_WEIGHT`.

The second term, negligible compared with the first, selects the most uniform of all
distributions with the same parameters. The dual problem has ten unknowns for any number
of points: with z = w C^-1 (phi - M m), m = max(m0 v + m0² v M'z, 0). A semismooth
Newton method finds z, for a small w first: where phi is far from all bodies it would
hardly advance from zero. From the z of a like problem it most often takes one step.
"""

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np

from hefting.core.immutable import immutable
from hefting.core.inertia import InertialParameters
from hefting.core.lapack import lapack
from hefting.core.spatial import Array
from hefting.estimators.bayes.distortion import Move, affine
from hefting.estimators.bayes.mixture import Mixture
from hefting.estimators.bayes.prior import LARGEST_DISTORTION, Prior, vector_second
from hefting.estimators.quadratic import nonnegative_least_squares
from hefting.shapes import Shape

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
"""The same as a share of the distance from the parameters, with which rounding
grows."""
NEGLIGIBLE_DUAL_CHANGE = 1e-13
"""Relative change of the dual objective that is attributed to rounding."""
SMALLEST_SHARE = 1e-9
"""Diagonal term that keeps the dual equations invertible, relative to their
diagonal."""


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


SUFFICIENT_CELL_DISTANCE = 0.3
"""Squared Mahalanobis distance, for ten parameters, within which a mass distribution
over whole cells is accepted instead of one over voxels."""
SUFFICIENT_STATED_DISTANCE = 2.0
"""Squared Mahalanobis distance within which a mass distribution over the shape as
stated is accepted, if the pose's error was not given."""
MOST_SLIP_STEPS = 4
"""Largest number of steps in which an error of the pose is refined."""
NEGLIGIBLE_SLIP = 0.1
"""Error of a pose, in prior standard deviations, that is neglected."""
CELL_REACH = 3.0
"""Half the side of the box of cells about an object of unknown shape, in standard
deviations of its mass along that side."""
CONTRADICTING_SHAPE_DISTANCE = 30.0
"""Squared Mahalanobis distance, for ten parameters, between the posterior mean and the
nearest body in the shape above which the shape contradicts the wrench: about five
standard deviations more than expected."""


Duals = Mapping[str, Array]
"""`Projection.dual` (10,) by where masses were placed: ``cells``, ``moved`` cells, and
``voxels``."""


@immutable
class Nearest:
    """The non-negative mass distribution nearest to the posterior mean."""

    vector: Array
    """(10,)"""
    masses: Array
    """(n,) in each point's cell [kg]"""
    distance: float
    """squared, in standard deviations"""
    margin: float | None
    """of its COM in the hull, where the shape most likely is; None for a certain
    shape"""
    duals: Duals
    """start of the search for a similar body"""


def nearest_body(
    prior: Prior,
    move: Move | None,
    mixture: Mixture,
    shape: Shape,
    before: Duals | None = None,
) -> Nearest:
    """The mass distribution over uniform cells or, where that is not near enough, over
    voxels; `move` is where `prior` has put the shape, if that was uncertain. The
    mixture is that of the prior, or of a body of any kind. `before` is what the search
    for a like body left, which saves time."""
    of_shape = len(mixture.weights) == len(prior.log_weight)
    mean, C = mixture.mean, mixture.covariance
    if of_shape:
        mean = prior.mean_as_stated(mixture.weights, mixture.means)
    mass = max(float(mean[0]), 1e-3 * float(C[0, 0]) ** 0.5)
    duals = dict(before or {})

    def over(where: str, points: Array, shares: Array) -> tuple[Array, float]:
        found = projected(mean, C, points, shares, mass, duals.pop(where, None))
        if found.dual is not None:
            duals[where] = found.dual
        return found.masses, found.distance

    masses, distance = over("cells", prior.cells, prior.shares)
    scores = np.zeros(len(prior.slips.shifts))
    if prior.offsets is not None:
        if distance > SUFFICIENT_CELL_DISTANCE and mean[0] > 0.0:
            prior = _drawn_together(prior, mean)
            masses, distance = over("moved", prior.cells, prior.shares)
    elif of_shape and distance > SUFFICIENT_STATED_DISTANCE and len(scores):
        scores = prior.likely_slips(mixture.weights, mixture.means)
    stated = prior
    if np.abs(scores).max(initial=0.0) > NEGLIGIBLE_SLIP:
        prior, move = _slipped(stated, scores)
        masses, distance = over("moved", prior.cells, prior.shares)
    if distance < SUFFICIENT_CELL_DISTANCE:
        vector = prior.cells @ masses
    else:
        fine, distance = over("voxels", prior.voxels, prior.voxel_shares)
        for _ in range(MOST_SLIP_STEPS if scores.any() else 0):
            if distance < SUFFICIENT_STATED_DISTANCE:
                break
            scores = _nearer(stated, scores, prior.voxels @ fine, mean, C)
            closer, there = _slipped(stated, scores)
            tried = over("voxels", closer.voxels, closer.voxel_shares)
            if tried[1] >= distance:
                break
            (fine, distance), prior, move = tried, closer, there
        vector = prior.voxels @ fine
        masses = fine.reshape(shape.n, -1).sum(axis=1)
        if distance > CONTRADICTING_SHAPE_DISTANCE and mean[0] > 0.0:
            return _without_shape(mean, masses, distance, duals)
    margin = None
    if move is not None and vector[0] > 0.0:
        margin = shape.margin(move.back(vector[1:4] / vector[0]))
    return Nearest(vector, masses, distance, margin, duals)


def duals_of(masses: Array | None, prior: Prior) -> Duals | None:
    """Start of a search from the masses (n,) that were found before in each cell; None
    if they are unknown or of another shape."""
    if masses is None or len(masses) != len(prior.shares):
        return None
    dual = dual_of(masses, prior.cells, prior.shares)
    return None if dual is None else {"cells": dual}


def _without_shape(
    mean: Array, masses: Array, distance: float, duals: Duals
) -> Nearest:
    """The body of any shape nearest to the mean, where no masses in the given shape
    come near it; `masses` (n,) are scaled to its mass."""
    body = InertialParameters(mean)
    m = body.mass
    c = mean[1:4] / m
    values, vectors = np.linalg.eigh(body.pseudo_inertia[:3, :3] / m - np.outer(c, c))
    P = np.empty((4, 4))
    P[:3, :3] = (vectors * np.maximum(values, 0.0)) @ vectors.T + np.outer(c, c)
    P[:3, 3] = P[3, :3] = c
    P[3, 3] = 1.0
    vector = InertialParameters.from_pseudo_inertia(m * P).vector
    share = float(masses.sum()) or 1.0
    return Nearest(np.array(vector), masses * (m / share), distance, None, duals)


def _slipped(prior: Prior, scores: Array) -> tuple[Prior, Move]:
    """Cells and voxels moved by errors of the pose of `scores` (d,) standard
    deviations."""
    move = prior.slips.by(scores)
    return prior.placed_by(move.parameters), move


def _nearer(prior: Prior, scores: Array, found: Array, mean: Array, C: Array) -> Array:
    """Errors of the pose (d,) that bring the body `found` (10,) nearer to `mean`: one
    Gauss-Newton step in the metric of C with a normal prior of the errors."""
    there = prior.slips.by(scores)
    body = np.asarray(np.linalg.solve(there.parameters, found), dtype=float)
    X = prior.slips.effects(body, scores)
    scale = np.sqrt(C.diagonal())
    X, off = X / scale[:, None], (mean - found) / scale
    W = np.linalg.pinv(C / np.outer(scale, scale), rcond=1e-12, hermitian=True)
    step = np.linalg.solve(X.T @ W @ X + np.eye(len(scores)), X.T @ W @ off - scores)
    return np.clip(scores + step, -LARGEST_DISTORTION, LARGEST_DISTORTION)


def _drawn_together(prior: Prior, phi: Array) -> Prior:
    """Cells and voxels of a box contracted about the body phi (10,), to `CELL_REACH` of
    its standard deviations on each side but inside the box: the original cells may be
    larger than the object."""
    c = phi[1:4] / phi[0]
    second = vector_second(phi) / phi[0] - np.outer(c, c)
    low, high = prior.voxels[1:4].min(axis=1), prior.voxels[1:4].max(axis=1)
    least = (1e-3 * (high - low).max()) ** 2
    reach = CELL_REACH * np.sqrt(np.maximum(second.diagonal(), least))
    lower, upper = np.maximum(c - reach, low), np.minimum(c + reach, high)
    if (lower >= upper).any():
        return prior
    A = np.diag((upper - lower) / (high - low))
    return prior.placed_by(affine(A, lower - A @ low))
