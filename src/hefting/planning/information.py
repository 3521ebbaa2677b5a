"""Information about the ten parameters that a motion would give, by the wrench or by the
torques of the joints, and its gradient by the motion.

The regressor is linear in twelve features x of a sample (`hefting.core.regressor`), A =
sum_a x_a D_a, so the information of all samples with noise of covariance S and a free
constant bias is linear in their second moment about the mean:

    Lambda = sum_k (A_k - mean)' S^-1 (A_k - mean) = sum_ab M_ab D_a' S^-1 D_b,
    M = sum_k (x_k - mean)(x_k - mean)'

The object loads joint j at instant k with the torque b_jk' phi, b_jk = A_k' S_jk, with
S_jk the joint's screw axis in the sensor frame. The arm is known from an empty run,
except for changes of an offset and a Coulomb friction until the loaded run
(`hefting.torques.runs`), whose standard deviations are multiples of that of the noise.
With c = (b, 1, s) the columns of a joint, s the sign of its speed, w in 0..1 the weight
of its samples and P the information of the changes,

    G_j = sum_k w_jk c_jk c_jk',    Lambda = sum_j (G_bb - G_bu (G_uu + P)^-1 G_ub) / sigma_j²

The estimator omits samples in which a joint hardly moves, as friction follows no law
there; here the weight w is smooth, and nearly zero where the sign changes. With E_j' =
[I, -G_bu (G_uu + P)^-1], a change of G_j changes Lambda by E_j' dG_j E_j.
"""

from __future__ import annotations

from functools import cached_property
from typing import NamedTuple, Self

import numpy as np

from hefting.core.measurements import MotionNoise, Noise
from hefting.core.regressor import FULL_MAP
from hefting.core.spatial import TENSOR_COLUMNS, TENSOR_ROWS, Array, frozen, immutable
from hefting.planning.kinematics import Passed, TipMotion
from hefting.torques.runs import FRICTION_CHANGE, OFFSET_CHANGE
from hefting.torques.samples import STICTION_SPEED

EFFECTS = FULL_MAP.reshape(12, 6, 10)
"""D (12, 6, 10)"""


class Slopes(NamedTuple):
    """Partial derivatives of a function of the information."""

    features: Array
    """(12, K)"""
    position: Array
    """(K, n) by joint positions, with constant features"""
    velocity: Array
    """(K, n) by joint velocities, with constant features"""


def features(tip: TipMotion) -> Array:
    """(12, K) features of a motion, as in `hefting.core.regressor`."""
    w = tip.angular_velocity
    squares = w[TENSOR_ROWS] * w[TENSOR_COLUMNS]
    return np.concatenate((tip.acceleration, tip.angular_acceleration, squares))


def feature_gradient(tip: TipMotion, by: Array) -> tuple[Array, Array, Array]:
    """Derivatives (3, K) of a function by acceleration, angular acceleration and angular
    velocity, from its derivatives `by` the features (12, K)."""
    w = tip.angular_velocity
    by_w = np.zeros_like(w)
    for row, column, own in zip(TENSOR_ROWS, TENSOR_COLUMNS, by[6:], strict=True):
        by_w[row] += own * w[column]
        by_w[column] += own * w[row]
    return by[:3], by[3:6], by_w


def expected_wrench(x: Array, vector: Array) -> Array:
    """(6, K) wrench [N, N m] of a body of parameters (10,) at features (12, K)."""
    return np.einsum("aip,p->ia", EFFECTS, vector) @ x


def noise_covariance(noise: Noise, motion: MotionNoise, vector: Array, rate: float):
    """(6, 6) effective covariance of a sample at `rate` [Hz]: of the wrench's noise, and
    of the accelerations' errors times the number of samples over which these persist
    (`hefting.motion.state`)."""
    E = np.einsum("aip,p->ia", EFFECTS[:6], vector)
    squares = np.repeat((motion.linear**2, motion.angular**2), 3)
    lasting = max(motion.memory * rate, 1.0)
    own = np.diag(np.repeat((noise.force**2, noise.torque**2), 3))
    return own + lasting * (E * squares) @ E.T


