"""Random bodies whose truth is known: voxels inside random solids, filled in ways that
no estimator's prior has, and things of several materials (`benchmarks.things`)."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property, partial
from typing import Any

import numpy as np
from scipy.ndimage import distance_transform_edt
from scipy.spatial.transform import Rotation

from benchmarks.things import THINGS
from hefting.core.inertia import InertialParameters
from hefting.core.spatial import Array
from hefting.shapes import Shape
from hefting.simulation import Assembly, Part

FINE = 6000
"""Voxels of the true body."""
POINTS = 56


@dataclass(frozen=True, eq=False)
class Body:
    """A body in the sensor frame."""

    kind: str
    """one of `KINDS`"""
    solid: str
    """key of `SOLIDS` or `THINGS`"""
    shape: Shape
    """what is known of it"""
    parameters: InertialParameters
    """its truth"""
    mesh: Any
    """its surface, in axes of its own"""
    contrast: float
    """standard deviation over mean of its density, by volume"""

    @cached_property
    def numbers(self) -> Array:
        """(16,) mass, COM, inertia about the sensor's origin and about the COM."""
        return sixteen(self.parameters)


def sixteen(body: InertialParameters) -> Array:
    """(16,) mass, COM, inertia about the origin and about the COM: xx, xy, xz, yy, yz,
    zz."""
    rows, columns = np.triu_indices(3)
    tensors = (
        body.inertia_at_origin[rows, columns],
        body.inertia_at_com[rows, columns],
    )
    return np.concatenate(([body.mass], body.center_of_mass, *tensors))


def ends(intervals: dict[str, Array]) -> tuple[Array, Array]:
    """Lower and upper ends (10,) of mass, COM and inertia about the origin."""
    rows, columns = np.triu_indices(3)
    low, high = (
        np.concatenate(
            (
                [intervals["mass"][i]],
                intervals["center_of_mass"][i],
                intervals["inertia_at_origin"][i][rows, columns],
            )
        )
        for i in (0, 1)
    )
    return low, high


def random_body(kind: str, seed: int) -> Body:
    """A body of one of the kinds, of a random solid, size, weight and grasp."""
    rng = np.random.default_rng([seed, *kind.encode()])
    if kind in THINGS:
        solid, (mesh, filling) = kind, THINGS[kind](rng)
    else:
        solid = list(SOLIDS)[rng.integers(len(SOLIDS))]
        mesh, filling = SOLIDS[solid](rng), partial(_FILLINGS[kind], rng)
    pose = np.eye(4)
    pose[:3, :3] = Rotation.random(rng=rng).as_matrix()
    middle = 0.5 * (mesh.vertices.min(axis=0) + mesh.vertices.max(axis=0))
    reach = 0.5 * float(np.ptp(mesh.vertices, axis=0).max())
    aside = rng.normal(size=3)
    pose[:3, 3] = (
        rng.uniform(0.2, 1.0) * reach * aside / np.linalg.norm(aside)
        - pose[:3, :3] @ middle
    )
    fine = Shape.from_mesh(mesh, pose=pose, points=FINE)
    density = filling((fine.positions - pose[:3, 3]) @ pose[:3, :3])
    assert fine.volumes is not None
    masses = fine.volumes * density
    contrast = float(np.sqrt(max(masses @ density / masses.sum() ** 2 - 1.0, 0.0)))
    mass = float(np.exp(rng.uniform(np.log(0.1), np.log(3.0))))
    truth = InertialParameters(fine.cell_matrix @ (mass * masses / masses.sum()))
    if kind == "homogeneous":
        truth = InertialParameters(mass * fine.homogeneous.vector)
    known = Shape.from_mesh(mesh, pose=pose, points=POINTS)
    return Body(kind, solid, known, truth, mesh, contrast)


# solids [m], in the axes of their file


def _box(rng: np.random.Generator):
    return Assembly(
        "box", (Part("box", tuple(rng.uniform(0.02, 0.25, 3)), 1.0, (0.0, 0.0, 0.0)),)
    ).mesh()


def _cylinder(rng: np.random.Generator):
    size = (float(rng.uniform(0.015, 0.06)), float(rng.uniform(0.03, 0.3)))
    return Assembly("cylinder", (Part("cylinder", size, 1.0, (0.0, 0.0, 0.0)),)).mesh(
        32
    )


def _polyhedron(rng: np.random.Generator):
    import trimesh

    corners = rng.normal(size=(int(rng.integers(8, 30)), 3)) * rng.uniform(
        0.02, 0.08, 3
    )
    return trimesh.convex.convex_hull(corners)


def _tee(rng: np.random.Generator):
    """A bar with a block across one end, which may be a cylinder: hammers, mallets, Ts
    and Ls."""
    length = rng.uniform(0.1, 0.25)
    width = rng.uniform(0.015, 0.04)
    depth = rng.uniform(0.015, 0.04)
    across, high = rng.uniform(0.05, 0.18), rng.uniform(0.02, 0.05)
    bar = Part("box", (width, depth, length), 1.0, (0.0, 0.0, 0.0))
    aside = rng.uniform(-0.5, 0.5) * across
    if rng.random() < 0.5:
        head = Part(
            "box",
            (across, depth * rng.uniform(1.0, 1.5), high),
            1.0,
            (aside, 0.0, 0.5 * length),
        )
    else:
        turned = np.array(((0.0, 0.0, 1.0), (0.0, 1.0, 0.0), (-1.0, 0.0, 0.0)))
        head = Part(
            "cylinder", (0.75 * high, across), 1.0, (aside, 0.0, 0.5 * length), turned
        )
    return Assembly("tee", (bar, head)).mesh(32)


