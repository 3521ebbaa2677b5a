"""Distortions: how far a shape may be from the object, its pose included, and what that
does to the ten parameters.

A distortion takes the shape's point x [m] to x + u(x), u(x) = t + B (x - o). Some of
them, each with a standard deviation, make the object's true place and shape a Gaussian
about the stated ones. What one does to the parameters of a homogeneous body is taken to
first order.
"""

from functools import cached_property
from typing import Self

import numpy as np

from hefting.core.inertia import InertialParameters
from hefting.core.spatial import Array, immutable, skew, tensor_to_vector
from hefting.shapes import Shape

TYPICAL_POSE_STD = (0.003, 0.05)
"""[m, rad] Standard deviations along and about each axis that are assumed of a pose
whose accuracy is not given: together 5 mm and 5 degrees."""


@immutable
class Distortions:
    """Modes in which a shape may be wrong, each by one standard deviation."""

    gradients: Array
    """(d, 3, 3) B"""
    shifts: Array
    """(d, 3) u [m] at the homogeneous COM"""
    center: Array
    """(3,) that COM [m], in the sensor frame"""

    @classmethod
    def none(cls, shape: Shape) -> Self:
        """No mode: the shape is certain."""
        return cls._of(shape, [])

    @classmethod
    def typical(cls, shape: Shape) -> Self:
        """A pose with `TYPICAL_POSE_STD`, about the place in the bounding box nearest
        to the origin of the shape's frame."""
        axes, fixed = shape.pose[:3, :3].T, _fixed_point(shape)
        move, turn = TYPICAL_POSE_STD
        modes = [(np.zeros((3, 3)), move * axis) for axis in axes]
        modes += [(B, -B @ fixed) for B in (turn * skew(axis) for axis in axes)]
        return cls._of(shape, modes)

    @classmethod
    def of(
        cls, shape: Shape, pose_std: tuple[float, float] | None, shape_std: float
    ) -> Self:
        """Of a pose known to so many m and rad about each axis of its frame, and a
        shape known to a share of itself.

        That share is the deviation of the whole size, of each side about the COM, and,
        of half a side, of the place of the COM. The whole grows from the origin of its
        frame, or from the place in its bounding box nearest to that. `pose_std` None: a
        `typical` one beside a shape that is uncertain, else none.
        """
        axes = shape.pose[:3, :3].T
        origin = shape.pose[:3, 3] - shape.homogeneous.center_of_mass
        none, nowhere = np.zeros((3, 3)), np.zeros(3)
        modes: list[tuple[Array, Array]] = []  # B, u at the COM
        if pose_std is None:
            if shape_std > 0.0:
                both = cls.typical(shape)
                modes += list(zip(both.gradients, both.shifts, strict=True))
            pose_std = (0.0, 0.0)
        if pose_std[0] > 0.0:
            modes += [(none, pose_std[0] * axis) for axis in axes]
        if pose_std[1] > 0.0:
            modes += [
                (B, -B @ origin) for B in (pose_std[1] * skew(axis) for axis in axes)
            ]
        if shape_std > 0.0:
            modes.append((shape_std * np.eye(3), -shape_std * _fixed_point(shape)))
            modes += [(shape_std * np.outer(axis, axis), nowhere) for axis in axes]
            modes += [
                (none, 0.5 * shape_std * side * axis)
                for side, axis in zip(shape.extents, axes, strict=True)
            ]
        return cls._of(shape, modes)

    @classmethod
    def _of(cls, shape: Shape, modes: list[tuple[Array, Array]]) -> Self:
        return cls(
            np.array([B for B, _ in modes]).reshape(-1, 3, 3),
            np.array([u for _, u in modes]).reshape(-1, 3),
            shape.homogeneous.center_of_mass,
        )

    def by(self, scores: Array) -> "Move":
        """The distortion by `scores` (d,) standard deviations of each mode."""
        A = np.eye(3) + np.tensordot(scores, self.gradients, 1)
        return Move(A, self.center + scores @ self.shifts - A @ self.center)

    def effects(self, body: Array, scores: Array) -> Array:
        """(10, d) derivative of parameters `body` (10,) by scores (d,), at these."""
        X, P = self.by(scores).transform, InertialParameters(body).pseudo_inertia
        half = self._changes @ P @ X.T
        return _parameters(half + half.transpose(0, 2, 1)).T

    def covariance(self, body: Array) -> Array:
        """(10, 10) covariance of parameters `body` (10,) under independent normal
        scores: exact, as the parameters are quadratic in the scores."""
        P, dX = InertialParameters(body).pseudo_inertia, self._changes
        linear = self.effects(body, np.zeros(len(dX)))
        i, k = np.triu_indices(len(dX))
        half = dX[i] @ P @ dX[k].transpose(0, 2, 1)
        products = _parameters(half + half.transpose(0, 2, 1)).T
        # z_i z_k and (z_i² - 1) / 2^½ are uncorrelated and of variance one
        products *= np.where(i == k, 0.5**0.5, 1.0)
        return linear @ linear.T + products @ products.T

    @cached_property
    def _changes(self) -> Array:
        """(d, 4, 4) derivative of the homogeneous transform by the scores."""
        dX = np.zeros((len(self.shifts), 4, 4))
        dX[:, :3, :3] = self.gradients
        dX[:, :3, 3] = self.shifts - self.gradients @ self.center
        return dX


