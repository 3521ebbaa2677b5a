"""Points inside a solid: the regular grid that matches its moments best, or seeded random points."""

import math
from dataclasses import dataclass
from itertools import product

import numpy as np

from hefting.errors import InputError
from hefting.shapes.inside import winding_numbers
from hefting.shapes.solid import Solid
from hefting.spatial import Array

MAX_POINTS = 1_000_000
"""Most points a shape may be given."""
MAX_CELLS = 20_000_000
"""Most grid cells looked at for one grid, or random points drawn for one sample."""
CELLS_LOOKED_AT = 200_000
"""Grid cells tested in search of the best grid; more points leave fewer grids to choose from."""
GOOD = 0.01
"""Mismatch (see `_score`) below which no better grid is looked for."""
FEWEST, MOST = 0.9, 1.3
"""Points a grid may have, relative to the wanted number, where there is such a grid."""
PHASES = (0.5, 0.0, 0.25, 0.75)
"""Where the first grid point lies in the first cell; 0.5 centres the grid in the bounding box."""


@dataclass(frozen=True)
class Samples:
    """Points that stand for nearly equal shares of a solid."""

    positions: Array
    """(n, 3) [m] in the axes of the shape's file."""
    volumes: Array
    """(n,) share of the solid's volume that each point stands for, summing to one."""
    cell_second_moment: Array
    """(3, 3) [m²] second moment per unit mass of the cell of one point about it, same axes."""


@dataclass(frozen=True)
class _Box:
    """The solid in its working frame: tight box, turned so that rays along z meet few triangles."""

    axes: Array  # (3, 3), columns are the working axes in the axes of the file
    low: Array
    sides: Array
    triangles: Array
    centroid: Array
    whitening: Array  # (3, 3) W with W second_moment W' = I


