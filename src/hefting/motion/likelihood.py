"""Restricted likelihood of a smoothing spline's bandwidth, order and noise: see
`hefting.motion.bspline`."""

from dataclasses import dataclass

import numpy as np

from hefting.core.spatial import Array
from hefting.motion.bspline import Normal, multiply

COARSE_STEPS = 8
"""Number of intervals of the coarse scan over ln(h wc). For h wc between 0.15 and 2.5
each is a factor of 1.4."""
NEGLIGIBLE_BANDWIDTH_CHANGE = 0.01
"""Change of ln(h wc) at which the search ends. The likelihood is flat at its
maximum."""
MOST_REFINEMENTS = 12
"""Largest number of evaluations after the coarse scan."""
HOPELESS = 2.0
"""Log likelihood missing, over the range of the first three, from which on an order is
given up: uphill it rises less and less."""


@dataclass(frozen=True)
class Smoothness:
    """Hyperparameters of a smoothing spline, and how likely they are."""

    order: int
    """m: white noise drives the m-th derivative"""
    bandwidth: float
    """wc, rad/s: above it signal is weaker than noise"""
    variance: float
    """r², of one sample of one component"""
    log_likelihood: float
    """restricted, comparable between orders"""

    def penalty(self, normal: Normal, dt: float) -> float:
        """lambda for samples dt apart."""
        h, w = normal.knots.h, self.bandwidth
        return h / dt * (h * w) ** (-2 * self.order) * normal.lift(w, dt)


class Likelihood:
    """Restricted likelihood of the bandwidth for one order m, with r² at its maximum.

    d independent components share lambda and r² (a unit quaternion's four have three
    degrees of freedom). The polynomials of degree below m, which the model leaves free,
    count as drawn with the variance they turn out
    to have: without that price a higher order always wins on short recordings.
    """

    def __init__(self, normal: Normal, m: int, dt: float, d: int, floor: float):
        self.normal, self.order, self.dt, self.d, self.floor = normal, m, dt, d, floor
        self.degrees = normal.averages - m * len(normal.knots.first)
        self.rank = normal.knots.size - m * len(normal.knots.first)
        self.log_det = normal.knots.log_penalty_determinant(m)
        self.free_score = 0.0
        target = normal.gradient + multiply(normal.bands, normal.pilot)
        for start, stop in zip(
            normal.knots.offset[:-1], normal.knots.offset[1:], strict=True
        ):
            free = _orthonormal_polynomials(stop - start, m)
            root = np.linalg.cholesky(
                free.T @ multiply(normal.bands[:, start:stop], free)
            )
            self.log_det += 2.0 * float(np.sum(np.log(np.diag(root))))
            # along orthonormal polynomials
            effects = np.linalg.solve(root, free.T @ target[start:stop])
            scale = np.maximum(np.sum(effects**2, axis=1) / d, floor)
            self.free_score -= 0.5 * d * float(np.sum(np.log(scale) + 1.0))

    def at(self, log_h_bandwidth: float) -> Smoothness:
        """Likelihood at ln(h wc)."""
        h = self.normal.knots.h
        trial = Smoothness(self.order, np.exp(log_h_bandwidth) / h, np.nan, np.nan)
        penalty = trial.penalty(self.normal, self.dt)
        square, factor = self.normal.minimum(self.order, penalty)
        variance = max(square / (self.d * self.degrees), self.floor)
        log_det = (
            2.0 * float(np.sum(np.log(factor[0])))
            - self.rank * np.log(penalty)
            - self.log_det
        )
        score = (
            -0.5 * self.d * (self.degrees * (np.log(variance) + 1.0) + log_det)
            + self.free_score
        )
        return Smoothness(self.order, trial.bandwidth, variance, score)

    def maximum(
        self,
        lowest: float,
        highest: float,
        near: float | None = None,
        needed: float = -np.inf,
    ) -> Smoothness:
        """The most likely bandwidth, with h wc between two bounds.

        A coarse scan, or with `near`, an h wc that is about right, only uphill from
        there; then parabolas through the three best, until the step is below
        `NEGLIGIBLE_BANDWIDTH_CHANGE`. Where the log likelihood `needed` is far off it is
        not searched for.
        """
        low, high = float(np.log(lowest)), float(np.log(highest))
        step = (high - low) / COARSE_STEPS
        tried: dict[float, Smoothness] = {}
        if near is None:
            for x in np.linspace(low, high, COARSE_STEPS + 1).tolist():
                tried[x] = self.at(x)
        else:
            middle = float(np.clip(np.log(near), low, high))
            for x in (middle - 0.5 * step, middle, middle + 0.5 * step):
                inside = float(np.clip(x, low, high))
                tried[inside] = self.at(inside)
        scores = [found.log_likelihood for found in tried.values()]
        refinements = MOST_REFINEMENTS
        if needed - max(scores) > HOPELESS * (max(scores) - min(scores)):
            refinements = 0
        for _ in range(refinements):
            x = _next(tried, low, high, step)
            if min(abs(x - other) for other in tried) < NEGLIGIBLE_BANDWIDTH_CHANGE:
                break
            tried[x] = self.at(x)
        return max(tried.values(), key=lambda found: found.log_likelihood)


def _next(
    tried: dict[float, Smoothness], low: float, high: float, step: float
) -> float:
    """Where the maximum should be, going by the best and its neighbours."""
    at = sorted(tried)
    scores = [tried[x].log_likelihood for x in at]
    k = int(np.argmax(scores))
    if k == 0:
        return max(at[0] - step, low)
    if k == len(at) - 1:
        return min(at[-1] + step, high)
    (a, b, c), (fa, fb, fc) = at[k - 1 : k + 2], scores[k - 1 : k + 2]
    left, right = (b - a) * (fb - fc), (b - c) * (fb - fa)
    vertex = b
    if left != right:
        vertex = b - 0.5 * ((b - a) * left - (b - c) * right) / (left - right)
    return float(np.clip(vertex, 0.5 * (a + b), 0.5 * (b + c)))


def _orthonormal_polynomials(n: int, m: int) -> Array:
    """(n, m) of degrees below m at n even places."""
    columns = np.polynomial.legendre.legvander(np.linspace(-1, 1, n), m - 1)
    # they are nearly orthogonal already
    root = np.linalg.inv(np.linalg.cholesky(columns.T @ columns))
    return np.array(columns @ root.T, dtype=float)
