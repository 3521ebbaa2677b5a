"""Quadratic: the sum of squared residuals as a function of the ten parameters, a free
constant bias minimised out.

    |S^-1/2 (D(1-w) (Ã phi + beta - b))|² + |S^-1/2 (D(w) (A phi + beta - b))|²

All samples together reduce to one triangular factor of [bias columns | regressor |
wrench]: its last rows are the problem that is left when the bias takes its best value,
whatever the parameters.
"""

from functools import cached_property

import numpy as np

from hefting.core.errors import InputError, NotIdentifiableError
from hefting.core.lapack import lapack
from hefting.core.measurements import Noise
from hefting.core.moments import FULL_EQUATIONS, REDUCED_EQUATIONS, triangular
from hefting.core.spatial import PARAMETERS, WRENCH, Array, Indices, frozen, immutable
from hefting.estimators.joint_state import (
    JointState,
    State,
    WhitenedState,
    as_one,
    states_of,
)
from hefting.estimators.sample_state import SampleState

WrenchNoise = Noise | Array | None
"""Known noise of the wrench: levels, or a covariance (6, 6) [N², N² m, N² m²]; None:
newtons weigh like N m."""

RANK_TOLERANCE = 1e-9
"""Singular values of the column-scaled regressor below this, relative to the largest,
count as zero."""

VANISHING_COLUMN = 1e-13
"""Length of a regressor's column, relative to the longest, below which it is a rounding
error."""

_REDUCED = np.zeros_like(FULL_EQUATIONS)
_REDUCED[[*range(10), 16]] = REDUCED_EQUATIONS

UNKNOWNS = PARAMETERS + tuple(f"bias {name}" for name in WRENCH)
"""Names of the ten parameters and of the bias."""


def warnings_of(open_: Indices, instead: str) -> tuple[str, ...]:
    """A warning that names the unknowns which the data leave open, and what determines
    them `instead`; none if nothing is open."""
    which: list[int] = open_.tolist()
    if not which:
        return ()
    names = ", ".join(UNKNOWNS[i] for i in which)
    return (f"the motion does not determine {names}: in their place are {instead}",)


def whitening(noise: WrenchNoise) -> Array | None:
    """S^-1/2 (6, 6), such that wrench noise multiplied by it has unit covariance; None
    for no known noise.

    Raises `InputError` unless the noise is positive in force and torque (definite, for
    a covariance).
    """
    if noise is None:
        return None
    if isinstance(noise, Noise):
        if not (0.0 < noise.force < np.inf and 0.0 < noise.torque < np.inf):
            what = "known noise must be positive in force and torque"
            raise InputError(what, fix="or give noise=None")
        return np.diag(np.repeat((1.0 / noise.force, 1.0 / noise.torque), 3))
    S = frozen(noise)
    if (
        S.shape != (6, 6)
        or not np.isfinite(S).all()
        or np.abs(S - S.T).max() > 1e-9 * np.abs(S).max()
    ):
        what = "a noise covariance of the wrench is a symmetric matrix (6, 6)"
        raise InputError(what, fix="or give noise=None")
    try:
        scale = 1.0 / np.sqrt(np.where(S.diagonal() > 0.0, S.diagonal(), 1.0))
        return np.linalg.inv(np.linalg.cholesky(S * np.outer(scale, scale))) * scale
    except np.linalg.LinAlgError as error:
        raise InputError(
            "the noise covariance of the wrench is not positive definite"
        ) from error


def stacked_factor(
    state: SampleState, noise: WrenchNoise = None, free_bias: bool = True
) -> Array:
    """Triangular factor (17, 17) of [bias columns | ten parameters | wrench] of both
    models' (whitened) equations.

    Without a free bias its six columns and rows are left out: (11, 11).
    """
    W, first = whitening(noise), 0 if free_bias else 6
    parts: list[Array] = []
    for moments, equations in ((state.full, FULL_EQUATIONS), (state.reduced, _REDUCED)):
        if moments.samples:
            chosen = equations[first:]
            parts.append(moments.factor_of(chosen if W is None else W @ chosen))
    if not parts:
        return np.zeros((17 - first, 17 - first))
    return parts[0] if len(parts) == 1 else triangular(np.vstack(parts))


def with_equation(R: Array, row: Array | None) -> Array:
    """A factor as of `stacked_factor` with one more equation (11,), if any."""
    if row is None:
        return R
    return np.vstack((R, np.pad(row, (R.shape[1] - len(row), 0))))


def require_information(problem: "Quadratic") -> None:
    """`NotIdentifiableError` if the samples contain no information."""
    if not len(problem.svd.S):
        beside = " beside a bias" if len(problem.bias_rows) else ""
        raise NotIdentifiableError(
            f"the samples determine nothing{beside}", fix="record other orientations"
        )


