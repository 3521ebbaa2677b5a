"""Cells: volume, centroid and second moment of a solid in each cell of a grid, exactly.

A solid is the sum of signed prisms, each between one of its triangles and a plane below
all of them. The triangles are cut at the planes of the grid; a piece in a cell gives
the prism below it in that cell, and a whole column to each cell under it.
"""

from dataclasses import dataclass

import numpy as np

from hefting.core.spatial import Array

POINTS, WEIGHTS = (
    np.array(
        [
            (1.0 - 2.0 * a, a, a)[k:] + (1.0 - 2.0 * a, a, a)[:k]
            for a in (0.445948490915965, 0.091576213509771)
            for k in range(3)
        ]
    ),
    np.repeat((0.223381589678011, 0.109951743655322), 3),
)
"""Barycentric points (6, 3) and weights (6,) of a quadrature over a triangle that is
exact for polynomials up to degree 4 (Dunavant 1985)."""


@dataclass(frozen=True)
class Moments:
    """Moments of volume of n bodies, about the origin."""

    volume: Array
    """(n,) [m³]"""
    first: Array
    """(n, 3) [m⁴] about the origin"""
    second: Array
    """(n, 3, 3) [m⁵] about the origin"""

    def together(self, group: np.ndarray, count: int) -> "Moments":
        """Sums over the bodies of each of `count` groups; `group` (n,) is negative for
        those that belong to none."""
        chosen = group >= 0
        index = group[chosen]

        def sums(values: Array) -> Array:
            flat = values[chosen].reshape(len(index), -1)
            columns = [np.bincount(index, column, count) for column in flat.T]
            stacked = np.asarray(np.stack(columns, axis=1), dtype=float)
            return stacked.reshape(count, *values.shape[1:])

        return Moments(sums(self.volume), sums(self.first), sums(self.second))

    @property
    def centroids(self) -> Array:
        """(n, 3) [m]"""
        return self.first / self.volume[:, None]

    @property
    def central(self) -> Array:
        """(n, 3, 3) [m²] second moments about the centroids, over the volume."""
        c = self.centroids
        return self.second / self.volume[:, None, None] - c[:, :, None] * c[:, None, :]


def moments_in_cells(
    triangles: Array, low: Array, size: Array, shape: tuple[int, int, int]
) -> Moments:
    """Moments of a solid in each cell of a grid, in the order of ``numpy.ravel``;
    negative volumes where the surface is inside out.

    The triangles (F, 3, 3) [m] are of a closed surface, oriented outward; `low` (3,) is
    the lower corner of the grid [m], which holds the solid, `size` (3,) the sides of a
    cell [m], and `shape` the numbers of cells along the axes.
    """
    pieces, index = (triangles - low) / size, np.zeros((len(triangles), 3), np.int64)
    for axis in range(3):
        pieces, index = _cut(pieces, index, axis, shape[axis])
    flat = np.ravel_multi_index(tuple(index.T), shape)
    # about the lower corner of the own cell, in sides of a cell
    local = pieces - index[:, None, :]
    one, two = local[:, 1] - local[:, 0], local[:, 2] - local[:, 0]
    area = 0.5 * (one[:, 0] * two[:, 1] - one[:, 1] * two[:, 0])
    nodes = np.einsum("qk,nkd->qnd", POINTS, local)
    own = np.zeros((10, len(area)))
    column = np.zeros((6, len(area)))
    for weight, (x, y, z) in zip(WEIGHTS, nodes.transpose(0, 2, 1), strict=True):
        w = weight * area
        flat_terms = (w, w * x, w * y, w * x * x, w * x * y, w * y * y)
        column += flat_terms
        own[[0, 1, 2, 4, 5, 7]] += np.array(flat_terms) * z
        half = 0.5 * z * z
        own[[3, 6, 8]] += (w * half, w * x * half, w * y * half)
        own[9] += w * z**3 / 3.0
    cells = int(np.prod(shape))
    sums = [np.bincount(flat, row, cells) for row in own]
    total = np.asarray(np.stack(sums), dtype=float)
    above = np.stack([np.bincount(flat, row, cells) for row in column])
    above = above.reshape(6, *shape)
    above = (np.cumsum(above[..., ::-1], axis=-1)[..., ::-1] - above).reshape(6, -1)
    total[[0, 1, 2, 4, 5, 7]] += above
    total[[3, 6, 8]] += 0.5 * above[:3]
    total[9] += above[0] / 3.0
    return _in_metres(total, low, size, shape)