@immutable
class Move:
    """Affine map x -> A x + t in the sensor frame."""

    A: Array
    """(3, 3)"""
    t: Array
    """(3,) [m]"""

    @property
    def transform(self) -> Array:
        """(4, 4) homogeneous."""
        X = np.eye(4)
        X[:3, :3], X[:3, 3] = self.A, self.t
        return X

    @cached_property
    def parameters(self) -> Array:
        """(10, 10) map of a body's parameters to those of the moved body."""
        return affine(self.A, self.t)

    def back(self, x: Array) -> Array:
        """The inverse map of a point (3,)."""
        return np.linalg.pinv(self.A) @ (x - self.t)


def _fixed_point(shape: Shape) -> Array:
    """(3,) [m] from the homogeneous COM to the place in the bounding box nearest to the
    origin of the shape's frame."""
    axes, center = shape.pose[:3, :3].T, shape.homogeneous.center_of_mass
    corners = (shape.hull - center) @ axes.T
    origin = axes @ (shape.pose[:3, 3] - center)
    return np.clip(origin, corners.min(axis=0), corners.max(axis=0)) @ axes


def affine(A: Array, t: Array) -> Array:
    """(10, 10) map of a body's parameters to those of the same masses at A x + t."""
    X = Move(A, t).transform
    both = (X[:, None, :, None] * X[None, :, None, :]).reshape(16, 16)
    return np.asarray(_TO_PARAMETERS @ both @ _TO_PSEUDO_INERTIA, dtype=float)


def _parameters(pseudo_inertias: Array) -> Array:
    """(n, 10) of pseudo-inertia matrices (n, 4, 4)."""
    S = pseudo_inertias[:, :3, :3]
    J = S.trace(axis1=1, axis2=2)[:, None, None] * np.eye(3) - S
    h = pseudo_inertias[:, 3, :3]
    return np.column_stack((pseudo_inertias[:, 3, 3], h, tensor_to_vector(J)))


_TO_PSEUDO_INERTIA = np.column_stack(
    [InertialParameters(unit).pseudo_inertia.ravel() for unit in np.eye(10)]
)
"""(16, 10) pseudo-inertia, row by row, of parameters"""
_TO_PARAMETERS = _parameters(np.eye(16).reshape(16, 4, 4)).T
"""(10, 16) the reverse, for a symmetric pseudo-inertia"""
