"""Groups of samples, by time scale or by stretch: their scores, and how well they
agree.

A group's score u = h - H phi is its gradient of the log-likelihood at the parameters
phi (10,), see `likelihood`. If the model holds its mean is zero and its covariance is v
G, with v the variance of the noise in the group over that of one sample. The means of
u'(v G)^+ u / 4 over its first four entries, mass and first moment, are Birge ratios
(1932): about 1 if the groups differ by chance.
"""

from collections.abc import Sequence
from functools import cached_property
from typing import Self

import numpy as np

from hefting.core.regressor import FEATURES, ONE, WRENCH, full_rows
from hefting.core.spatial import Array, immutable

COMPARED_ENTRIES = 4
"""Number of leading entries of a score that are compared: mass and first moment."""


@immutable
class Groups:
    """Virtual samples of g groups, by channel."""

    factors: Array
    """(g, 22, 22) triangular, of their features"""
    counts: Array
    """(g,) samples of each, by weight"""

    @classmethod
    def of(
        cls, factors: Sequence[Array], counts: Sequence[float], mean: Array | None
    ) -> Self:
        """From triangular factors (g, 22, 22) of the groups' features, less a `mean`
        (22,) for all or (g, 22) of each."""
        g = len(factors)
        R = np.array(factors).reshape(g, FEATURES, FEATURES)
        if mean is not None:
            R = R - R[:, :, ONE, None] * mean.reshape(-1, 1, FEATURES)
        return cls(R, np.array(counts, dtype=float))

    @cached_property
    def A(self) -> Array:
        """(g, 6, 22 * 10)"""
        rows = full_rows(self.factors.reshape(-1, FEATURES))
        A = rows.reshape(-1, FEATURES, 6, 10)
        return A.transpose(0, 2, 1, 3).reshape(-1, 6, FEATURES * 10)

    @property
    def b(self) -> Array:
        """(g, 6, 22)"""
        return self.factors[:, :, WRENCH].transpose(0, 2, 1)

    def whitened(self, W: Array) -> Array:
        """(g, 6 * 22, 10) A with the wrench multiplied by W (6, 6)."""
        return (W @ self.A).reshape(-1, 6 * FEATURES, 10)

    def information(self, B: Array) -> Array:
        """(g, 10, 10) sum of A'B'B A of each group, for weights B (6, 6)."""
        rows = self.whitened(B)
        return rows.transpose(0, 2, 1) @ rows

    def scores(self, W: Array, phi: Array, attenuation: Array | None) -> "Scores":
        """Scores at parameters phi (10,), with the wrench whitened by W (6, 6);
        `attenuation` (10, 10) is the contribution of the motion's white noise to G, per
        sample."""
        A = self.whitened(W)
        r = (W @ self.b).reshape(-1, 6 * FEATURES) - A @ phi
        T = A.transpose(0, 2, 1)
        u = (T @ r[:, :, None])[:, :, 0]
        if attenuation is not None:
            u = u + self.counts[:, None] * (attenuation @ phi)
        return Scores(T @ A, u, (r * r).sum(axis=1), A)


@immutable
class Scores:
    """Information, scores and energies of groups at given parameters."""

    information: Array
    """(g, 10, 10) G"""
    scores: Array
    """(g, 10) u"""
    energies: Array
    """(g,) sums of squared whitened residuals"""
    A: Array
    """(g, 6 * 22, 10) whitened regressors, by channel"""

    def gain(self) -> float:
        """Decrease of all groups' energies together if each had its own parameters."""
        size = np.sqrt(np.maximum(np.einsum("gii->gi", self.information), 0.0))
        scale = np.where(size > 0.0, size, 1.0)
        G = self.information / (scale[:, :, None] * scale[:, None, :]) + 1e-9 * np.eye(
            10
        )
        x = self.scores / scale
        return float((x * np.linalg.solve(G, x[:, :, None])[:, :, 0]).sum())

    def birge(self, variances: Array, more: Array | None = None) -> Array:
        """Birge ratio (g,) of each group for noise of variance (g,); 0 for a group
        without information. `more` (g, 10, 10) is added to the scores' covariance by
        noise."""
        n = COMPARED_ENTRIES
        V = variances[:, None, None] * self.information[:, :n, :n]
        if more is not None:
            V = V + more[:, :n, :n]
        u = self.scores[:, :n]
        size = np.sqrt(np.maximum(np.einsum("gii->gi", V), 0.0))
        scale = np.where(size > 0.0, size, 1.0)
        x = u / scale
        V = V / (scale[:, :, None] * scale[:, None, :]) + 1e-9 * np.eye(n)
        return np.einsum("gi,gi->g", x, np.linalg.solve(V, x[:, :, None])[:, :, 0]) / n


def combined(weights: Array, matrices: Array) -> Array:
    """(10, 10) sum of matrices (g, 10, 10) times `weights` (g,)."""
    return (weights @ matrices.reshape(-1, 100)).reshape(10, 10)
