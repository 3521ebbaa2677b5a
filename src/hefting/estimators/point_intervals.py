"""Intervals of an estimate that is a point: the posterior of the bodies its method
takes for possible, and the point itself.

The posterior is that of the state's likelihood (`state_likelihood`) over the mixture of
`possible_bodies`; each member is a Gaussian in closed form, so the cost does not depend
on the samples. Where the method knows nothing of the object, as least squares, it is the
likelihood itself. The estimate may be off by more than the posterior is wide, as its
method pulls it to a prior, leaves out part of the model or weighs the wrench otherwise:
the ends are moved out to include it.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Self

import numpy as np

from hefting.core.inertia import InertialParameters
from hefting.core.spatial import Array, Mask, frozen, tensor_to_vector, vector_to_tensor
from hefting.estimators.bayes.likelihood import Likelihood
from hefting.estimators.bayes.mixture import INTERVAL_QUANTITIES, Mixture
from hefting.estimators.possible_bodies import PossibleBodies
from hefting.estimators.state_likelihood import StateSamples

INTERVAL_LEVEL = 0.95
"""Probability of the intervals."""
SMALLEST_SCALE, LARGEST_SCALE = 0.2, 2.0
"""Bounds on the mass [rough masses] of the bodies taken for possible, as of Bayes'
prior."""
UNSEEN = 1e-12
"""Eigenvalue of the scaled precision, relative to the largest, up to which a direction
counts as not seen by the samples."""
NON_NEGATIVE = [0, 4, 7, 9, 10, 13, 15]
"""Indices of mass and moments of inertia among the sixteen numbers of
`INTERVAL_QUANTITIES`."""

PASSES = 2
"""Number of times the posterior is found: the errors of the motion, and the mass of the
bodies taken for possible, follow from the parameters."""
FARTHEST_COM = 1.0
"""[m] Largest distance of a held object's COM from the sensor."""


def intervals_of(
    body: InertialParameters,
    samples: StateSamples,
    systematic: Array | None,
    possible_bodies: Callable[[Array], PossibleBodies | None],
) -> tuple[dict[str, Array], Array]:
    """Intervals of `INTERVAL_QUANTITIES` that hold the truth with 95 % probability, and
    the estimate too; and the mean square of the truth's distance (10, 10) from it.

    Parameters
    ----------
    body : the estimate.
    samples : what its state tells.
    systematic : (10, 10) covariance of an error that all samples share.
    possible_bodies : what the method takes an object to be, by the COM (3,) of least
        squares; None for any ten numbers.
    """
    if not samples.informative:
        open_ = np.ones(10, dtype=bool)
        ends = opened(np.zeros((2, 16)), open_, com_known=False)
        return including(ends, body), np.diag(np.full(10, np.inf))
    at = samples.samples.least_squares
    bodies = possible_bodies(_center(at))
    found, phi, open_ = samples.likelihood(), at, np.zeros(10, dtype=bool)
    for step in range(PASSES):
        if step and samples.motion.variances is not None:
            found = samples.likelihood(phi)
        likelihood = found.likelihood
        if systematic is not None:
            likelihood = likelihood.blurred(systematic)
        root = Root.of(likelihood)
        if bodies is None:
            mixture, open_ = root.gaussian, root.open
        else:
            mass = float(phi[0]) / found.rough_mass if step else 1.0
            scale = min(max(mass, SMALLEST_SCALE), LARGEST_SCALE) * found.rough_mass
            mixture = posterior(bodies, scale, root, at)
        phi = mixture.mean
    if found.response:
        mixture = mixture.scaled(found.response)
    off = mixture.mean - body.vector
    covariance = mixture.covariance + np.outer(off, off)
    covariance[open_], covariance[:, open_] = 0.0, 0.0
    covariance[open_, open_] = np.inf
    ends = ends_of(mixture)
    com_known = bodies is not None or ends[0, 0] > 0.0
    return including(opened(ends, open_, com_known), body), covariance


def _center(vector: Array) -> Array:
    """COM (3,) [m] of parameters (10,), at most `FARTHEST_COM` from the origin; the
    origin where the mass is not positive."""
    if not vector[0] > 0.0:
        return np.zeros(3)
    c = vector[1:4] / vector[0]
    return c * min(1.0, FARTHEST_COM / max(float(np.sqrt(c @ c)), 1e-300))


def posterior(
    bodies: PossibleBodies, scale: float, root: "Root", at: Array
) -> Mixture:
    """Each member in closed form: of mean s mu and factor F for a body of `scale` s kg.

    With Lambda = X'X, d = s mu - at and r = X^-T (lambda - Lambda at) - X d, the
    deviation z minimises |r - X F z|² + |z|². The QR factor R of (X F; 1) gives the
    covariance F (R'R)^-1 F', and the log weight is minus half that minimum, less
    log det R, with that of the member. `at` (10,) near the answer keeps the numbers
    small.
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
    half = np.linalg.solve(R.transpose(0, 2, 1), F.transpose(0, 2, 1))
    return Mixture(weights / weights.sum(), means, half.transpose(0, 2, 1))


@dataclass(frozen=True, eq=False)
class Root:
    """Root of a likelihood's precision: Lambda = X'X, without directions that the
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
        seen = size > 1e-13 * size.max(initial=0.0)
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


def including(ends: Array, body: InertialParameters) -> dict[str, Array]:
    """Intervals with the lower and upper `ends` (2, 16) that hold the body's own
    numbers, mass and moments not negative unless the body's are."""
    own = sixteen(body)
    ends = np.array(ends)
    ends[:, NON_NEGATIVE] = np.maximum(ends[:, NON_NEGATIVE], 0.0)
    known = np.isfinite(own)
    ends[0, known] = np.minimum(ends[0], own)[known]
    ends[1, known] = np.maximum(ends[1], own)[known]
    found = {name: ends[:, part] for name, part in INTERVAL_QUANTITIES.items()}
    found["mass"] = found["mass"][:, 0]
    return {
        name: frozen(v if name in ("mass", "center_of_mass") else vector_to_tensor(v))
        for name, v in found.items()
    }


def ends_of(mixture: Mixture) -> Array:
    """(2, 16) ends of the mixture's intervals."""
    found = mixture.intervals(INTERVAL_LEVEL)
    ends = np.empty((2, 16))
    for name, part in INTERVAL_QUANTITIES.items():
        values = found[name]
        values = tensor_to_vector(values) if values.ndim == 3 else values
        ends[:, part] = values.reshape(2, -1)
    return ends


def opened(ends: Array, open_: Array, com_known: bool) -> Array:
    """`ends` (2, 16) without an end where a parameter that is open (10,) matters."""
    infinite = np.zeros(16, dtype=bool)
    infinite[:10] = open_
    if open_[:4].any() or not com_known:
        infinite[1:4] = infinite[10:] = True
    infinite[10:] |= open_[4:]
    found = np.array(ends)
    found[0, infinite], found[1, infinite] = -np.inf, np.inf
    return found


def sixteen(body: InertialParameters) -> Array:
    """(16,) mass, COM, inertia about the origin and about the COM."""
    with np.errstate(invalid="ignore"):
        return np.concatenate(
            (
                [body.mass],
                body.center_of_mass,
                body.vector[4:],
                tensor_to_vector(body.inertia_at_com),
            )
        )
