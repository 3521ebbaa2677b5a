"""Evidence for an explanation: a robust fit of a linear model, and how likely it makes
the wrench.

All explanations are compared on the same averages of the wrench. Residuals are
coloured: the log-likelihood counts independent samples only.
"""

from typing import Self

import numpy as np

from hefting.core.spatial import Array, Indices, Mask, column_medians, immutable
from hefting.estimators.timescales import autocorrelation_time
from hefting.ingest.model import FEATURES, REGRESSOR_BY_FEATURE
from hefting.ingest.rivals.case import Case
from hefting.ingest.robust_rows import (
    DAMPING,
    RobustRows,
    fit_channels,
    fit_each,
    normal_equations,
    scaled_to_ones,
)

TYPICAL_DEVIATION = 4.46
"""Mean of 4.5 log(1 + x / 3) for x of a chi-squared distribution with six degrees of
freedom: the reduction of a sample's log-likelihood by noise alone."""
NEGLIGIBLE_UNEXPLAINED = 0.3
"""Missing log-likelihood per sample (`missing`) that is negligible."""
LARGEST_LEFT = 0.9
"""Share of what noise does not explain that the rough fit of a mistake may leave. In
300 recordings with mistakes those that were named left at most 0.73, and half of the
others 0.99."""
ITERATIONS, MORE_ITERATIONS = 6, 2
"""Number of reweightings of a robust fit, and of one that starts from a similar fit."""
NOISE_ALLOWANCE = 1.3
"""Factor by which a squared residual may exceed that of the noise by chance."""
SMALLEST_CHANGE = 1e-6
"""Variance of a wrench over its mean square below which it counts as constant."""
SMALLEST_FLOOR = 1e-12
"""Smallest floor of a residual, against division by zero."""


@immutable
class Rows:
    """A model that is linear in its unknowns, for O alternatives (such as clock
    offsets) and K samples."""

    known: Array
    """(O, K, z) rows in which the columns are linear"""
    maps: Array
    """(z, 6, p) columns of the design matrix per unit of a known row"""
    used: Array
    """(O, K) 1 where the motion is known, else 0"""
    wrench: Array | None = None
    """(O, K, 6) wrench in place of the recorded one"""

    def part(self, index: slice | Indices) -> "Rows":
        """The rows of some alternatives."""
        wrench = None if self.wrench is None else self.wrench[index]
        return Rows(self.known[index], self.maps, self.used[index], wrench)

    def predict(self, solution: Array) -> Array:
        """(O, K, 6) wrench by each alternative, for the first unknowns `solution` (p,)
        or fewer."""
        maps = self.maps[:, :, : len(solution)]
        return self.known @ (maps @ solution)


@immutable
class Fitted(RobustRows):
    """Robust fits of the O alternatives."""

    rows: Rows

    def of_best(self) -> Self:
        """The fit of the most likely alternative only."""
        part = slice(self.best, self.best + 1)
        return type(self)(
            self.likelihood[part],
            self.solution[part],
            self.scale[part],
            self.weights[part],
            self.residual[part],
            self.rows.part(part),
        )


def beside_body(columns: Array) -> Array:
    """Maps (12 + z, 6, 10 + p) of a model with more unknowns than the ten parameters.

    The known row of a sample holds its 12 features, then z other numbers; `columns`
    (z, 6, p) are the derivatives of the wrench by the p further unknowns, per unit of
    those numbers.
    """
    z, _, p = columns.shape
    maps = np.zeros((FEATURES + z, 6, 10 + p))
    maps[:FEATURES, :, :10] = REGRESSOR_BY_FEATURE
    maps[FEATURES:, :, 10:] = columns
    return maps


