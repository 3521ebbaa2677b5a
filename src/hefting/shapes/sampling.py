"""Points inside a solid: the regular grid that matches its moments best, or seeded
random points.

Points inside are those with a winding number other than zero (`hefting.shapes.winding`).
"""

import math
from dataclasses import dataclass
from itertools import product
from operator import itemgetter

import numpy as np

from hefting.core.errors import InputError
from hefting.core.spatial import Array, changed_rows, median
from hefting.shapes.cells import (
    MOST_DIVIDED_CELLS,
    Lattice,
    Moments,
    divided,
    has_missed,
    misses_a_part,
)
from hefting.shapes.solid import Solid
from hefting.shapes.winding import (
    WorkingBox,
    points_inside,
    winding_numbers,
    working_box,
)

MAX_POINTS = 1_000_000
"""Most points a shape may be given."""
MAX_CELLS = 20_000_000
"""Most cells of one grid, or random points drawn for one sample."""
CELLS_LOOKED_AT = 200_000
"""Cells tested in the search of the best grid, which limit the number of grids."""
MOST_UNEVEN = 1.7
"""Longest over shortest side up to which a cell counts as nearly cubic."""
LONGEST_ALONE = 1.6
"""Longest side of the only cell along an axis, in pitches of the wanted cell."""
FARTHEST_PITCH, PITCHES = 0.4, 61
"""Largest logarithm of a pitch that is tried over the wanted one, and number of
pitches, most of them near it."""
GOOD = 0.01
"""Score (see `_scores`) up to which other phases are not tried."""
FEWEST, MOST = 0.9, 1.3
"""Preferred number of points of a grid over the wanted one."""
PHASES = (0.5, 0.0, 0.25, 0.75)
"""Where the first grid point lies in the first cell; 0.5 centres the grid in the
bounding box."""

LATTICE = {
    0.5: (0.0, 0, 0),
    0.0: (-0.5, 1, 1),
    0.25: (-0.25, 0, 1),
    0.75: (-0.75, 1, 0),
}
"""By phase: begin of the first cell that covers the bounding box, in cells from its lower
end, and number of cells without a grid point before and after those with one."""
LARGEST_MISMATCH = 0.3
"""`_mismatch` above which points represent their exact shares of the solid. With 56
points it is 0.23 for one of twelve workshop tools and below 0.05 for the others, but at
least 0.37 where the grid counts a thin part too often or misses it."""
FINER_GRIDS = 12
"""Most grids, each of half the cell, tried for a solid without a grid point inside."""


@dataclass(frozen=True)
class Samples:
    """Points that represent shares of a solid."""

    positions: Array
    """(n, 3) [m] in the axes of the shape's file."""
    volumes: Array
    """(n,) share of the solid's volume of each point, with sum one."""
    cell_second_moment: Array
    """(3, 3) of every point, or (n, 3, 3) of each: second moment of its cell about it per
    unit mass [m²], same axes."""
    missed: bool = False
    """Whether the grid misses parts of the solid that are not divided as it has more than
    `MOST_DIVIDED_CELLS`."""


def sample(solid: Solid, count: int, sampling: str, seed: int) -> Samples:
    """About `count` points in a solid, in a ``"grid"`` or at ``"random"`` by a seed.

    Raises `InputError` for another `sampling`.
    """
    if sampling == "grid":
        return grid_points(solid, count)
    if sampling == "random":
        return random_points(solid, count, seed)
    raise InputError(f"unknown sampling '{sampling}'", fix="use 'grid' or 'random'")


