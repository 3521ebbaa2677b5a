"""Penalised quintic B-splines on uniform knots: band matrices, restricted likelihood,
pointwise variance.

A signal y(t) = f(t) + noise of variance r² is fitted by f = sum_i c_i B_i with knots at
spacing h,

    minimise  sum_k w_k |y_k - f(t_k)|² + lambda |D^m c|²,          D^m = m-th difference,

the spline equivalent of white noise of intensity q = h^(1-2m) r²/lambda on the m-th
derivative of f. With samples at interval dt the fit suppresses frequencies above the
bandwidth wc = (q/(r² dt))^(1/2m), so lambda = (h/dt) (h wc)^(-2m). Samples of the k-th
derivative, at interval dt_k and of weight w_k, multiply the lambda of the same wc by
1 + sum w_k dt/dt_k wc^2k.

Long gaps split the recording into segments. These share lambda and r²; their
coefficients are independent.

Sources: Eilers & Marx, Flexible smoothing with B-splines and penalties, Statistical
Science 11 (1996); restricted likelihood: Wahba, Annals of Statistics 13 (1985);
variance: Wahba, J. Royal Statistical Society B 45 (1983).
"""

from dataclasses import field, replace
from functools import cached_property
from itertools import pairwise
from math import comb, factorial, perm
from typing import Self

import numpy as np
from numpy.typing import NDArray

from hefting.core.lapack import lapack
from hefting.core.spatial import Array, immutable, median

Integers = NDArray[np.int_]
Mask = NDArray[np.bool_]

SPLINE_DEGREE = 5
"""Degree of the polynomials: quintic, for a twice differentiable acceleration."""
SUPPORT = SPLINE_DEGREE + 1
"""Number of basis functions that are not zero on a knot interval."""
FEWEST_SEGMENT_SAMPLES = 8
"""Smallest number of samples in a segment that is smoothed."""
FIRST_KNOT_MARGIN = 0.25
"""Knot spacings between the first knot and the first sample, so that samples half a
spacing apart are not on the borders of blocks."""
TIMES_EVALUATED_TOGETHER = 8192
"""Number of samples evaluated at a time, to bound the memory."""
SMALLEST_DIFFERENCE = 1e-6
"""Ratio of the objectives of a fit and of the pilot below which their difference is not
used, as rounding would be 1e-10 of it."""


def _piece_coefficients() -> Array:
    """(6, 6) coefficient of u^p (rows) in the function B_(i+j) (columns) on knot
    interval i, u in [0, 1]."""
    coefficients = np.zeros((SUPPORT, SUPPORT))
    for j in range(SUPPORT):
        for k in range(SUPPORT - j):
            sign = (-1) ** k * comb(SUPPORT, k) / factorial(SPLINE_DEGREE)
            for p in range(SUPPORT):
                coefficients[p, j] += (
                    sign
                    * comb(SPLINE_DEGREE, p)
                    * float(SPLINE_DEGREE - j - k) ** (SPLINE_DEGREE - p)
                )
    return coefficients


PIECE_COEFFICIENTS = _piece_coefficients()
"""(6, 6) polynomial coefficients of the basis functions on a knot interval: see
`_piece_coefficients`."""


def _derivative_pieces(derivative: int) -> Array:
    """(6, 6): `PIECE_COEFFICIENTS` differentiated, transposed."""
    factors = [perm(p, derivative) for p in range(SUPPORT)]
    pieces = np.array(factors, dtype=float)[:, None] * PIECE_COEFFICIENTS
    return np.roll(pieces, -derivative, axis=0).T


DERIVATIVE_COEFFICIENTS = np.stack([_derivative_pieces(k) for k in range(SUPPORT)])
"""(6, 6, 6) coefficients (6, 6) of the k-th derivatives of the basis functions on a knot
interval."""


def basis(u: Array, derivative: int | tuple[int, ...] = 0) -> Array:
    """Values (6, K) of the six basis functions that are not zero on a knot interval, or
    (n, 6, K) of n derivatives.

    `u` (K,) is the position in the interval, from 0 to 1; `derivative` is the order of
    the derivative by u, or several.
    """
    powers = np.empty((SUPPORT, len(u)))
    powers[0] = 1.0
    for p in range(1, SUPPORT):
        np.multiply(powers[p - 1], u, out=powers[p])
    return DERIVATIVE_COEFFICIENTS[np.array(derivative)] @ powers


