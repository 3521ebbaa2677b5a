"""Clouds: the convex hull of points, the depth of a point inside it, and one
representative point of each voxel.

A polytope grows by one point after another until its planes are those of the hull; the
depth of a point is known after few of these steps.
"""

from typing import Self

import numpy as np
from numpy.typing import ArrayLike

from hefting.core.errors import InputError
from hefting.core.spatial import Array, Mask, immutable
from hefting.shapes.solid import normals_of

SMALL_HULL = 3000
"""Most points for which this file finds the hull, if it has at most `LARGEST_HULL`
corners: faster than importing `scipy.spatial`, which takes a quarter of a second."""
FLAT = 1e-9
"""Thickness of a hull relative to its length up to which it counts as flat (collinear, a
single point)."""

LOOKED_AT, PER_VOXEL, MOST_VOXELS = 8_000, 5, 10_000_000
"""Of `empty_share`: most points that are used, points per voxel, and most voxels."""


def convex_hull(points: Array, where: object = None) -> tuple[Array, np.ndarray]:
    """The points (n, 3) and the faces (F, 3) of their convex hull, oriented outward;
    `InputError` if they are flat."""
    from scipy.spatial import ConvexHull, QhullError

    try:
        hull = ConvexHull(points)
    except (QhullError, ValueError) as error:
        raise InputError(
            "the points are flat, too few or not finite: no convex hull", where
        ) from error
    normal = normals_of(points[hull.simplices])
    inward = np.einsum("fi,fi->f", normal, hull.equations[:, :3]) < 0
    return points, np.where(inward[:, None], hull.simplices[:, ::-1], hull.simplices)


def voxel_representatives(
    points: Array, target: int, pitch: float | None
) -> tuple[np.ndarray, float]:
    """Indices of one point of every occupied voxel, and the pitch [m].

    It is the point nearest to the mean of the voxel's points. Without a `pitch`, one is
    searched that gives about `target` points; a cloud of at most `target` points is kept
    whole.
    """
    low, sides = points.min(axis=0), np.ptp(points, axis=0)
    longest = float(sides.max())
    if pitch is None:
        small, large = 0.3 * longest / max(target, len(points)), 1.01 * longest + 1e-9
        counts: dict[float, int] = {}
        for _ in range(40 if longest > 0 else 0):
            middle = float(np.sqrt(small * large))
            counts[middle] = len(np.unique(_voxels(points, low, sides, middle)))
            fine = counts[middle] > target
            small, large = (middle, large) if fine else (small, middle)
        pitch = min(counts, key=lambda p: abs(counts[p] - target)) if counts else 1e-9
        if len(points) <= target:
            return np.arange(len(points)), pitch
    _, voxel = np.unique(_voxels(points, low, sides, pitch), return_inverse=True)
    voxel = voxel.ravel()
    number = np.bincount(voxel)
    sums = [np.bincount(voxel, weights=column) for column in points.T]
    mean = np.column_stack(sums) / number[:, None]
    order = np.lexsort((np.linalg.norm(points - mean[voxel], axis=1), voxel))
    return np.sort(order[np.concatenate(([0], np.cumsum(number)[:-1]))]), pitch


