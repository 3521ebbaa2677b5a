"""A surface in a few parts whose convex hulls stand out from it less than that of the
whole."""

from itertools import product

import numpy as np
from scipy.spatial import ConvexHull, QhullError

from hefting.core.spatial import Array, Indices

SMALLER = 0.9
"""Share of the hull's volume that the hulls of two parts may have together for a
surface to be cut in two."""
DEEPEST = 2
"""How often a part is cut, so that there are four at most. Base and upper
arm of a UR5 then touch in 7 % of random configurations, uncut in 33 %, and their
meshes in 5 %."""
MOST_TRIANGLES = 50_000
"""Triangles of a surface that is cut at most; collision meshes have some thousands."""
PLACES = (0.2, 0.4, 0.6, 0.8)
"""Where it is cut, as shares of its extent."""


def _directions(count: int) -> Array:
    """Unit vectors (count, 3), evenly over the sphere by the golden angle."""
    i = np.arange(count)
    z = (2.0 * i + 1.0) / count - 1.0
    turn = i * np.pi * (3.0 - np.sqrt(5.0))
    ring = np.sqrt(1.0 - z**2)
    return np.column_stack((ring * np.cos(turn), ring * np.sin(turn), z))


DIRECTIONS = _directions(100)
"""In which the farthest points of a large surface stand for all: volumes are a few
hundredths too small, of the whole as of the parts, and take a fifth of the time."""


def convex_parts(
    vertices: Array, faces: Indices, deepest: int = DEEPEST
) -> list[Array]:
    """Points (N, 3) of each part of a surface of vertices (V, 3) and triangles (F, 3).

    The surface is cut across the axis, and at the place, where the hulls of both parts
    are smallest together, while that pays. The hulls cover the surface. One of more
    than `MOST_TRIANGLES` stays whole.
    """
    if not deepest or len(faces) > MOST_TRIANGLES:
        return [vertices]
    edges = np.unique(
        np.sort(faces[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2)), axis=0
    )
    planes = [_plane(vertices, *where) for where in product(range(3), PLACES)]
    volumes = [_volume_cut(vertices, edges, *plane) for plane in planes]
    best = int(np.argmin(volumes))
    if volumes[best] > SMALLER * _volume(vertices):
        return [vertices]
    halves = _cut(vertices, faces, *planes[best])
    return [part for half in halves for part in convex_parts(*half, deepest - 1)]


def _plane(vertices: Array, axis: int, place: float) -> tuple[int, float]:
    """An axis, and where on it a share of the vertices' extent is [m]."""
    low, high = vertices[:, axis].min(), vertices[:, axis].max()
    return axis, float(low + place * (high - low))


def _volume_cut(vertices: Array, edges: Indices, axis: int, at: float) -> float:
    """Volume [m³] of the hulls of both parts together."""
    height = vertices[:, axis] - at
    first, second = edges.T
    crossed = height[first] * height[second] < 0.0
    a, b = first[crossed], second[crossed]
    share = (height[a] / (height[a] - height[b]))[:, None]
    between = vertices[a] + share * (vertices[b] - vertices[a])
    sides = vertices[height <= 0.0], vertices[height >= 0.0]
    return sum(_volume(np.concatenate((side, between))) for side in sides)


def _cut(
    vertices: Array, faces: Indices, axis: int, at: float
) -> list[tuple[Array, Indices]]:
    """Both parts of a surface."""
    from trimesh.intersections import slice_faces_plane

    normal = np.eye(3)[axis]
    halves = (
        slice_faces_plane(vertices, faces, sign * normal, at * normal)
        for sign in (1.0, -1.0)
    )
    return [
        (np.asarray(half[0]), np.asarray(half[1])) for half in halves if len(half[1])
    ]


def _volume(points: Array) -> float:
    """Volume [m³] of the hull of points, of those that are farthest in `DIRECTIONS`;
    zero where they are in a plane."""
    if len(points) > len(DIRECTIONS):
        points = points[np.unique((DIRECTIONS @ points.T).argmax(axis=1))]
    try:
        return float(ConvexHull(points).volume)
    except (QhullError, ValueError):
        return 0.0