@immutable
class Knots:
    """Knots at uniform spacing h over each segment of a recording."""

    h: float
    """[s] Spacing."""
    first: Array
    """(S,) [s] Start of each segment."""
    last: Array
    """(S,) [s] End of each segment."""

    intervals: Integers = field(init=False)
    """(S,) Number of knot intervals of each segment."""
    offset: Integers = field(init=False)
    """(S + 1,) Index of the first coefficient of each segment, and their number."""

    def __post_init__(self):
        intervals = (
            np.floor((self.last - self.first) / self.h + FIRST_KNOT_MARGIN).astype(int)
            + 1
        )
        object.__setattr__(self, "intervals", intervals)
        object.__setattr__(
            self, "offset", np.concatenate(([0], np.cumsum(intervals + SPLINE_DEGREE)))
        )

    @property
    def size(self) -> int:
        """Number of coefficients."""
        return int(self.offset[-1])

    @property
    def spans(self) -> list[tuple[int, int]]:
        """First coefficient of each segment, and that after its last."""
        return list(pairwise(self.offset.tolist()))

    def locate(self, time: Array) -> tuple[Integers, Array, Mask]:
        """Place of times (K,) [s] among the knots: index (K,) of the first of six
        coefficients in effect, position u (K,) in the knot interval, and a mask (K,) of
        the times inside a segment."""
        segment = np.zeros(1, dtype=int)  # most recordings have but one
        if len(self.first) > 1:
            segment = np.maximum(np.searchsorted(self.first, time, side="right") - 1, 0)
        x = (time - self.first[segment]) / self.h
        x += FIRST_KNOT_MARGIN
        interval = x.astype(int)  # rounded to 0 before the first one
        np.clip(interval, 0, self.intervals[segment] - 1, out=interval)
        covered = (time >= self.first[segment]) & (time <= self.last[segment])
        x -= interval
        return self.offset[segment] + interval, x, covered

    def roughness(self, coefficients: Array, m: int) -> float:
        """|D^m c|² of coefficients (n, d), summed over the segments."""
        return float(np.sum(self.differences(coefficients, m) ** 2))

    def roughened(self, coefficients: Array, m: int, penalty: float | Array) -> Array:
        """D^m' L D^m c of coefficients (n, d), as in `Normal.solve`; by differences, as
        the products of `penalty` cancel for smooth curves."""
        out = np.zeros(coefficients.T.shape)
        each = np.zeros(self.size - m)
        each[self.rows_of_differences(m)] = penalty
        weighted = np.diff(coefficients.T, m) * each
        for a, factor in enumerate(np.diff(np.eye(m + 1), m)[:, 0]):
            out[:, a : a + len(each)] += factor * weighted
        return out.T

    def differences(self, coefficients: Array, m: int) -> Array:
        """D^m c (d, r) of coefficients (n, d)."""
        return np.diff(coefficients.T, m)[:, self.rows_of_differences(m)]

    def rows_of_differences(self, m: int) -> Integers:
        """First coefficient of each row of D^m; no row spans a gap."""
        return np.concatenate(
            [np.arange(start, stop - m) for start, stop in self.spans]
        )

    def penalty(self, m: int, weights: Array | None = None) -> Array:
        """Lower bands (6, n) of D^m' W D^m, W being diagonal; `weights` are one for
        each row of D^m, all 1 by default."""
        each = np.zeros(self.size)
        each[self.rows_of_differences(m)] = 1.0 if weights is None else weights
        bands = np.zeros((SUPPORT, self.size))
        stencil, rows = np.diff(np.eye(m + 1), m)[:, 0], self.size - m
        for a in range(m + 1):
            for b in range(a, m + 1):
                bands[b - a, a : a + rows] += (stencil[a] * stencil[b]) * each[:rows]
        return bands

    def log_penalty_determinant(self, m: int) -> float:
        """Log of the product of the positive eigenvalues of D^m' D^m.

        That is det(D D') = prod (n + i + j + 1)/(i + j + 1) over i, j = 0..m-1, D
        having n rows.
        """
        i, j = np.divmod(np.arange(m * m), m)
        rows = np.diff(self.offset)[:, None] - m
        return float(np.sum(np.log1p(rows / (i + j + 1.0))))