def _in_metres(
    total: Array, low: Array, size: Array, shape: tuple[int, int, int]
) -> Moments:
    """Moments about the origin from those about the lower corner of each cell in sides
    of a cell: rows (10, n) 1, x, y, z, xx, xy, xz, yy, yz, zz."""
    scaled = total * float(np.prod(size))
    volume, first = scaled[0], scaled[1:4].T * size
    i, j = np.triu_indices(3)
    second = np.zeros((len(volume), 3, 3))
    second[:, i, j] = second[:, j, i] = scaled[4:].T * (size[i] * size[j])
    corner = low + size * np.indices(shape, dtype=float).reshape(3, -1).T
    mixed = first[:, :, None] * corner[:, None, :]
    second += mixed + mixed.transpose(0, 2, 1)
    second += volume[:, None, None] * corner[:, :, None] * corner[:, None, :]
    return Moments(volume, first + volume[:, None] * corner, second)


def _cut(
    pieces: Array, index: np.ndarray, axis: int, count: int
) -> tuple[Array, np.ndarray]:
    """Triangles (n, 3, 3) cut at the whole numbers along an axis, and the cells (n, 3)
    they are in."""
    along = pieces[:, :, axis]
    first = np.clip(np.floor(along.min(axis=1)).astype(np.int64), 0, count - 1)
    last = np.clip(np.ceil(along.max(axis=1)).astype(np.int64) - 1, first, count - 1)
    index = index.copy()
    index[:, axis] = first
    whole = first == last
    parts, places = [pieces[whole]], [index[whole]]
    rows = np.flatnonzero(~whole)
    number = (last - first + 1)[rows]
    row = np.repeat(rows, number)
    step = np.arange(len(row)) - np.repeat(np.cumsum(number) - number, number)
    place = index[row]
    place[:, axis] += step
    # the outermost cells take what rounding leaves outside
    below = np.where(place[:, axis] == first[row], -np.inf, place[:, axis])
    above = np.where(place[:, axis] == last[row], np.inf, place[:, axis] + 1.0)
    cut, kept = _half_space(pieces[row], axis, below, 1.0)
    cut, again = _half_space(cut, axis, above[kept], -1.0)
    parts.append(cut)
    places.append(place[kept[again]])
    return np.concatenate(parts), np.concatenate(places)


def _half_space(
    triangles: Array, axis: int, bound: Array, side: float
) -> tuple[Array, np.ndarray]:
    """What of triangles (n, 3, 3) is on one side of a plane each, as triangles, and
    which triangle each is part of.

    `bound` (n,) is the coordinate along `axis`; `side` is 1 for what is above it, -1
    for what is below. Orientations are kept.
    """
    depth = side * (triangles[:, :, axis] - bound[:, None])
    inside = depth > 0.0
    number = inside.sum(axis=1)
    whole = np.flatnonzero(number == 3)
    parts, kept = [triangles[whole]], [whole]
    for count in (1, 2):
        some = np.flatnonzero(number == count)
        lone = np.argmax(inside[some] == (count == 1), axis=1)
        order = (lone[:, None] + np.arange(3)) % 3
        t = np.take_along_axis(triangles[some], order[:, :, None], axis=1)
        d = np.take_along_axis(depth[some], order, axis=1)
        a, b, c = t[:, 0], t[:, 1], t[:, 2]
        ab = a + (d[:, :1] / (d[:, :1] - d[:, 1:2])) * (b - a)
        ac = a + (d[:, :1] / (d[:, :1] - d[:, 2:3])) * (c - a)
        new = [(a, ab, ac)] if count == 1 else [(ab, b, c), (ab, c, ac)]
        for corners in new:
            parts.append(np.stack(corners, axis=1))
            kept.append(some)
    return np.concatenate(parts), np.concatenate(kept)
