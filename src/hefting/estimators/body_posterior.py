"""Posterior of possible bodies: a likelihood of the ten parameters over a mixture of
Gaussians, each member in closed form."""

from dataclasses import dataclass
from typing import Self

import numpy as np

from hefting.core.spatial import Array, Mask
from hefting.estimators.bayes.likelihood import Likelihood
from hefting.estimators.bayes.mixture import Mixture
from hefting.estimators.possible_bodies import PossibleBodies

UNSEEN = 1e-12
"""Eigenvalue of the scaled precision, relative to the largest, up to which a direction
counts as not seen by the samples."""
VANISHING = 1e-13
"""Root of a parameter's precision, relative to the largest, up to which it counts as
zero: rounding."""


@dataclass(frozen=True, eq=False)
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
