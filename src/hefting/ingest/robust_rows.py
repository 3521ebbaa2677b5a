"""Robust least squares of many alternatives at once, such as clock offsets or mistakes.

Every column of a design matrix, and the wrench, are linear in the known row of a
sample, so that the normal equations of an alternative follow from its Z'WZ, as in
`hefting.ingest.model`. The residuals of a sample follow a multivariate Student t
distribution, so that contacts and spikes count little (Lange, Little & Taylor, J.
American Statistical Association 84, 1989).
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from hefting.core.spatial import Array, squared_lengths
from hefting.ingest.fit import STUDENT_DEGREES_OF_FREEDOM

DAMPING = 1e-9
"""Added to the diagonal of normal equations that were scaled to ones there: it keeps
what the motion leaves undetermined finite."""

ALTERNATIVES_AT_A_TIME = 16
"""Of so many what is computed in between stays in the processor's cache."""


@dataclass(frozen=True, eq=False)
class RobustRows:
    """Robust fits of O alternatives to K samples."""

    likelihood: Array
    """(O,) log-likelihood of one sample on average, up to a constant; -inf where the
    motion is known at less than half of them"""
    solution: Array
    """(O, p)"""
    scale: Array
    """(O, 2) size of force [N] and torque [N m] residuals"""
    weights: Array
    """(O, K) of the samples; zero where the motion is not known"""
    residual: Array
    """(O, K, 6)"""

    @property
    def best(self) -> int:
        """Index of the most likely alternative."""
        return int(np.argmax(self.likelihood))


def fit_each(
    both: Array, maps: Array, used: Array, floor: Array, iterations: int
) -> RobustRows:
    """Least squares of each alternative by iterative reweighting.

    Parameters
    ----------
    both : (O, K, z + 6) known rows, with the wrench behind them.
    maps : (z, 6, p) columns of the design matrix per unit of a known row.
    used : (O, K) 1 where the motion is known, else 0.
    floor : (2,) smallest size of a residual of force [N] and torque [N m].
    iterations : how often the samples are weighted anew.
    """
    O, z = len(both), both.shape[2] - 6
    flat = maps.reshape(6 * z, -1)

    def solve(weights: Array, scale: Array) -> tuple[Array, Array]:
        solution = solve_each(*normal_equations(both, maps, weights, scale))
        return solution, (solution @ flat.T).reshape(O, z, 6)

    return _reweighted(both, used, floor, iterations, solve)


def fit_channels(both: Array, used: Array, floor: Array, iterations: int) -> RobustRows:
    """The same where each channel of the wrench is any linear function of the known
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
) -> RobustRows:
    """Least squares by iterative reweighting.

    `solve` finds solutions, and the wrench per unit of the known rows (O, z, 6), from
    weights (O, K) and scales (O, 2); the other arguments are those of `fit_each`.
    """
    known, wrench = both[:, :, :-6], both[:, :, -6:]
    O, K, _ = known.shape
    nu = STUDENT_DEGREES_OF_FREEDOM
    residual = wrench - wrench.mean(axis=1, keepdims=True)
    square = squared_lengths(residual)
    count = np.maximum(used.sum(axis=1), 1.0)
    scale = np.maximum(np.sqrt(square.mean(axis=1) / 3.0), floor)
    weights, solution = np.ones((O, K)), np.zeros((O, 0))
    for _ in range(iterations):
        solution, coefficients = solve(used * weights, scale)
        residual = wrench - known @ coefficients
        square = squared_lengths(residual)
        for _ in range(2):
            weights = (nu + 6.0) / (nu + _distances(square, scale))
            total = ((used * weights)[:, None] @ square)[:, 0]
            scale = np.maximum(np.sqrt(total / (3.0 * count[:, None])), floor)
    tail = 0.5 * (nu + 6.0) * np.log1p(_distances(square, scale) / nu)
    likelihood = -np.sum(used * tail, axis=1) / count - 3.0 * np.log(scale).sum(axis=1)
    likelihood[count < 0.5 * K] = -np.inf
    return RobustRows(likelihood, solution, scale, used * weights, residual)


def _distances(square: Array, scale: Array) -> Array:
    """(O, K) squares of force and torque residuals (O, K, 2) in units of their sizes
    (O, 2)."""
    return (square @ (scale**-2.0)[:, :, None])[:, :, 0]


def normal_equations(
    both: Array, maps: Array, weights: Array, scale: Array
) -> tuple[Array, Array]:
    """Normal matrices (O, p, p) and right-hand sides (O, p), for weights (O, K) and
    residual scales (O, 2); the other arguments as for `fit_each`."""
    O, z, p = len(both), both.shape[2] - 6, maps.shape[2]
    flat = maps.reshape(6 * z, p)
    normal, right = np.empty((O, p, p)), np.empty((O, p))
    for first in range(0, O, ALTERNATIVES_AT_A_TIME):
        part = slice(first, first + ALTERNATIVES_AT_A_TIME)
        weighted = both[part, :, :z] * weights[part, :, None]
        gram = np.swapaxes(weighted, 1, 2) @ both[part]
        inverse_variance = np.repeat(scale[part] ** -2.0, 3, axis=1)
        columns = (gram[:, :, :z] @ maps.reshape(z, -1)).reshape(-1, z, 6, p)
        columns *= inverse_variance[:, None, :, None]
        normal[part] = flat.T @ columns.reshape(-1, 6 * z, p)
        sums = gram[:, :, z:] * inverse_variance[:, None]
        right[part] = sums.reshape(-1, 6 * z) @ flat
    return normal, right


def scaled_to_ones(normal: Array) -> tuple[Array, Array]:
    """Normal matrices (O, p, p) scaled to a unit diagonal and slightly damped, and the
    scales (O, p): one where the data do not depend on an unknown."""
    length = np.sqrt(np.maximum(np.diagonal(normal, axis1=1, axis2=2), 0.0))
    length = np.where(length > 1e-150, length, 1.0)
    scaled = normal / length[:, :, None] / length[:, None, :]
    return scaled + DAMPING * np.eye(normal.shape[1]), length


def solve_each(normal: Array, right: Array) -> Array:
    """Solutions (O, p) of normal equations (O, p, p) and (O, p)."""
    scaled, length = scaled_to_ones(normal)
    return np.linalg.solve(scaled, (right / length)[:, :, None])[:, :, 0] / length
