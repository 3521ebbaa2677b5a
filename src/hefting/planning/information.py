"""What a motion would tell of the ten parameters, and how that changes with it.

The regressor is linear in twelve features x of a sample (`hefting.core.regressor`), A =
sum_a x_a D_a, so the information of all samples with noise of covariance S, a constant
bias free, is linear in their second moment about the mean:

    Lambda = sum_k (A_k - mean)' S^-1 (A_k - mean) = sum_ab M_ab D_a' S^-1 D_b,
    M = sum_k (x_k - mean)(x_k - mean)'
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple, Protocol, Self

import numpy as np

from hefting.core.measurements import MotionNoise, Noise
from hefting.core.regressor import FULL_MAP
from hefting.core.spatial import TENSOR_COLUMNS, TENSOR_ROWS, Array, frozen
from hefting.planning.kinematics import Passed, TipMotion

EFFECTS = FULL_MAP.reshape(12, 6, 10)
"""D (12, 6, 10)"""


class Slopes(NamedTuple):
    """Derivatives of a function of the information."""

    features: Array
    """(12, K)"""
    position: Array
    """(K, n) by joint positions, at the same features"""
    velocity: Array
    """(K, n) by joint velocities, at the same features"""


class Tells(Protocol):
    """What a sensor would tell of the ten parameters along a motion."""

    def gained(self, passed: Passed, x: Array, duration: float) -> Array:
        """(10, 10) information of a motion of `duration` [s], with features (12, K) at
        equal intervals."""
        ...

    def back(self, passed: Passed, x: Array, duration: float, by: Array) -> Slopes:
        """Derivatives of what has those `by` (10, 10) by the information."""
        ...


def features(tip: TipMotion) -> Array:
    """(12, K) of the motion of the sensor frame, as `hefting.core.regressor` has
    them."""
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
    """(6, 6) covariance that one sample at `rate` [Hz] counts with: of the wrench's
    noise, and of the errors of the accelerations by a body of ten parameters, as often
    as they last for (`hefting.motion.weighting`)."""
    E = np.einsum("aip,p->ia", EFFECTS[:6], vector)
    squares = np.repeat((motion.linear**2, motion.angular**2), 3)
    lasting = max(motion.memory * rate, 1.0)
    own = np.diag(np.repeat((noise.force**2, noise.torque**2), 3))
    return own + lasting * (E * squares) @ E.T


@dataclass(frozen=True, eq=False)
class Information:
    """Information of the wrench, one sample a time, of a given noise."""

    tensor: Array
    """(144, 100) D_a' S^-1 D_b"""
    rate: float
    """of the samples that will be recorded [Hz]"""

    @classmethod
    def of(cls, covariance: Array, rate: float) -> Self:
        """For samples at `rate` [Hz] with noise of a covariance (6, 6)."""
        weighed = np.einsum("ij,bjq->biq", np.linalg.inv(covariance), EFFECTS)
        tensor = np.einsum("aip,biq->abpq", EFFECTS, weighed).reshape(144, 100)
        return cls(frozen(tensor), rate)

    def gained(self, passed: Passed, x: Array, duration: float) -> Array:
        """As `Tells` has it; `passed` is not looked at."""
        off = x - x.mean(axis=1, keepdims=True)
        samples = self.rate * duration / x.shape[1]
        moment = samples * (off @ off.T)
        return (moment.ravel() @ self.tensor).reshape(10, 10)

    def back(self, passed: Passed, x: Array, duration: float, by: Array) -> Slopes:
        """As `Tells` has it."""
        off = x - x.mean(axis=1, keepdims=True)
        samples = self.rate * duration / x.shape[1]
        moment = (self.tensor @ by.ravel()).reshape(12, 12)
        none = np.zeros((x.shape[1], passed.chain.joints))
        return Slopes(samples * ((moment + moment.T) @ off), none, none)