def with_bias(
    case: Case,
    known: Array,
    maps: Array,
    used: Array | Mask,
    wrench: Array | None = None,
    functions: Array | None = None,
) -> Rows:
    """Rows of a model with a bias as its last unknowns: 6 n coefficients of n functions of
    time, which are those of the case or `functions` (..., K, n)."""
    if functions is None:
        functions = case.bias_functions
    n = functions.shape[-1]
    shared = np.broadcast_to(functions, (len(known), *functions.shape[-2:]))
    known = np.concatenate((known, shared), axis=2)
    z, _, p = maps.shape
    whole = np.zeros((z + n, 6, p + 6 * n))
    whole[:z, :, :p] = maps
    whole[z:, :, p:] = np.eye(6 * n).reshape(n, 6, 6 * n)
    return Rows(known, whole, np.asarray(used, dtype=float), wrench)


def fit_rows(
    case: Case, rows: Rows, iterations: int = ITERATIONS, start: Fitted | None = None
) -> Fitted:
    """Robust least squares of each alternative; `start` is a fit of similar rows, from
    whose weights it begins."""
    iterations = iterations if start is None else MORE_ITERATIONS
    wrench = case.wrench if rows.wrench is None else rows.wrench
    wrench = np.broadcast_to(wrench, (*rows.known.shape[:2], 6))
    both = np.concatenate((rows.known, wrench), axis=2)
    floor = np.maximum(case.floor, SMALLEST_FLOOR)
    used = rows.used * case.relative_worth
    fits = fit_each(both, rows.maps, used, floor, iterations, start)
    return Fitted(**vars(fits), rows=rows)


def fit_free_channels(
    case: Case, known: Array, used: Array | Mask, iterations: int = ITERATIONS
) -> RobustRows:
    """Robust least squares of free channels: each channel of the wrench is any linear
    function of the known rows (O, K, z), whatever a rigid body allows."""
    wrench = np.broadcast_to(case.wrench, (*known.shape[:2], 6))
    return fit_channels(
        np.concatenate((known, wrench), axis=2),
        used * case.relative_worth,
        np.maximum(case.floor, SMALLEST_FLOOR),
        iterations,
    )


def correlation(fitted: RobustRows) -> float:
    """Autocorrelation time [samples] of the weighted residuals of the likeliest
    alternative: 1 for white noise."""
    best = fitted.best
    weights = np.sqrt(fitted.weights[best])[:, None]
    scale = np.repeat(fitted.scale[best], 3)
    return autocorrelation_time(weights * fitted.residual[best] / scale)


def mean_square(case: Case, fitted: Fitted) -> float:
    """Mean square of all residuals of the likeliest alternative over the floor."""
    residual = fitted.residual[fitted.best] / np.repeat(case.floor, 3)
    return float(np.mean(np.square(residual[fitted.rows.used[fitted.best] > 0.0])))


def missing(case: Case, fitted: RobustRows) -> float:
    """Mean log-likelihood of a sample if noise alone were left, less that of the best
    alternative."""
    ideal = -TYPICAL_DEVIATION - 3.0 * float(
        np.log(np.maximum(case.level, 1e-12)).sum()
    )
    return ideal - float(fitted.likelihood[fitted.best])


def missing_by_motion(case: Case) -> float:
    """Mean log-likelihood of a sample that errors of the motion cost. On turns about one
    axis what they leave resembles many a mistake."""
    worth = case.worth[case.worth > 0.0]
    return float(np.average(4.5 * np.log((1.0 + 2.0 / worth) / 3.0), weights=worth))


def unexplained_share(case: Case, fitted: Fitted, level: Array) -> float:
    """Root of the residual variance of the best alternative beyond the noise `level` (2,)
    of force [N] and torque [N m], over the variance of the wrench; the larger share of
    the two, at most 1."""
    fitted = fitted.of_best()
    changes = np.var(case.wrench, axis=0).reshape(2, 3).mean(axis=1)
    used = fitted.weights[0] > 0.0
    square = np.square(fitted.residual[0][used]).reshape(-1, 2, 3).sum(axis=2)
    # the median of chi-squared with three degrees of freedom is 2.37
    left = np.maximum(np.square(fitted.scale[0]), column_medians(square) / 2.37)
    excess = np.maximum(left - NOISE_ALLOWANCE * np.square(level), 0.0)
    size = np.mean(case.wrench**2, axis=0).reshape(2, 3).mean(axis=1)
    varies = changes > SMALLEST_CHANGE * size
    share = np.where(varies, excess / np.maximum(changes, 1e-300), 0.0)
    return float(np.sqrt(np.minimum(share, 1.0)).max())


