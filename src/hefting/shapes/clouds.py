"""Clouds: the convex hull of points, how deep a point is inside it, and one
representative a voxel."""

from dataclasses import dataclass
from typing import Self

import numpy as np
from numpy.typing import ArrayLike

from hefting.core.errors import InputError
from hefting.core.spatial import Array, Mask

SMALL_HULL, LARGEST_HULL = 3000, 400
"""Points up to which a hull is found here, if it has no more than so many corners: that
takes less time than importing `scipy.spatial`, which is a quarter of a second."""
ROUNDING = 1e-13
"""Distance from a plane, in a box of unit sides, that counts as none."""
FLAT = 1e-9
"""Thickness of a hull, relative to its length, up to which it counts as flat
(collinear, a single point)."""
_NEXT, _AFTER = [1, 2, 0], [2, 0, 1]


def convex_hull(points: Array, where: object = None) -> tuple[Array, np.ndarray]:
    """Points (n, 3) and outward faces (F, 3) of their convex hull; `InputError` if they
    are flat."""
    from scipy.spatial import ConvexHull, QhullError

    try:
        hull = ConvexHull(points)
    except (QhullError, ValueError) as error:
        raise InputError(
            "the points are flat, too few or not finite: no convex hull", where
        ) from error
    corner = points[hull.simplices]
    normal = np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0])
    inward = np.einsum("fi,fi->f", normal, hull.equations[:, :3]) < 0
    return points, np.where(inward[:, None], hull.simplices[:, ::-1], hull.simplices)


def voxel_representatives(
    points: Array, target: int, pitch: float | None
) -> tuple[np.ndarray, float]:
    """Indices of one point from every occupied voxel, and the pitch used.

    The point is the one nearest to the mean of those in its voxel. Without a `pitch`,
    one that leaves about `target` points is searched for; a cloud of no more points
    than that is kept whole.
    """
    low, sides = points.min(axis=0), np.ptp(points, axis=0)
    longest = float(sides.max())
    if pitch is None:
        small, large = 0.3 * longest / max(target, len(points)), 1.01 * longest + 1e-9
        found: dict[float, int] = {}
        for _ in range(40 if longest > 0 else 0):
            middle = float(np.sqrt(small * large))
            found[middle] = len(np.unique(_voxels(points, low, sides, middle)))
            fine = found[middle] > target
            small, large = (middle, large) if fine else (small, middle)
        pitch = min(found, key=lambda p: abs(found[p] - target)) if found else 1e-9
        if len(points) <= target:
            return np.arange(len(points)), pitch
    _, voxel = np.unique(_voxels(points, low, sides, pitch), return_inverse=True)
    voxel = voxel.ravel()
    number = np.bincount(voxel)
    sums = [np.bincount(voxel, weights=column) for column in points.T]
    mean = np.column_stack(sums) / number[:, None]
    order = np.lexsort((np.linalg.norm(points - mean[voxel], axis=1), voxel))
    return np.sort(order[np.concatenate(([0], np.cumsum(number)[:-1]))]), pitch


