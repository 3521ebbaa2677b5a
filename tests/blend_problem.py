"""Samples, weights, noise and a shape for both models, and the dense matrices of every
sample."""

from dataclasses import replace

import numpy as np
import pytest

from hefting.core.measurements import Measurements
from hefting.core.regressor import full_regressor, reduced_regressor
from hefting.shapes import Shape
from random_problems import random_body, random_motion, with_wrench

ROUNDING = 1e-11
"""Of sums over 60 samples and orthogonal transformations of them, 1e-14, times the
conditioning of the regressor's scaled columns, about ten, and a margin."""
BIAS = np.array((3.0, -7.0, 11.0, 0.5, -1.0, 2.0))
K = 60


def weighted_samples() -> Measurements:
    """Slow and fast samples, of unequal weight, with a bias."""
    rng = np.random.default_rng(51)
    motion = random_motion(rng, K)
    speed = 10.0 ** rng.uniform(-1.0, 0.5, (K, 1))
    motion = replace(
        motion,
        linear_acceleration=speed * motion.linear_acceleration,
        angular_velocity=speed * motion.angular_velocity,
        angular_acceleration=speed * motion.angular_acceleration,
        weights=rng.uniform(0.2, 2.0, K),
    )
    return with_wrench(motion, random_body(rng), BIAS, rng, 0.1, 0.005)


def correlated_noise() -> np.ndarray:
    """Correlated wrench noise of 0.1 N and 0.005 N m."""
    rng = np.random.default_rng(52)
    scale = np.repeat((0.1, 0.005), 3)
    return np.cov(rng.normal(size=(6, 20))) * np.outer(scale, scale)


def random_shape() -> Shape:
    """56 random points."""
    return Shape(np.random.default_rng(53).uniform(-0.1, 0.2, (56, 3)))


WEIGHTS = {
    "reduced": 0.0,
    "full": 1.0,
    "half": 0.5,
    "arrays": np.random.default_rng(54).uniform(size=K),
    "zeros and ones": (np.arange(K) % 2).astype(float),
}
weights = pytest.mark.parametrize("w", WEIGHTS.values(), ids=WEIGHTS)


def dense(
    z: Measurements, w: np.ndarray | float, free_bias: bool, S: np.ndarray | None = None
):
    """Rows [D(1-w) Ã; D(w) A] (12 K, 10) and right-hand side (12 K,), whitened; bias
    columns first where it is free."""
    root = np.ones(K) if z.weights is None else np.sqrt(z.weights)
    W = np.eye(6) if S is None else np.linalg.inv(np.linalg.cholesky(S))
    plain = replace(z, weights=None)
    columns, right = [], []
    for share, A in (
        (1.0 - np.broadcast_to(w, K), reduced_regressor(plain)),
        (np.broadcast_to(w, K), full_regressor(plain)),
    ):
        if free_bias:
            A = np.concatenate((np.broadcast_to(np.eye(6), (K, 6, 6)), A), axis=2)
        scale = (share * root)[:, None, None] * W
        columns.append((scale @ A).reshape(6 * K, -1))
        right.append((scale @ z.wrench[:, :, None]).ravel())
    return np.vstack(columns), np.concatenate(right)
