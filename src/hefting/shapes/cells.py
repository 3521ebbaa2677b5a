"""Cells: exact volume, centroid and second moment of a solid in each cell of a grid.

A solid is the sum of signed prisms, each between one of its triangles and a plane below
all of them. The triangles are cut at the planes of the grid; a piece in a cell adds the
prism below it in that cell, and a full column to each cell under it.

A part thinner than a cell may lie between the points of the grid. If the surface enters
a cell with no point within two cells, the solid is divided exactly into its shares of
the cells. The point of a cell moves to the centroid of the share; a cell without a point
is joined to a neighbour with one; the remaining cells are merged into larger pieces, in
number proportional to their volume, with a point at the centroid of each. The centroid
of a bent piece may be outside of the solid.
"""

from dataclasses import dataclass

import numpy as np

from hefting.core.spatial import Array, Mask, immutable

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
        bodies that are left out."""
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
    negative volumes where the surface is inside out, and no more than the cell's.

    The triangles (F, 3, 3) [m] are of a closed surface, oriented outward; `low` (3,) is
    the lower corner of the grid [m], which holds the solid, `size` (3,) the sides of a
    cell [m], and `shape` the numbers of cells along the axes.
    """
    pieces, index = (triangles - low) / size, np.zeros((len(triangles), 3), np.int64)
    for axis in range(3):
        pieces, index = _cut(pieces, index, axis, shape[axis])
    flat = np.ravel_multi_index(tuple(index.T), shape)
    # relative to the lower corner of the cell, in sides of a cell
    local = pieces - index[:, None, :]
    one, two = local[:, 1] - local[:, 0], local[:, 2] - local[:, 0]
    area = 0.5 * (one[:, 0] * two[:, 1] - one[:, 1] * two[:, 0])
    nodes = np.einsum("qk,nkd->qnd", POINTS, local)
    # moments 1, x, y, z, xx, xy, xz, yy, yz, zz of the prisms below the pieces in their
    # cells, and moments 1, x, y, xx, xy, yy of the pieces' projections
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
    # of the pieces above each cell, whose prisms fill its whole height
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
    # parts that overlap fill a cell twice
    scaled = total / np.maximum(total[0], 1.0) * float(np.prod(size))
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
    """Pieces (m, 3, 3) of triangles (n, 3, 3), cut at the integers along an axis, and the
    cells (m, 3) they are in."""
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
    """The parts (m, 3, 3) of triangles (n, 3, 3) on one side of a plane for each, and the
    index (m,) of the triangle that each belongs to.

    `bound` (n,) are the planes' coordinates along `axis`; `side` is 1 for the parts
    above, -1 for those below. Orientations are kept.
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


SPACING = 0.5
"""Spacing of the sample points of large triangles, in sides of a cell."""
MOST_SURFACE_POINTS = 2_000_000
"""Most sample points of large triangles; for finer grids the spacing grows."""
MOST_DIVIDED_CELLS = 2_000_000
"""Most cells a solid is divided into."""
REACH = 2
"""Cells by which a part may extend beyond the cells with a point; tips and edges of
tools do so by one."""
NEGLIGIBLE_CELL = 1e-9
"""Share of a cell up to which it counts as empty, as by rounding."""
NEGLIGIBLE_PART = 1e-5
"""Share of the solid's volume that parts without points may have."""
POINTS_OVER_SHARE = 1.0
"""Number of points of missed parts over that in proportion to their volume."""
POINTS_OF_PART = 3
"""Points added for each missed part, whose inertia one point does not represent."""
PIECE_SIDES = (1, 2, 3, 4, 6, 8, 12, 16, 24, 32, 48, 64, 128, 256)
"""Candidate sides of a piece, in cells."""


@immutable
class Lattice:
    """Cells of a grid over a solid's bounding box, and which of them have a point."""

    low: Array
    """(3,) [m] lower corner"""
    size: Array
    """(3,) [m] sides of a cell"""
    occupied: Mask
    """(nx, ny, nz) the cells with a point"""

    @property
    def shape(self) -> tuple[int, int, int]:
        """Numbers of cells along the axes."""
        x, y, z = self.occupied.shape
        return x, y, z


def misses_a_part(triangles: Array, lattice: Lattice) -> bool:
    """Whether the surface (F, 3, 3) enters a cell with no point within `REACH` cells."""
    near = lattice.occupied
    for _ in range(REACH):
        near = _widened(near)
    if near.all():
        return False
    points = np.concatenate(
        (triangles[:, 0], _points_on_large(triangles, SPACING * lattice.size.min()))
    )
    index = np.floor((points - lattice.low) / lattice.size).astype(np.int64)
    index = np.clip(index, 0, np.array(lattice.shape) - 1)
    return not bool(near[tuple(index.T)].all())