def multiply(bands: Array, x: Array) -> Array:
    """Product (n, d), in column-major order, of a symmetric band matrix and x (n, d);
    entry [b, i] of its lower bands (6, n) is that of row i + b and column i."""
    columns = np.ascontiguousarray(x.T)
    product = bands[0] * columns
    for b in range(1, min(SUPPORT, len(x))):
        product[:, b:] += bands[b, :-b] * columns[:, :-b]
        product[:, :-b] += bands[b, :-b] * columns[:, b:]
    return product.T


@immutable
class Observation:
    """Samples of a signal or of one of its derivatives."""

    time: Array
    """(K,) s"""
    values: Array
    """(K, d)"""
    derivative: int = 0
    weight: float = 1.0
    """Weight of a squared residual relative to that of a sample of the signal."""

    @cached_property
    def interval(self) -> float:
        """[s] Median time between samples."""
        return median(np.diff(self.time))

    def __getitem__(self, index: Mask) -> Self:
        """The samples chosen by a mask (K,)."""
        return replace(self, time=self.time[index], values=self.values[index])


class Normal:
    """Normal equations of the unpenalised fit: the bands of B' W B, and B' W y.

    The right-hand side is formed from the residuals of a pilot fit, which avoids
    cancellation. Samples are averaged over blocks of about `block` seconds, so that
    coloured noise has less effect; the basis functions are averaged alike, so that the
    averages cause no bias. The averages are kept in a grid of P rows, one for each
    block of a knot interval, and a column for each coefficient that is the first of an
    interval; blocks without samples have weight zero.
    """

    def __init__(self, knots: Knots, data: tuple[Observation, ...], block: float):
        self.knots = knots
        self._penalties: dict[int, Array] = {}
        per_interval = max(round(knots.h / block), 1)
        weight, rows, values = zip(
            *(_block_averages(knots, o, per_interval) for o in data), strict=True
        )
        self.weight = np.concatenate(weight)
        """(P, n)"""
        self.rows = np.concatenate(rows, axis=1)
        """(6, P, n) the basis"""
        self.values = np.concatenate(values, axis=1)
        """(d, P, n)"""
        self.averages = int(np.count_nonzero(self.weight))
        self._rates = [
            (o.derivative, o.weight * len(o.time) / np.ptp(o.time)) for o in data[1:]
        ]
        n = knots.size
        self.bands = np.zeros((SUPPORT, n))
        weighted = self.weight * self.rows
        for a in range(SUPPORT):
            products = np.einsum("pn,bpn->bn", weighted[a], self.rows[a:])
            self.bands[: SUPPORT - a, a:] += products[:, : n - a]
        self._set_pilot(np.zeros((self.values.shape[0], n)).T)
        self.right = self.gradient
        """(n, d) B' W y"""

    def lift(self, bandwidth: float, dt: float) -> float:
        """Ratio of the information with measured derivatives to that without, at the
        frequency `bandwidth` [rad/s] for samples of the signal at interval `dt` [s]; 1
        without derivatives."""
        return 1.0 + dt * sum(rate * bandwidth ** (2 * k) for k, rate in self._rates)

    def _set_pilot(self, coefficients: Array) -> None:
        """Make a fit the pilot, from whose residuals the right-hand side is formed."""
        columns, n = coefficients.T[:, None], len(coefficients)
        residual = self.values.copy()
        for a in range(SUPPORT if coefficients.any() else 0):
            residual[:, :, : n - a] -= self.rows[a, :, : n - a] * columns[:, :, a:]
        weighted = self.weight * residual
        self.pilot = coefficients
        self._rough_pilot: dict[int, Array] = {}
        self._pilot_roughness: dict[int, float] = {}
        self._pilot_square = float(np.vdot(weighted, residual))
        gradient = np.zeros(coefficients.T.shape)
        for a, rows in enumerate(self.rows):
            gradient[:, a:] += np.einsum("pn,dpn->dn", rows, weighted)[:, : n - a]
        self.gradient = gradient.T

    def refine_pilot(self, m: int, penalty: float | Array) -> None:
        """Make the fit with this penalty the pilot, so that sums of squares of similar
        fits are free of cancellation."""
        self._set_pilot(self.solve(m, penalty)[0])

    def solve(self, m: int, penalty: float | Array) -> tuple[Array, Array]:
        """Coefficients (n, d) and the lower Cholesky bands (6, n) of B' W B + D' L D.

        L is diagonal: `penalty` times the identity, or one penalty for each row of
        D^m.
        """
        factor, right = self._factorised(m, penalty)
        return self.pilot + lapack.dpbtrs(factor, right, lower=1)[0], factor

    def minimum(self, m: int, penalty: float) -> tuple[float, Array]:
        """The `objective` of the fit with this penalty, and its Cholesky bands.

        It is that of the pilot less the square of half of a solution, but where the two
        cancel, as without noise.
        """
        factor, right = self._factorised(m, penalty)
        half = lapack.dtbtrs(factor, right, uplo="L")[0]
        at_pilot = self._pilot_square + penalty * self._pilot_roughness[m]
        square = at_pilot - float(np.vdot(half.T, half.T))
        if square < SMALLEST_DIFFERENCE * at_pilot:
            step = lapack.dtbtrs(factor, half, uplo="L", trans="T")[0]
            square = self.objective(self.pilot + step, m, penalty)
        return square, factor

    def _factorised(self, m: int, penalty: float | Array) -> tuple[Array, Array]:
        """The lower Cholesky bands (6, n), and the right-hand side (n, d) of the step
        from the pilot."""
        if isinstance(penalty, np.ndarray):
            roughness = self.knots.penalty(m, penalty)
            rough_pilot = self.knots.roughened(self.pilot, m, penalty)
        else:
            if m not in self._penalties:
                self._penalties[m] = self.knots.penalty(m)
            if m not in self._rough_pilot:
                self._rough_pilot[m] = self.knots.roughened(self.pilot, m, 1.0)
                self._pilot_roughness[m] = self.knots.roughness(self.pilot, m)
            roughness = penalty * self._penalties[m]
            rough_pilot = penalty * self._rough_pilot[m]
        factor, failed = lapack.dpbtrf(self.bands + roughness, lower=1)
        if failed:
            raise np.linalg.LinAlgError(
                "the normal equations of the spline are not positive definite"
            )
        return factor, self.gradient - rough_pilot

    def objective(self, coefficients: Array, m: int, penalty: float) -> float:
        """Weighted sum of squared residuals of a fit, and penalty |D c|²."""
        step = coefficients - self.pilot
        change = float(
            np.sum(step * (multiply(self.bands, step) - 2.0 * self.gradient))
        )
        return max(self._pilot_square + change, 0.0) + penalty * self.knots.roughness(
            coefficients, m
        )


