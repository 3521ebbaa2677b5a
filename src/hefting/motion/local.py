"""Local smoothness: a penalty that varies over the recording, for motions whose
acceleration jumps.

An arm that moves by velocity trapezoids has smooth stretches between jumps of its
acceleration. One penalty for all of it rounds the jumps and lets the noise through
between them. Here each row of the penalty has a weight of its own,

    minimise  sum_k w_k |y_k - f(t_k)|² + sum_j lambda_j |(D^m c)_j|²,

where r²/lambda_j is the variance of row j of D^m c. It is found from the data by the
fixed point of the likelihood's maximum (MacKay, Neural Computation 4 (1992), sec. 4.4):
with C the inverse of the normal matrix,

    1/lambda_j = sum |(D^m c)_j|² / (r² d sum g_j),   g_j = 1 - lambda_j (D^m C D^m')_jj,

both sums over the rows near j. g_j is the share of the row that the data determine.
"""

from math import comb

import numpy as np

from hefting.core.spatial import Array, immutable, median
from hefting.motion.bspline import SPLINE_DEGREE, SUPPORT, Integers, Knots, Normal
from hefting.motion.tuning import Smoothness

INVERSE_STRETCH = 64
"""Number of coefficients in a stretch of `inverse_bands`; shorter ones take fewer
steps, longer ones repeat less of the overlap."""
STRETCHES_TOGETHER = 256
"""Number of stretches inverted together, to bound the memory."""
LOCAL_ORDER = 4
"""Order m of the local penalty. Two free rows let the acceleration jump; order 3 leaves
twice the error of the angular acceleration between the jumps of trapezoids."""
LOCAL_KNOT_SPACING = 0.01
"""[s] Knot spacing of a local fit, at least the sampling interval; a jump of the
acceleration is rounded over about two of them."""
FEWEST_NEIGHBOURS, MOST_NEIGHBOURS = 2, 3
"""Number of rows on each side that determine the variance of a row with it, as many as
span the time constant of the global fit. On trapezoids at 100 and 500 Hz, one to five
rows give inertia errors that differ by a tenth."""
LOCAL_ROUNDS = 4
"""Rounds of the fixed-point iteration. On trapezoids the inertia's errors are the same
after 5 and 8."""
LARGEST_STEP = 3.0
"""Largest change of ln(lambda_j) in a round."""
SMALLEST_DETERMINED_SHARE = 1e-3
"""Lower bound of g_j."""
STIFFEST_ROW = 1e4
"""Largest lambda_j over the median; at rest nothing else bounds it."""
STIFFEST = 1e11
"""Largest lambda_j over the weight of the samples of a coefficient, so that rounding
does not lose them."""
LARGEST_BANDWIDTH_RATIO = 1.5
"""Largest local bandwidth over the global one. On trapezoids 1.4 suffices; the bound
limits the effect of glitches of the poses."""
LARGEST_KURTOSIS = 6.0
"""Kurtosis of the residuals of the global fit above which they are not white noise: 3.0
to 3.5 on simulated trapezoids, 11 to 47 on two recordings of an arm with a jittering
clock. Glitches would count as jumps of the acceleration."""
LARGEST_AUTOCORRELATION = 0.15
"""Correlation of subsequent residuals above which they are no white noise: below 0 on
simulated trapezoids, 0.22 to 0.40 on those recordings."""
STRETCH, OVERLAP = 24, 32
"""Number of coefficients in a stretch of `inverse_bands`, and overlap of the stretches,
during the iteration, where a tenth of the variances is precise enough."""
JUMP_ERROR = 0.95
"""Error of the acceleration near a jump over the jerk of the curve times its local time
constant: an average over 30 ms on each side of the corners of trapezoids at 100 and 500
Hz."""


