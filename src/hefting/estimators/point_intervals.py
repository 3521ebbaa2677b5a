"""Intervals of a point estimate: those of a posterior, widened to include the point.

The posterior follows in closed form from the state's likelihood (`state_likelihood`) and
the mixture of bodies that the method takes for possible (`possible_bodies`); its cost does
not depend on the number of samples. For a method without a prior, such as least squares,
it is the likelihood. The estimate may be outside, as its method pulls it to a prior, leaves
out part of the model or weighs the wrench otherwise.
"""

from collections.abc import Callable
from typing import Self

import numpy as np

from hefting.core.inertia import InertialParameters
from hefting.core.quantity import MassReading
from hefting.core.spatial import Array, Mask, immutable
from hefting.estimators.bayes.likelihood import Likelihood, with_reading
from hefting.estimators.bayes.mixture import Mixture, holding
from hefting.estimators.bayes.passes import LARGEST_PRIOR_SCALE, SMALLEST_PRIOR_SCALE
from hefting.estimators.possible_bodies import PossibleBodies
from hefting.estimators.state_likelihood import StateLikelihood, StateSamples

FARTHEST_COM = 1.0
"""[m] Largest distance of a held object's COM from the sensor."""
LARGEST_MASS_ERROR = 0.1
"""Relative standard deviation of the mass by the samples alone, beside a free bias, above
which a prior does not narrow the intervals: errors of the motion in the regressor, together
with a prior, reduce the mass by up to ten times its relative variance."""
TakenForPossible = Callable[[Array], PossibleBodies | None]
"""The bodies that a method takes for possible, given the COM (3,) [m] of least squares;
None for any ten parameters."""

UNSEEN = 1e-12
"""Eigenvalue of the scaled precision, relative to the largest, up to which a direction
counts as not seen by the samples."""
VANISHING = 1e-13
"""Root of a parameter's precision, relative to the largest, up to which it counts as
zero: rounding."""


@immutable
class Known:
    """Posterior of the parameters from samples and possible bodies."""

    mixture: Mixture
    open: Mask
    """(10,) parameters that are not determined at all"""
    bodies: bool
    """whether the method takes only some bodies for possible"""

    @property
    def mass_error(self) -> float:
        """Standard deviation of the mass, relative to it; infinite where it is open."""
        mass, variance = self.mixture.mean[0], self.mixture.covariance[0, 0]
        if self.open[0] or not mass > 0.0:
            return np.inf
        return float(variance**0.5 / mass)

    def covariance_about(self, vector: Array) -> Array:
        """(10, 10) mean square of the truth's distance from `vector` (10,); infinite
        variance where open."""
        off = self.mixture.mean - vector
        covariance = self.mixture.covariance + np.outer(off, off)
        covariance[self.open], covariance[:, self.open] = 0.0, 0.0
        covariance[self.open, self.open] = np.inf
        return covariance

    @property
    def ends(self) -> Array:
        """(2, 16) ends of the intervals of the sixteen numbers; infinite where an open
        parameter matters."""
        ends = self.mixture.ends()
        infinite = np.zeros(16, dtype=bool)
        infinite[:10] = self.open
        # the COM is open where the mass may be zero
        if self.open[:4].any() or (not self.bodies and self.mass_error > 0.5):
            infinite[1:4] = infinite[10:] = True
        infinite[10:] |= self.open[4:]
        ends[0, infinite], ends[1, infinite] = -np.inf, np.inf
        return ends


def intervals_of(
    body: InertialParameters,
    samples: StateSamples,
    systematic: Array | None,
    possible_bodies: TakenForPossible,
    reading: MassReading | None = None,
) -> tuple[dict[str, Array], Array]:
    """95 % intervals of `INTERVAL_QUANTITIES` that include the estimate, and the mean
    square (10, 10) of the truth's distance from it.

    Parameters
    ----------
    body : the estimate.
    samples : of its state, with their noise.
    systematic : (10, 10) covariance of an error that all samples share.
    possible_bodies : of the method.
    reading : of a scale.
    """
    # noise-free or few samples overflow; an end that is NaN then counts as open
    with np.errstate(over="ignore", divide="ignore", invalid="ignore"):
        known = _known(samples, systematic, possible_bodies, reading)
        ends = known.ends
        if samples.free_bias and known.bodies:
            alone = _known(samples, systematic, _anything, reading)
            if alone.mass_error > LARGEST_MASS_ERROR:
                low, high = alone.ends
                ends = np.stack((np.minimum(ends[0], low), np.maximum(ends[1], high)))
                known = alone
        ends[0] = np.where(np.isnan(ends[0]), -np.inf, ends[0])
        ends[1] = np.where(np.isnan(ends[1]), np.inf, ends[1])
        return holding(ends, body), known.covariance_about(body.vector)