@immutable
class ScaledSVD:
    """Singular value decomposition of A (r, n), r >= n, with its columns scaled to one
    length: A = (U S V) scale."""

    U: Array
    """(r, k) for the k singular values above `RANK_TOLERANCE`"""
    S: Array
    """(k,)"""
    V: Array
    """(k, n)"""
    kernel: Array
    """(n - k, n) directions, in scaled unknowns, that A maps to zero"""
    scale: Array
    """(n,) lengths of the columns; 1 for those that vanish"""

    @classmethod
    def of(cls, A: Array, lengths: Array | None = None) -> "ScaledSVD":
        """Of `A`. With the columns' `lengths` (n,) before something was eliminated from
        them, rounding errors of that are not taken for information; by default the
        present lengths."""
        norms = np.sqrt((A * A).sum(axis=0)) if lengths is None else lengths
        scale = np.where(norms > VANISHING_COLUMN * norms.max(initial=0.0), norms, 1.0)
        U, S, V, _ = lapack.dgesdd(A / scale, full_matrices=0)
        kept = RANK_TOLERANCE * (S[0] if lengths is None else 1.0) < S
        return cls(U[:, kept], S[kept], V[kept], V[~kept], scale)

    def solve(self, b: Array) -> Array:
        """(n,) least squares |A x - b|², the shortest such x in scaled unknowns."""
        return self.V.T @ ((self.U.T @ b) / self.S) / self.scale

    @property
    def open(self) -> Indices:
        """Indices of the unknowns that A does not determine."""
        return np.flatnonzero(np.abs(self.kernel).max(axis=0, initial=0.0) > 1e-6)


@immutable
class Quadratic:
    """|A phi - b|² with the bias eliminated, see the module."""

    A: Array
    """(11, 10)"""
    b: Array
    """(11,)"""
    bias_rows: Array
    """(n, 6, 17) rows [C | A | b] that the best bias of each recording satisfies
    exactly; (0, 6, 17) without a free bias"""

    @classmethod
    def of(
        cls, state: State, noise: WrenchNoise = None, free_bias: bool = False
    ) -> "Quadratic":
        """From all samples in `state`."""
        if isinstance(state, WhitenedState):
            return cls(state.factor[:, :10], state.factor[:, 10], np.zeros((0, 6, 17)))
        if not free_bias:
            R = stacked_factor(as_one(state), noise, False)
            return cls(R[:, :10], R[:, 10], np.zeros((0, 6, 17)))
        factors = np.stack([stacked_factor(each, noise) for each in states_of(state)])
        R = factors[:, 6:, 6:].reshape(-1, 11)
        if len(factors) > 1:
            R = triangular(R)
        A, lengths = R[:, :10], np.sqrt((factors[:, :, 6:16] ** 2).sum(axis=(0, 1)))
        svd = ScaledSVD.of(A, lengths)
        if len(svd.kernel):  # what a bias explains as well leaves but rounding
            A = ((svd.U * svd.S) @ svd.V) * svd.scale
        return cls(A, R[:, 10], factors[:, :6])

    def with_equation(self, row: Array | None) -> "Quadratic":
        """With one more equation (11,) of the parameters; None for none."""
        if row is None:
            return self
        R = triangular(np.vstack((np.column_stack((self.A, self.b)), row)))
        return Quadratic(R[:, :10], R[:, 10], self.bias_rows)

    @cached_property
    def svd(self) -> ScaledSVD:
        """Of A."""
        return ScaledSVD.of(self.A)

    @property
    def size(self) -> float:
        """|b|: norm of the (whitened) wrench with the bias eliminated."""
        return float(np.sqrt(self.b @ self.b))

    def square(self, vector: Array) -> float:
        """|A phi - b|² at parameters (10,)."""
        r = self.A @ vector - self.b
        return float(r @ r)

    def bias(self, vector: Array) -> Array | None:
        """(6,) best bias [N, N m] for parameters (10,), or (n, 6) of n recordings; None
        without a free bias."""
        if not len(self.bias_rows):
            return None
        right = self.bias_rows[:, :, 16] - self.bias_rows[:, :, 6:16] @ vector
        found = np.zeros((len(right), 6))
        for i, C in enumerate(self.bias_rows[:, :, :6]):
            solution, failed = lapack.dtrtrs(C, right[i])
            if not failed:
                found[i] = solution
        return found[0] if len(found) == 1 else found

    def least_squares(self) -> Array:
        """(10,) unconstrained least squares, the smallest solution in directions that
        the data leave open."""
        return self.svd.solve(self.b)

    def measured_mass(self, homogeneous: Array) -> float:
        """Mass [kg] by unconstrained least squares or, unless that is positive, by
        scaling the parameters `homogeneous` (10,) of 1 kg spread over the shape. Always
        positive."""
        mass = float(self.least_squares()[0])
        if mass > 0.0:
            return mass
        column = self.A @ homogeneous
        square = float(column @ column)
        mass = float(column @ self.b) / square if square else 0.0
        return mass if mass > 0.0 else 1e-3 * self.size / (square**0.5 or 1.0) or 1e-3


def nonnegative_least_squares(A: Array, b: Array) -> Array:
    """(n,) x >= 0 that minimises |A x - b|, for A (r, n) and b (r,) (Lawson & Hanson,
    1974). Raises `RuntimeError` if it has not ended after 100 n steps, which rounding
    could cause."""
    from scipy.optimize import nnls  # pyright: ignore[reportUnknownVariableType]

    return np.asarray(nnls(A, b, maxiter=100 * A.shape[1])[0], dtype=float)


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
    """indices of the unknowns that the data leave open"""
    square: float
    """sum of squared (whitened) residuals"""
    bound: float
    """lower bound on the minimum, from the remaining gradient"""

    @property
    def warnings(self) -> tuple[str, ...]:
        """A warning on undetermined unknowns, if there are any."""
        return warnings_of(self.free, "the smallest values that fit")


def least_squares(
    state: State, free_bias: bool, noise: WrenchNoise, equation: Array | None = None
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
