"""Mixture: the posterior of the ten parameters as a sum of Gaussians, and intervals."""

from functools import cached_property, lru_cache
from math import erfc, exp, pi
from typing import Self

import numpy as np

from hefting.core.errors import InputError
from hefting.core.inertia import InertialParameters
from hefting.core.spatial import (
    STEINER,
    Array,
    immutable,
    own,
    tensor_to_vector,
    vector_to_tensor,
)
from hefting.estimators.bayes.likelihood import Likelihood
from hefting.estimators.bayes.prior import Prior

INTERVAL_LEVEL = 0.95
"""Probability of the intervals of an estimate."""
NON_NEGATIVE_NUMBERS = (0, 4, 7, 9, 10, 13, 15)
"""Indices of mass and moments of inertia in the numbers of `INTERVAL_QUANTITIES`."""
_NON_NEGATIVE = np.array([i in NON_NEGATIVE_NUMBERS for i in range(16)])
LEAST_ABOVE_ZERO = 0.25
"""Least share of an interval's width, four standard deviations, that lies above zero
for quantities that cannot be negative, so that no interval collapses."""
NEGLIGIBLE_WEIGHT = 5e-4
"""Total weight of the least probable members, which the intervals neglect."""
BEYOND_ROWS = 1e100
"""Value on the diagonal beyond a matrix that is factored, so that Cholesky's method
does not fail there; it is not part of the result."""
NUMBER_OF_DRAWS = 1000
"""Number of draws from the posterior, for quantities without a closed form. The 95 %
quantile of an error then has a standard error of 3 %."""
INTERVAL_QUANTITIES = {
    "mass": slice(0, 1),
    "center_of_mass": slice(1, 4),
    "inertia_at_origin": slice(4, 10),
    "inertia_at_com": slice(10, 16),
}
"""Quantities with intervals, and their indices in a vector of sixteen numbers."""


@immutable
class Mixture:
    """Gaussians over the parameters (10,) in sensor axes about the sensor origin."""

    weights: Array
    """(j,) Probabilities of the members."""
    means: Array
    """(j, 10) Means of the members."""
    factors: Array
    """(j, 10, 10) Factors X of the members' covariances X X'."""
    evidence: float = 0.0
    """Log of the samples' probability under the prior, up to a constant that is the
    same for every prior."""

    @classmethod
    def of(cls, prior: Prior, scale: float, likelihood: Likelihood) -> Self:
        """Posterior of a prior for a body of about `scale` kg: each member of the
        mixture on its own, in closed form.

        With F = s F_j and the prior's mean s mu: I + F'Lambda F = R R', y = R^-1
        F'(lambda - Lambda s mu), the mean is s mu + F R^-T y, the covariance F (R
        R')^-1 F', and the log weight ½ |y|² - log det R + log of the prior's. Where the
        members have means of their own, mu_j, that of the samples at each is added,
        lambda' mu_j - ½ mu_j' Lambda mu_j.
        """
        F, mu = scale * prior.spread, scale * prior.mean[None]
        if prior.offsets is not None:
            mu = mu + scale * prior.offsets
        own = mu @ likelihood.shift - 0.5 * ((mu @ likelihood.precision) * mu).sum(
            axis=1
        )
        left = likelihood.shift - mu @ likelihood.precision
        log_det, half, y = _factored(F, likelihood.precision, left)
        log = 0.5 * (y * y).sum(axis=1) - log_det + prior.log_weight
        if prior.offsets is not None:
            log, own = log + own, np.zeros(1)
        weights = np.exp(log - log.max())
        evidence = float(log.max() + np.log(weights.sum()) + own[0])
        weights /= weights.sum()
        means = mu + (half @ y[:, :, None])[:, :, 0]
        return cls(weights, means, half, evidence)

    @cached_property
    def mean(self) -> Array:
        """(10,)"""
        return self.weights @ self.means

    @cached_property
    def covariance(self) -> Array:
        """(10, 10) covariance, including the differences between the members' means."""
        off, columns = self.means - self.mean, self.factors.shape[2]
        X = self.factors.transpose(1, 0, 2).reshape(10, -1)
        return (X * self.weights.repeat(columns)) @ X.T + (off.T * self.weights) @ off

    @property
    def mass_std(self) -> float:
        """Standard deviation of the mass [kg]."""
        return float(self.covariance[0, 0]) ** 0.5

    def draws(self, number: int = NUMBER_OF_DRAWS) -> Array:
        """(number, 10) draws from the posterior, the same in every call."""
        ends = np.round(number * np.cumsum(self.weights)).astype(int)
        normal = _standard_normal_draws(number)
        parts = zip((0, *ends[:-1]), ends, self.means, self.factors, strict=True)
        return np.concatenate(
            [
                mean + normal[low:high] @ factor.T
                for low, high, mean, factor in parts
                if high > low
            ]
        )

    def ends(self, level: float = INTERVAL_LEVEL) -> Array:
        """(2, 16) ends of the central intervals of the sixteen numbers of
        `INTERVAL_QUANTITIES` that contain the truth with probability `level`.

        They are linearised about the mean of each member. Raises `InputError` unless 0
        < level < 1.
        """
        if not 0.0 < level < 1.0:
            raise InputError(f"a level is between 0 and 1, not {level}")
        return mixture_ends(*self._marginals, 0.5 - 0.5 * level)

    def intervals(self, level: float = INTERVAL_LEVEL) -> dict[str, Array]:
        """Central intervals that contain the truth with probability `level`, as
        `shaped`; errors as of `ends`."""
        return shaped(self.ends(level))

    @cached_property
    def _marginals(self) -> tuple[Array, Array, Array]:
        """Means (j, 16) and standard deviations (j, 16) of the sixteen numbers of each
        member, and its weights (j,)."""
        order = self.weights.argsort()
        kept = order[self.weights[order].cumsum().searchsorted(NEGLIGIBLE_WEIGHT) :]
        phi, X, weights = self.means[kept], self.factors[kept], self.weights[kept]
        m = phi[:, :1]
        # a member without mass has its COM anywhere
        if not m.all():
            std = np.sqrt((X[:, :1] ** 2).sum(axis=2))
            m = np.where(m == 0.0, 1e-9 * std + 1e-300, m)
        means, c, turned = _sixteen(phi, m)
        shift = X[:, 1:4] - c[:, :, None] * X[:, :1]  # of the COM, times the mass
        rows = np.concatenate((X[:, :1], shift / m[:, :, None], X[:, 4:], X[:, 4:]), 1)
        rows[:, 10:] -= turned @ (shift + X[:, 1:4])
        variances = np.maximum(np.square(rows) @ np.ones(rows.shape[2]), 1e-300)
        return means, np.sqrt(variances), weights / weights.sum()