@immutable
class LocalSmoothness:
    """A fit with a penalty that varies along the curve."""

    coefficients: Array
    """(n, d)"""
    factor: Array
    """(6, n) lower Cholesky bands of the normal equations"""
    variance: float
    """r², of one sample of one component"""
    bandwidth: Array
    """(n,) [rad/s] about the middle of each coefficient"""
    jump_time: Array
    """(n,) [s] time by which a jump may be displaced or rounded; zero where the
    bandwidth is at most its median. Times the jerk it is the standard deviation of the
    acceleration by jumps."""


def is_white(residual: Array) -> bool:
    """Whether residuals (K, d) look like white noise, which a local penalty assumes."""
    square = residual**2
    total = float(square.sum())
    if not total > 0.0:
        return False
    kurtosis = float(np.mean(square**2)) / (total / square.size) ** 2
    correlation = float(np.vdot(residual[1:], residual[:-1])) / total
    return kurtosis <= LARGEST_KURTOSIS and correlation <= LARGEST_AUTOCORRELATION


def fit_locally(
    normal: Normal, found: Smoothness, dt: float, floor: float
) -> LocalSmoothness | None:
    """Fit with a local penalty, starting from a global smoothness; None where the
    normal equations cannot be solved.

    Parameters
    ----------
    normal : normal equations; their pilot is replaced.
    found : the most likely global smoothness, of any order.
    dt : [s] sampling interval.
    floor : lower bound of the variance of a sample.
    """
    m, knots = LOCAL_ORDER, normal.knots
    start = Smoothness(m, found.bandwidth, found.variance, found.log_likelihood)
    variance, d = found.variance, 3
    per_row = knots.rows_of_differences(m)
    penalty = np.full(len(per_row), start.penalty(normal, dt))
    neighbours = _neighbour_weights(knots.h * found.bandwidth)
    freest = float(penalty[0]) * LARGEST_BANDWIDTH_RATIO ** (-2 * m)
    stiffest = STIFFEST * float(normal.bands[0].mean())
    try:
        normal.refine_pilot(m, penalty)
        for round_ in range(LOCAL_ROUNDS):
            c, factor = normal.solve(m, penalty)
            if round_ == 0:
                determined = np.full(len(penalty), _uniform_share(knots, start))
            else:
                inverse = inverse_bands(factor, OVERLAP, STRETCH)
                determined = 1.0 - penalty * _difference_variances(inverse, m)[per_row]
                variance = _noise_variance(normal, c, inverse, d, floor)
            squares = np.sum(knots.differences(c, m) ** 2, axis=0)
            determined = np.clip(determined, SMALLEST_DETERMINED_SHARE, 1.0)
            determined = np.convolve(determined, neighbours, "same")
            squares = np.convolve(squares, neighbours, "same")
            wanted = variance * d * determined / np.maximum(squares, 1e-300)
            step = np.log(wanted / penalty)
            penalty = penalty * np.exp(np.clip(step, -LARGEST_STEP, LARGEST_STEP))
            middle = median(penalty)
            penalty = np.clip(penalty, freest, min(STIFFEST_ROW * middle, stiffest))
        c, factor = normal.solve(m, penalty)
    except np.linalg.LinAlgError:
        return None
    if not (np.isfinite(c).all() and np.isfinite(factor).all()):
        return None
    h = knots.h
    scaled = (h / (dt * penalty)) ** (0.5 / m) / h
    bandwidth = np.interp(np.arange(knots.size), per_row + 0.5 * m, scaled)
    typical = median(bandwidth)
    excess = np.maximum(1.0 - (typical / bandwidth) ** 2, 0.0)
    jump_time = JUMP_ERROR * (1.0 / bandwidth + 0.5 * h) * excess
    return LocalSmoothness(c, factor, variance, bandwidth, jump_time)


def _uniform_share(knots: Knots, uniform: Smoothness) -> float:
    """g of all rows under a uniform penalty: the integral over all frequencies of what
    the fit lets through, times the knot spacing."""
    m = uniform.order
    return knots.h * uniform.bandwidth / (2.0 * m * np.sin(0.5 * np.pi / m))


