"""How deep a point lies in the convex hull of others."""

from dataclasses import dataclass
from typing import Self

import numpy as np
from numpy.typing import ArrayLike

from hefting.errors import InputError
from hefting.spatial import Array

FLAT = 1e-9
"""Thickness of a hull, relative to its length, up to which it counts as flat (collinear, a single point)."""


@dataclass(frozen=True, eq=False)
class Hull:
    """Convex hull of points: solid, flat, collinear or a single point."""

    center: Array
    """(3,) [m]"""
    axes: Array
    """(3, 3) principal axes as rows, those along which it extends first"""
    normals: Array
    """(faces, d) outward unit normals in the first d axes; d = 3 for a solid hull"""
    offsets: Array
    """(faces,) [m] the hull is where normals @ y <= offsets"""

    @classmethod
    def of(cls, points: ArrayLike) -> Self:
        """Of points (V, 3) [m]. Raises `InputError` unless there is one and all are finite."""
        P = np.asarray(points, dtype=float)
        if P.ndim != 2 or P.shape[1:] != (3,) or not len(P) or not np.isfinite(P).all():
            raise InputError(f"a hull needs finite points (V, 3), V >= 1, not an array of shape {P.shape}")
        center = P.mean(axis=0)
        axes = np.linalg.svd(P - center, full_matrices=len(P) < 3)[2]
        along = (P - center) @ axes.T
        sides = np.ptp(along, axis=0)
        rounding = 32.0 * np.finfo(float).eps * float(np.abs(center).max())
        d = int(np.sum(sides > max(FLAT * float(sides.max()), rounding)))
        normals, offsets = _faces(along[:, :d], sides[:d])
        return cls(center, axes, normals, offsets)

    def depth(self, x: ArrayLike) -> float:
        """Distance [m] from x (3,) to the nearest face, negative outside.

        Outside it is that of the plane of the face that is violated most, which is the distance to the hull itself
        only where the nearest point is inside that face, and less beside an edge or a corner. A flat hull has faces on
        both sides: the depth is 0 on it, and off it minus the larger of the distances from its plane and beyond its
        outline; likewise for collinear points, and minus the distance for a single point. The frame does not matter.

        Raises `InputError` unless x is finite.
        """
        target = np.asarray(x, dtype=float)
        if target.shape != (3,) or not np.isfinite(target).all():
            raise InputError("a point to find in a hull is three finite numbers")
        y, d = self.axes @ (target - self.center), self.normals.shape[1]
        off = float(np.linalg.norm(y[d:]))  # from the plane or line of a flat hull, or from its one point
        depth = float(np.min(self.offsets - self.normals @ y[:d])) if d else 0.0
        return depth if d == 3 else min(depth, -off)


def _faces(points: Array, sides: Array) -> tuple[Array, Array]:
    """Normals (faces, d) and offsets (faces,) of the solid hull of points (V, d), found where all `sides` are one."""
    if len(sides) == 0:
        return np.zeros((0, 0)), np.zeros(0)
    if len(sides) == 1:
        return np.array([[1.0], [-1.0]]), np.array([points.max(), -points.min()])
    from scipy.spatial import ConvexHull

    faces = ConvexHull(points / sides).equations
    normals = faces[:, :-1] / sides
    lengths = np.linalg.norm(normals, axis=1)
    return normals / lengths[:, None], -faces[:, -1] / lengths
