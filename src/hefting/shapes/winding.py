"""Winding numbers: points inside a closed surface, by rays along z; and the axes in which
its bounding box is small and rays meet few triangles."""

from dataclasses import dataclass, replace

import numpy as np

from hefting.core.spatial import Array, frozen
from hefting.shapes.solid import Solid

PAIRS_AT_ONCE = 500_000
"""Ray-triangle pairs tested at once; bounds the memory."""
RAYS_FOR_OVERLAPS, STEPS_FOR_OVERLAPS = 2000, 50
"""Rays, and points on each, of `without_overlaps`."""
LEAST_OVERLAP = 0.01
"""Share of the volume from which on overlaps are corrected, by rays to 0.6 %."""
STEPS_TO_WALLS = 1000
"""Points of a ray to each side at which `sides_with_walls` tests for walls."""


def winding_numbers(
    triangles: Array, rays: Array, start: Array, step: Array, count: np.ndarray
) -> np.ndarray:
    """Winding numbers of equally spaced points on rays along z: integers (sum of
    `count`,), ray after ray, +1 for a point inside a surface oriented outward, 0
    outside.

    The surface of triangles (F, 3, 3) is closed. Ray r at `rays[r]` (x, y) carries the
    points z = start + step * (0 .. count - 1), each (R,), step > 0.

    Each number is the signed number of triangles above the point. Edges follow a
    half-open rule, so that a ray through one is counted exactly once.
    """
    # the signed crossings of ray r between its points, from slot[r] on
    slot = np.concatenate(([0], np.cumsum(count + 1)))
    tally = np.zeros(slot[-1], dtype=np.int32)
    a, b, c = triangles[:, 0, :2], triangles[:, 1, :2], triangles[:, 2, :2]
    low, high = np.minimum(np.minimum(a, b), c), np.maximum(np.maximum(a, b), c)
    order, first, last, rows = _candidates(low, high, rays)
    pairs = np.concatenate(([0], np.cumsum(last - first)))
    (x_low, y_low), (x_high, y_high), (x, y) = (
        low.T.copy(),
        high.T.copy(),
        rays.T.copy(),
    )
    position = 0
    while position < len(rows):
        stop = max(
            int(np.searchsorted(pairs, pairs[position] + PAIRS_AT_ONCE, "right")) - 1,
            position + 1,
        )
        length = last[position:stop] - first[position:stop]
        ray = order[_ranges(first[position:stop], length)]
        triangle = np.repeat(rows[position:stop], length)
        near = (x_low[triangle] <= x[ray]) & (x[ray] <= x_high[triangle])
        near &= (y_low[triangle] <= y[ray]) & (y[ray] <= y_high[triangle])
        ray, height, sign = _crossings(triangles, rays, ray[near], triangle[near])
        below = np.clip(
            np.ceil((height - start[ray]) / step[ray]), 0, count[ray]
        ).astype(np.int64)
        np.add.at(tally, slot[ray] + below, sign)
        position = stop
    # the sum over each ray is zero, so one cumulative sum serves all rays
    above = np.cumsum(tally[::-1], dtype=np.int32)[::-1] - tally
    keep = np.ones(len(tally), dtype=bool)
    keep[slot[1:] - 1] = False
    return above[keep]


def points_inside(triangles: Array, points: Array) -> np.ndarray:
    """Booleans (n,): whether each of points (n, 3) is inside the closed surface of
    triangles (F, 3, 3)."""
    one, (rays, start) = np.ones(len(points)), (points[:, :2], points[:, 2])
    return winding_numbers(triangles, rays, start, one, one.astype(np.int64)) != 0


def sides_with_walls(triangles: Array) -> int:
    """Number of the six rays from the origin along the axes that pass through the inside
    of the closed surface of triangles (F, 3, 3); 0 if the origin is inside."""
    sides, n = 0, STEPS_TO_WALLS
    steps = (np.arange(2 * n) + 0.5) / n - 1.0
    for axis in np.diag(np.abs(triangles).max(axis=(0, 1))):
        inside = points_inside(triangles, steps[:, None] * axis)
        if inside[n - 1 : n + 1].any():
            return 0
        sides += int(inside[:n].any()) + int(inside[n:].any())
    return sides


