"""Seeded random bodies, motions and measurements for the tests."""

from dataclasses import dataclass, replace

import numpy as np
from scipy.spatial.transform import Rotation

from conic import Problem
from hefting.core.inertia import InertialParameters
from hefting.core.measurements import Measurements
from hefting.core.regressor import (
    full_model_weight,
    full_regressor,
    predict_wrench,
    reduced_regressor,
)
from hefting.estimators import PMD
from hefting.shapes import Shape


def random_pose(rng: np.random.Generator, reach: float = 0.5) -> np.ndarray:
    """Rigid motion (4, 4): any rotation, a translation of about `reach` [m]."""
    pose = np.eye(4)
    pose[:3, :3] = Rotation.random(random_state=rng).as_matrix()
    pose[:3, 3] = reach * rng.normal(size=3)
    return pose


def random_body(
    rng: np.random.Generator, mass: float = 1.0, size: float = 0.1, offset: float = 0.1
) -> InertialParameters:
    """Ten random point masses: total `mass` [kg], spread over `size` [m], about
    `offset` [m] from the origin."""
    masses = rng.exponential(size=10)
    points = size * rng.normal(size=(10, 3)) + offset * rng.normal(size=3)
    return InertialParameters.from_points(points, mass * masses / masses.sum())


def random_motion(
    rng: np.random.Generator, K: int, speed: float = 1.0, gravity: float = 9.81
) -> Measurements:
    """K unrelated samples of motion in all directions, any orientation, and no
    wrench."""
    g = rng.normal(size=(K, 3))
    g *= gravity / np.linalg.norm(g, axis=1, keepdims=True)
    a, w, alpha = speed * rng.normal(size=(3, K, 3))
    return Measurements(0.01 * np.arange(K), g, a, w, alpha, *np.zeros((2, K, 3)))


def with_wrench(
    motion: Measurements,
    body: InertialParameters,
    bias: np.ndarray | float = 0.0,
    rng: np.random.Generator | None = None,
    force: float = 0.0,
    torque: float = 0.0,
) -> Measurements:
    """`motion` with the wrench of `body`, a constant bias (6,), and noise of levels
    `force` [N], `torque` [N m]."""
    wrench = predict_wrench(motion, body.vector) + bias
    if rng is not None:
        wrench = wrench + np.repeat((force, torque), 3) * rng.normal(size=wrench.shape)
    return replace(motion, force=wrench[:, :3], torque=wrench[:, 3:])


@dataclass(frozen=True)
class PMDCase:
    """One random problem for PMD, and the same in the oracle's terms."""

    label: str
    estimator: PMD
    measurements: Measurements
    problem: Problem


def pmd_case(seed: int) -> PMDCase:
    """Problem number `seed`: anything from noise-free to mostly noise, 1 to 40 samples,
    4 to 120 points, coplanar and collinear points, at rest, full model only, without
    regularisation, with and without bias."""
    rng = np.random.default_rng([20220, seed])
    n, K = int(rng.choice([4, 10, 56, 120])), int(rng.choice([1, 2, 10, 40]))
    noise = float(rng.choice([0.0, 1e-3, 0.1, 1.0]))
    regularization = float(rng.choice([0.0, 1e-3, 0.1, 10.0]))
    free_bias = bool(rng.random() < 0.5)
    mode = str(rng.choice(["mixed", "at rest", "full only"], p=[0.7, 0.15, 0.15]))
    c1 = 1e-12 if mode == "full only" else float(rng.choice([1e-3, 10.0, 300.0, 25e3]))
    layout = str(rng.choice(["solid", "coplanar", "collinear"], p=[0.7, 0.2, 0.1]))
    points = rng.uniform(-0.1, 0.1, (n, 3)) * 10 ** rng.uniform(-1.0, 0.5)
    if layout != "solid":
        points[:, 2] = 0.0
    if layout == "collinear":
        points[:, 1] = 0.0
    points = points @ Rotation.random(random_state=rng).as_matrix() + 0.1 * rng.normal(
        size=3
    )
    masses = rng.exponential(size=n) ** 3
    masses *= 10 ** rng.uniform(-2.0, 1.0) / masses.sum()
    body = InertialParameters.from_points(
        points * (1.0 if rng.random() < 0.7 else 0.9), masses
    )
    speed = 0.0 if mode == "at rest" else 10 ** rng.uniform(-1.5, 0.7)
    bias = rng.normal(size=6) * (5.0, 5.0, 5.0, 0.5, 0.5, 0.5) if free_bias else 0.0
    z = with_wrench(random_motion(rng, K, speed), body, bias, rng, noise, 0.05 * noise)
    estimator = PMD(
        Shape(points), c1, regularization, "estimate" if free_bias else "none"
    )
    w = full_model_weight(z, c1)
    problem = Problem(
        reduced_regressor(z),
        full_regressor(z),
        z.wrench,
        w,
        estimator.shape.matrix,
        regularization,
        free_bias,
    )
    label = (
        f"problem {seed}: {n} {layout} points, {K} samples {mode}, noise {noise:g} N, c1 {c1:g}, "
        f"lambda {regularization:g}, bias {estimator.bias}"
    )
    return PMDCase(label, estimator, z, problem)
