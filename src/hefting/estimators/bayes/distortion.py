"""Distortions: how far a shape may be from the object, its pose included, and what that
does to the ten parameters.

A distortion takes the shape's point x [m] to x + u(x), u(x) = t + B (x - o). Some of
them, each with a standard deviation, make the object's true place and shape a Gaussian
about the stated ones. What one does to the parameters of a homogeneous body is taken to
first order.
"""

from dataclasses import dataclass
from functools import cached_property
from typing import Self

import numpy as np

from hefting.core.inertia import InertialParameters
from hefting.core.spatial import Array, skew, tensor_to_vector
from hefting.shapes import Shape


@dataclass(frozen=True, eq=False)
class Distortions:
    """Ways in which a shape may be wrong, each by one standard deviation."""

    gradients: Array
    """(d, 3, 3) B"""
    shifts: Array
    """(d, 3) u [m] at the homogeneous COM"""
    center: Array
    """(3,) that COM [m], in the sensor frame"""

    @classmethod
    def of(cls, shape: Shape, pose_std: tuple[float, float], shape_std: float) -> Self:
        """Of a pose known to so many m and rad about each axis of its frame, and a
        shape known to a share of itself.

        That share is the deviation of the whole size, of each side about the COM, and,
        of half a side, of the place of the COM. The whole grows from the origin of its
        frame, or from the place in its bounding box nearest to that.
        """
        center = shape.homogeneous.center_of_mass
        axes, origin = shape.pose[:3, :3].T, shape.pose[:3, 3] - center
        none, nowhere = np.zeros((3, 3)), np.zeros(3)
        modes: list[tuple[Array, Array]] = []  # B, u at the COM
        if pose_std[0] > 0.0:
            modes += [(none, pose_std[0] * axis) for axis in axes]
        if pose_std[1] > 0.0:
            modes += [
                (B, -B @ origin) for B in (pose_std[1] * skew(axis) for axis in axes)
            ]
        if shape_std > 0.0:
            corners = (shape.hull - center) @ axes.T
            fixed = (
                np.clip(axes @ origin, corners.min(axis=0), corners.max(axis=0)) @ axes
            )
            modes.append((shape_std * np.eye(3), -shape_std * fixed))
            modes += [(shape_std * np.outer(axis, axis), nowhere) for axis in axes]
            modes += [
                (none, 0.5 * shape_std * side * axis)
                for side, axis in zip(shape.extents, axes, strict=True)
            ]
        return cls(
            np.array([B for B, _ in modes]).reshape(-1, 3, 3),
            np.array([u for _, u in modes]).reshape(-1, 3),
            center,
        )

    def by(self, scores: Array) -> "Move":
        """The distortion by so many standard deviations (d,)."""
        A = np.eye(3) + np.tensordot(scores, self.gradients, 1)
        return Move(A, self.center + scores @ self.shifts - A @ self.center)

    def effects(self, body: Array, scores: Array) -> Array:
        """(10, d) change of parameters `body` (10,) by each, to first order about the
        distortion of these scores."""
        there = self.by(scores)
        changes: list[Array] = []
        for B, u in zip(self.gradients, self.shifts, strict=True):
            t = u - B @ self.center
            changes.append(
                0.5
                * (affine(there.A + B, there.t + t) - affine(there.A - B, there.t - t))
                @ body
            )
        return np.array(changes).T


@dataclass(frozen=True, eq=False)
class Move:
    """x -> A x + t, in the sensor frame."""

    A: Array
    """(3, 3)"""
    t: Array
    """(3,) [m]"""

    @cached_property
    def parameters(self) -> Array:
        """(10, 10) takes those of a body to those of the moved one."""
        return affine(self.A, self.t)

    def back(self, x: Array) -> Array:
        """Where a point (3,) was before."""
        return np.linalg.pinv(self.A) @ (x - self.t)


def affine(A: Array, t: Array) -> Array:
    """(10, 10) takes the parameters of a body to those of the same masses at A x + t
    instead of x."""
    X = np.eye(4)
    X[:3, :3], X[:3, 3] = A, t
    moved = X @ _PSEUDO_INERTIAS @ X.T
    S = moved[:, :3, :3]
    J = S.trace(axis1=1, axis2=2)[:, None, None] * np.eye(3) - S
    return np.vstack((moved[:, 3, 3], moved[:, :3, 3].T, tensor_to_vector(J).T))


_PSEUDO_INERTIAS = np.array(
    [InertialParameters(unit).pseudo_inertia for unit in np.eye(10)]
)
"""(10, 4, 4) those of unit parameters"""