def _block_averages(
    knots: Knots, data: Observation, per_interval: int
) -> tuple[Array, Array, Array]:
    """Averages of samples over the P blocks of each knot interval.

    Returns their weight (P, n), basis functions (6, P, n) and values (d, P, n). The
    basis is averaged to second order: its value at the mean time, plus half its second
    derivative times the variance of the times. For blocks of up to a quarter of a knot
    interval the neglected terms are below 1e-4 of that.
    """
    P, n, d = per_interval, knots.size, data.values.shape[1]
    grids = np.zeros((P, n)), np.zeros((SUPPORT, P, n)), np.zeros((d, P, n))
    index, u, covered = knots.locate(data.time)
    values = data.values
    if not covered.all():
        index, u, values = index[covered], u[covered], values[covered]
    block = np.minimum((u * P).astype(int), P - 1)
    starts = np.flatnonzero(np.diff(index * P + block, prepend=-1))
    if not len(starts):
        return grids
    count = np.diff(np.append(starts, len(u))).astype(float)
    if len(starts) == len(u):
        rows = basis(u, data.derivative)
    else:
        mean = np.add.reduceat(u, starts) / count
        variance = np.maximum(np.add.reduceat(u * u, starts) / count - mean**2, 0.0)
        rows = basis(mean, data.derivative)
        if SPLINE_DEGREE - data.derivative >= 2:
            rows += 0.5 * variance * basis(mean, data.derivative + 2)
        values = np.add.reduceat(values, starts, axis=0) / count[:, None]
    place = block[starts], index[starts]
    weight, basis_grid, value_grid = grids
    weight[place] = data.weight * count
    basis_grid[:, *place] = rows / knots.h**data.derivative
    value_grid[:, *place] = values.T
    return grids
