"""Point clouds: convex hull, and one representative a voxel."""

import numpy as np

from hefting.core.errors import InputError
from hefting.core.spatial import Array


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
            small, large = (
                (middle, large) if found[middle] > target else (small, middle)
            )
        pitch = min(found, key=lambda p: abs(found[p] - target)) if found else 1e-9
        if len(points) <= target:
            return np.arange(len(points)), pitch
    _, voxel = np.unique(_voxels(points, low, sides, pitch), return_inverse=True)
    voxel = voxel.ravel()
    number = np.bincount(voxel)
    mean = (
        np.column_stack([np.bincount(voxel, weights=column) for column in points.T])
        / number[:, None]
    )
    order = np.lexsort((np.linalg.norm(points - mean[voxel], axis=1), voxel))
    return np.sort(order[np.concatenate(([0], np.cumsum(number)[:-1]))]), pitch


def _voxels(points: Array, low: Array, sides: Array, pitch: float) -> np.ndarray:
    """Number (n,) of the voxel each point is in, of a lattice of some `pitch` centred
    on the bounding box."""
    shift = 0.5 * (np.ceil(sides / pitch) - sides / pitch)
    index = np.minimum(np.floor((points - low) / pitch + shift), 2**20).astype(np.int64)
    return (index[:, 0] << 42) + (index[:, 1] << 21) + index[:, 2]
