"""Robust least squares of many alternatives at once, such as clock offsets or mistakes.

Every column of a design matrix, and the wrench, are linear in the known row of a
sample, so that the normal equations of an alternative follow from its Z'WZ, as in
`hefting.ingest.model`. The residuals of a sample follow a multivariate Student t
distribution, so that contacts and spikes count little (Lange, Little & Taylor, J.
American Statistical Association 84, 1989).
"""

from dataclasses import dataclass

import numpy as np

from hefting.core.spatial import Array, squared_lengths
from hefting.ingest.fit import STUDENT_DEGREES_OF_FREEDOM

DAMPING = 1e-9
"""Added to the diagonal of normal equations that were scaled to ones there: it keeps
what the motion leaves undetermined finite."""


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
    known, wrench = both[:, :, :-6], both[:, :, -6:]
    O, K, _ = known.shape
    nu = STUDENT_DEGREES_OF_FREEDOM
    residual = wrench - wrench.mean(axis=1, keepdims=True)
    square = squared_lengths(residual)
    count = np.maximum(used.sum(axis=1), 1.0)
    scale = np.maximum(np.sqrt(square.mean(axis=1) / 3.0), floor)
    weights = np.ones((O, K))
    solution = np.zeros((O, maps.shape[2]))
    for _ in range(iterations):
        solution = solve_each(*normal_equations(both, maps, used * weights, scale))
        residual = wrench - known @ np.einsum("zcp,op->ozc", maps, solution)
        square = squared_lengths(residual)
        for _ in range(2):
            distance = np.einsum("okt,ot->ok", square, scale**-2.0)
            weights = (nu + 6.0) / (nu + distance)
            total = np.einsum("ok,okt->ot", used * weights, square)
            scale = np.maximum(np.sqrt(total / (3.0 * count[:, None])), floor)
    distance = np.einsum("okt,ot->ok", square, scale**-2.0)
    tail = 0.5 * (nu + 6.0) * np.log1p(distance / nu)
    likelihood = -np.sum(used * tail, axis=1) / count - 3.0 * np.log(scale).sum(axis=1)
    likelihood[count < 0.5 * K] = -np.inf
    return RobustRows(likelihood, solution, scale, used * weights, residual)


def normal_equations(
    both: Array, maps: Array, weights: Array, scale: Array
) -> tuple[Array, Array]:
    """Normal matrices (O, p, p) and right-hand sides (O, p), for weights (O, K) and
    residual scales (O, 2); the other arguments as for `fit_each`."""
    z = both.shape[2] - 6
    gram = np.swapaxes(both * weights[:, :, None], 1, 2) @ both
    inverse_variance = np.repeat(scale**-2.0, 3, axis=1)
    O, p = len(both), maps.shape[2]
    normal, right = np.zeros((O, p, p)), np.zeros((O, p))
    for channel, columns in enumerate(maps.transpose(1, 0, 2)):
        rows = np.flatnonzero(columns.any(axis=1))
        used = columns[rows]
        weight = inverse_variance[:, channel]
        part = gram[:, rows[:, None], rows]
        normal += weight[:, None, None] * (used.T @ (part @ used))
        right += weight[:, None] * (gram[:, rows, z + channel] @ used)
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
