"""The modular test object of the paper in its eight configurations.

A printed H with ten closed cylindrical pockets, each empty or with a weight of steel or
ABS (Nadeau et al. 2022, sec. V-A; dimensions from the authors' generator), without
bolts. Parameters are the exact sum over its parts, with negative ones for holes.
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import reduce
from itertools import product
from operator import add

import numpy as np

from hefting.core.errors import InputError, nearest
from hefting.core.spatial import Array, tensor_to_vector
from hefting.shapes import Shape
from hefting.simulation.objects import Assembly, HeldObject, Part

PLA, STEEL_WEIGHT, ABS_WEIGHT = 491.0, 7847.0, 1321.0
"""Densities [kg/m³] of the print (20 % infill) and of the weights."""

SLOTS = (
    (-65.0, 125.0), (0.0, 125.0), (65.0, 125.0), (0.0, 75.0), (0.0, 25.0),
    (0.0, -25.0), (0.0, -75.0), (-65.0, -125.0), (0.0, -125.0), (65.0, -125.0),
)  # fmt: skip
"""Places of the pockets W0 to W9 in the H [mm]."""

BOLT_HOLES = (
    *((0.0, y) for y in (-150.0, -100.0, -50.0, 0.0, 50.0, 100.0, 150.0)),
    *((x, y) for x in (-90.0, -40.0, 40.0, 90.0) for y in (-125.0, 125.0)),
)
"""Places of the fifteen holes for bolts [mm]."""

THICKNESS = 0.050
"""Thickness of the H [m], from z = 0."""

POCKET = (0.015, 0.0254)
WEIGHT = (0.0127, 0.0254)
BOLT_HOLE = (0.0033, THICKNESS)
BOSS = (0.0075, THICKNESS)
"""Radius and height [m]."""

PAPER_VOLUME = 1400.0
"""Volume [cm³] for which the paper's 56 points are 0.04 points/cm³."""

PAPER_DENSITIES = (0.04, 0.09)
"""Densities of points [1/cm³] that the paper compares; it chooses the first."""

GRASPED = 5
"""Slot by which the object is held, as by the paper's authors."""

UNEVEN = 1.8
"""Largest ratio of the sides of a grid's cells."""

SECTIONS = 32
"""Number of sides of the prisms for bolt holes in the mesh."""


@dataclass(frozen=True)
class Filling:
    """Slots with weights of steel and of ABS."""

    steel: tuple[int, ...]
    abs: tuple[int, ...] = ()


MODULAR = {
    "hammer": Filling((0, 1, 2, 3), (4, 5, 6, 8)),
    "barbell": Filling((0, 1, 2, 7, 8, 9), (3, 4, 5, 6)),
    "tee": Filling((0, 1, 2, 3, 4, 5, 6)),
    "uniform": Filling(tuple(range(10))),
    "corners": Filling((0, 2, 7, 9)),
    "rod": Filling((1, 3, 4, 5, 6, 8)),
    "half-n-half": Filling((0, 1, 2, 3, 4), (5, 6, 7, 8, 9)),
    "empty": Filling(()),
}
"""The eight configurations."""


def modular(name: str) -> Assembly:
    """One of the eight configurations (`MODULAR`), in the frame of its mesh, with the
    origin in the middle of one face. Raises `InputError` for another name.
    """
    if name.lower() not in MODULAR:
        fix = f"choose one of {', '.join(MODULAR)}"
        what = f"'{name}' is no configuration of the modular object{nearest(name, MODULAR)}"
        raise InputError(what, fix=fix)
    filling = MODULAR[name.lower()]
    middle = 0.5 * THICKNESS
    turned = np.diag((-1.0, -1.0, 1.0))
    outline = (
        Part("box", (0.200, 0.050, THICKNESS), PLA, (0.0, 0.125, middle)),
        Part("box", (0.200, 0.050, THICKNESS), PLA, (0.0, -0.125, middle)),
        Part("box", (0.050, 0.200, THICKNESS), PLA, (0.0, 0.0, middle)),
        Part("half cylinder", BOSS, PLA, (0.0, 0.150, middle)),
        Part("half cylinder", BOSS, PLA, (0.0, -0.150, middle), turned),
        *(
            Part("cylinder", BOLT_HOLE, -PLA, _at(place, middle))
            for place in BOLT_HOLES
        ),
    )
    inside = [Part("cylinder", POCKET, -PLA, _at(place, middle)) for place in SLOTS]
    for density, slots in ((STEEL_WEIGHT, filling.steel), (ABS_WEIGHT, filling.abs)):
        inside += [
            Part("cylinder", WEIGHT, density, _at(SLOTS[slot], middle))
            for slot in slots
        ]
    return Assembly(name.lower(), (*outline, *inside), outline)