def _known(
    samples: StateSamples,
    systematic: Array | None,
    possible_bodies: TakenForPossible,
    reading: MassReading | None = None,
) -> Known:
    """The posterior, found twice: the effect of the motion's errors and the mass of the
    possible bodies depend on the parameters, which the first pass finds."""
    if not samples.informative:
        everything = Mixture(np.ones(1), np.eye(1, 10), np.zeros((1, 10, 10)))
        return Known(everything, np.ones(10, dtype=bool), bodies=False)
    start = samples.samples.least_squares
    bodies = possible_bodies(_center(start))

    def found(state: StateLikelihood, mass: float) -> tuple[Root, Mixture]:
        """Of bodies of some `mass` [kg]."""
        likelihood = state.likelihood
        if systematic is not None:
            likelihood = likelihood.blurred(systematic)
        root = Root.of(with_reading(likelihood, reading))
        if bodies is None:
            return root, root.gaussian
        return root, posterior(bodies, mass, root, start)

    state = samples.likelihood(start)
    rough = state.rough_mass if reading is None else reading.mass
    first = found(state, rough)[1].mean
    if samples.source.motion.variances is not None:
        state = samples.likelihood(first)
    scale = min(max(float(first[0]) / rough, SMALLEST_PRIOR_SCALE), LARGEST_PRIOR_SCALE)
    root, mixture = found(state, scale * rough)
    return Known(mixture, root.open & (bodies is None), bodies is not None)


def _anything(_: Array) -> None:
    """Any ten numbers are possible."""


def _center(vector: Array) -> Array:
    """COM (3,) [m] of parameters (10,), at most `FARTHEST_COM` from the origin; the
    origin where the mass is not positive."""
    if not vector[0] > 0.0:
        return np.zeros(3)
    c = vector[1:4] / vector[0]
    return c * min(1.0, FARTHEST_COM / max(float(np.sqrt(c @ c)), 1e-300))


@immutable
class Root:
    """Root of a likelihood's precision, Lambda = X'X, without directions that the
    samples do not see."""

    X: Array
    """(k, 10)"""
    inverse: Array
    """(10, k) X^+"""
    shift: Array
    """(10,) lambda"""
    open: Mask
    """(10,) parameters that the samples do not determine"""

    @classmethod
    def of(cls, likelihood: Likelihood) -> Self:
        """Of a likelihood."""
        precision = likelihood.precision
        size = np.sqrt(np.maximum(precision.diagonal(), 0.0))
        seen = size > VANISHING * size.max(initial=0.0)
        scale = np.where(seen, size, 1.0)
        values, vectors = np.linalg.eigh(precision / np.outer(scale, scale))
        kept = values > UNSEEN * max(float(values[-1]), 1e-300)
        roots = np.sqrt(values[kept])
        hidden = np.abs(vectors[:, ~kept]).max(axis=1, initial=0.0) > 1e-6
        return cls(
            (vectors[:, kept] * roots).T * scale,
            vectors[:, kept] / roots / scale[:, None],
            likelihood.shift,
            hidden | ~seen,
        )

    def whitened(self, at: Array) -> Array:
        """X^-T (lambda - Lambda at) (k,)."""
        return self.inverse.T @ self.shift - self.X @ at

    @property
    def gaussian(self) -> Mixture:
        """The likelihood itself, without what it leaves open."""
        factor = np.zeros((10, 10))
        factor[:, : self.inverse.shape[1]] = self.inverse
        mean = self.inverse @ (self.inverse.T @ self.shift)
        return Mixture(np.ones(1), mean[None], factor[None])


def posterior(bodies: PossibleBodies, scale: float, root: Root, at: Array) -> Mixture:
    """Posterior of bodies of about `scale` s kg.

    With Lambda = X'X, d = s mu - at and r = X^-T (lambda - Lambda at) - X d, each
    member's deviation z minimises |r - X F z|² + |z|², F being s times its spread. The
    QR factor R of (X F; 1) gives its covariance F (R'R)^-1 F', and the log weight is
    minus half that minimum, less log det R, with that of the member. `at` (10,) near
    the answer keeps the numbers small.
    """
    mu, F = scale * bodies.means, scale * bodies.spread
    k = F.shape[2]
    XF = root.X @ F
    r = root.whitened(at) - (mu - at) @ root.X.T
    rows = np.concatenate((XF, np.tile(np.eye(k), (len(F), 1, 1))), axis=1)
    Q, R = np.linalg.qr(rows)
    right = (Q[:, : len(root.X)].transpose(0, 2, 1) @ r[:, :, None])[:, :, 0]
    z = np.linalg.solve(R, right[:, :, None])[:, :, 0]
    rest = r - (XF @ z[:, :, None])[:, :, 0]
    log = (
        bodies.log_weight
        - 0.5 * ((rest * rest).sum(axis=1) + (z * z).sum(axis=1))
        - np.log(np.abs(R.diagonal(axis1=1, axis2=2))).sum(axis=1)
    )
    weights = np.exp(log - log.max())
    means = mu + (F @ z[:, :, None])[:, :, 0]
    half = np.asarray(
        np.linalg.solve(R.transpose(0, 2, 1), F.transpose(0, 2, 1)), dtype=float
    )
    return Mixture(weights / weights.sum(), means, half.transpose(0, 2, 1))
