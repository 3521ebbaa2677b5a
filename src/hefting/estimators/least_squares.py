"""Least squares of the ten parameters, unconstrained, and of a constant bias."""

from __future__ import annotations

import numpy as np

from hefting.core.immutable import immutable
from hefting.core.spatial import Array, Indices
from hefting.estimators.joint_state import JointState, State, WhitenedState, as_one
from hefting.estimators.quadratic import (
    Quadratic,
    ScaledSVD,
    WrenchNoise,
    stacked_factor,
    warnings_of,
    with_equation,
)


@immutable
class LeastSquares:
    """Least-squares fit of the full model: the ten parameters and, when it is free, the
    six of a constant bias."""

    solution: Array
    """(10,) or (16,); (10,) of several recordings"""
    bias: Array | None
    """(6,) constant bias, or (n, 6) those of n recordings; None where none is free"""
    covariance: Array
    """(10, 10) or (16, 16), as the solution; infinite where the data do not decide"""
    free: Indices
    """indices of the unknowns the data do not decide"""
    square: float
    """sum of squared (whitened) residuals"""
    bound: float
    """lower bound on its minimum, by the gradient that is left"""

    @property
    def warnings(self) -> tuple[str, ...]:
        """A sentence on what is undetermined, if anything is."""
        return warnings_of(self.free, "the smallest values that fit")


def least_squares(
    state: State,
    free_bias: bool,
    noise: WrenchNoise,
    equation: Array | None = None,
) -> LeastSquares:
    """Minimise |S^-1/2 (A phi + beta - b)|² over phi (10,) and, if free, beta (6,); S
    from `noise`, or the identity.

    Without `noise` the covariance is scaled by the mean squared residual. Directions
    that no sample excites get the smallest solution (with columns scaled to one length)
    and infinite variance. An `equation` (11,) of the parameters alone is one row more.
    Biases of several recordings are eliminated beforehand.
    """
    whitened = isinstance(state, WhitenedState)
    if whitened or (free_bias and isinstance(state, JointState)):
        problem = Quadratic.of(state, noise, True).with_equation(equation)
        eliminated = 6 * len(problem.bias_rows)
        A, b, svd = problem.A, problem.b, problem.svd
        bias = problem.bias(svd.solve(b))
    else:
        R = stacked_factor(as_one(state), noise, free_bias)
        R, eliminated = with_equation(R, equation), 0
        if free_bias:
            R = R[:, [*range(6, 16), *range(6), 16]]
        A, b = R[:, :-1], R[:, -1]
        svd = ScaledSVD.of(A)
        bias = svd.solve(b)[10:] if free_bias else None
    solution = svd.solve(b)
    r = b - A @ solution
    square = float(r @ r)
    slack = svd.U.T @ r  # zero at the exact minimum
    half = svd.V.T / svd.S / svd.scale[:, None]
    covariance = half @ half.T
    if noise is None and not whitened:
        covariance *= square / max(6 * state.samples - len(svd.S) - eliminated, 1)
    free = svd.open
    covariance[free], covariance[:, free] = 0.0, 0.0
    covariance[free, free] = np.inf
    bound = max(0.0, square - float(slack @ slack))
    return LeastSquares(solution, bias, covariance, free, square, bound)
