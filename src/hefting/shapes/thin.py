"""Thin parts: those of a solid that a grid of points misses, and points for them.

A part thinner than a cell may pass between the points of the grid. Where the surface
comes to a cell with no point within two cells of it, the solid is divided exactly into
its shares of the cells (`hefting.shapes.cells`). A cell with a point keeps it, at the
centroid of its share; a cell without one joins a neighbour that has one; what is left
is put together to larger pieces, as many as suit its volume, with a point at the
centroid of each. That of a bent piece may be outside of the solid.
"""

import numpy as np

from hefting.core.immutable import immutable
from hefting.core.spatial import Array, Mask
from hefting.shapes.cells import Moments, moments_in_cells

SPACING = 0.5
"""Distance of the points at which the surface is looked at, in sides of a cell."""
MOST_SURFACE_POINTS = 2_000_000
"""Most points at which the surface is looked at; of finer grids only some of them."""
MOST_DIVIDED_CELLS = 2_000_000
"""Most cells a solid is divided into."""
REACH = 2
"""Cells by which a part may reach beyond those with a point; tips and edges of tools
reach one further."""
NEGLIGIBLE_CELL = 1e-9
"""Share of a cell below which it counts as empty: rounding."""
NEGLIGIBLE_PART = 1e-5
"""Share of the solid's volume that parts without points may have."""
POINTS_OVER_SHARE = 1.0
"""Largest number of points of thin parts over what their volume would get."""
POINTS_OF_PART = 3
"""Number of points of a thin part that may be more than that, so that its inertia does
not rest on one."""
PIECE_SIDES = (1, 2, 3, 4, 6, 8, 12, 16, 24, 32, 48, 64, 128, 256)
"""Sides of a piece that are tried, in cells."""


@immutable
class Lattice:
    """Cells of a grid that cover the bounding box of a solid, and which of them have a
    point."""

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
    """Whether the surface (F, 3, 3) comes to a cell with no point within `REACH` cells
    of it."""
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
    """The solid as pieces, each for a point: those of the cells with a point, then those
    that the grid misses.

    `target` is the number of points wanted of the whole solid, `count` the most points
    of thin parts, by default as many as suit their volume.
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
    """Number of the piece each missed cell is part of, in the order of
    ``numpy.nonzero``: the finest division that has not too many."""
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
    """Owners of cells (nx, ny, nz), with those of neighbours for cells without: across
    a face first, then an edge, then a corner."""
    found = owner
    padded = np.pad(owner, 1, constant_values=-1)
    steps = [s for s in np.ndindex(3, 3, 3) if s != (1, 1, 1)]
    x, y, z = owner.shape
    for step in sorted(steps, key=lambda s: sum(abs(i - 1) for i in s)):
        i, j, k = step
        neighbour = padded[i : i + x, j : j + y, k : k + z]
        found = np.where(found < 0, neighbour, found)
    return found


def _widened(mask: Mask) -> Mask:
    """The cells of a mask and all cells around them."""
    for axis in range(3):
        moved = np.moveaxis(mask, axis, 0)
        wide = moved.copy()
        wide[1:] |= moved[:-1]
        wide[:-1] |= moved[1:]
        mask = np.moveaxis(wide, 0, axis)
    return mask


def _points_on_large(triangles: Array, spacing: float) -> Array:
    """Points on the triangles that are larger than `spacing` [m], about so far apart:
    rows parallel to the longest edge."""
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
