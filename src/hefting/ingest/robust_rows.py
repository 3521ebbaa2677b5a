"""Robust least squares of many alternatives at once, such as clock offsets or mistakes.

The columns of the design matrix and the wrench are linear in the known row of a sample,
so that the normal equations of an alternative follow from its Z'WZ, as in
`hefting.ingest.model`. The residuals of a sample have a multivariate Student t
distribution, so that contacts and spikes count little (Lange, Little & Taylor, J.
American Statistical Association 84, 1989).
"""

from collections.abc import Callable

import numpy as np

from hefting.core.lapack import lapack
from hefting.core.spatial import Array, immutable, squared_lengths
from hefting.ingest.fit import STUDENT_DEGREES_OF_FREEDOM

DAMPING = 1e-9
"""Added to the unit diagonal of scaled normal equations, so that undetermined unknowns
stay finite."""

ALTERNATIVES_AT_A_TIME = 16
"""Number of alternatives processed together, whose intermediate values stay in the
processor's cache."""


@immutable
class RobustRows:
    """Robust fits of O alternatives to K samples."""

    likelihood: Array
    """(O,) mean log-likelihood of a sample, up to a constant; -inf if the motion is
    known at less than half of the samples"""
    solution: Array
    """(O, p)"""
    scale: Array
    """(O, 2) scale of force [N] and torque [N m] residuals"""
    weights: Array
    """(O, K) of the samples; zero where the motion is unknown"""
    residual: Array
    """(O, K, 6)"""

    @property
    def best(self) -> int:
        """Index of the most likely alternative."""
        return int(np.argmax(self.likelihood))


def fit_each(
    both: Array,
    maps: Array,
    used: Array,
    floor: Array,
    iterations: int,
    start: RobustRows | None = None,
) -> RobustRows:
    """Least squares of each alternative by iterative reweighting.

    Parameters
    ----------
    both : (O, K, z + 6) known rows, followed by the wrench.
    maps : (z, 6, p) columns of the design matrix per unit of a known row.
    used : (O, K) 1 where the motion is known, else 0.
    floor : (2,) smallest size of a residual of force [N] and torque [N m].
    iterations : number of reweightings.
    start : fits of similar models, from whose weights to begin.
    """
    O, z = len(both), both.shape[2] - 6
    flat = maps.reshape(6 * z, -1)

    def solve(weights: Array, scale: Array) -> tuple[Array, Array]:
        solution = solve_each(*normal_equations(both, maps, weights, scale))
        return solution, (solution @ flat.T).reshape(O, z, 6)

    return _reweighted(both, used, floor, iterations, solve, start)


def fit_channels(both: Array, used: Array, floor: Array, iterations: int) -> RobustRows:
    """As `fit_each`, if each channel of the wrench is any linear function of the known
    rows: the solution (O, 6 z) holds the coefficients (z, 6)."""

    def solve(weights: Array, scale: Array) -> tuple[Array, Array]:
        gram = np.swapaxes(both * weights[:, :, None], 1, 2) @ both
        scaled, length = scaled_to_ones(gram[:, :-6, :-6])
        right = gram[:, :-6, -6:] / length[:, :, None]
        coefficients = np.linalg.solve(scaled, right) / length[:, :, None]
        return coefficients.reshape(len(both), -1), coefficients

    return _reweighted(both, used, floor, iterations, solve)


def _reweighted(
    both: Array,
    used: Array,
    floor: Array,
    iterations: int,
    solve: Callable[[Array, Array], tuple[Array, Array]],
    start: RobustRows | None = None,
) -> RobustRows:
    """Least squares by iterative reweighting.

    `solve` returns solutions, and the wrench per unit of the known rows (O, z, 6), for
    weights (O, K) and scales (O, 2); other arguments as for `fit_each`.
    """
    known, wrench = both[:, :, :-6], both[:, :, -6:]
    O, K, _ = known.shape
    nu = STUDENT_DEGREES_OF_FREEDOM
    residual = wrench
    count = np.maximum(used.sum(axis=1), 1.0)
    per_axis, least = 3.0 * count[:, None], np.square(floor)
    solution, square = np.zeros((O, 0)), np.zeros((O, K, 2))
    if start is not None:
        weights, variance = start.weights, np.square(start.scale)
    else:
        changes = np.var(wrench, axis=1).reshape(O, 2, 3).sum(axis=2)
        weights, variance = used, np.maximum(changes / 3.0, least)
    heavy = (nu + 6.0) * used
    for _ in range(iterations):
        solution, coefficients = solve(weights, np.sqrt(variance))
        residual = wrench - known @ coefficients
        square = squared_lengths(residual)
        for _ in range(2):
            weights = heavy / (nu + _distances(square, variance))
            total = (weights[:, None] @ square)[:, 0]
            variance = np.maximum(total / per_axis, least)
    tail = 0.5 * (nu + 6.0) * np.log1p(_distances(square, variance) / nu)
    likelihood = -np.sum(used * tail, axis=1) / count
    likelihood -= 1.5 * np.log(variance).sum(axis=1)
    likelihood[count < 0.5 * K] = -np.inf
    return RobustRows(likelihood, solution, np.sqrt(variance), weights, residual)


def _distances(square: Array, variance: Array) -> Array:
    """(O, K) squared residuals of force and torque (O, K, 2) over variances (O, 2)."""
    return (square @ (1.0 / variance)[:, :, None])[:, :, 0]


def normal_equations(
    both: Array, maps: Array, weights: Array, scale: Array
) -> tuple[Array, Array]:
    """Normal matrices A'WA (O, p, p) and right-hand sides A'Wy (O, p) of the design
    matrices A = `both` `maps` and the wrench y, from the Gram matrices of `both`. The
    weights are (O, K), the residual scales (O, 2); other arguments as for `fit_each`.
    """
    O, z, p = len(both), both.shape[2] - 6, maps.shape[2]
    flat, wide = maps.reshape(6 * z, p), maps.reshape(z, 6 * p)
    normal, right = np.empty((O, p, p)), np.empty((O, p))
    for first in range(0, O, ALTERNATIVES_AT_A_TIME):
        part = slice(first, first + ALTERNATIVES_AT_A_TIME)
        weighted = both[part, :, :z] * weights[part, :, None]
        gram = weighted.transpose(0, 2, 1) @ both[part]
        inverse_variance = scale[part, None, :, None] ** -2.0
        columns = (gram[:, :, :z] @ wide).reshape(-1, z, 2, 3 * p)
        columns *= inverse_variance
        normal[part] = flat.T @ columns.reshape(-1, 6 * z, p)
        sums = gram[:, :, z:].reshape(-1, z, 2, 3) * inverse_variance
        right[part] = sums.reshape(-1, 6 * z) @ flat
    return normal, right


def scaled_to_ones(normal: Array) -> tuple[Array, Array]:
    """Normal matrices (O, p, p) scaled to a unit diagonal and slightly damped, and the
    scales (O, p): one for an unknown without information."""
    length = np.sqrt(np.maximum(np.einsum("oii->oi", normal), 0.0))
    length[length <= 1e-150] = 1.0
    scaled = normal / length[:, :, None]
    scaled /= length[:, None, :]
    np.einsum("oii->oi", scaled)[...] += DAMPING
    return scaled, length


def solve_each(normal: Array, right: Array) -> Array:
    """Solutions (O, p) of normal equations (O, p, p) and (O, p)."""
    scaled, length = scaled_to_ones(normal)
    solution = right / length
    for N, x in zip(scaled, solution, strict=True):
        _, x[:], failed = lapack.dposv(N.T, x)
        if failed:  # not finite
            x[:] = np.nan
    return solution / length
