"""Samples: the sums over all samples of a state that the likelihood needs."""

from functools import cached_property
from typing import Self

import numpy as np

from hefting.core.errors import NotIdentifiableError
from hefting.core.lapack import triangular_root
from hefting.core.moments import triangular
from hefting.core.regressor import ONE, WRENCH, full_rows
from hefting.core.spatial import Array, immutable
from hefting.estimators.joint_state import (
    State,
    WhitenedState,
    states_by_bias,
    states_of,
)

NOISE_FLOOR_SHARE = 1e-6
"""Smallest noise, relative to the wrench's root mean square: smaller values are due to
rounding."""
POOR_SENSOR_NOISE = 0.05
"""Noise of a poor sensor relative to its wrench, assumed while there are too few
samples to measure it."""
SEPARATE_POSE_INTERVAL = 0.5
"""[s] Mean time between samples from which on they count as separate poses, with
independent slow errors of the sensor."""
SPENT_SAMPLES = 10.0 / 6.0 + 6.0
"""Number of samples without information on the residuals' covariance: ten parameters
take 10/6, and six leave it singular."""
ISOTROPY_SAMPLES = 12.0
"""Weight, in samples, of the prior of the residuals' covariance: independent channels,
with one variance for the forces and one for the torques."""


@immutable
class Samples:
    """Virtual samples of a state, less the mean of each recording if a bias is free."""

    A: Array
    """(22, 6, 10)"""
    b: Array
    """(22, 6)"""
    K: float
    """samples, by weight; one less for each free bias"""
    d: Array
    """(22, 3) a - g"""
    floor: Array
    """(6,) least standard deviations of the wrench [N, N m]"""
    A_mean: Array
    """(n, 6, 10) mean regressor of each recording with a bias of its own"""
    b_mean: Array
    """(n, 6) mean wrench"""
    shares: Array
    """(n,) of the samples; they sum to one"""
    pace: float
    """mean time between samples [s]"""

    @classmethod
    def of(cls, state: State, free_bias: bool) -> Self:
        """Of all samples in `state`."""
        if isinstance(state, WhitenedState):
            return cls._of_equations(state)
        factors = [each.full.factor for each in states_by_bias(state, free_bias)]
        factors = [R for R in factors if R[:, ONE].any()] or factors[:1]
        each = np.array([R[:, ONE] @ R[:, ONE] for R in factors])
        means = np.array([R[:, ONE] @ R for R in factors]) / each[:, None]
        K, wrench = float(each.sum()), np.concatenate(factors)[:, WRENCH]
        sizes = np.sqrt((wrench**2).reshape(-1, 2, 3).sum(axis=(0, 2)) / (3.0 * K))
        if free_bias:
            factors = [
                R - R[:, ONE, None] * mean
                for R, mean in zip(factors, means, strict=True)
            ]
        R = factors[0] if len(factors) == 1 else triangular(np.concatenate(factors))
        floor = NOISE_FLOOR_SHARE * np.repeat(np.maximum(sizes, 1e-3 * sizes.max()), 3)
        return cls(
            full_rows(R),
            R[:, WRENCH],
            K - len(factors) if free_bias else K,
            R[:, :3],
            np.maximum(floor, 1e-12),
            full_rows(means),
            means[:, WRENCH],
            each / K,
            state.duration / max(state.samples - 1, 1),
        )

    @classmethod
    def _of_equations(cls, state: WhitenedState) -> Self:
        """From equations of unit noise as channels of virtual samples: that of the mass
        alone as a force, the nine others as torques, and zeros."""
        rows = np.zeros((3, 6, 11))
        rows[:, 3:] = state.mass_last[:9].reshape(3, 3, 11)
        rows[0, 0] = state.mass_last[9]
        d = np.zeros((3, 3))
        d[0, 0] = rows[0, 0, 0]
        return cls(
            rows[..., :10],
            rows[..., 10],
            float(max(state.samples, 1)),
            d,
            np.full(6, 1e-12),
            np.zeros((1, 6, 10)),
            np.zeros((1, 6)),
            np.ones(1),
            state.duration / max(state.samples - 1, 1),
        )

    @cached_property
    def by_channel(self) -> Array:
        """(6, 22 * 10) A by channel, so that whitening it is one matrix product."""
        return np.ascontiguousarray(self.A.transpose(1, 0, 2)).reshape(6, -1)

    @cached_property
    def least_squares(self) -> Array:
        """(10,) parameters of least squares, forces and torques weighed by size."""
        squares = (self.b * self.b).sum(axis=0).reshape(2, 3).sum(axis=1)
        scale = np.repeat(1.0 / np.sqrt(squares + self.floor[::3] ** 2), 3)
        A, b = (self.A * scale[:, None]).reshape(-1, 10), (self.b * scale).ravel()
        G = A.T @ A
        units: Array = np.sqrt(G.diagonal())
        units[units < 1e-13 * units.max()] = np.inf
        root = triangular_root(G / units / units[:, None])
        if root is not None:
            root /= units
            return root.T @ (root @ (b @ A))
        return np.linalg.lstsq(A / units, b, rcond=1e-10)[0] / units

    @cached_property
    def least_residual(self) -> Array:
        """(6, 6) covariance of the residuals of least squares."""
        return self.residual_covariance(self.least_squares)

    def residual_covariance(self, phi: Array, spent: float = 10.0) -> Array:
        """(6, 6) mean square of the residuals at parameters phi (10,), with `spent` of
        the 6 K equations, at most three quarters, taken off the degrees of freedom."""
        r = self.b.T - (self.by_channel.reshape(-1, 10) @ phi).reshape(6, -1)
        return (r @ r.T) / max(self.K - spent / 6.0, 0.25 * self.K)

    def noise_left(self, R: Array, autocorrelation: float = 1.0) -> Array:
        """(6, 6) noise covariance from residuals of covariance R (6, 6), of which
        `autocorrelation` samples count as one."""
        levels = (R.diagonal().reshape(2, 3).sum(axis=1) / 3.0).repeat(3)
        K = max(self.K / autocorrelation - SPENT_SAMPLES, 0.0)
        S = K / (K + ISOTROPY_SAMPLES) * R
        S.flat[::7] += ISOTROPY_SAMPLES / (K + ISOTROPY_SAMPLES) * levels
        S.flat[::7] += self.floor**2
        return S

    def unproven(self, enough: int) -> Array:
        """(6, 6) covariance of the noise that fewer than `enough` samples cannot
        exclude: that of a poor sensor with the same error in all samples. Zero for
        separate poses, at least `SEPARATE_POSE_INTERVAL` apart."""
        if self.pace >= SEPARATE_POSE_INTERVAL:
            return np.zeros((6, 6))
        share = max(1.0 - self.K / enough, 0.0) * max(self.K, 1.0)
        return share * np.diag(
            (POOR_SENSOR_NOISE / NOISE_FLOOR_SHARE * self.floor) ** 2
        )

    def bias(self, phi: Array) -> Array:
        """(6,) best bias for parameters phi (10,); (n, 6) those of n recordings."""
        found = self.b_mean - self.A_mean @ phi
        return found[0] if len(found) == 1 else found

    def constant_load(self, W: Array, phi: Array) -> float:
        """Mean square, summed over channels, of each recording's mean wrench at
        parameters phi (10,), multiplied by W (6, 6)."""
        return float(self.shares @ np.sum((self.A_mean @ phi @ W.T) ** 2, axis=1))

    def mass_scale(self, force_std: float) -> float:
        """Rough mass [kg], never zero: the force over the largest measure of the
        acceleration."""
        f = self.b[:, :3]
        square = float((self.d * self.d).sum()) or 1e-12
        by_size = max(float((f * f).sum()) - 3.0 * self.K * force_std**2, 0.0)
        return max(
            (by_size / square) ** 0.5,
            float((f * self.d).sum()) / square,
            3.0 * force_std / square**0.5,
            1e-9,
        )


def require_information(samples: Samples, state: State, free_bias: bool) -> None:
    """`NotIdentifiableError` if the regressor, less its mean for a free bias, is zero
    up to rounding."""
    if isinstance(state, WhitenedState):
        size = float(np.abs(state.factor[:, :10]).max())
        size = max(size, np.finfo(float).tiny)
    else:
        size = max(float(np.abs(each.full.full).max()) for each in states_of(state))
    if float(np.abs(samples.A).max()) <= 1e-9 * size:
        beside = " beside a bias" if free_bias else ""
        raise NotIdentifiableError(
            f"the samples determine nothing{beside}", fix="record other orientations"
        )
