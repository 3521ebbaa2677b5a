"""What a motion would tell of the ten parameters, by the wrench or by the torques of the
joints, and how that changes with the motion.

The regressor is linear in twelve features x of a sample (`hefting.core.regressor`), A =
sum_a x_a D_a, so the information of all samples with noise of covariance S, a constant
bias free, is linear in their second moment about the mean:

    Lambda = sum_k (A_k - mean)' S^-1 (A_k - mean) = sum_ab M_ab D_a' S^-1 D_b,
    M = sum_k (x_k - mean)(x_k - mean)'

The torque that the object asks of joint j at instant k is b_jk' phi with b_jk = A_k'
S_jk, S_jk the joint's screw axis in the sensor frame. The arm is known from an empty run,
but for what changes from that run to the loaded one (`hefting.torques.runs`): an offset,
and a Coulomb friction, with standard deviations in proportion to that of the noise. With
c = (b, 1, s) the columns of a joint, s the sign of its speed, w in 0..1 the weight of its
samples and P the information of the changes,

    G_j = sum_k w_jk c_jk c_jk',    Lambda = sum_j (G_bb - G_bu (G_uu + P)^-1 G_ub) / sigma_j²

Samples in which a joint hardly moves do not count in the estimator, as its friction has
no law there; here the weight w is smooth, and next to nothing where the sign changes.
With E_j' = [I, -G_bu (G_uu + P)^-1] the derivative of Lambda by G_j is E_j' dG_j E_j: a
best value changes nothing to first order.
"""

from __future__ import annotations

from functools import cached_property
from typing import NamedTuple, Self

import numpy as np

from hefting.core.immutable import immutable
from hefting.core.measurements import MotionNoise, Noise
from hefting.core.regressor import FULL_MAP
from hefting.core.spatial import TENSOR_COLUMNS, TENSOR_ROWS, Array, frozen
from hefting.planning.kinematics import Passed, TipMotion
from hefting.torques.equations import STICTION_SPEED
from hefting.torques.runs import FRICTION_CHANGE, OFFSET_CHANGE

EFFECTS = FULL_MAP.reshape(12, 6, 10)
"""D (12, 6, 10)"""


class Slopes(NamedTuple):
    """Derivatives of a function of the information, position and velocity at the same
    features."""

    features: Array
    """(12, K)"""
    position: Array
    """(K, n) by joint positions, at the same features"""
    velocity: Array
    """(K, n) by joint velocities, at the same features"""


def features(tip: TipMotion) -> Array:
    """(12, K) as `hefting.core.regressor` has them."""
    w = tip.angular_velocity
    squares = w[TENSOR_ROWS] * w[TENSOR_COLUMNS]
    return np.concatenate((tip.acceleration, tip.angular_acceleration, squares))


def feature_gradient(tip: TipMotion, by: Array) -> tuple[Array, Array, Array]:
    """Derivatives (3, K) by acceleration, angular acceleration and angular velocity of
    what has the derivatives `by` (12, K) by the features."""
    w, rest = tip.angular_velocity, by[6:]
    turning = np.zeros_like(w)
    for row, column, own in zip(TENSOR_ROWS, TENSOR_COLUMNS, rest, strict=True):
        turning[row] += own * w[column]
        turning[column] += own * w[row]
    return by[:3], by[3:6], turning


def expected_wrench(x: Array, vector: Array) -> Array:
    """(6, K) [N, N m] that a body of ten parameters needs for motions of features (12,
    K)."""
    return np.einsum("aip,p->ia", EFFECTS, vector) @ x


def noise_covariance(noise: Noise, motion: MotionNoise, vector: Array, rate: float):
    """(6, 6) that one sample at `rate` [Hz] counts with: of the wrench's noise, and of
    the accelerations' errors, as often as they last for
    (`hefting.motion.weighting`)."""
    E = np.einsum("aip,p->ia", EFFECTS[:6], vector)
    squares = np.repeat((motion.linear**2, motion.angular**2), 3)
    lasting = max(motion.memory * rate, 1.0)
    own = np.diag(np.repeat((noise.force**2, noise.torque**2), 3))
    return own + lasting * (E * squares) @ E.T


