"""How deep a point lies in the convex hull of others."""

import numpy as np
from numpy.typing import ArrayLike

from hefting.errors import InputError
from hefting.spatial import Array

FLAT = 1e-9
"""Thickness of a hull, relative to its length, up to which it counts as flat (collinear, a single point)."""


def depth_in_hull(points: ArrayLike, x: ArrayLike) -> float:
    """Distance [m] from x (3,) to the nearest face of the convex hull of points (V, 3), negative outside.

    Outside it is that of the plane of the face that is violated most, which is the distance to the hull itself only
    where the nearest point is inside that face, and less beside an edge or a corner. A flat hull has faces on both
    sides: the depth is 0 on it, and off it minus the larger of the distances from its plane and beyond its outline;
    likewise for collinear points, and minus the distance for a single point. The frame does not matter.

    Raises `InputError` unless there is a finite point (V >= 1) and a finite x.
    """
    P, target = np.asarray(points, dtype=float), np.asarray(x, dtype=float)
    if P.ndim != 2 or P.shape[1:] != (3,) or not len(P) or not np.isfinite(P).all():
        raise InputError(f"a hull needs finite points (V, 3), V >= 1, not an array of shape {P.shape}")
    if target.shape != (3,) or not np.isfinite(target).all():
        raise InputError("a point to find in a hull is three finite numbers")
    center = P.mean(axis=0)
    P, target = P - center, target - center
    axes = np.linalg.svd(P, full_matrices=len(P) < 3)[2]
    along = P @ axes.T
    sides = np.ptp(along, axis=0)
    rounding = 32.0 * np.finfo(float).eps * float(np.abs(center).max())
    d = int(np.sum(sides > max(FLAT * float(sides.max()), rounding)))
    y = axes @ target
    off = float(np.linalg.norm(y[d:]))  # from the plane or line of a flat hull, or from its one point
    depth = _depth(along[:, :d] / sides[:d], y[:d] / sides[:d], sides[:d]) if d else 0.0
    return depth if d == 3 else min(depth, -off)


def _depth(points: Array, x: Array, sides: Array) -> float:
    """Depth of x (d,) in the solid hull of points (V, d), all divided by `sides` (d,): the same faces, well scaled."""
    if len(sides) == 1:
        return float(min(x[0] - points.min(), points.max() - x[0]) * sides[0])
    from scipy.spatial import ConvexHull

    faces = ConvexHull(points).equations
    distance = (faces[:, :-1] @ x + faces[:, -1]) / np.linalg.norm(faces[:, :-1] / sides, axis=1)
    return -float(distance.max())