def without_overlaps(solid: Solid) -> Solid:
    """The solid with the moments of all points inside, of which the divergence theorem
    counts those in two parts twice: rays find these."""
    box, n = working_box(solid), STEPS_FOR_OVERLAPS
    # evenly spread by the plastic number
    spread = np.outer(np.arange(RAYS_FOR_OVERLAPS), (0.7548776662, 0.5698402910)) % 1.0
    rays = box.low[:2] + box.sides[:2] * spread
    step = np.full(len(rays), box.sides[2] / n)
    start = box.low[2] + step * (spread.sum(axis=1) % 1.0)
    numbers = winding_numbers(box.triangles, rays, start, step, np.full(len(rays), n))
    missing = (numbers != 0) - numbers
    among = np.flatnonzero(missing)
    share = missing[among] * (np.prod(box.sides) / len(numbers) / solid.volume)
    if np.abs(share).sum() < LEAST_OVERLAP:
        return solid
    ray, height = np.divmod(among, n)
    points = np.column_stack((rays[ray], start[ray] + step[ray] * height))
    points = points @ box.axes.T - solid.centroid
    total = 1.0 + float(share.sum())
    shift = share @ points / total
    second = (solid.second_moment + (points.T * share) @ points) / total
    return replace(
        solid,
        volume=solid.volume * total,
        centroid=frozen(solid.centroid + shift),
        second_moment=frozen(second - np.outer(shift, shift)),
    )


def _ranges(first: np.ndarray, length: np.ndarray) -> np.ndarray:
    """first[0], first[0]+1, .. (length[0] of them), first[1], .. as one array."""
    before = np.concatenate(([0], np.cumsum(length)[:-1]))
    return np.arange(length.sum()) + np.repeat(first - before, length)


def _candidates(box_low: Array, box_high: Array, rays: Array):
    """Rays that can meet a triangle, by bins of rays and the triangles' bounding boxes.

    Returns the indices of the rays ordered by bin, and for every (triangle, row of bins)
    that has rays, begin and end of the range of that order in the triangle's bounding
    box, and the triangle's index.
    """
    low, high = rays.min(axis=0), rays.max(axis=0)
    size = np.maximum(high - low, 1e-12 + 1e-12 * np.abs(high))
    nx, ny = np.ceil(
        np.clip(np.sqrt(len(rays) * size / size[::-1]), 1, 4 * np.sqrt(len(rays)))
    ).astype(np.int64)

    def column(x):
        return np.clip((x - low[0]) * (nx / size[0]), 0, nx - 1).astype(np.int64)

    def row(y):
        return np.clip((y - low[1]) * (ny / size[1]), 0, ny - 1).astype(np.int64)

    flat = row(rays[:, 1]) * nx + column(rays[:, 0])
    order = np.argsort(
        flat.astype(np.uint16) if nx * ny <= 2**16 else flat, kind="stable"
    )
    begin = np.concatenate(([0], np.cumsum(np.bincount(flat, minlength=nx * ny))))
    over = (box_low[:, 0] <= high[0]) & (box_high[:, 0] >= low[0])
    index = np.flatnonzero(
        over & (box_low[:, 1] <= high[1]) & (box_high[:, 1] >= low[1])
    )
    (x_low, y_low), (x_high, y_high) = box_low[index].T, box_high[index].T
    bottom = row(y_low)
    tall = row(y_high) - bottom + 1
    line = _ranges(bottom, tall) * nx
    first = begin[line + np.repeat(column(x_low), tall)]
    last = begin[line + np.repeat(column(x_high), tall) + 1]
    occupied = np.flatnonzero(last > first)
    return order, first[occupied], last[occupied], np.repeat(index, tall)[occupied]