def grasp() -> Array:
    """Pose (4, 4) of the object in the sensor frame: the face at z = 0 is on the flange,
    the slot `GRASPED` at its centre."""
    pose = np.eye(4)
    pose[:2, 3] = -1e-3 * np.array(SLOTS[GRASPED])
    return pose


def held_modular(name: str) -> HeldObject:
    """A configuration held by `grasp`, with its visible surface: with bolt holes, without
    pockets."""
    return HeldObject.of(modular(name), grasp(), sections=SECTIONS)


def paper_points(held: HeldObject, points_per_cm3: float = PAPER_DENSITIES[0]) -> Shape:
    """A regular grid in a modular object, in the sensor frame: 56 points at 0.04
    points/cm³, 126 at 0.09.

    The paper's numbers of points are those of an object with `PAPER_VOLUME`; 56 cells of
    40 x 25 x 25 mm have exactly 0.04 points/cm³. Among centred grids of nearly cubic
    cells with this number of centres in the H, that one is chosen whose equal point
    masses have the second moments nearest to the H's; if there is none, the grid of
    `Shape.from_mesh` of about as many. Raises `InputError` for less than one point.
    """
    wanted = round(PAPER_VOLUME * points_per_cm3)
    base = held.points(points=wanted)
    grids = list(_grids(wanted))
    if not grids:
        return base
    points, cell = min(grids, key=lambda grid: _mismatch(grid[0]))
    rotation = held.pose[:3, :3]
    square = np.square(cell) / 12.0
    inertia = (rotation * (square.sum() - square)) @ rotation.T
    return replace(
        base,
        positions=points @ rotation.T + held.pose[:3, 3],
        volumes=None,
        cell_inertia=np.tile(tensor_to_vector(inertia), (wanted, 1)),
    )


def _bars() -> tuple[Part, ...]:
    """The H without its holes and bosses."""
    return tuple(part for part in modular("empty").parts if part.solid == "box")


def _grids(count: int) -> Iterator[tuple[Array, Array]]:
    """Centres (count, 3) and sides (3,) [m] of grids with `count` centres in the H."""
    corners = [
        (
            np.array(bar.center) - np.divide(bar.size, 2),
            np.array(bar.center) + np.divide(bar.size, 2),
        )
        for bar in _bars()
    ]
    low = np.min([low for low, _ in corners], axis=0)
    high = np.max([high for _, high in corners], axis=0)
    about = (high - low) / np.cbrt(1e-6 * PAPER_VOLUME / count)
    for cells in product(
        *(range(max(1, int(0.6 * number)), int(1.7 * number) + 2) for number in about)
    ):
        cell = (high - low) / cells
        if cell.max() > UNEVEN * cell.min():
            continue
        lines = (low[i] + cell[i] * (np.arange(cells[i]) + 0.5) for i in range(3))
        centres = np.stack(np.meshgrid(*lines, indexing="ij"), axis=-1).reshape(-1, 3)
        inside = np.any(
            [((centres > a) & (centres < b)).all(axis=1) for a, b in corners], axis=0
        )
        if inside.sum() == count:
            yield centres[inside], cell


def _mismatch(points: Array) -> float:
    """Relative difference of the second moments of equal point masses and of the H."""
    bars = reduce(add, (bar.parameters for bar in _bars()))
    second = bars.pseudo_inertia[:3, :3] / bars.mass
    return float(
        np.linalg.norm(
            (points.T @ points / len(points) - second)
            / np.sqrt(np.outer(*[np.diag(second)] * 2))
        )
    )


def _at(place: tuple[float, float], z: float) -> tuple[float, float, float]:
    return 1e-3 * place[0], 1e-3 * place[1], z
