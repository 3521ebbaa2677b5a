"""Polytope: a convex polytope of triangles that grows by points. With it the planes of a
convex hull are found, and how deep a point is inside the hull, which takes few of
them."""

import numpy as np

from hefting.core.spatial import Array, Mask

LARGEST_HULL = 400
"""Corners up to which a hull is found here."""
ROUNDING = 1e-13
"""Distance from a plane, in a box of unit sides, that counts as none."""
MOST_STEPS = 100
"""Points that are added at most to find the depth of another; most need a tenth."""
_NEXT, _AFTER = [1, 2, 0], [2, 0, 1]


class Polytope:
    """Convex polytope whose corners are some of the points (V, 3) in a box of unit
    sides: at first four that are far from one another."""

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
        """Planes (F, 4) of its faces: n x + b <= 0 inside, normals outward; of those
        that are gone n is zero and b -1."""
        return self._planes[: self._count]

    def add(self, k: int) -> bool:
        """Grow by the k-th of the points: the faces that see it give way to a cone from
        their outline to it. False where more than `LARGEST_HULL` corners would be
        needed, or rounding leaves no outline."""
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
        self._planes[sees] = 0.0, 0.0, 0.0, -1.0  # gone: they see nothing
        new = slice(self._count, self._count + len(cone))
        self._planes[new], self._corners[new] = _plane(self._points, cone), cone
        self._count += len(cone)
        return True


def hull_planes(points: Array) -> Array | None:
    """Planes (F, 4) of the solid hull of points (V, 3) in a box of unit sides, as of
    `Polytope.planes`, none gone.

    None where it has more than `LARGEST_HULL` corners, or rounding leaves a point
    outside of a plane. Point after point, those far out first.
    """
    found = Polytope(points)
    center = points.mean(axis=0)
    left = np.argsort(-np.linalg.norm(points - center, axis=1), kind="stable")
    while len(left := left[_outside(points[left], found.planes)]):
        if not all(found.add(k) for k in left[:64].tolist()):
            return None
        left = left[64:]
    planes = found.planes[found.planes[:, :3].any(axis=1)]
    return None if _outside(points, planes, 10.0 * ROUNDING).any() else planes


def depth_inside(points: Array, sides: Array, x: Array) -> float | None:
    """Distance from x (3,) to the nearest face of the solid hull of points (V, 3), both
    in a box of unit sides that are so long (3,); None where x is outside, or it takes
    many steps.

    A polytope in the hull grows by the point furthest beyond its face nearest to x. Where
    there is none, that face is one of the hull's. No other is nearer, as the ball about
    x that touches it is in the polytope, and so in the hull.
    """
    found = Polytope(points)
    for _ in range(MOST_STEPS):
        planes = found.planes
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
        if not found.add(furthest):
            return None
    return None


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
