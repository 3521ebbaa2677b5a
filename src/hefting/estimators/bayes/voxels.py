"""Voxels: the solid that the points of a shape represent; the cell of each point is
divided into small boxes."""

from typing import Any, Self

import numpy as np

from hefting.core.spatial import (
    Array,
    Indices,
    Mask,
    immutable,
    median,
    vector_to_tensor,
)
from hefting.shapes import Shape

TARGET_VOXELS = 4000
"""Approximate number of voxels of a shape; there is at least one for each point."""
MOST_CELLS = 150
"""Number of points above which they are grouped into about half as many cells."""
MOST_GRID_CELLS = 2_000_000
"""Largest number of grid cells in which depth is measured; it bounds the memory."""


@immutable
class Voxels:
    """A shape filled with voxels, about its homogeneous centre of mass, in sensor axes.
    They are scaled slightly to have exactly the moments of the homogeneous body."""

    parameters: Array
    """(10, N) a_f: parameters of 1 kg in each voxel."""
    volumes: Array
    """(N,) Share of each voxel in the volume."""
    depth_rank: Array
    """(N,) Share of the volume that is nearer to the surface, from 0 to 1."""
    mean: Array
    """(10,) Parameters of 1 kg of uniform density."""
    points: Array
    """(10, n) Parameters of 1 kg in the cell of each point."""
    shares: Array
    """(n,) Share of the cell of each point in the volume."""
    cells: Array
    """(10, c) Parameters of 1 kg in each cell, that of one point or of a group."""
    cell_shares: Array
    """(c,) Share of each cell in the volume."""
    cell_positions: Array
    """(c, 3) [m] Centroids of the cells."""

    @classmethod
    def of(cls, shape: Shape) -> Self:
        """Voxels of a shape in the sensor frame; its points have cells of one size."""
        n = shape.n
        axes, sides = _cell_box(shape)
        cuts = _subdivisions(sides, TARGET_VOXELS / n)
        step = sides / cuts
        offsets = _offsets_in_cell(sides, cuts)
        along_axes = shape.positions @ axes
        positions = (along_axes[:, None] + offsets[None]).reshape(-1, 3)
        volumes = np.repeat(shape.shares / len(offsets), len(offsets))
        rank = _depth_rank(positions, step, volumes)

        x, own = _like_homogeneous(shape, axes, positions, volumes, step)
        parameters = _parameters_of_points(x, own)
        points = parameters.reshape(10, n, -1).mean(axis=2)
        cells, cell_shares = _grouped(points, shape.shares)
        return cls(
            parameters,
            volumes,
            rank,
            parameters @ volumes,
            points,
            shape.shares,
            cells,
            cell_shares,
            cells[1:4].T.copy(),
        )


def _offsets_in_cell(sides: Array, cuts: Indices) -> Array:
    """(v, 3) [m] centres of the voxels of a cell from its own centre, for a cell with
    the given sides (3,) [m] and numbers (3,) of voxels along them."""
    numbers: list[int] = cuts.tolist()
    grids: list[Array] = [
        sides[i] * ((np.arange(c) + 0.5) / c - 0.5) for i, c in enumerate(numbers)
    ]
    return np.stack([g.ravel() for g in np.meshgrid(*grids, indexing="ij")], axis=1)


def _like_homogeneous(
    shape: Shape, axes: Array, positions: Array, volumes: Array, step: Array
) -> tuple[Array, Array]:
    """Voxels about their centroid, stretched to the second moment of the homogeneous
    body: centres (N, 3) [m] and the second moment (3, 3) [m²] of each about its own
    centre, in sensor axes.

    The positions (N, 3) and the sides of a voxel, `step` (3,) [m], are along the
    columns of `axes` (3, 3).
    """
    own = np.diag(step**2 / 12.0)
    x = positions - volumes @ positions
    body = shape.homogeneous
    c = body.center_of_mass
    of_body = body.pseudo_inertia[:3, :3] / body.mass - np.outer(c, c)
    A = _stretch((x.T * volumes) @ x + own, axes.T @ of_body @ axes)
    return x @ A.T @ axes.T, axes @ A @ own @ A.T @ axes.T