def divided(
    triangles: Array, lattice: Lattice, target: int, count: int | None = None
) -> Moments:
    """Moments of the pieces of the solid, one for each point: first those of cells with a
    point, then those that the grid misses.

    `target` is the wanted number of points of the solid, `count` the most points of
    missed parts, by default in proportion to their volume.
    """
    shares = moments_in_cells(triangles, lattice.low, lattice.size, lattice.shape)
    full = shares.volume > NEGLIGIBLE_CELL * float(np.prod(lattice.size))
    occupied = lattice.occupied.ravel() & full
    owner = np.full(len(full), -1)
    owner[occupied] = np.arange(int(occupied.sum()))
    owner = _joined(owner.reshape(lattice.shape)).ravel()
    owner[~full] = -1
    missed = full & (owner < 0)
    if missed.any():
        part = float(shares.volume[missed].sum() / shares.volume[full].sum())
        piece = _pieces(missed.reshape(lattice.shape), part * target, count)
        owner[missed] = int(occupied.sum()) + piece
    return shares.together(owner, int(owner.max()) + 1)


def has_missed(pieces: Moments, lattice: Lattice) -> bool:
    """Whether the pieces that the grid misses are more than negligible."""
    missed = pieces.volume[int(lattice.occupied.sum()) :].sum()
    return bool(missed > NEGLIGIBLE_PART * pieces.volume.sum())


def _pieces(missed: np.ndarray, suitable: float, count: int | None) -> np.ndarray:
    """Index of the piece of each missed cell, in the order of ``numpy.nonzero``, for the
    finest division with fewer pieces than `count`, by default than a number that follows
    from `suitable`, the number in proportion to volume."""
    from scipy.ndimage import label

    parts, number = label(missed, structure=np.ones((3, 3, 3)))  # pyright: ignore[reportGeneralTypeIssues]
    most = POINTS_OVER_SHARE * suitable + POINTS_OF_PART * number
    cells = np.array(np.nonzero(missed))
    cells -= cells.min(axis=1, keepdims=True)
    of_part = parts[missed]
    piece = np.zeros(len(of_part), dtype=np.int64)
    for side in PIECE_SIDES:
        keys = np.vstack((of_part, cells // side))
        _, piece = np.unique(keys, axis=1, return_inverse=True)
        piece = piece.ravel()
        if piece.max() < (most if count is None else count):
            break
    return piece


def _joined(owner: np.ndarray) -> np.ndarray:
    """Owners (nx, ny, nz), where a cell without one, -1, gets that of a neighbour: first
    across a face, then an edge, then a corner."""
    result = owner
    padded = np.pad(owner, 1, constant_values=-1)
    steps = [s for s in np.ndindex(3, 3, 3) if s != (1, 1, 1)]
    x, y, z = owner.shape
    for step in sorted(steps, key=lambda s: sum(abs(i - 1) for i in s)):
        i, j, k = step
        neighbour = padded[i : i + x, j : j + y, k : k + z]
        result = np.where(result < 0, neighbour, result)
    return result


def _widened(mask: Mask) -> Mask:
    for axis in range(3):
        moved = np.moveaxis(mask, axis, 0)
        wide = moved.copy()
        wide[1:] |= moved[:-1]
        wide[:-1] |= moved[1:]
        mask = np.moveaxis(wide, 0, axis)
    return mask


def _points_on_large(triangles: Array, spacing: float) -> Array:
    """Points (n, 3) on the triangles that are larger than `spacing` [m], about `spacing`
    apart, in rows parallel to the longest edge."""
    a, b, c = triangles[:, 0], triangles[:, 1], triangles[:, 2]
    large = (np.maximum(np.abs(b - a), np.abs(c - a)) > spacing).any(axis=1)
    t = triangles[large]
    if not len(t):
        return np.empty((0, 3))
    length = np.linalg.norm(np.roll(t, -1, axis=1) - t, axis=2)
    order = (np.argmax(length, axis=1)[:, None] + np.arange(3)) % 3
    a, b, c = np.take_along_axis(t, order[:, :, None], axis=1).transpose(1, 0, 2)
    longest = length.max(axis=1)
    height = np.linalg.norm(np.cross(b - a, c - a), axis=1) / longest
    columns = np.ceil(longest / spacing).astype(np.int64) + 1
    rows = np.ceil(height / spacing).astype(np.int64) + 1
    number = columns * rows
    coarser = max(float(number.sum()) / MOST_SURFACE_POINTS, 1.0) ** 0.5
    columns = np.maximum((columns / coarser).astype(np.int64), 2)
    rows = np.maximum((rows / coarser).astype(np.int64), 2)
    number = columns * rows
    which = np.repeat(np.arange(len(t)), number)
    step = np.arange(len(which)) - np.repeat(np.cumsum(number) - number, number)
    u = (step % columns[which]) / (columns[which] - 1.0)
    v = (step // columns[which]) / (rows[which] - 1.0)
    edge = a[which] + u[:, None] * (b - a)[which]
    return edge + v[:, None] * (c[which] - edge)
