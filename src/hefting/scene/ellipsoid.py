"""Ellipsoids that are drawn: where the COM is with 95 % probability, and the uniform
ellipsoid of equal inertia."""

from dataclasses import dataclass

import numpy as np

from hefting.core.estimate import Estimate, com_jacobian
from hefting.core.inertia import InertialParameters
from hefting.core.sensor_accuracy import Z95
from hefting.core.spatial import Array, frozen

CHI95 = 2.7954834829151074
"""Radius that holds 95 % of a normal distribution in three dimensions, in standard
deviations: the root of the 0.95 quantile of chi-squared with 3 degrees of freedom."""


@dataclass(frozen=True, eq=False)
class Ellipsoid:
    """The points ``center + half_axes @ u`` with |u| <= 1."""

    center: Array
    """(3,) [m]"""
    half_axes: Array
    """(3, 3) [m], a half-axis in each column"""

    def __post_init__(self):
        object.__setattr__(self, "center", frozen(self.center))
        object.__setattr__(self, "half_axes", frozen(self.half_axes))

    @property
    def reach(self) -> Array:
        """(3,) [m] farthest distance from the center along each axis of the frame."""
        return np.linalg.norm(self.half_axes, axis=1)

    @property
    def principal(self) -> tuple[Array, Array]:
        """Lengths (3,) [m] of the half-axes that are perpendicular to one another, the
        longest first, and the rotation (3, 3) whose columns they lie along.

        The half-axes given need not be perpendicular: those that are follow from a
        singular value decomposition.
        """
        rotation, lengths, _ = np.linalg.svd(self.half_axes)
        if np.linalg.det(rotation) < 0.0:
            rotation[:, 2] = -rotation[:, 2]
        return lengths, rotation

    def triangles(self, rings: int = 16) -> tuple[Array, np.ndarray]:
        """Its surface: vertices (V, 3) [m] and triangles (F, 3) of their indices, on
        so many circles of latitude, twice as many points on each."""
        polar = np.pi * (np.arange(rings) + 0.5) / rings
        azimuth = np.pi * np.arange(2 * rings) / rings
        p, a = (grid.ravel() for grid in np.meshgrid(polar, azimuth, indexing="ij"))
        ball = np.column_stack(
            (np.sin(p) * np.cos(a), np.sin(p) * np.sin(a), np.cos(p))
        )
        ball = np.vstack((ball, (0.0, 0.0, 1.0), (0.0, 0.0, -1.0)))
        return self.center + ball @ self.half_axes.T, _ball_faces(rings)

    def shadow(self, i: int, j: int, count: int = 120) -> Array:
        """Outline (count, 2) [m] of the ellipsoid seen along the third axis, projected
        on axes `i` and `j`."""
        # the shadow of {A u} is {B u}, B the two rows of A: an ellipse of matrix B B'
        rows = self.half_axes[[i, j]]
        values, vectors = np.linalg.eigh(rows @ rows.T)
        angle = np.linspace(0.0, 2.0 * np.pi, count)
        circle = np.vstack((np.cos(angle), np.sin(angle)))
        outline = (vectors * np.sqrt(np.maximum(values, 0.0))) @ circle
        return self.center[[i, j]] + outline.T


def _ball_faces(rings: int) -> np.ndarray:
    """(F, 3) indices of a grid of points on a ball and of its two poles, which come
    last."""
    around = 2 * rings
    row, column = np.divmod(np.arange(around * (rings - 1)), around)
    here, beside = around * row + column, around * row + (column + 1) % around
    below, diagonal = here + around, beside + around
    i = np.arange(around)
    north, south, last = around * rings, around * rings + 1, around * (rings - 1)
    return np.vstack(
        (
            np.column_stack((here, below, diagonal)),
            np.column_stack((here, diagonal, beside)),
            np.column_stack((np.full(around, north), i, (i + 1) % around)),
            np.column_stack(
                (last + (i + 1) % around, last + i, np.full(around, south))
            ),
        )
    )


def uniform_ellipsoid(body: InertialParameters) -> Ellipsoid | None:
    """The ellipsoid of uniform density with the mass, COM and inertia of `body`.

    From J1 = m/5 (s2² + s3²) and so on: s1² = 5/(2m) (J2 + J3 - J1). None when no body
    has these parameters.
    """
    if not body.consistency().is_consistent:
        return None
    moments, axes = body.principal()
    square = 2.5 / body.mass * (moments.sum() - 2.0 * moments)
    return Ellipsoid(body.center_of_mass, axes * np.sqrt(np.maximum(square, 0.0)))


def com_region(estimate: Estimate) -> Ellipsoid | None:
    """The region that holds the COM with 95 % probability.

    Its width along each axis follows from the estimate's intervals, which hold errors
    that the covariance of some methods does not; its tilt from the covariance. None
    where neither is known, or an axis is open.
    """
    half = com_half_widths(estimate)
    if half is None or not np.isfinite(half).all():
        return None
    values, axes = np.linalg.eigh(_com_correlation(estimate))
    root = axes * np.sqrt(np.maximum(values, 0.0))
    scale = half * (CHI95 / Z95)
    return Ellipsoid(estimate.parameters.center_of_mass, scale[:, None] * root)


def com_half_widths(estimate: Estimate) -> Array | None:
    """(3,) [m] half-widths of the 95 % intervals of the COM, the larger side of each;
    infinite where it is open, None where the method has no uncertainty."""
    return half_widths(estimate, "center_of_mass", estimate.parameters.center_of_mass)


def half_widths(estimate: Estimate, name: str, value: Array | float) -> Array | None:
    """Half-widths of the 95 % intervals of a quantity of ``Estimate.intervals`` about
    its `value`, the larger side of each; from the covariance where there are no
    intervals. Infinite where the estimate is undetermined."""
    open_ = np.asarray(getattr(estimate.undetermined, name))
    if estimate.intervals is not None:
        low, high = estimate.intervals[name]
        half = np.maximum(high - value, value - low)
    elif estimate.std is not None:
        half = Z95 * np.asarray(estimate.std[name])
    elif open_.any():
        half = np.full(open_.shape, np.nan)
    else:
        return None
    return np.where(open_, np.inf, half)


def _com_correlation(estimate: Estimate) -> Array:
    """Correlation (3, 3) of the COM's errors; none where the covariance does not tell
    it."""
    covariance = estimate.covariance
    if covariance is None or not np.isfinite(covariance[:4, :4]).all():
        return np.eye(3)
    jacobian = com_jacobian(estimate.parameters)[1:4, :4]
    of_com = jacobian @ covariance[:4, :4] @ jacobian.T
    std = np.sqrt(np.maximum(of_com.diagonal(), 0.0))
    if not (std > 0.0).all():
        return np.eye(3)
    return of_com / np.outer(std, std)