def _grouped(points: Array, shares: Array) -> tuple[Array, Array]:
    """Parameters (10, c) of 1 kg in each cell, and the cells' shares (c,) in the volume:
    those of the points, or of groups of neighbours if there are more than
    `MOST_CELLS`."""
    if len(shares) <= MOST_CELLS:
        return points, shares
    label = _group_points(points[1:4].T, MOST_CELLS // 2)
    of_group = np.asarray(np.bincount(label, weights=shares), dtype=float)
    sums = np.stack([np.bincount(label, weights=row * shares) for row in points])
    kept = of_group > 0.0
    return sums[:, kept] / of_group[kept], of_group[kept]


def _parameters_of_points(x: Array, own: Array) -> Array:
    """(10, N) parameters of 1 kg at each point x (N, 3) [m]; `own` (3, 3) [m²] is its
    second moment about that point."""
    i, j = (0, 0, 0, 1, 1, 2), (0, 1, 2, 1, 2, 2)
    second = x[:, i] * x[:, j] + own[i, j]
    parameters = np.empty((10, len(x)))
    parameters[0], parameters[1:4], parameters[4:] = 1.0, x.T, -second.T
    parameters[[4, 7, 9]] += second[:, 0] + second[:, 3] + second[:, 5]
    return parameters


def _cell_box(shape: Shape) -> tuple[Array, Array]:
    """Axes (3, 3), as columns, and sides (3,) [m] of a box for the cell of a point."""
    axes = np.array(shape.pose[:3, :3])
    if shape.cell_inertia is None:
        return axes, np.full(3, _spacing(shape))
    J = vector_to_tensor(shape.cell_inertia.mean(axis=0))
    second = 0.5 * np.trace(J) * np.eye(3) - J
    turned = axes.T @ second @ axes
    if np.abs(turned - np.diag(turned.diagonal())).max() > 1e-9 * np.trace(turned):
        axes = np.linalg.eigh(second)[1]
        turned = axes.T @ second @ axes
    return axes, np.sqrt(
        12.0 * np.maximum(turned.diagonal(), 1e-12 * max(np.trace(turned), 1e-12))
    )


def _spacing(shape: Shape) -> float:
    """Median distance [m] of a point to its nearest neighbour."""
    from scipy.spatial import KDTree

    if shape.n == 1:
        return 1e-3
    tree: Any = KDTree(shape.positions)
    distance = np.asarray(
        tree.query(shape.positions[: 100 * MOST_CELLS], k=2)[0], dtype=float
    )[:, 1]
    return median(distance) or 1e-3 * (float(np.linalg.norm(shape.extents)) or 1.0)


def _subdivisions(sides: Array, wanted: float) -> Indices:
    """Numbers (3,) of boxes along the sides of a cell, nearly cubic and about `wanted`
    in all; at least two along each side if `wanted` is eight or more."""
    least = 2 if wanted >= 8.0 else 1
    pitch = (np.prod(sides) / max(wanted, 1.0)) ** (1.0 / 3.0)
    for _ in range(3):  # sides that are not cut leave more for the others
        thick = sides > pitch
        if not thick.any():
            return np.full(3, least)
        pitch = (np.prod(sides[thick]) / max(wanted, 1.0)) ** (1.0 / thick.sum())
    return np.clip(np.round(sides / pitch), least, 64).astype(int)


def _depth_rank(positions: Array, step: Array, volumes: Array) -> Array:
    """(N,) share of the volume that is nearer to the surface of the solid."""
    low: Array = positions.min(axis=0)
    step = np.maximum(step, np.ptp(positions, axis=0) / 1000.0)
    while True:
        index = np.round((positions - low) / step).astype(int) + 1
        size = index.max(axis=0) + 2
        if np.prod(size.astype(float)) <= MOST_GRID_CELLS:
            break
        step = 1.3 * step
    filled = np.zeros(size, dtype=bool)
    filled[tuple(index.T)] = True
    depth = _distance_to_outside(filled, step)[tuple(index.T)]
    levels, inverse = np.unique(
        np.round(depth / float(step.min()), 6), return_inverse=True
    )
    per_level = np.bincount(inverse, weights=volumes, minlength=len(levels))
    return (np.cumsum(per_level) - 0.5 * per_level)[inverse]


def _distance_to_outside(filled: Mask, step: Array) -> Array:
    """Euclidean distance [m] of each voxel to the nearest one that is not filled.

    `step` (3,) [m] is the spacing of the grid. One axis after the other, the squared
    distance of a voxel becomes the minimum, over all voxels of its line, of their value
    plus the squared distance to them (Felzenszwalb & Huttenlocher, Theory of Computing
    8, 2012).
    """
    far = float(np.sum((np.array(filled.shape) * step) ** 2))
    square = np.where(filled, far, 0.0)
    for axis, (n, length) in enumerate(zip(filled.shape, step, strict=True)):
        lines = np.moveaxis(square, axis, 0)
        apart = np.square(length * np.arange(n, dtype=float))
        least = lines.copy()
        for k in range(1, n):
            if apart[k] >= lines.max():
                break
            np.minimum(least[k:], lines[:-k] + apart[k], out=least[k:])
            np.minimum(least[:-k], lines[k:] + apart[k], out=least[:-k])
        square = np.moveaxis(least, 0, axis)
    return np.sqrt(square)


def _stretch(from_: Array, to: Array) -> Array:
    """The symmetric (3, 3) A with A from_ A = to: the least displacement that maps one
    second moment to another."""
    values, vectors = np.linalg.eigh(from_)
    values = np.maximum(values, 1e-12 * max(float(values[2]), 1e-30))
    root = (vectors * np.sqrt(values)) @ vectors.T
    back = (vectors / np.sqrt(values)) @ vectors.T
    values, vectors = np.linalg.eigh(root @ to @ root)
    return back @ ((vectors * np.sqrt(np.maximum(values, 0.0))) @ vectors.T) @ back


def _group_points(x: Array, number: int) -> Indices:
    """Index (n,) of the cubic cell of each point x (n, 3), for about `number` cells."""
    low: Array = x.min(axis=0)
    sides: Array = np.maximum(np.ptp(x, axis=0), 1e-9)
    sides = np.maximum(sides, 0.02 * sides.max())
    pitch = (np.prod(sides) / number) ** (1.0 / 3.0)
    while True:
        index = np.floor((x - low) / pitch).astype(np.int64)
        size = index.max(axis=0) + 1
        key = (index[:, 0] * size[1] + index[:, 1]) * size[2] + index[:, 2]
        label = np.unique(key, return_inverse=True)[1]
        if label.max() + 1 <= 2 * number:
            return label
        pitch *= 1.15
