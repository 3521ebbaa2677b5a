"""Noise of joint torques, found in the residuals of least squares, and what it does to
the payload.

Each joint weighs by the standard deviation sigma_j of its residuals. Their colour,
which would follow the model's errors, is used for the covariance alone: with v_jl the
variance of the residuals of joint j at time scale l, and Z_jl the regressors of arm and
payload at that scale, each joint's nuisances taken out,

    cov = G^+ (sum_jl v_jl / sigma_j⁴ Z_jl' Z_jl) G^+,   G = sum_jl Z_jl' Z_jl / sigma_j²

as of the wrench (`hefting.estimators.bayes.colour`). Residuals have fewer freedoms than
rows, by the share of the unknowns in each scale.
"""

from collections.abc import Callable
from functools import cached_property

import numpy as np

from hefting.core.immutable import immutable
from hefting.core.moments import triangular
from hefting.core.spatial import Array
from hefting.core.torque_moments import (
    PAYLOAD,
    TorqueMoments,
    payload_factor,
    pseudo_inverse_half,
)
from hefting.estimators.joint_state import WhitenedState
from hefting.estimators.quadratic import ScaledSVD
from hefting.torques.equations import TorqueScales

PASSES = 3
"""Number of times the noise of the joints is found: their weights depend on it."""
NEIGHBOURS = 8.0
"""Freedoms that the variance at the next shorter scale is worth for that at a scale."""
FIRST = 0.02
"""Standard deviation of the noise over the torque's root mean square, to begin with."""
FLOOR = 1e-6
"""Least standard deviation of the noise over the torque's root mean square: smaller
values are due to rounding."""

LEAST_VARIANCE = 0.25
"""Least variance of a combination of the payload's parameters over that by white noise:
noise at the scales that tell it is hardly smaller than on average by more."""


