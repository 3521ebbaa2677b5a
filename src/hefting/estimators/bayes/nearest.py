"""Nearest: the non-negative mass distribution nearest to the posterior mean, over cells
or voxels, where the shape most likely is."""

from collections.abc import Mapping

import numpy as np

from hefting.core.immutable import immutable
from hefting.core.inertia import InertialParameters
from hefting.core.spatial import Array
from hefting.estimators.bayes.distortion import Move, affine
from hefting.estimators.bayes.mixture import Mixture
from hefting.estimators.bayes.prior import LARGEST_DISTORTION, Prior, vector_second
from hefting.estimators.bayes.projection import dual_of, projected
from hefting.shapes import Shape

SUFFICIENT_CELL_DISTANCE = 0.3
"""Squared Mahalanobis distance, for ten parameters, within which a mass distribution
over whole cells is accepted instead of one over voxels."""
SUFFICIENT_STATED_DISTANCE = 2.0
"""Squared Mahalanobis distance within which a mass distribution over the shape as
stated is accepted, where nothing was said of the pose's error."""
MOST_SLIP_STEPS = 4
"""Largest number of steps in which an error of the pose is found more exactly."""
NEGLIGIBLE_SLIP = 0.1
"""Error of a pose, in prior standard deviations, for which nothing is moved."""
CELL_REACH = 3.0
"""Half the side of the box of cells about an object of unknown shape, in standard
deviations of its mass along that side."""
CONTRADICTING_SHAPE_DISTANCE = 30.0
"""Squared Mahalanobis distance, for ten parameters, between the posterior mean and the
nearest body in the shape above which the shape contradicts the wrench: about five
standard deviations more than expected."""


Duals = Mapping[str, Array]
"""`Projection.dual` (10,) by where mass was looked for: ``cells``, ``moved`` cells, and
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
    """with which the search for a body that is a little different may begin"""


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
    """With what the search for a body may begin, by the masses (n,) in each cell of one
    that was found before; None where they are not known, or of another shape."""
    if masses is None or len(masses) != len(prior.shares):
        return None
    dual = dual_of(masses, prior.cells, prior.shares)
    return None if dual is None else {"cells": dual}


def _without_shape(
    mean: Array, masses: Array, distance: float, duals: Duals
) -> Nearest:
    """The body nearest to the mean of any shape, where no mass in the given one comes
    near it; `masses` (n,) are scaled to its mass."""
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
    """Cells and voxels where errors of the pose of so many standard deviations (d,) have
    them."""
    move = prior.slips.by(scores)
    return prior.placed_by(move.parameters), move


def _nearer(prior: Prior, scores: Array, found: Array, mean: Array, C: Array) -> Array:
    """Errors of the pose (d,) that bring the body `found` (10,) nearer to `mean`: a step
    of Gauss and Newton, in the metric of C, with each error normal."""
    there = prior.slips.by(scores)
    body = np.asarray(np.linalg.solve(there.parameters, found), dtype=float)
    X = prior.slips.effects(body, scores)
    scale = np.sqrt(C.diagonal())
    X, off = X / scale[:, None], (mean - found) / scale
    W = np.linalg.pinv(C / np.outer(scale, scale), rcond=1e-12, hermitian=True)
    step = np.linalg.solve(X.T @ W @ X + np.eye(len(scores)), X.T @ W @ off - scores)
    return np.clip(scores + step, -LARGEST_DISTORTION, LARGEST_DISTORTION)


def _drawn_together(prior: Prior, phi: Array) -> Prior:
    """Cells and voxels of a box drawn together about the body of parameters phi (10,),
    `CELL_REACH` of its standard deviations to each side but inside the box: as they
    are, they may be larger than the whole object."""
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