def _sixteen(phi: Array, m: Array) -> tuple[Array, Array, Array]:
    """The sixteen numbers (j, 16) of parameters (j, 10) with masses m (j, 1), none
    zero; the COM c (j, 3); and (j, 6, 3) derivative of the parallel-axis term by m c.
    """
    h = phi[:, 1:4]
    c = h / m
    turned = (c @ STEINER).transpose(1, 0, 2)
    at_com = phi[:, 4:] - (turned @ h[:, :, None])[:, :, 0]
    return np.concatenate((phi[:, :1], c, phi[:, 4:], at_com), 1), c, turned


def prior_mixture(prior: Prior, mass: float, is_known: bool = True) -> Mixture:
    """A prior for a body of about a mass [kg] as a mixture: with that mass exactly if
    `is_known`, else with the prior's freedom."""
    factors = mass * prior.spread
    if is_known:
        factors[:, :, 0] = 0.0
    means = prior.mean if prior.offsets is None else prior.mean + prior.offsets
    weights = np.exp(prior.log_weight - prior.log_weight.max())
    shape = (len(weights), 10)
    means = np.broadcast_to(mass * means, shape)
    return Mixture(weights / weights.sum(), means, factors)


def shaped(ends: Array) -> dict[str, Array]:
    """Intervals from `ends` (2, 16): mass (2,) [kg], center_of_mass (2, 3) [m] and both
    inertia tensors (2, 3, 3) [kg m²] in sensor axes; mass and moments are not negative,
    see `LEAST_ABOVE_ZERO`."""
    return _by_quantity(*_above_zero(ends))


def holding(ends: Array, body: InertialParameters) -> dict[str, Array]:
    """Intervals from `ends` (2, 16), as `shaped`, widened to include the body, which
    may be slightly outside if no mass distribution in the shape has the posterior's
    mean."""
    low, high = _above_zero(ends)
    com, at_com = body.center_of_mass, tensor_to_vector(body.inertia_at_com)
    numbers = np.concatenate((body.vector[:1], com, body.vector[4:], at_com))
    return _by_quantity(np.fmin(low, numbers), np.fmax(high, numbers))


def _above_zero(ends: Array) -> tuple[Array, Array]:
    """Lower and upper ends (16,), of mass and moments not negative; see `shaped`."""
    low, high = ends
    above = np.maximum(high, LEAST_ABOVE_ZERO * (high - low))
    low, high = np.where(_NON_NEGATIVE, (np.maximum(low, 0.0), above), ends)
    return low, high


def _by_quantity(low: Array, high: Array) -> dict[str, Array]:
    """Ends (16,) by the name of each quantity."""
    ends = np.array((low, high))
    tensors = vector_to_tensor(ends[:, 4:].reshape(2, 2, 6))
    found = (ends[:, 0], ends[:, 1:4], tensors[:, 0], tensors[:, 1])
    each = [own(np.array(part, dtype=float)) for part in found]
    return dict(zip(INTERVAL_QUANTITIES, each, strict=True))