def is_hopeless(case: Case, first: RobustRows, given: RobustRows) -> bool:
    """Whether the `first` rough fit of a mistake leaves nearly all that the recording as
    `given` leaves unexplained, so that the mistake need not be fitted further."""
    most = min(LARGEST_LEFT * missing(case, given), case.most_left)
    return missing(case, first) > max(most, 2.0 * NEGLIGIBLE_UNEXPLAINED)


@immutable
class Step:
    """A Gauss-Newton step of q unknowns in which the model is not linear."""

    change: Array
    """(q,) of the unknowns"""
    white: Array
    """(q, q) covariance for white residuals"""
    fitted: RobustRows

    @property
    def covariance(self) -> Array:
        """(q, q) covariance for residuals with their autocorrelation."""
        return self.white * correlation(self.fitted)


def linear_step(fitted: Fitted, columns: Array) -> Step:
    """Gauss-Newton step of q unknowns together with all linear unknowns of the likeliest
    alternative; `columns` (K, 6, q) are derivatives of the wrench by the unknowns."""
    fitted = fitted.of_best()
    rows = fitted.rows
    K, _, q = columns.shape
    z, _, p = rows.maps.shape
    parts = (rows.known[0], columns.reshape(K, 6 * q), fitted.residual[0])
    maps = np.zeros((z + 6 * q, 6, p + q))
    maps[:z, :, :p] = rows.maps
    maps[z:, :, p:] = np.eye(6 * q).reshape(6 * q, 6, q)
    both = np.concatenate(parts, axis=1)[None]
    normal, right = normal_equations(both, maps, fitted.weights, fitted.scale)
    scaled, length = scaled_to_ones(normal)
    inverse = np.linalg.inv(scaled[0]) / length[0] / length[0, :, None]
    change = (inverse @ right[0])[p:]
    return Step(change, inverse[p:, p:], fitted)


@immutable
class LinearPart:
    """Weighted equations of the linear unknowns of one alternative, to eliminate these
    from the equations of further unknowns; samples count as independent."""

    weights: Array
    """(K, 6) square roots of the weights of the residuals"""
    columns: Array
    """(6 K, p) weighted columns of the design matrix, scaled to unit length"""
    normal: Array
    """(p, p) normal matrix of these"""
    residual: Array
    """(6 K,) weighted"""

    @property
    def square(self) -> float:
        """Weighted square of the residuals."""
        return float(self.residual @ self.residual)

    @classmethod
    def of(cls, fitted: Fitted) -> Self:
        """The equations of the likeliest alternative."""
        fitted = fitted.of_best()
        rows = fitted.rows
        weights = np.sqrt(fitted.weights[0])[:, None] / np.repeat(fitted.scale[0], 3)
        A = rows.known[0] @ rows.maps.reshape(rows.known.shape[2], -1)
        A = (A.reshape(len(weights), 6, -1) * weights[:, :, None]).reshape(
            weights.size, -1
        )
        A = A / np.maximum(np.linalg.norm(A, axis=0), 1e-300)
        normal = A.T @ A + DAMPING * np.eye(A.shape[1])
        residual = (fitted.residual[0] * weights).ravel()
        return cls(weights, A, normal, residual)

    def beside(self, columns: Array) -> tuple[Array, Array]:
        """Normal matrix (q, q) and right-hand side (q,) of q further unknowns, from which
        the linear ones are eliminated; `columns` (K, 6, q) are the derivatives of the
        wrench by them."""
        A = self.columns
        B = (columns * self.weights[:, :, None]).reshape(len(A), -1)
        both = np.column_stack((B, self.residual))
        sums = A.T @ both
        found = B.T @ both - sums[:, :-1].T @ np.linalg.solve(self.normal, sums)
        return found[:, :-1], found[:, -1]