@immutable
class Information:
    """Information of the wrench, one sample a time, of a given noise."""

    tensor: Array
    """(144, 100) D_a' S^-1 D_b"""
    rate: float
    """[Hz] of the samples that will be recorded"""

    @classmethod
    def of(cls, covariance: Array, rate: float) -> Self:
        """For samples at `rate` [Hz] with noise of a covariance (6, 6)."""
        weighed = np.einsum("ij,bjq->biq", np.linalg.inv(covariance), EFFECTS)
        tensor = np.einsum("aip,biq->abpq", EFFECTS, weighed).reshape(144, 100)
        return cls(frozen(tensor), rate)

    def gained(self, passed: Passed, x: Array, duration: float) -> Array:
        """(10, 10) by a motion of `duration` [s] with features (12, K) at equal
        intervals; `passed` is not looked at."""
        off, samples = self._off(x, duration)
        moment = samples * (off @ off.T)
        return (moment.ravel() @ self.tensor).reshape(10, 10)

    def back(self, passed: Passed, x: Array, duration: float, by: Array) -> Slopes:
        """Derivatives of what has those `by` (10, 10) by the information."""
        off, samples = self._off(x, duration)
        moment = (self.tensor @ by.ravel()).reshape(12, 12)
        none = np.zeros((x.shape[1], passed.chain.joints))
        return Slopes(samples * ((moment + moment.T) @ off), none, none)

    def _off(self, x: Array, duration: float) -> tuple[Array, float]:
        """Features less their mean, and samples that an instant stands for."""
        samples = self.rate * duration / x.shape[1]
        return x - x.mean(axis=1, keepdims=True), samples


PARAMETERS = 10
STEEPNESS = 8
"""Power of the speed over `STICTION_SPEED` by which samples begin to count."""
CHANGES = np.diag((OFFSET_CHANGE**-2, FRICTION_CHANGE**-2))
"""P, times the variance of the noise"""
MAP = EFFECTS.transpose(1, 2, 0).reshape(60, 12)


@immutable
class JointInformation:
    """Information of the torques of n joints, one sample a time."""

    noise: Array
    """(n,) standard deviations [N m]"""
    rate: float
    """of the samples that will be recorded [Hz]"""

    def gained(self, passed: Passed, x: Array, duration: float) -> Array:
        """As of `Information`."""
        G, E = self._columns(passed, x, duration).reduced
        return np.einsum("nap,naq,n->pq", G[:, :, :PARAMETERS], E, self.noise**-2)

    def back(self, passed: Passed, x: Array, duration: float, by: Array) -> Slopes:
        """As of `Information`."""
        own = self._columns(passed, x, duration)
        each = self.noise[:, None, None] ** -2 * (by + by.T)
        _, E = own.reduced
        return own.back(E @ each @ E.swapaxes(1, 2))

    def _columns(self, passed: Passed, x: Array, duration: float) -> _Columns:
        return _Columns(passed, x, self.rate * duration / x.shape[1])


@immutable
class _Columns:
    """Columns of the joints' equations along a motion."""

    passed: Passed
    x: Array
    """(12, K) features"""
    samples: float
    """that an instant stands for"""

    @cached_property
    def regressors(self) -> Array:
        """(6, 10, K) A"""
        return (MAP @ self.x).reshape(6, PARAMETERS, -1)

    @cached_property
    def screws(self) -> Array:
        """(6, n, K) as the wrench is ordered"""
        own = self.passed.screws
        return own.swapaxes(0, 1).reshape(6, *own.shape[2:])

    @cached_property
    def values(self) -> Array:
        """(n, 12, K) c"""
        rates = self.passed.rates
        b = np.einsum("ink,ipk->npk", self.screws, self.regressors)
        sign = np.sign(rates)
        return np.concatenate((b, np.stack((np.ones_like(sign), sign), 1)), axis=1)

    @cached_property
    def powers(self) -> Array:
        """(n, K) of the speeds"""
        return (self.passed.rates / STICTION_SPEED) ** STEEPNESS

    @cached_property
    def weights(self) -> Array:
        """(n, K)"""
        return self.samples * self.powers / (1.0 + self.powers)

    @cached_property
    def reduced(self) -> tuple[Array, Array]:
        """G (n, 12, 12) and E (n, 12, 10)"""
        c = self.values
        G = (self.weights[:, None] * c) @ c.swapaxes(1, 2)
        own = G[:, PARAMETERS:, PARAMETERS:] + CHANGES
        taken = np.linalg.solve(own, G[:, PARAMETERS:, :PARAMETERS])
        unit = np.broadcast_to(np.eye(PARAMETERS), (len(c), PARAMETERS, PARAMETERS))
        return G, np.concatenate((unit, np.asarray(-taken, dtype=float)), axis=1)

    def back(self, by: Array) -> Slopes:
        """Derivatives of what has those `by` / 2 (n, 12, 12) by G."""
        c, rates = self.values, self.passed.rates
        pull = by @ c
        by_weights = 0.5 * (pull * c).sum(axis=1)
        pull = pull * self.weights[:, None]
        b = pull[:, :PARAMETERS]
        by_screws = np.einsum("npk,ipk->ink", b, self.regressors)
        by_regressors = np.einsum("npk,ink->ipk", b, self.screws)
        parted = by_screws.reshape(2, 3, *rates.shape).swapaxes(0, 1)
        rising = STEEPNESS * rates ** (STEEPNESS - 1) / STICTION_SPEED**STEEPNESS
        velocity = self.samples * by_weights * rising / (1.0 + self.powers) ** 2
        return Slopes(
            MAP.T @ by_regressors.reshape(6 * PARAMETERS, -1),
            self.passed.screws_back(parted),
            velocity.T,
        )