def _factored(F: Array, precision: Array, left: Array) -> tuple[Array, Array, Array]:
    """log det R (j,), F R^-T (j, 10, 10) and R^-1 F' left (j, 10) of members with the
    factors F (j, 10, 10), for `left` (j or 1, 10) and I + F'Lambda F = R R'.

    Cholesky's method divides the rows below a matrix by its factor: so F and left'F, as
    such rows, become F R^-T and y'. What stands to the right of them does not matter.
    """
    T = F.transpose(0, 2, 1)
    rows = np.zeros((len(F), 21, 21))
    rows[:, :10, :10] = T @ precision @ F
    rows[:, 10:20, :10] = F
    rows[:, 20:, :10] = left[:, None] @ F
    diagonal = rows.reshape(-1, 441)[:, ::22]
    diagonal[:, :10] += 1.0
    diagonal[:, 10:] = BEYOND_ROWS
    try:
        root = np.asarray(np.linalg.cholesky(rows), dtype=float)
    except np.linalg.LinAlgError:
        R = _cholesky(rows[:, :10, :10])
        root = np.concatenate(
            (R, rows[:, 10:, :10] @ np.linalg.inv(R).transpose(0, 2, 1)), 1
        )
    log_det = np.log(root[:, :10, :10].diagonal(axis1=1, axis2=2)).sum(axis=1)
    return log_det, root[:, 10:20, :10], root[:, 20, :10]


def _cholesky(M: Array) -> Array:
    """Cholesky factors (j, 10, 10) of matrices with eigenvalues of 1 or more."""
    try:
        return np.asarray(np.linalg.cholesky(M), dtype=float)
    except np.linalg.LinAlgError:
        values, vectors = np.linalg.eigh(0.5 * (M + M.transpose(0, 2, 1)))
        raised = np.sqrt(np.maximum(values, 1.0))[:, :, None]
        # M = (QR)'QR = R'R: no product whose rounding could be larger than one
        upper = np.linalg.qr(raised * vectors.transpose(0, 2, 1), mode="r")
        signs = np.where(np.einsum("jii->ji", upper) < 0.0, -1.0, 1.0)
        root = (signs[:, :, None] * upper).transpose(0, 2, 1)
        return np.ascontiguousarray(root, dtype=float)


@lru_cache(maxsize=1)
def _standard_normal_draws(number: int) -> Array:
    """(number, 10)"""
    return np.random.default_rng(0).standard_normal((number, 10))


MOST_STEPS = 60
"""Largest number of Newton steps in finding an end."""
END_TOLERANCE = 0.02
"""Relative error of a tail's probability at which the iteration ends; for a Gaussian
the error after the last step is some 2e-5 standard deviations."""


def mixture_ends(means: Array, stds: Array, weights: Array, tail: float) -> Array:
    """(2, k) lower and upper ends of k mixtures of Gaussians, each with the probability
    `tail` < 1/2 beyond it.

    `means` and `stds` are (j, k), `weights` (j,). The log of the probability, which is
    nearly linear, is solved by Newton's method, safeguarded by bisection. Upper ends are
    the lower ones of the mirrored mixture.
    """
    center = np.array((means.T, -means.T))
    width = np.ascontiguousarray(stds.T)
    rate = 1.0 / width
    density = (0.5 / np.pi) ** 0.5 * rate * weights
    each = center + normal_quantile(tail) * width
    low, high, x = each.min(axis=2), each.max(axis=2), each @ weights
    for _ in range(MOST_STEPS):
        t = (x[:, :, None] - center) * rate
        bell = np.exp(-0.5 * t * t)
        below = np.maximum(normal_cdf(t, bell) @ weights, 1e-300)
        slope = np.maximum((bell * density).sum(axis=2), 1e-300)
        off = np.log(below / tail)
        low, high = np.where(off < 0.0, x, low), np.where(off < 0.0, high, x)
        new = x - off * below / slope
        new = np.where((new >= low) & (new <= high), new, 0.5 * (low + high))
        done = (np.abs(off) <= END_TOLERANCE) | (new == x)
        x = new
        if done.all():
            break
    x[1] *= -1.0
    return x


def normal_cdf(t: Array, bell: Array) -> Array:
    """Probability that a standard normal number is below t, `bell` being exp(-t²/2);
    within 7.5e-8 (Abramowitz & Stegun 26.2.17). SciPy's takes a tenth of a second to
    import."""
    k = 1.0 / (1.0 + 0.2316419 * np.abs(t))
    tail = k * (
        0.319381530
        + k * (-0.356563782 + k * (1.781477937 + k * (-1.821255978 + k * 1.330274429)))
    )
    tail *= bell * (0.5 / np.pi) ** 0.5
    return np.asarray(np.where(t < 0.0, tail, 1.0 - tail), dtype=float)


@lru_cache
def normal_quantile(probability: float) -> float:
    """Quantile of the standard normal distribution, to rounding, by Newton's method."""
    x = 0.0
    for _ in range(MOST_STEPS):
        error = 0.5 * erfc(-x / 2.0**0.5) - probability
        step = error * (2.0 * pi) ** 0.5 * exp(0.5 * x * x)
        x -= min(max(step, -0.5), 0.5)
        if abs(step) < 1e-12:
            break
    return x