def _voxels(points: Array, low: Array, sides: Array, pitch: float) -> np.ndarray:
    """Number (n,) of the voxel each point is in, of a lattice of some `pitch` centred
    on the bounding box."""
    shift = 0.5 * (np.ceil(sides / pitch) - sides / pitch)
    index = np.minimum(np.floor((points - low) / pitch + shift), 2**20).astype(np.int64)
    return (index[:, 0] << 42) + (index[:, 1] << 21) + index[:, 2]


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
        """Of points (V, 3) [m]. Raises `InputError` unless there is one and all are
        finite."""
        P = np.asarray(points, dtype=float)
        if P.ndim != 2 or P.shape[1:] != (3,) or not len(P) or not np.isfinite(P).all():
            raise InputError(
                f"a hull needs finite points (V, 3), V >= 1, not an array of shape {P.shape}"
            )
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

        Outside it is that of the plane of the face that is violated most, which is the
        distance to the hull itself only where the nearest point is inside that face,
        and less beside an edge or a corner. A flat hull has faces on
        both sides: the depth is 0 on it, and off it minus the larger of the distances
            from its plane and beyond its outline; likewise for collinear points, and
            minus the distance for a single point. The frame does not matter.

        Raises `InputError` unless x is finite.
        """
        target = np.asarray(x, dtype=float)
        if target.shape != (3,) or not np.isfinite(target).all():
            raise InputError("a point to find in a hull is three finite numbers")
        y, d = self.axes @ (target - self.center), self.normals.shape[1]
        # from the plane or line of a flat hull, or from its one point
        off = float(np.linalg.norm(y[d:]))
        depth = float(np.min(self.offsets - self.normals @ y[:d])) if d else 0.0
        return depth if d == 3 else min(depth, -off)


def _faces(points: Array, sides: Array) -> tuple[Array, Array]:
    """Normals (faces, d) and offsets (faces,) of the solid hull of points (V, d), found
    where all `sides` are one."""
    if len(sides) == 0:
        return np.zeros((0, 0)), np.zeros(0)
    if len(sides) == 1:
        return np.array([[1.0], [-1.0]]), np.array([points.max(), -points.min()])
    scaled = points / sides
    faces = _planes(scaled) if len(sides) == 3 and len(scaled) <= SMALL_HULL else None
    if faces is None:
        from scipy.spatial import ConvexHull

        faces = ConvexHull(scaled).equations
    normals = faces[:, :-1] / sides
    lengths = np.linalg.norm(normals, axis=1)
    return normals / lengths[:, None], -faces[:, -1] / lengths


def _planes(points: Array) -> Array | None:
    """Planes (F, 4) of the solid hull of points (V, 3) in a box of unit sides: n x + b
    <= 0 inside, normals outward.

    None where it has more than `LARGEST_HULL` corners, or rounding leaves a point
    outside of a plane.

    Point after point, those far out first: the faces that see it give way to a cone
    from their outline to it.
    """
    center = points.mean(axis=0)
    start = _tetrahedron(points)
    faces = start[np.array(((0, 1, 2), (0, 2, 3), (0, 3, 1), (1, 3, 2)))]
    one, two, three = points[start[1:]] - points[start[0]]
    if np.cross(one, two) @ three > 0.0:
        faces = faces[:, ::-1]
    planes = np.zeros((12 * LARGEST_HULL, 4))
    corners = np.zeros((12 * LARGEST_HULL, 3), dtype=np.int64)
    count = 4
    planes[:4], corners[:4] = _plane(points, faces), faces
    left = np.argsort(-np.linalg.norm(points - center, axis=1), kind="stable")
    while len(left := left[_outside(points[left], planes[:count])]):
        for k in left[:64].tolist():
            x, y, z = points[k].tolist()
            known = planes[:count]
            height = known[:, 0] * x + known[:, 1] * y + known[:, 2] * z + known[:, 3]
            sees = np.flatnonzero(height > ROUNDING)
            if not len(sees):
                continue
            edges = {
                edge
                for a, b, c in corners[sees].tolist()
                for edge in ((a, b), (b, c), (c, a))
            }
            cone = np.array(
                [(a, b, k) for a, b in sorted(edges) if (b, a) not in edges]
            )
            if count + len(cone) > len(planes) or not len(cone):
                return None
            planes[sees] = 0.0, 0.0, 0.0, -1.0  # gone: they see nothing
            new = slice(count, count + len(cone))
            planes[new], corners[new] = _plane(points, cone), cone
            count += len(cone)
        left = left[64:]
    found = planes[:count][planes[:count, :3].any(axis=1)]
    return None if _outside(points, found, 10.0 * ROUNDING).any() else found


def _outside(points: Array, planes: Array, tolerance: float = ROUNDING) -> Mask:
    """Which points (V, 3) are further outside of any of the planes (F, 4) than that."""
    number = 1 + len(planes) * len(points) // 1_000_000  # bounds the memory
    parts = np.array_split(planes[planes[:, :3].any(axis=1)], number)
    return np.logical_or.reduce(
        [
            (points @ each[:, :3].T + each[:, 3] > tolerance).any(axis=1)
            for each in parts
        ]
    )


def _tetrahedron(points: Array) -> np.ndarray:
    """Four of the points (V, 3), far from one another, not in a plane."""
    first = int(np.argmin(points[:, 0]))
    away = points - points[first]
    second = int(np.argmax(np.einsum("vi,vi->v", away, away)))
    off = np.cross(away, away[second])
    third = int(np.argmax(np.einsum("vi,vi->v", off, off)))
    fourth = int(np.argmax(np.abs(away @ off[third])))
    return np.array((first, second, third, fourth))


def _plane(points: Array, faces: np.ndarray) -> Array:
    """Planes (F, 4) of triangles (F, 3) of points; one without a normal, and all points
    inside, where it is a line."""
    a = points[faces[:, 0]]
    u, v = points[faces[:, 1]] - a, points[faces[:, 2]] - a
    planes = np.empty((len(faces), 4))
    normal = planes[:, :3]
    # as np.cross, in a fifth of its time
    normal[:] = u[:, _NEXT] * v[:, _AFTER] - u[:, _AFTER] * v[:, _NEXT]
    length = np.sqrt((normal * normal).sum(axis=1))[:, None]
    normal /= np.where(length > 0.0, length, 1.0)
    planes[:, 3] = -(normal * a).sum(axis=1)
    planes[length[:, 0] < 1e-14] = 0.0, 0.0, 0.0, -1.0
    return planes