@immutable
class TorqueFit:
    """Least squares of all unknowns for one standard deviation of the noise a joint."""

    scales: TorqueScales
    std: Array
    """(n,) [N m]"""
    prior: Array
    """(own, n) standard deviations of the nuisances, infinite where nothing is known"""

    @cached_property
    def moments(self) -> TorqueMoments:
        """Of all rows, whitened, with the prior's."""
        weighed = self.scales.whole.weighed(self.std)
        rows = np.zeros((weighed.own, *weighed.factors.shape[:2]))
        for i, own in enumerate(self.prior):
            rows[i, :, i] = 1.0 / own
        return weighed.fold_rows(rows)

    @cached_property
    def shared(self) -> Array:
        """(m + 1, m + 1) factor [arm | payload | torque]."""
        return self.moments.shared()

    @cached_property
    def payload(self) -> Array:
        """(11, 11) factor of the payload's equations, for white noise."""
        return payload_factor(self.shared)

    @cached_property
    def half(self) -> Array:
        """(m, k) X with X X' = G^+."""
        return pseudo_inverse_half(self.shared[:, :-1])

    @cached_property
    def common(self) -> Array:
        """(m,) arm and payload; of what is left open the smallest."""
        R = self.shared
        return self.half @ (self.half.T @ (R[:, :-1].T @ R[:, -1]))

    @cached_property
    def by_gain(self) -> Array:
        """(n, 10) what is added to the payload's parameters where the torque of each
        joint is shown twice as large."""
        rows = self.moments.without_nuisances
        right = (rows[:, :, :-1] * rows[:, :, -1:]).sum(axis=1)
        return right @ self.half @ self.half[-PAYLOAD:].T

    @cached_property
    def nuisances_half(self) -> Array:
        """(n, own, k) X with X X' the inverse of each joint's normal matrix, of its
        nuisances alone."""
        own = self.moments.own
        return pseudo_inverse_half(self.moments.factors[:, :own, :own])

    @cached_property
    def nuisances(self) -> Array:
        """(n, own, m + 1): the nuisances of each joint at their best are this
        times (-arm, -payload, 1)."""
        own, X = self.moments.own, self.nuisances_half
        R = self.moments.factors[:, :own]
        right = np.swapaxes(R[:, :, :own], 1, 2) @ R[:, :, own:]
        return X @ (np.swapaxes(X, 1, 2) @ right)

    @property
    def changes(self) -> float:
        """Largest change under load of an offset or friction, over its prior."""
        best = self.nuisances @ np.append(-self.common, 1.0)
        return float(np.abs(best[:, -2:].T / self.prior[-2:]).max())

    @cached_property
    def squares(self) -> Array:
        """(levels, n) of the residuals [N² m²]."""
        s = np.append(-self.common, 1.0)
        x = np.concatenate((-self.nuisances @ s, np.tile(s, (len(self.std), 1))), 1)
        return ((self.scales.factors @ x[:, :, None])[..., 0] ** 2).sum(axis=2)

    @cached_property
    def regressors(self) -> Array:
        """(levels, n, c, m) Z: of arm and payload, the nuisances taken out."""
        own, factors = self.moments.own, self.scales.factors
        M = self.nuisances[:, :, :-1]
        return factors[..., own:-1] - factors[..., :own] @ M

    @cached_property
    def freedoms(self) -> Array:
        """(levels, n) of the residuals: rows less the share of the unknowns."""
        own = self.scales.factors[..., : self.moments.own] @ self.nuisances_half
        shared = self.regressors @ self.half
        taken = (shared * shared).sum(axis=(2, 3)) + (own * own).sum(axis=(2, 3))
        return np.maximum(self.scales.counts - taken / self.std**2, 0.0)

    @cached_property
    def variances(self) -> Array:
        """(levels, n) of the noise at each time scale [N² m²]."""
        found = np.empty_like(self.squares)
        before = self.std**2
        for level, (square, freedom) in enumerate(
            zip(self.squares, self.freedoms, strict=True)
        ):
            weight = NEIGHBOURS if level else 1e-3
            before = (square + weight * before) / (freedom + weight)
            found[level] = before
        return found

    @property
    def slow_std(self) -> Array:
        """(n,) standard deviation of the residuals at the two longest scales, where a
        wrong model shows [N m]."""
        return np.sqrt(self.variances[-2:].mean(axis=0))

    @cached_property
    def covariance(self) -> Array:
        """(10, 10) of the payload's parameters by noise of each scale's variance, where
        the samples tell them."""
        weights = self.variances / self.std**4
        inverse = self.half @ self.half[-PAYLOAD:].T
        Z = self.regressors @ inverse * np.sqrt(weights)[:, :, None, None]
        rows = Z.reshape(-1, PAYLOAD)
        return rows.T @ rows

    @cached_property
    def state(self) -> WhitenedState:
        """The payload's equations, whitened by all of the noise.

        In coordinates u = S V phi, in which white noise has unit covariance, that of
        the noise is K = S V cov V' S; they are multiplied by K^-1/2.
        """
        whole = self.scales.whole
        seen = ScaledSVD.of(self.payload[:, :PAYLOAD])
        rows = (seen.S[:, None] * seen.V) * seen.scale
        K = rows @ self.covariance @ rows.T
        values, vectors = np.linalg.eigh(0.5 * (K + K.T))
        values = np.maximum(values, LEAST_VARIANCE)
        left = np.column_stack((rows, seen.U.T @ self.payload[:, PAYLOAD]))
        left = (vectors / np.sqrt(values)).T @ left
        noise = float(np.exp(np.mean(np.log(self.std))))
        return WhitenedState(triangular(left), whole.samples, whole.duration, noise)


def fit(scales: TorqueScales, prior: Callable[[Array], Array]) -> TorqueFit:
    """Least squares with each joint's noise found from its residuals.

    `prior` gives the standard deviations (own, n) of the nuisances for those of the
    noise (n,), infinite where nothing is known.
    """
    whole = scales.whole
    counts = np.maximum(whole.counts, 1.0)
    size = np.sqrt((whole.factors[:, :, -1] ** 2).sum(axis=1) / counts)
    floor = np.maximum(FLOOR * size, 1e-12)
    std = np.maximum(FIRST * size, floor)
    for _ in range(PASSES):
        found = TorqueFit(scales, std, prior(std))
        freedom = np.maximum(found.freedoms.sum(axis=0), 1.0)
        std = np.maximum(np.sqrt(found.squares.sum(axis=0) / freedom), floor)
    return TorqueFit(scales, std, prior(std))
