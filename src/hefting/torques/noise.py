"""Noise of joint torques, from the residuals of least squares, and the covariance of the
payload's parameters due to it.

Joint j is weighted by the standard deviation sigma_j of its residuals. Their colour
affects only the covariance, as weights by it would follow the model's errors: with v_jl
the variance of the residuals of joint j at time scale l, and Z_jl the regressors of arm
and payload at that scale, orthogonal to the joint's nuisances,

    cov = G^+ (sum_jl v_jl / sigma_j⁴ Z_jl' Z_jl + P) G^+,
    G = sum_jl Z_jl' Z_jl / sigma_j² + P

as for the wrench (`hefting.estimators.bayes.colour`), with P the same product of the
prior's rows. The residuals of a scale have its rows less the share of the unknowns as
degrees of freedom.
"""

from collections.abc import Callable
from dataclasses import replace
from functools import cached_property
from typing import Self

import numpy as np

from hefting.core.moments import triangular
from hefting.core.spatial import Array, immutable
from hefting.core.torque_moments import (
    PAYLOAD,
    TorqueMoments,
    payload_factor,
    pseudo_inverse_half,
)
from hefting.estimators.joint_state import WhitenedState
from hefting.estimators.quadratic import ScaledSVD
from hefting.torques.equations import CHANGES, GAIN, TorqueScales

PASSES = 3
"""Number of iterations of fit and noise: the weights depend on the noise."""
NEIGHBOURS = 8.0
"""Degrees of freedom with which the variance at the next shorter scale counts in the
variance at a scale."""
FIRST = 0.02
"""Initial standard deviation of the noise over the root mean square of the torque."""
FLOOR = 1e-6
"""Least standard deviation of the noise over the root mean square of the torque:
smaller residuals are rounding."""

GAIN_STD = 0.01
"""Standard deviation of the gain of each joint's torque, or constant of its current, as
on data sheets of torque sensors."""
LEAST_VARIANCE = 0.25
"""Lower bound of the variance of a combination of the payload's parameters, over that
with white noise of the same standard deviation."""