def empty_share(points: Array) -> float:
    """Share of the volume of a cloud (n, 3) in voxels without points that have some on
    both sides along every axis."""
    chosen = np.random.default_rng(0).permutation(len(points))[:LOOKED_AT]
    points = points[chosen] - points.min(axis=0)
    pitch = voxel_representatives(points, len(points) // PER_VOXEL, None)[1]
    index = (points / pitch).astype(np.int64)
    if np.prod(index.max(axis=0) + 1.0) > MOST_VOXELS:  # of points far away
        return 0.0
    full = np.zeros(index.max(axis=0) + 1, bool)
    full[tuple(index.T)] = True
    enclosed = ~full
    for axis in range(3):
        for view, seen in (
            (enclosed, full),
            (np.flip(enclosed, axis), np.flip(full, axis)),
        ):
            view &= np.logical_or.accumulate(seen, axis)
    return float(enclosed.sum() / (enclosed.sum() + full.sum()))


def _voxels(points: Array, low: Array, sides: Array, pitch: float) -> np.ndarray:
    """Key (n,) of the voxel of each point, in a lattice of some `pitch` [m] centred on
    the bounding box."""
    shift = 0.5 * (np.ceil(sides / pitch) - sides / pitch)
    index = np.minimum(np.floor((points - low) / pitch + shift), 2**20).astype(np.int64)
    return (index[:, 0] << 42) + (index[:, 1] << 21) + index[:, 2]


@immutable
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
        """Hull of points (V, 3) [m]. Raises `InputError` unless V >= 1, all finite."""
        center, axes, along, sides = _principal(points)
        return cls(center, axes, *_faces(along, sides))

    def depth(self, x: ArrayLike) -> float:
        """Distance [m] from x (3,) to the nearest face, negative outside.

        Outside it is the distance to the farthest plane of those beyond which x lies,
        which is less than the distance to the hull if an edge or a corner is nearest. A
        flat hull has faces on both sides: the depth is 0 on it, and elsewhere minus the
        larger of the distances from its plane and beyond its outline; likewise for
        collinear points, and minus the distance for a single point. The result does not
        depend on the frame.

        Raises `InputError` unless x is finite.
        """
        target = _target(x)
        y, d = self.axes @ (target - self.center), self.normals.shape[1]
        # from the plane or line of a flat hull, or from its one point
        off = float(np.linalg.norm(y[d:]))
        depth = float(np.min(self.offsets - self.normals @ y[:d])) if d else 0.0
        return depth if d == 3 else min(depth, -off)


def depth_in_hull(points: ArrayLike, x: ArrayLike) -> float:
    """`Hull.depth` of x (3,) in the hull of points (V, 3) [m]. If x is inside a solid
    hull it takes a tenth of the time, as few faces are needed."""
    center, axes, along, sides = _principal(points)
    if len(sides) == 3 and len(along) <= SMALL_HULL:
        place = (axes @ (_target(x) - center)) / sides
        depth = depth_inside(along / sides, sides, place)
        if depth is not None:
            return depth
    return Hull(center, axes, *_faces(along, sides)).depth(x)


def _principal(points: ArrayLike) -> tuple[Array, Array, Array, Array]:
    """Center (3,) and principal axes (3, 3) as rows of points (V, 3); along the first d
    axes, in which they extend, the points' coordinates (V, d) and extents (d,)."""
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
    return center, axes, along[:, :d], sides[:d]


def _target(x: ArrayLike) -> Array:
    target = np.asarray(x, dtype=float)
    if target.shape != (3,) or not np.isfinite(target).all():
        raise InputError("a point to find in a hull is three finite numbers")
    return target


def _faces(points: Array, sides: Array) -> tuple[Array, Array]:
    """Normals (faces, d) and offsets (faces,) of the solid hull of points (V, d), found
    where all `sides` are one."""
    if len(sides) == 0:
        return np.zeros((0, 0)), np.zeros(0)
    if len(sides) == 1:
        return np.array([[1.0], [-1.0]]), np.array([points.max(), -points.min()])
    scaled = points / sides
    small = len(sides) == 3 and len(scaled) <= SMALL_HULL
    faces = hull_planes(scaled) if small else None
    if faces is None:
        from scipy.spatial import ConvexHull

        faces = ConvexHull(scaled).equations
    normals = faces[:, :-1] / sides
    lengths = np.linalg.norm(normals, axis=1)
    return normals / lengths[:, None], -faces[:, -1] / lengths


LARGEST_HULL = 400
"""Most corners of a `Polytope`."""
ROUNDING = 1e-13
"""Distance from a plane, in a box of unit sides, that counts as zero."""
MOST_STEPS = 100
"""Most points that are added to find a depth; usually ten are enough."""
_NEXT, _AFTER = [1, 2, 0], [2, 0, 1]


class Polytope:
    """Convex polytope whose corners are some of the points (V, 3) in a box of unit sides,
    initially four distant ones."""

    def __init__(self, points: Array):
        self._points = points
        start = _tetrahedron(points)
        faces = start[np.array(((0, 1, 2), (0, 2, 3), (0, 3, 1), (1, 3, 2)))]
        one, two, three = points[start[1:]] - points[start[0]]
        if np.cross(one, two) @ three > 0.0:
            faces = faces[:, ::-1]
        self._planes = np.zeros((12 * LARGEST_HULL, 4))
        self._corners = np.zeros((12 * LARGEST_HULL, 3), dtype=np.int64)
        self._count = 4
        self._planes[:4], self._corners[:4] = _plane(points, faces), faces

    @property
    def planes(self) -> Array:
        """Planes (F, 4) of its faces, (n, b) with n x + b <= 0 inside; removed faces have
        n = 0 and b = -1."""
        return self._planes[: self._count]

    def add(self, k: int) -> bool:
        """Add the k-th point: the faces that see it are replaced by a cone from their
        outline to it. False if there is no space for the faces of more than
        `LARGEST_HULL` corners, or rounding leaves no outline."""
        x, y, z = self._points[k].tolist()
        known = self.planes
        height = known[:, 0] * x + known[:, 1] * y + known[:, 2] * z + known[:, 3]
        sees = np.flatnonzero(height > ROUNDING)
        if not len(sees):
            return True
        edges = {
            edge
            for a, b, c in self._corners[sees].tolist()
            for edge in ((a, b), (b, c), (c, a))
        }
        cone = np.array([(a, b, k) for a, b in sorted(edges) if (b, a) not in edges])
        if self._count + len(cone) > len(self._planes) or not len(cone):
            return False
        self._planes[sees] = 0.0, 0.0, 0.0, -1.0  # removed: no point is above these
        new = slice(self._count, self._count + len(cone))
        self._planes[new], self._corners[new] = _plane(self._points, cone), cone
        self._count += len(cone)
        return True


def hull_planes(points: Array) -> Array | None:
    """Planes (F, 4) of the solid hull of points (V, 3) in a box of unit sides, as those
    of `Polytope.planes` without removed ones.

    Points are added one by one, the outermost first. None if the hull has more than
    `LARGEST_HULL` corners, or rounding leaves a point outside.
    """
    polytope = Polytope(points)
    center = points.mean(axis=0)
    remaining = np.argsort(-np.linalg.norm(points - center, axis=1), kind="stable")
    while len(remaining := remaining[_outside(points[remaining], polytope.planes)]):
        if not all(polytope.add(k) for k in remaining[:64].tolist()):
            return None
        remaining = remaining[64:]
    planes = polytope.planes[polytope.planes[:, :3].any(axis=1)]
    return None if _outside(points, planes, 10.0 * ROUNDING).any() else planes


def depth_inside(points: Array, sides: Array, x: Array) -> float | None:
    """Distance [m] from x (3,) to the nearest face of the solid hull of points (V, 3),
    with coordinates of both over the `sides` (3,) [m] of their box. None if x is outside
    or `MOST_STEPS` are not enough.

    A polytope in the hull grows by the point farthest beyond its face nearest to x, until
    there is none: that face is then a face of the hull. No other is nearer, as the ball
    about x that touches it lies in the polytope, and so in the hull.
    """
    polytope = Polytope(points)
    for _ in range(MOST_STEPS):
        planes = polytope.planes
        lengths = np.sqrt(np.square(planes[:, :3] / sides).sum(axis=1))
        gone = lengths == 0.0
        lengths[gone] = 1.0
        depth = -(planes[:, :3] @ x + planes[:, 3]) / lengths
        depth[gone] = np.inf
        nearest = int(np.argmin(depth))
        height = points @ planes[nearest, :3]
        furthest = int(np.argmax(height))
        if height[furthest] + planes[nearest, 3] <= ROUNDING:
            return float(depth[nearest]) if depth[nearest] >= 0.0 else None
        if not polytope.add(furthest):
            return None
    return None


def _outside(points: Array, planes: Array, tolerance: float = ROUNDING) -> Mask:
    """Which of the points (V, 3) are outside any plane (F, 4) by over the tolerance."""
    number = 1 + len(planes) * len(points) // 1_000_000  # bounds the memory
    parts = np.array_split(planes[planes[:, :3].any(axis=1)], number)
    return np.logical_or.reduce(
        [
            (points @ each[:, :3].T + each[:, 3] > tolerance).any(axis=1)
            for each in parts
        ]
    )


def _tetrahedron(points: Array) -> np.ndarray:
    """Indices (4,) of distant points of (V, 3) that are not in a plane."""
    first = int(np.argmin(points[:, 0]))
    away = points - points[first]
    second = int(np.argmax(np.einsum("vi,vi->v", away, away)))
    normals = np.cross(away, away[second])
    third = int(np.argmax(np.einsum("vi,vi->v", normals, normals)))
    fourth = int(np.argmax(np.abs(away @ normals[third])))
    return np.array((first, second, third, fourth))


def _plane(points: Array, faces: np.ndarray) -> Array:
    """Planes (F, 4) of triangles (F, 3) of points, as of a removed face for a degenerate
    triangle."""
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