def grid_points(solid: Solid, target: int) -> Samples:
    """Regular grid of cell centres inside a solid, about `target` of them;
    deterministic.

    It lies along the axes of the file, or along the principal axes if these have a
    clearly smaller bounding box. Cells are nearly cubic, with at least one layer through
    each thin direction. Of grids of different pitch and phase the one is chosen whose
    count is near to `target` and whose centroid and second moment as equal point masses
    are nearest to those of the solid. If it misses a part that is thinner than its
    cells, points are added; then, or if it counts such a part too often, all points
    represent their exact shares of the solid (`hefting.shapes.cells`).
    """
    box, volume = working_box(solid), solid.volume
    looked_at = CELLS_LOOKED_AT * volume / (target * np.prod(box.sides))
    budget = int(np.clip(looked_at, 8, 320))
    cell = volume / target
    # the count is about volume / cell; correct for parts the grid misses or favours
    for _ in range(2):
        first = _evaluate(box, _centred(box, cell, 1 + budget // 60), target)
        volumes_inside = [
            count * np.prod(box.sides / cells) for count, _, (cells, _) in first
        ]
        middle = np.clip(median(np.array(volumes_inside)), 0.1 * volume, 3 * volume)
        cell = float(middle) / target
    ranked = _evaluate(box, _centred(box, cell, max(12, budget // 3)), target)
    ranked.sort(key=itemgetter(1))
    best = budget // len(PHASES) ** 3 if ranked[0][1] > GOOD else 0
    grids = [
        (cells, phase)
        for _, _, (cells, _) in ranked[:best]
        for phase in product(PHASES, repeat=3)
    ]
    ranked = [ranked[0], *_evaluate(box, grids, target)]
    count, _, grid = min(ranked, key=itemgetter(1))
    if count == 0:
        return _cells_alone(box, target)
    cells, (positions, lattice) = grid[0], _points(box, grid)
    cell = (box.axes * ((box.sides / cells) ** 2 / 12)) @ box.axes.T
    cell_in_box = box.axes.T @ cell @ box.axes
    volumes = _volumes(box, positions, cell_in_box)
    missed = misses_a_part(box.triangles, lattice)
    uneven = _mismatch(box, positions, volumes, cell_in_box) > LARGEST_MISMATCH
    divisible = lattice.occupied.size <= MOST_DIVIDED_CELLS
    if (missed or uneven) and divisible:
        pieces = divided(box.triangles, lattice, target)
        if uneven or has_missed(pieces, lattice):
            return _samples_of(box, pieces)
    return Samples(positions @ box.axes.T, volumes, cell, missed and not divisible)


def _mismatch(box: WorkingBox, points: Array, shares: Array, cell: Array) -> float:
    """Root of the summed squares of the differences between points (n, 3) with `shares`
    (n,) and the solid: of the centroid, over the radius of gyration, and of the second
    moment, over its square."""
    offset = points - box.centroid
    mean = shares @ offset
    second = (offset * shares[:, None]).T @ offset + cell
    root = np.linalg.inv(box.whitening)
    own = root @ root.T
    square = float(np.trace(own))
    difference = np.sum((second - own) ** 2) / square**2
    return float(np.sqrt(mean @ mean / square + difference))


def _cells_alone(box: WorkingBox, target: int) -> Samples:
    """About `target` points in a solid so thin that no grid has a point inside: those of
    its shares of the cells of a grid."""
    cell, pieces = float(np.prod(box.sides)) / target, None
    for _ in range(FINER_GRIDS):
        cells = _centred(box, cell, 1)[0][0]
        if math.prod(cells) > MOST_DIVIDED_CELLS:
            break
        empty = Lattice(box.low, box.sides / cells, np.zeros(cells, dtype=bool))
        pieces = divided(box.triangles, empty, target, target)
        if len(pieces.volume) >= FEWEST * target:
            break
        cell *= 0.5
    if pieces is None:
        raise InputError(
            "no grid point falls inside the shape", fix="ask for more points"
        )
    return _samples_of(box, pieces)


def _samples_of(box: WorkingBox, pieces: Moments) -> Samples:
    volume = pieces.volume
    return Samples(
        pieces.centroids @ box.axes.T,
        volume / volume.sum(),
        box.axes @ pieces.central @ box.axes.T,
    )


def random_points(solid: Solid, count: int, seed: int) -> Samples:
    """`count` independent, uniformly distributed points inside a solid, by a `seed`."""
    box, rng = working_box(solid), np.random.default_rng(seed)
    share = min(1.0, solid.volume / float(np.prod(box.sides)))
    batch = int(np.clip(1.2 * count / share + 16, 64, 1_000_000))
    parts, total, drawn = [], 0, 0
    while total < count:
        if drawn > max(MAX_CELLS, 20 * count):
            what = "the shape fills too little of its bounding box for random points"
            raise InputError(what, fix="use a grid")
        points = box.low + box.sides * rng.random((batch, 3))
        inside = points_inside(box.triangles, points)
        parts.append(points[inside])
        total, drawn = total + int(inside.sum()), drawn + batch
    positions = np.concatenate(parts)[:count]
    cell = np.eye(3) * (solid.volume / count) ** (2 / 3) / 12
    return Samples(positions @ box.axes.T, _volumes(box, positions, cell), cell)


def _volumes(box: WorkingBox, points: Array, cell: Array) -> Array:
    """Nearly equal shares of volume (n,) with which the points have the solid's centroid
    and second moment.

    Least squares in the nine moments, damped where the points cannot fit them (as in a
    single layer), with the change scaled down so that no share is below a quarter of an
    equal one.
    """
    w = (points - box.centroid) @ box.whitening.T
    i, j = np.triu_indices(3)
    moments = np.column_stack(
        (w, w[:, i] * w[:, j] + (box.whitening @ cell @ box.whitening.T)[i, j])
    )
    mean = moments.mean(axis=0)
    moments -= mean  # so that the sum of the shares stays one
    damped = moments.T @ moments / len(w) + 1e-3 * np.eye(9)
    wanted = np.append(np.zeros(3), np.eye(3)[i, j])
    change = moments @ np.linalg.solve(damped, wanted - mean)
    length = min(1.0, 0.75 / max(-float(change.min()), 1e-12))
    shares = 1 + length * change
    return shares / shares.sum()


def _centred(box: WorkingBox, cell: float, number: int) -> list[tuple]:
    """Up to `number` grids (cells along each side, phases) of nearly cubic cells of
    about the volume `cell`."""
    low, high = 0.0, float(box.sides.max())
    sides = box.sides.tolist()
    # bisection for the pitch h at which the product of min(h, side) is `cell`
    for _ in range(60):
        middle = 0.5 * (low + high)
        small = math.prod(min(middle, side) for side in sides) < cell
        low, high = (middle, high) if small else (low, middle)
    pitch = high * np.exp(FARTHEST_PITCH * np.linspace(-1, 1, PITCHES) ** 3)
    pitch = pitch[:, None, None]
    cells = np.floor(box.sides / pitch) + np.indices((3, 3, 3)).reshape(3, 27).T
    cells = np.maximum(cells, 1).reshape(-1, 3)
    cells = cells[np.lexsort(cells.T[::-1])]
    cells = cells[changed_rows(cells)]
    size = box.sides / cells
    longest = np.where(cells > 1, size, 0).max(axis=1)
    uneven = longest / np.where(cells > 1, size, np.inf).min(axis=1)
    # a side of one cell may be short, but not long
    even = (uneven < MOST_UNEVEN) & (size * (cells == 1) <= LONGEST_ALONE * high).all(
        axis=1
    )
    cells = cells[even] if even.any() else cells
    deviation = np.abs(np.log(np.prod(box.sides / cells, axis=1) / cell))
    chosen = cells[np.argsort(deviation, kind="stable")[:number]].astype(int)
    return [(tuple(row), (0.5,) * 3) for row in chosen.tolist()]


def _evaluate(box: WorkingBox, grids: list, target: int) -> list[tuple]:
    """(count, score, grid) of every grid (cells, phases) that has points, in batches of
    bounded memory."""
    results, batch, size = [], [], 0
    known: dict[tuple, Array] = {}
    for grid in grids:
        lines = []
        for axis, line in enumerate(zip(*grid, strict=True)):
            if (axis, line) not in known:
                known[axis, line] = _centres(
                    line[0], line[1], box.low[axis], box.sides[axis]
                )
            lines.append(known[axis, line])
        cells = math.prod(len(line) for line in lines)
        if cells > MAX_CELLS:
            what = "the shape is too thin and wide for so many grid points"
            raise InputError(what, fix="ask for fewer points")
        if size and size + cells > 2_000_000:
            results += _evaluate_batch(box, batch, target)
            batch, size = [], 0
        if cells:
            batch.append((grid, lines))
            size += cells
    return results + (_evaluate_batch(box, batch, target) if batch else [])


def _evaluate_batch(box: WorkingBox, batch: list, target: int) -> list[tuple]:
    """As `_evaluate`, for grids with the coordinates of their points along each axis."""
    rays, start, step, count, inside = _inside(box, batch)
    indices = np.flatnonzero(inside)
    end = np.cumsum(count)
    ray = np.searchsorted(end, indices, "right")
    height = start[ray] + step[ray] * (indices - end[ray] + count[ray])
    ends = np.cumsum([0, *(math.prod(map(len, lines)) for _, lines in batch)])
    number = np.diff(np.searchsorted(indices, ends))
    w = (np.column_stack((rays[ray], height)) - box.centroid) @ box.whitening.T
    scores = _scores(w, number, target)
    return [
        (n, score, grid)
        for n, score, (grid, _) in zip(number.tolist(), scores, batch, strict=True)
    ]


def _inside(
    box: WorkingBox, batch: list
) -> tuple[Array, Array, Array, np.ndarray, np.ndarray]:
    """Rays (R, 2) of all grids with their coordinates; start, step and number of the
    points on each ray; and which points are inside."""
    number = [len(x) * len(y) for _, (x, y, _) in batch]
    rays, position = np.empty((sum(number), 2)), 0
    for (_, (x, y, _)), length in zip(batch, number, strict=True):
        part = rays[position : position + length].reshape(len(x), len(y), 2)
        part[..., 0], part[..., 1] = x[:, None], y
        position += length
    lines = np.array(
        [(z[0], box.sides[2] / cells[2], len(z)) for (cells, _), (_, _, z) in batch]
    )
    start, step, count = np.repeat(lines, number, axis=0).T
    count = count.astype(np.int64)
    inside = winding_numbers(box.triangles, rays, start, step, count) != 0
    return rays, start, step, count, inside


def _points(box: WorkingBox, grid: tuple) -> tuple[Array, Lattice]:
    """The points of a grid in the solid, in the working frame, and its lattice."""
    cells, phases = grid
    sides = zip(*grid, box.low, box.sides, strict=True)
    lines = [_centres(*side) for side in sides]
    inside = _inside(box, [(grid, lines)])[-1].reshape([len(line) for line in lines])
    columns = [line[i] for line, i in zip(lines, np.nonzero(inside), strict=True)]
    size = box.sides / cells
    first = np.array([LATTICE[phase][0] for phase in phases])
    around = [LATTICE[phase][1:] for phase in phases]
    lattice = Lattice(box.low + size * first, size, np.pad(inside, around))
    return np.column_stack(columns), lattice


def _centres(cells: int, phase: float, low: float, side: float) -> Array:
    """Coordinates of a grid's points strictly inside one side of the box."""
    index = np.arange(1 if phase == 0 else 0, cells)
    return np.asarray(low + side / cells * (index + phase), float)


def _scores(w: Array, number: np.ndarray, target: int) -> list[float]:
    """Scores of grids: the difference of centroid and second moment of equal point
    masses from those of the solid (whitened: 0.1 is a tenth of the solid's standard
    deviation or variance along some axis), plus the relative error of the count; at
    least 10 for a count outside of `FEWEST` to `MOST`.

    `w` are the whitened points of all grids in turn, `number` of each. They count as
    points, as in PMD: with the inertia of cells its median COM error on twelve tools was
    0.99 % instead of 0.77 %.
    """
    grid = np.repeat(np.arange(len(number)), number)
    i, j = np.triu_indices(3)
    sums = [
        np.bincount(grid, column, len(number)) for column in (*w.T, *(w.T[i] * w.T[j]))
    ]
    with np.errstate(divide="ignore", invalid="ignore"):
        mean = np.array(sums) / number
        share = number / target
        far = 10.0 + np.abs(np.log(share))
    first, second = mean[:3], mean[3:] - mean[i] * mean[j] - (i == j)[:, None]
    mismatch = np.sqrt((first**2).sum(axis=0) + np.where(i == j, 1, 2) @ second**2)
    scores = np.abs(share - 1) + mismatch
    near = (share >= FEWEST) & (share <= MOST)
    # scores of mirrored grids are equal in spite of rounding: the first one wins
    return [
        round(score, 6) if close else other
        for score, close, other in zip(scores.tolist(), near, far.tolist(), strict=True)
    ]