@immutable
class TorqueFit:
    """Least squares of all unknowns, with one deviation of the noise per joint."""

    scales: TorqueScales
    std: Array
    """(n,) standard deviations of the noise [N m]"""
    prior: Array
    """(own, n) standard deviations of the nuisances, infinite without prior knowledge"""

    @cached_property
    def moments(self) -> TorqueMoments:
        """Moments of all rows and of the prior, divided by their standard deviations."""
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
        """(11, 11) factor [payload | torque] of the payload's equations for white
        noise, with the arm eliminated."""
        return payload_factor(self.shared)

    @cached_property
    def half(self) -> Array:
        """(m, k) X with X X' = G^+, G as above."""
        return pseudo_inverse_half(self.shared[:, :-1])

    @cached_property
    def common(self) -> Array:
        """(m,) parameters of arm and payload; the smallest if they are not unique."""
        R = self.shared
        return self.half @ (self.half.T @ (R[:, :-1].T @ R[:, -1]))

    @cached_property
    def by_gain(self) -> Array:
        """(n, 10) change of the payload's parameters per relative increase of the torque
        of each joint."""
        rows = self.moments.without_nuisances
        right = (rows[:, :, :-1] * rows[:, :, -1:]).sum(axis=1)
        return right @ self.half @ self.half[-PAYLOAD:].T

    @cached_property
    def nuisances_half(self) -> Array:
        """(n, own, k) X, X X' the inverse normal matrix of each joint's nuisances."""
        own = self.moments.own
        return pseudo_inverse_half(self.moments.factors[:, :own, :own])

    @cached_property
    def nuisances(self) -> Array:
        """(n, own, m + 1) M: the most likely nuisances of each joint are M times
        (-arm, -payload, 1)."""
        own, X = self.moments.own, self.nuisances_half
        R = self.moments.factors[:, :own]
        right = np.swapaxes(R[:, :, :own], 1, 2) @ R[:, :, own:]
        return X @ (np.swapaxes(X, 1, 2) @ right)

    @property
    def of_usual_gains(self) -> Self:
        """The fit with gains that are off by `GAIN_STD`, to tell them from mistakes. Errors
        of the model imitate them, so they are no part of the answer but of its interval."""
        prior = self.prior.copy()
        prior[GAIN] = GAIN_STD
        return replace(self, prior=prior)

    @property
    def changes(self) -> float:
        """Largest change under load of an offset or a friction, over the standard deviation
        of its prior."""
        best = self.nuisances @ np.append(-self.common, 1.0)
        return float(np.abs(best[:, CHANGES].T / self.prior[CHANGES]).max())

    @cached_property
    def squares(self) -> Array:
        """(levels, n) sums of squared residuals [N² m²]."""
        common = np.append(-self.common, 1.0)
        every_joint = np.tile(common, (len(self.std), 1))
        solution = np.concatenate((-self.nuisances @ common, every_joint), 1)
        residuals = (self.scales.factors @ solution[:, :, None])[..., 0]
        return (residuals**2).sum(axis=2)

    @cached_property
    def regressors(self) -> Array:
        """(levels, n, c, m) Z: factors of arm and payload, orthogonal to nuisances."""
        own, factors = self.moments.own, self.scales.factors
        M = self.nuisances[:, :, :-1]
        return factors[..., own:-1] - factors[..., :own] @ M

    @cached_property
    def freedoms(self) -> Array:
        """(levels, n) residuals' degrees of freedom: rows less the unknowns' share."""
        own = self.scales.factors[..., : self.moments.own] @ self.nuisances_half
        common = self.regressors @ self.half
        leverage = (common * common).sum(axis=(2, 3)) + (own * own).sum(axis=(2, 3))
        return np.maximum(self.scales.counts - leverage / self.std**2, 0.0)

    @cached_property
    def variances(self) -> Array:
        """(levels, n) variances of the noise at each time scale [N² m²], each shrunk
        towards that of the next shorter one."""
        variances = np.empty_like(self.squares)
        variance = self.std**2
        for level, (square, freedom) in enumerate(
            zip(self.squares, self.freedoms, strict=True)
        ):
            weight = NEIGHBOURS if level else 1e-3
            variance = (square + weight * variance) / (freedom + weight)
            variances[level] = variance
        return variances

    @property
    def slow_std(self) -> Array:
        """(n,) standard deviation of the residuals at the two longest scales [N m],
        which errors of the model increase most."""
        return np.sqrt(self.variances[-2:].mean(axis=0))

    @cached_property
    def covariance(self) -> Array:
        """(10, 10) covariance of the payload's parameters by the noise of all scales and
        by the nuisances' prior, in the directions that the samples determine."""
        weights = np.sqrt(self.variances) / self.std**2
        noise = self.regressors * weights[:, :, None, None]
        prior = self.nuisances[:, :, :-1] / self.prior.T[:, :, None]
        m = len(self.half)
        rows = np.vstack((noise.reshape(-1, m), prior.reshape(-1, m)))
        rows = rows @ self.half @ self.half[-PAYLOAD:].T
        return rows.T @ rows

    @cached_property
    def state(self) -> WhitenedState:
        """The payload's equations, whitened for noise of each scale's variance.

        Coordinates u = S V phi have unit covariance for white noise, and the covariance
        K = S V cov V' S for this noise; the equations are multiplied by K^-1/2.
        """
        whole = self.scales.whole
        svd = ScaledSVD.of(self.payload[:, :PAYLOAD])
        rows = (svd.S[:, None] * svd.V) * svd.scale
        K = rows @ self.covariance @ rows.T
        values, vectors = np.linalg.eigh(0.5 * (K + K.T))
        values = np.maximum(values, LEAST_VARIANCE)
        equations = np.column_stack((rows, svd.U.T @ self.payload[:, PAYLOAD]))
        factor = triangular((vectors / np.sqrt(values)).T @ equations)
        noise = float(np.exp(np.mean(np.log(self.std))))
        return WhitenedState(factor, whole.samples, whole.duration, noise)


def fit(scales: TorqueScales, prior: Callable[[Array], Array]) -> TorqueFit:
    """Least squares with the noise of each joint from its residuals, by iteration.

    `prior` maps standard deviations of the noise (n,) [N m] to those of the nuisances
    (own, n), infinite without prior knowledge.
    """
    whole = scales.whole
    counts = np.maximum(whole.counts, 1.0)
    size = np.sqrt((whole.factors[:, :, -1] ** 2).sum(axis=1) / counts)
    floor = np.maximum(FLOOR * size, 1e-12)
    std = np.maximum(FIRST * size, floor)
    for _ in range(PASSES):
        fitted = TorqueFit(TorqueScales((whole,)), std, prior(std))
        freedom = np.maximum(fitted.freedoms.sum(axis=0), 1.0)
        std = np.maximum(np.sqrt(fitted.squares.sum(axis=0) / freedom), floor)
    return TorqueFit(scales, std, prior(std))