def _aitch(rng: np.random.Generator):
    a, b, c = rng.uniform(0.1, 0.25), rng.uniform(0.08, 0.2), rng.uniform(0.02, 0.05)
    thick = rng.uniform(0.02, 0.05)
    bars = [Part("box", (a, c, thick), 1.0, (0.0, y, 0.0)) for y in (-0.5 * b, 0.5 * b)]
    spine = Part("box", (c, b, thick), 1.0, (rng.uniform(-0.4, 0.4) * a, 0.0, 0.0))
    return Assembly("aitch", (*bars, spine)).mesh()


SOLIDS: dict[str, Callable] = {
    "box": _box,
    "cylinder": _cylinder,
    "polyhedron": _polyhedron,
    "tee": _tee,
    "aitch": _aitch,
}


# densities (N,) at points x (N, 3)


def _homogeneous(rng: np.random.Generator, x: Array) -> Array:
    return np.ones(len(x))


def _two_material(rng: np.random.Generator, x: Array) -> Array:
    """Two halves, or a part of one: a plane divides them."""
    side = _along(rng, x)
    cut = np.quantile(side, rng.uniform(0.1, 0.9))
    return np.where(side < cut, 1.0, np.exp(rng.uniform(np.log(1.5), np.log(10.0))))


def _hollow(rng: np.random.Generator, x: Array) -> Array:
    """A shell, its inside empty or nearly so."""
    depth = _depth(x)
    wall = rng.uniform(0.15, 0.6) * depth.max()
    return np.where(depth <= max(wall, depth.min()), 1.0, rng.choice((0.0, 0.1, 0.2)))


def _concentrated(rng: np.random.Generator, x: Array) -> Array:
    """Something heavy somewhere inside: a battery, a motor."""
    size = float(np.linalg.norm(np.ptp(x, axis=0)))
    near = (
        np.linalg.norm(x - x[rng.integers(len(x))], axis=1)
        < rng.uniform(0.08, 0.18) * size
    )
    return np.where(near, np.exp(rng.uniform(np.log(4.0), np.log(20.0))), 1.0)


def _graded(rng: np.random.Generator, x: Array) -> Array:
    """Ever denser towards one side."""
    side = _along(rng, x)
    share = (side - side.min()) / np.ptp(side)
    return 1.0 + rng.uniform(1.0, 9.0) * share ** rng.uniform(0.5, 2.0)


def _cavity(rng: np.random.Generator, x: Array) -> Array:
    """A hole somewhere inside."""
    size = float(np.linalg.norm(np.ptp(x, axis=0)))
    hole = (
        np.linalg.norm(x - x[rng.integers(len(x))], axis=1)
        < rng.uniform(0.08, 0.2) * size
    )
    return np.where(hole & (np.count_nonzero(~hole) > 0.2 * len(x)), 0.0, 1.0)


FILLINGS: dict[str, Callable[[np.random.Generator, Array], Array]] = {
    "homogeneous": _homogeneous,
    "two-material": _two_material,
    "hollow": _hollow,
    "concentrated": _concentrated,
    "graded": _graded,
    "cavity": _cavity,
}


def _materials(rng: np.random.Generator, x: Array) -> Array:
    """Two to five materials, from foam to steel, each nearest to a place of its own."""
    seeds = x[rng.integers(len(x), size=int(rng.integers(2, 6)))]
    near = np.argmin(((x[:, None] - seeds) ** 2).sum(axis=2), axis=1)
    return np.exp(rng.uniform(np.log(0.2), np.log(8.0), len(seeds)))[near]


def _insert(rng: np.random.Generator, x: Array) -> Array:
    """Something small and very heavy in or on something very light."""
    middle = x[rng.integers(len(x))]
    apart = np.linalg.norm(x - middle, axis=1)
    near = apart <= np.quantile(apart, rng.uniform(0.03, 0.2))
    return np.where(near, np.exp(rng.uniform(np.log(10.0), np.log(100.0))), 1.0)


MATERIALS: dict[str, Callable[[np.random.Generator, Array], Array]] = {
    "materials": _materials,
    "insert": _insert,
}
_FILLINGS = {**FILLINGS, **MATERIALS}
KINDS = (*FILLINGS, *MATERIALS, *THINGS)
"""Classes of bodies."""


def _along(rng: np.random.Generator, x: Array) -> Array:
    direction = rng.normal(size=3)
    return x @ (direction / np.linalg.norm(direction))


def _depth(x: Array) -> Array:
    """(N,) [m] distance of voxels on a grid, which may be turned, to the nearest place
    without one."""
    from scipy.spatial import KDTree

    step = float(np.median(KDTree(x).query(x[::50], k=2)[0][:, 1]))
    low = x.min(axis=0)
    index = np.round((x - low) / (1.3 * step)).astype(int) + 1
    filled = np.zeros(index.max(axis=0) + 2, dtype=bool)
    filled[tuple(index.T)] = True
    return np.asarray(distance_transform_edt(filled))[tuple(index.T)] * 1.3 * step