def _noise_variance(
    normal: Normal, coefficients: Array, inverse: Array, d: int, floor: float
) -> float:
    """Residual variance of one component, for the degrees of freedom that the fit
    leaves."""
    used = float(np.vdot(inverse[0], normal.bands[0]))
    used += 2.0 * float(np.vdot(inverse[1:], normal.bands[1:]))
    square = normal.objective(coefficients, LOCAL_ORDER, 0.0)
    return max(square / (d * max(normal.averages - used, 1.0)), floor)


def _difference_variances(inverse: Array, m: int) -> Array:
    """Diagonal (n - m,) of D^m C D^m' from the lower bands (6, n) of C."""
    stencil = [(-1.0) ** (m - a) * comb(m, a) for a in range(m + 1)]
    rows = inverse.shape[1] - m
    variances = np.zeros(rows)
    for a in range(m + 1):
        for b in range(a, m + 1):
            factor = (1.0 if a == b else 2.0) * stencil[a] * stencil[b]
            variances += factor * inverse[b - a, a : a + rows]
    return variances


def _neighbour_weights(scaled_bandwidth: float) -> Array:
    """Raised-cosine weights of a row and its neighbours, for a bandwidth times knot
    spacing."""
    wanted = round(1.0 / scaled_bandwidth)
    reach = min(max(wanted, FEWEST_NEIGHBOURS), MOST_NEIGHBOURS)
    return np.cos(0.5 * np.pi * np.arange(-reach, reach + 1) / (reach + 1)) ** 2


def inverse_bands(factor: Array, overlap: int, stretch: int = INVERSE_STRETCH) -> Array:
    """Lower bands (6, n) of A^-1 from the lower Cholesky bands (6, n) of A.

    The recursion runs backward (Takahashi, Fagan & Chin 1973; Hutchinson & de Hoog
    1985), in parallel over stretches of the matrix. Each starts from zeros, `overlap`
    coefficients after the end of its `stretch` coefficients; the error of that start decreases as
    exp(-2 sin(pi/2m) wc h overlap).
    """
    begins = np.arange(0, factor.shape[1], stretch)
    bands = np.zeros_like(factor)
    for first in range(0, len(begins), STRETCHES_TOGETHER):
        some = begins[first : first + STRETCHES_TOGETHER]
        _invert_stretches(bands, factor, some, overlap, stretch)
    return bands


def _invert_stretches(
    bands: Array, factor: Array, begins: Integers, overlap: int, stretch: int
) -> None:
    """Fill in the `bands` of the stretches that begin at the coefficients `begins`."""
    n, count = factor.shape[1], len(begins)
    length = min(stretch + overlap, n)
    stop = np.minimum(begins + stretch + overlap, n)
    column = stop - 1 - np.arange(length)[:, None]  # (length, count)
    own = (column >= begins) & (column < begins + stretch)
    # it is negative in a stretch that is finished; its result is not used
    column = np.maximum(column, 0)
    pivots = factor[0, column]
    slopes = (factor[1:, column] / pivots).transpose(1, 2, 0)[..., None]
    last = 1.0 / pivots**2
    rows = np.empty((length, count, SUPPORT))
    window = np.zeros((count, SUPPORT, SUPPORT))
    for k, slope in enumerate(slopes):  # (count, 5, 1)
        corner = window[:, :SPLINE_DEGREE, :SPLINE_DEGREE]
        row = -(corner @ slope)
        grown = np.empty_like(window)
        grown[:, 1:, 1:] = corner
        grown[:, 1:, :1] = row
        grown[:, 0, 1:] = row[:, :, 0]
        grown[:, 0, 0] = last[k] - (row * slope).sum(axis=1)[:, 0]
        window = grown
        rows[k] = window[:, 0]
    bands[:, column[own]] = rows[own].T