@immutable
class Information:
    """Information by samples of the wrench."""

    tensor: Array
    """(144, 100) D_a' S^-1 D_b"""
    rate: float
    """[Hz] of the samples"""

    @classmethod
    def of(cls, covariance: Array, rate: float) -> Self:
        """Information by samples at `rate` [Hz] with noise of a covariance (6, 6)."""
        weighed = np.einsum("ij,bjq->biq", np.linalg.inv(covariance), EFFECTS)
        tensor = np.einsum("aip,biq->abpq", EFFECTS, weighed).reshape(144, 100)
        return cls(frozen(tensor), rate)

    def gained(self, passed: Passed, x: Array, duration: float) -> Array:
        """(10, 10) information by a motion of `duration` [s] with features `x` (12, K)
        at equal intervals; `passed` is unused."""
        centred, samples = self._centred(x, duration)
        moment = samples * (centred @ centred.T)
        return (moment.ravel() @ self.tensor).reshape(10, 10)

    def back(self, passed: Passed, x: Array, duration: float, by: Array) -> Slopes:
        """Derivatives of a function, from those `by` the information (10, 10)."""
        centred, samples = self._centred(x, duration)
        moment = (self.tensor @ by.ravel()).reshape(12, 12)
        zeros = np.zeros((x.shape[1], passed.chain.joints))
        return Slopes(samples * ((moment + moment.T) @ centred), zeros, zeros)

    def _centred(self, x: Array, duration: float) -> tuple[Array, float]:
        """Features less their mean, and the number of samples per instant."""
        samples = self.rate * duration / x.shape[1]
        return x - x.mean(axis=1, keepdims=True), samples


PARAMETERS = 10
STEEPNESS = 8
"""Exponent n of the weight w = u / (1 + u), u = (speed / `STICTION_SPEED`)^n."""
CHANGES = np.diag((OFFSET_CHANGE**-2, FRICTION_CHANGE**-2))
"""P times the variance of the noise"""
MAP = EFFECTS.transpose(1, 2, 0).reshape(60, 12)


@immutable
class JointInformation:
    """Information by samples of the torques of n joints."""

    noise: Array
    """(n,) standard deviations [N m]"""
    rate: float
    """[Hz] of the samples"""

    def gained(self, passed: Passed, x: Array, duration: float) -> Array:
        """As `Information.gained`."""
        G, E = self._columns(passed, x, duration).reduced
        return np.einsum("nap,naq,n->pq", G[:, :, :PARAMETERS], E, self.noise**-2)

    def back(self, passed: Passed, x: Array, duration: float, by: Array) -> Slopes:
        """As `Information.back`."""
        columns = self._columns(passed, x, duration)
        each = self.noise[:, None, None] ** -2 * (by + by.T)
        _, E = columns.reduced
        return columns.back(E @ each @ E.swapaxes(1, 2))

    def _columns(self, passed: Passed, x: Array, duration: float) -> _Columns:
        return _Columns(passed, x, self.rate * duration / x.shape[1])


@immutable
class _Columns:
    """Columns of the joints' equations along a motion."""

    passed: Passed
    x: Array
    """(12, K) features"""
    samples: float
    """number per instant"""

    @cached_property
    def regressors(self) -> Array:
        """(6, 10, K) A"""
        return (MAP @ self.x).reshape(6, PARAMETERS, -1)

    @cached_property
    def screws(self) -> Array:
        """(6, n, K) S, linear part first, as the wrench"""
        screws = self.passed.screws
        return screws.swapaxes(0, 1).reshape(6, *screws.shape[2:])

    @cached_property
    def values(self) -> Array:
        """(n, 12, K) c"""
        rates = self.passed.rates
        b = np.einsum("ink,ipk->npk", self.screws, self.regressors)
        sign = np.sign(rates)
        return np.concatenate((b, np.stack((np.ones_like(sign), sign), 1)), axis=1)

    @cached_property
    def powers(self) -> Array:
        """(n, K) u of `STEEPNESS`"""
        return (self.passed.rates / STICTION_SPEED) ** STEEPNESS

    @cached_property
    def weights(self) -> Array:
        """(n, K) w times the number of samples"""
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
        """Derivatives of a function, from those `by` / 2 (n, 12, 12) by G."""
        c, rates = self.values, self.passed.rates
        weightless = by @ c
        by_weights = 0.5 * (weightless * c).sum(axis=1)
        by_b = (weightless * self.weights[:, None])[:, :PARAMETERS]
        by_screws = np.einsum("npk,ipk->ink", by_b, self.regressors)
        by_regressors = np.einsum("npk,ink->ipk", by_b, self.screws)
        by_parts = by_screws.reshape(2, 3, *rates.shape).swapaxes(0, 1)
        powers_by_rate = STEEPNESS * rates ** (STEEPNESS - 1)
        powers_by_rate = powers_by_rate / STICTION_SPEED**STEEPNESS
        velocity = self.samples * by_weights * powers_by_rate / (1.0 + self.powers) ** 2
        return Slopes(
            MAP.T @ by_regressors.reshape(6 * PARAMETERS, -1),
            self.passed.screws_back(by_parts),
            velocity.T,
        )
