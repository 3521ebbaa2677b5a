"""The Cramér-Rao bound of the ten parameters, and the errors of an estimator that
reaches it.

It holds for unbiased estimators that know nothing of the shape. Knowledge of the shape
may lead below it.
"""

from dataclasses import dataclass

import numpy as np

from hefting.core.errors import NotIdentifiableError
from hefting.core.inertia import InertialParameters, com_jacobian
from hefting.core.measurements import Measurements
from hefting.core.regressor import full_regressor
from hefting.core.spatial import Array, skew, tensor_to_vector, vector_to_tensor

OPEN = 1e-10
"""Singular value, relative to the largest, of a direction that the motion does not
tell."""
GROUPS = (slice(0, 1), slice(1, 4), slice(4, 10))
"""Mass, COM and inertia among ten relative errors."""


def bound(
    exact: Measurements,
    body: InertialParameters,
    wrench_variances: Array,
    motion_variances: Array | None = None,
) -> Array:
    """Least covariance (10, 10) of ten free parameters: (sum A'S^-1 A)^-1 at the true
    motion.

    `exact` has the true motion of K samples, `body` is the truth in the sensor frame,
    `wrench_variances` (6,) are those of white noise in force and torque [N², N² m²].
    Where the motion is known S is theirs alone. `motion_variances`, (6,) or (K, 6), of
    white noise in linear and angular acceleration [m²/s⁴, rad²/s⁴], add E S_k E', E =
    d(f, tau)/d(a, alpha): the bound where every true acceleration is unknown too. Noise
    that lasts for n samples counts n times.

    Raises `NotIdentifiableError` where the motion leaves a parameter open.
    """
    A = full_regressor(exact)
    S = np.broadcast_to(np.diag(wrench_variances), (len(A), 6, 6))
    if motion_variances is not None:
        m, h = body.mass, skew(body.vector[1:4])
        E = np.block([[m * np.eye(3), -h], [h, body.inertia_at_origin]])
        S = S + (E * np.atleast_2d(motion_variances)[:, None, :]) @ E.T
    whitened = np.linalg.solve(np.linalg.cholesky(S), A).reshape(-1, 10)
    lengths = np.linalg.norm(whitened, axis=0)
    lengths[lengths == 0.0] = 1.0
    _, values, V = np.linalg.svd(whitened / lengths, full_matrices=False)
    if len(values) < 10 or not values[-1] > OPEN * values[0]:
        raise NotIdentifiableError(
            "the motion leaves a parameter open: there is no bound"
        )
    half = V / values[:, None] / lengths
    return half.T @ half


@dataclass(frozen=True, eq=False)
class Scale:
    """What turns deviations of the ten parameters into the paper's errors
    (`hefting.core.accuracy`), to first order."""

    body: InertialParameters
    """the truth"""
    extents: Array
    """(3,) sides of its bounding box [m]"""
    axes: Array
    """(3, 3) axes of its shape's file in the sensor frame"""

    @property
    def relative(self) -> Array:
        """(10, 10) takes deviations of the parameters to those of mass, COM and inertia
        about the sensor [%]."""
        m, a, R = self.body.mass, np.asarray(self.extents, dtype=float), self.axes
        scale = tensor_to_vector(m / 12.0 * (np.eye(3) * (a @ a) - np.outer(a, a)))
        T = np.zeros((10, 10))
        T[0, 0] = 1.0 / m
        T[1:4] = R.T @ com_jacobian(self.body)[1:4] / a[:, None]
        T[4:, 4:] = (tensor_to_vector(R.T @ vector_to_tensor(np.eye(6)) @ R) / scale).T
        return 100.0 * T

    def errors(self, deviations: Array) -> Array:
        """Errors (n, 3) [%] of mass, COM and inertia about the sensor where the
        parameters deviate by (n, 10)."""
        return _grouped(np.abs(deviations @ self.relative.T))

    def mean_errors(self, covariance: Array) -> Array:
        """Mean errors (3,) [%] of Gaussian deviations of a covariance (10, 10): sqrt(2
        / pi) standard deviations."""
        spread = np.sqrt((self.relative @ covariance @ self.relative.T).diagonal())
        return _grouped((2.0 / np.pi) ** 0.5 * spread)

    def drawn_errors(self, covariance: Array, count: int, seed: int = 0) -> Array:
        """Errors (count, 3) [%] of such deviations, seeded: for medians, of which there
        is no closed form."""
        of_all = self.relative @ covariance @ self.relative.T
        spread = np.sqrt(of_all.diagonal())
        L = spread[:, None] * np.linalg.cholesky(of_all / np.outer(spread, spread))
        return _grouped(
            np.abs(np.random.default_rng(seed).normal(size=(count, 10)) @ L.T)
        )


def _grouped(errors: Array) -> Array:
    """Means (..., 3) over mass, COM and inertia of relative errors (..., 10)."""
    return np.stack([errors[..., part].mean(axis=-1) for part in GROUPS], axis=-1)