def grid_points(solid: Solid, target: int) -> Samples:
    """Regular grid of cell centres inside a solid, about `target` of them.

    The grid lies along the axes of the file, or along the principal axes where these have a clearly smaller
    bounding box. Cells are nearly cubic, with at least one layer through each thin direction. Among the
    grids of different pitch and phase the one is taken that has nearly the wanted count and, as equal
    point masses, the centroid and second moment nearest to those of the solid. Deterministic.
    """
    box = _working_box(solid)
    budget = int(np.clip(CELLS_LOOKED_AT * solid.volume / (target * np.prod(box.sides)), 8, 320))
    cell = solid.volume / target
    for _ in range(2):  # the count goes with 1 / cell, but not exactly: the grid may miss or favour the shape
        first = _evaluate(box, _centred(box, cell, 1 + budget // 60), target)
        counts = [count * np.prod(box.sides / cells) for count, _, (cells, _), _ in first]
        cell = float(np.clip(np.median(counts), 0.1 * solid.volume, 3 * solid.volume)) / target
    ranked = _evaluate(box, _centred(box, cell, max(12, budget // 3)), target)
    ranked.sort(key=lambda found: found[1])
    best = budget // len(PHASES) ** 3 if ranked[0][1] > GOOD else 0
    grids = [(cells, phase) for _, _, (cells, _), _ in ranked[:best] for phase in product(PHASES, repeat=3)]
    ranked = sorted([ranked[0], *_evaluate(box, grids, target)], key=lambda found: found[1])
    count, _, (cells, _), positions = ranked[0]
    if count == 0:
        raise InputError("no grid point falls inside the shape", fix="ask for more points")
    cell = (box.axes * ((box.sides / cells) ** 2 / 12)) @ box.axes.T
    return Samples(positions @ box.axes.T, _volumes(box, positions, box.axes.T @ cell @ box.axes), cell)


def random_points(solid: Solid, count: int, seed: int) -> Samples:
    """`count` independent, uniformly distributed points inside a solid; the same for the same `seed`."""
    box, rng = _working_box(solid), np.random.default_rng(seed)
    share = min(1.0, solid.volume / float(np.prod(box.sides)))
    batch = int(np.clip(1.2 * count / share + 16, 64, 1_000_000))
    found, total, drawn = [], 0, 0
    while total < count:
        if drawn > max(MAX_CELLS, 20 * count):
            raise InputError("the shape fills too little of its bounding box for random points", fix="use a grid")
        points = box.low + box.sides * rng.random((batch, 3))
        one = np.ones(batch, dtype=np.int64)
        inside = winding_numbers(box.triangles, points[:, :2], points[:, 2], np.ones(batch), one) != 0
        found.append(points[inside])
        total, drawn = total + int(inside.sum()), drawn + batch
    positions = np.concatenate(found)[:count]
    cell = np.eye(3) * (solid.volume / count) ** (2 / 3) / 12
    return Samples(positions @ box.axes.T, _volumes(box, positions, cell), cell)


def _volumes(box: _Box, points: Array, cell: Array) -> Array:
    """Shares of volume near to equal ones that give the points the solid's centroid and second moment.

    Least squares in the nine moments, damped where the points cannot reach them (a single layer, say) and
    shortened so that no share falls below a quarter of its equal part.
    """
    w = (points - box.centroid) @ box.whitening.T
    i, j = np.triu_indices(3)
    moments = np.column_stack((w, w[:, i] * w[:, j] + (box.whitening @ cell @ box.whitening.T)[i, j]))
    mean = moments.mean(axis=0)
    moments -= mean  # so that whatever the shares, their sum stays one
    gram = moments.T @ moments / len(w)
    change = moments @ np.linalg.solve(gram + 1e-3 * np.eye(9), np.append(np.zeros(3), np.eye(3)[i, j]) - mean)
    length = min(1.0, 0.75 / max(-float(change.min()), 1e-12))
    shares = 1 + length * change
    return shares / shares.sum()


def _working_box(solid: Solid) -> _Box:
    """The axes of the file, or the principal axes if their box is smaller by a tenth; rays along the last."""
    _, principal = np.linalg.eigh(solid.second_moment)
    principal = principal * np.sign(principal[np.abs(principal).argmax(axis=0), np.arange(3)])
    turned = np.ptp(solid.vertices @ principal, axis=0)
    axes = principal if np.prod(turned) < 0.9 * np.prod(solid.extents) else np.eye(3)
    triangles = (solid.vertices @ axes)[solid.faces]
    spans = np.ptp(triangles, axis=1)  # the best rays meet the fewest triangles: smallest sum of projected boxes
    last = int(np.argmin([(spans[:, i - 2] * spans[:, i - 1]).sum() for i in range(3)]))
    axes = np.roll(axes, 2 - last, axis=1)
    vertices = solid.vertices @ axes
    low, sides = vertices.min(axis=0), np.ptp(vertices, axis=0)
    whitening = np.asarray(np.linalg.inv(np.linalg.cholesky(axes.T @ solid.second_moment @ axes)), float)
    return _Box(axes, low, sides, vertices[solid.faces], solid.centroid @ axes, whitening)


def _centred(box: _Box, cell: float, number: int) -> list[tuple]:
    """Up to `number` grids (cells along each side, phase) of nearly cubic cells of about volume `cell`."""
    low, high = 0.0, float(box.sides.max())
    for _ in range(60):  # the pitch h at which min(h, side) multiply to the wanted volume
        middle = 0.5 * (low + high)
        low, high = (middle, high) if np.prod(np.minimum(middle, box.sides)) < cell else (low, middle)
    pitch = high * np.exp(0.4 * np.linspace(-1, 1, 61) ** 3)[:, None, None]
    cells = np.floor(box.sides / pitch) + np.indices((3, 3, 3)).reshape(3, 27).T
    cells = np.unique(np.maximum(cells, 1).reshape(-1, 3), axis=0)
    size = box.sides / cells
    uneven = np.where(cells > 1, size, 0).max(axis=1) / np.where(cells > 1, size, np.inf).min(axis=1)
    thin = (size * (cells == 1) <= 1.6 * high).all(axis=1)  # a side of one cell may be short, but not long
    cells = cells[(uneven < 1.7) & thin] if ((uneven < 1.7) & thin).any() else cells
    off = np.abs(np.log(np.prod(box.sides / cells, axis=1) / cell))
    chosen = cells[np.argsort(off, kind="stable")[:number]].astype(int)
    return [(tuple(row), (0.5,) * 3) for row in chosen.tolist()]


def _evaluate(box: _Box, grids: list, target: int) -> list[tuple]:
    """(count, score, grid, positions in the working frame) of every grid (cells, phase)."""
    results, batch, size = [], [], 0
    for grid in grids:
        lines = [_centres(k, phase, low, side) for k, phase, low, side in zip(*grid, box.low, box.sides, strict=True)]
        cells = math.prod(len(line) for line in lines)
        if cells > MAX_CELLS:
            raise InputError("the shape is too thin and wide for so many grid points", fix="ask for fewer points")
        if size and size + cells > 2_000_000:
            results += _evaluate_batch(box, batch, target)
            batch, size = [], 0
        if cells:
            batch.append((grid, lines))
            size += cells
    return results + (_evaluate_batch(box, batch, target) if batch else [])


def _evaluate_batch(box: _Box, batch: list, target: int) -> list[tuple]:
    rays = [np.column_stack((np.repeat(x, len(y)), np.tile(y, len(x)))) for _, (x, y, _) in batch]
    lines = np.array([(z[0], box.sides[2] / cells[2], len(z)) for (cells, _), (_, _, z) in batch])
    start, step, count = np.repeat(lines, [len(r) for r in rays], axis=0).T
    winding = winding_numbers(box.triangles, np.vstack(rays), start, step, count.astype(np.int64))
    results, position = [], 0
    for grid, lines in batch:
        shape = tuple(len(line) for line in lines)
        inside = winding[position : position + math.prod(shape)].reshape(shape) != 0
        position += inside.size
        points = np.column_stack([line[i] for line, i in zip(lines, np.nonzero(inside), strict=True)])
        results.append((len(points), _score(box, points, target), grid, points))
    return results


def _centres(cells: int, phase: float, low: float, side: float) -> Array:
    """Grid coordinates strictly inside one side of the box."""
    index = np.arange(1 if phase == 0 else 0, cells)
    return np.asarray(low + side / cells * (index + phase), float)


def _score(box: _Box, points: Array, target: int) -> float:
    """Mismatch of a grid: of centroid and second moment of equal point masses against the solid's own (whitened: 0.1
    is a tenth of the solid's standard deviation or variance along some axis), plus the relative error in count.

    Mere points, as PMD uses them: with the cells' own inertia counted, its median COM error on twelve tools was 0.99 %
    in place of 0.77 %.
    """
    share = len(points) / target
    if not FEWEST <= share <= MOST:
        return np.inf if len(points) == 0 else 10.0 + abs(np.log(share))
    penalty = abs(share - 1)
    centroid = points.mean(axis=0)
    second = (points - centroid).T @ (points - centroid) / len(points)
    first_error = box.whitening @ (centroid - box.centroid)
    second_error = box.whitening @ second @ box.whitening.T - np.eye(3)
    mismatch = np.sqrt((first_error**2).sum() + (second_error**2).sum())
    return round(penalty + float(mismatch), 6)  # mirrored grids tie, whatever the rounding: the first one wins