def _crossings(triangles: Array, rays: Array, ray: np.ndarray, triangle: np.ndarray):
    """Of the given pairs of rays and triangles those that cross: the ray, the height z of
    the crossing, and its sign (+1 for a normal upward).

    The line y = const through a ray meets a triangle if one corner lies on the other side
    of it than the two others, and crosses the two edges of that corner.
    """
    y = rays[ray, 1]
    x_of, y_of, z_of = triangles.reshape(-1, 3).T.copy()
    under = [y_of[3 * triangle + k] <= y for k in range(3)]
    meets = np.flatnonzero((under[0] != under[1]) | (under[1] != under[2]))
    ray, first, y = ray[meets], 3 * triangle[meets], y[meets]
    u, v, w = (each[meets] for each in under)
    alone = np.where(v == w, 0, np.where(u == w, 1, 2))
    is_low = np.where(alone == 0, u, np.where(alone == 1, v, w))
    x = rays[ray, 0]
    # the edges to the next corner and to the last: lower and higher end, and the share
    # of the edge below the line
    edges = []
    for step in (1, 2):
        one, other = first + alone, first + (alone + step) % 3
        low, high = np.where(is_low, one, other), np.where(is_low, other, one)
        share = (y - y_of[low]) / (y_of[high] - y_of[low])
        ends = x_of[low], x_of[high]
        edge_x = ends[0] + share * (ends[1] - ends[0])
        # rounding must not move it out of the bounding box that `_candidates` uses
        edge_x = np.clip(edge_x, np.minimum(*ends), np.maximum(*ends))
        edges.append((low, high, share, edge_x))
    ahead, last_ahead = (x < edge_x for *_, edge_x in edges)
    hit = np.flatnonzero(ahead != last_ahead)
    ahead = ahead[hit]
    (next_x, next_z), (last_x, last_z) = (
        (edge_x[hit], z_of[low[hit]] + share[hit] * (z_of[high[hit]] - z_of[low[hit]]))
        for low, high, share, edge_x in edges
    )
    left_x, right_x = np.where(ahead, last_x, next_x), np.where(ahead, next_x, last_x)
    left_z, right_z = np.where(ahead, last_z, next_z), np.where(ahead, next_z, last_z)
    height = left_z + (x[hit] - left_x) / (right_x - left_x) * (right_z - left_z)
    return ray[hit], height, np.where(ahead == is_low[hit], 1, -1).astype(np.int32)


@dataclass(frozen=True)
class WorkingBox:
    """The solid in its working frame."""

    axes: Array
    """(3, 3), columns are the working axes in the axes of the file"""
    low: Array
    """(3,) [m] lower corner"""
    sides: Array
    """(3,) [m]"""
    triangles: Array
    """(F, 3, 3) [m], oriented outward here too where the axes are left-handed"""
    centroid: Array
    """(3,) [m]"""
    whitening: Array
    """(3, 3) W with W second_moment W' = I"""


def working_box(solid: Solid) -> WorkingBox:
    """The solid in the axes of the file, or in principal axes if their box is smaller by a
    tenth, with the axis last along which rays meet the fewest triangles."""
    _, principal = np.linalg.eigh(solid.second_moment)
    principal = principal * np.sign(
        principal[np.abs(principal).argmax(axis=0), np.arange(3)]
    )
    turned = np.ptp(solid.vertices @ principal, axis=0)
    axes = principal if np.prod(turned) < 0.9 * np.prod(solid.extents) else np.eye(3)
    triangles = (solid.vertices @ axes)[solid.faces]
    # the best rays meet the fewest triangles: smallest sum of projected boxes
    spans = np.ptp(triangles, axis=1)
    last = int(np.argmin([(spans[:, i - 2] * spans[:, i - 1]).sum() for i in range(3)]))
    axes = np.roll(axes, 2 - last, axis=1)
    vertices = solid.vertices @ axes
    low, sides = vertices.min(axis=0), np.ptp(vertices, axis=0)
    whitening = np.asarray(
        np.linalg.inv(np.linalg.cholesky(axes.T @ solid.second_moment @ axes)), float
    )
    faces = solid.faces[:, :: 1 if np.linalg.det(axes) > 0.0 else -1]
    return WorkingBox(
        axes, low, sides, vertices[faces], solid.centroid @ axes, whitening
    )
