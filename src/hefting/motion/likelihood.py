"""Restricted likelihood of a smoothing spline's bandwidth, order and noise: see `hefting.motion.bspline`."""

from dataclasses import dataclass

import numpy as np
from scipy.optimize import minimize_scalar

from hefting.motion.bspline import Normal, multiply


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

    d independent components share lambda and r² (a unit quaternion's four have three degrees of freedom). The
    polynomials of degree below m, which the model leaves free, count as drawn with the variance they turn out
    to have: without that price a higher order always wins on short recordings.
    """

    def __init__(self, normal: Normal, m: int, dt: float, d: int, floor: float):
        self.normal, self.order, self.dt, self.d, self.floor = normal, m, dt, d, floor
        self.degrees = len(normal.count) - m * len(normal.knots.first)
        self.rank = normal.knots.size - m * len(normal.knots.first)
        self.log_det = normal.knots.log_penalty_determinant(m)
        self.free_score = 0.0
        target = normal.gradient + multiply(normal.bands, normal.pilot)
        for start, stop in zip(normal.knots.offset[:-1], normal.knots.offset[1:], strict=True):
            free = np.linalg.qr(np.polynomial.legendre.legvander(np.linspace(-1, 1, stop - start), m - 1))[0]
            root = np.linalg.cholesky(free.T @ multiply(normal.bands[:, start:stop], free))
            self.log_det += 2.0 * float(np.sum(np.log(np.diag(root))))
            effects = np.linalg.solve(root, free.T @ target[start:stop])  # along orthonormal polynomials
            scale = np.maximum(np.sum(effects**2, axis=1) / d, floor)
            self.free_score -= 0.5 * d * float(np.sum(np.log(scale) + 1.0))

    def at(self, log_h_bandwidth: float) -> Smoothness:
        """Likelihood at ln(h wc)."""
        h = self.normal.knots.h
        trial = Smoothness(self.order, np.exp(log_h_bandwidth) / h, np.nan, np.nan)
        penalty = trial.penalty(self.normal, self.dt)
        c, factor = self.normal.solve(self.order, penalty)
        roughness = float(np.sum(self.normal.knots.differences(c, self.order) ** 2))
        square = max(self.normal.residual_square(c), 0.0) + penalty * roughness
        variance = max(square / (self.d * self.degrees), self.floor)
        log_det = 2.0 * float(np.sum(np.log(factor[0]))) - self.rank * np.log(penalty) - self.log_det
        score = -0.5 * self.d * (self.degrees * (np.log(variance) + 1.0) + log_det) + self.free_score
        return Smoothness(self.order, trial.bandwidth, variance, score)

    def maximum(self, lowest: float, highest: float) -> Smoothness:
        """The most likely bandwidth with h wc between two bounds: a coarse scan, then Brent's method."""
        grid = np.linspace(np.log(lowest), np.log(highest), 9)
        scores = [self.at(x).log_likelihood for x in grid]
        best = int(np.argmax(scores))
        bracket = grid[max(best - 1, 0)], grid[min(best + 1, len(grid) - 1)]
        found = minimize_scalar(
            lambda x: -self.at(x).log_likelihood, bounds=bracket, method="bounded", options={"xatol": 0.02}
        )
        return self.at(float(found.x))
