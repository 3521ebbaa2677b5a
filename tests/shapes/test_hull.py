"""Depth in a convex hull against closed forms, a linear program, and in any frame."""

import numpy as np
import pytest
from scipy.optimize import linprog
from scipy.spatial.transform import Rotation

from hefting.core.errors import InputError
from hefting.shapes.clouds import Hull, depth_in_hull
from random_problems import random_pose

CUBE = np.array(
    [(x, y, z) for x in (0, 1) for y in (0, 1) for z in (0, 1)], dtype=float
)
SIDES = np.array((0.3, 0.2, 0.05))


def box_depth(x):
    """Depth in the box of `SIDES` with a corner at the origin: least distance to its
    six planes."""
    return float(np.minimum(x, SIDES - x).min())


@pytest.mark.parametrize("seed", range(20))
def test_box(seed):
    """Inside and outside, with points inside the box besides its corners, in any
    frame."""
    rng = np.random.default_rng(seed)
    points = np.vstack((CUBE, rng.uniform(size=(50, 3)))) * SIDES
    pose = random_pose(rng)
    for x in rng.uniform(-0.5, 1.5, (10, 3)) * SIDES:
        depth = box_depth(x)
        # rounding of 0.3 m
        assert depth_in_hull(points, x) == pytest.approx(depth, abs=1e-14)
        moved = points @ pose[:3, :3].T + pose[:3, 3]
        assert depth_in_hull(moved, pose[:3, :3] @ x + pose[:3, 3]) == pytest.approx(
            depth, abs=1e-14
        )


def test_tetrahedron():
    """Corners (0,0,0), (1,0,0), (0,1,0), (0,0,1): three planes through the origin, one
    at distance 1/sqrt(3)."""
    points = np.vstack((np.zeros(3), np.eye(3)))
    inscribed = 1.0 / (3.0 + np.sqrt(3.0))
    assert depth_in_hull(points, np.full(3, inscribed)) == pytest.approx(
        inscribed, abs=1e-15
    )
    assert depth_in_hull(points, np.full(3, 1.0)) == pytest.approx(
        -2.0 / np.sqrt(3.0), abs=1e-15
    )
    # on the face
    assert depth_in_hull(points, np.full(3, 1.0 / 3.0)) == pytest.approx(0.0, abs=1e-15)
    for corner in points:
        assert depth_in_hull(points, corner) == pytest.approx(0.0, abs=1e-15)
    # beside a corner the plane violated most is nearer than the corner itself
    assert depth_in_hull(points, (-0.1, -0.2, -0.3)) == pytest.approx(-0.3, abs=1e-15)


def disc(n=360, radius=0.1):
    angle = 2.0 * np.pi * np.arange(n) / n
    return radius * np.column_stack((np.cos(angle), np.sin(angle), np.zeros(n)))


@pytest.mark.parametrize("seed", range(5))
def test_disc(seed):
    """A flat hull: 0 on it, the distance from its plane above it, beyond its outline
    the larger of the two."""
    rng = np.random.default_rng(seed)
    points, pose = disc(), random_pose(rng)
    outline = 0.1 * np.cos(np.pi / 360)  # distance of its 360 edges

    def depth(x):
        return depth_in_hull(
            points @ pose[:3, :3].T + pose[:3, 3], pose[:3, :3] @ x + pose[:3, 3]
        )

    for x in ((0.0, 0.0), (0.03, -0.05), (0.0, 0.0999)):
        assert depth((*x, 0.0)) == pytest.approx(0.0, abs=1e-15)
        assert depth((*x, 0.02)) == pytest.approx(-0.02, abs=1e-15)
        assert depth((*x, -0.02)) == pytest.approx(-0.02, abs=1e-15)
    edge = np.array((np.cos(np.pi / 360), np.sin(np.pi / 360)))
    assert depth((*(0.15 * edge), 0.02)) == pytest.approx(-(0.15 - outline), abs=1e-14)
    assert depth((*(0.11 * edge), 0.02)) == pytest.approx(-0.02, abs=1e-14)


def test_ball_of_many_points():
    """100,000 points on a sphere; their hull's faces are at most 1 - cos of the largest
    gap, 1e-3, below it."""
    points = np.random.default_rng(1).normal(size=(100_000, 3))
    points /= np.linalg.norm(points, axis=1, keepdims=True)
    x = np.array((0.1, -0.2, 0.3))
    assert depth_in_hull(points, x) == pytest.approx(1.0 - np.linalg.norm(x), abs=1e-3)


def test_box_full_of_points():
    points = (
        np.vstack((CUBE, np.random.default_rng(2).uniform(size=(100_000, 3)))) * SIDES
    )
    x = np.array((0.1, 0.08, 0.02))
    assert depth_in_hull(points, x) == pytest.approx(box_depth(x), abs=1e-14)


@pytest.mark.parametrize("distance", [1.0, 1e3, 1e6])
def test_far_from_the_origin(distance):
    """Coordinates of 1e6 m are rounded to 1e-10 m; solid and flat hulls alike."""
    far = distance * np.array((1.0, -0.7, 0.3))
    rounding = 1e-15 * distance + 1e-15
    x = np.array((0.1, 0.08, 0.02))
    assert depth_in_hull(CUBE * SIDES + far, x + far) == pytest.approx(
        box_depth(x), abs=4 * rounding
    )
    turn = Rotation.from_euler("xyz", (0.3, 0.5, 0.7)).as_matrix()
    flat = (CUBE * SIDES * (1, 1, 0)) @ turn.T + far
    assert depth_in_hull(flat, turn @ (0.1, 0.08, 0.0) + far) == pytest.approx(
        0.0, abs=4 * rounding
    )
    assert depth_in_hull(flat, turn @ (0.1, 0.08, 0.02) + far) == pytest.approx(
        -0.02, abs=4 * rounding
    )


@pytest.mark.parametrize("thickness", [1e-3, 1e-6, 1e-8, 1e-12])
def test_thin_plate(thickness):
    """The middle of a plate is half its thickness deep, down to where it counts as
    flat."""
    rng = np.random.default_rng(3)
    sides, pose = np.array((0.3, 0.2, thickness)), random_pose(rng)
    points = (
        np.vstack((CUBE, rng.uniform(size=(100, 3)))) * sides @ pose[:3, :3].T
        + pose[:3, 3]
    )
    middle = pose[:3, :3] @ (sides / 2) + pose[:3, 3]
    expected = thickness / 2 if thickness > 1e-9 else 0.0  # relative 3e-9
    tolerance = 1e-6 * thickness + 1e-15 if expected else thickness
    assert depth_in_hull(points, middle) == pytest.approx(expected, abs=tolerance)
    assert depth_in_hull(points, middle + 0.1 * pose[:3, 2]) == pytest.approx(
        -0.1 + expected, abs=1e-9
    )


def test_collinear_points():
    rng = np.random.default_rng(4)
    pose = random_pose(rng)
    points = (
        np.outer(rng.permutation(np.linspace(0.0, 0.4, 9)), pose[:3, 0]) + pose[:3, 3]
    )
    for along, off, depth in (
        (0.1, 0.0, 0.0),
        (0.4, 0.0, 0.0),
        (0.1, 0.03, -0.03),
        (0.5, 0.03, -0.1),
        (-0.2, 0.0, -0.2),
    ):
        x = (
            pose[:3, 3]
            + along * pose[:3, 0]
            + off * (0.6 * pose[:3, 1] + 0.8 * pose[:3, 2])
        )
        assert depth_in_hull(points, x) == pytest.approx(depth, abs=1e-15)
        assert depth_in_hull(points[[0, 0]], points[0]) == pytest.approx(0.0, abs=1e-15)
    two = np.array(((0.0, 0.0, 0.0), (0.0, 0.0, 1.0)))
    assert depth_in_hull(two, (0.0, 0.0, 0.3)) == 0.0
    assert depth_in_hull(two, (0.0, 0.0, 1.3)) == pytest.approx(-0.3, abs=1e-15)


def test_one_point():
    point = np.array(((0.1, -2.0, 3.0),))
    for points in (point, np.repeat(point, 7, axis=0)):
        assert depth_in_hull(points, point[0]) == pytest.approx(0.0, abs=1e-15)
        assert depth_in_hull(points, point[0] + (0.3, 0.0, 0.4)) == pytest.approx(
            -0.5, abs=1e-15
        )


@pytest.mark.parametrize("seed", range(30))
def test_sign_is_that_of_a_linear_program(seed):
    """Random hulls of any dimension: x is in the hull if and only if it is a convex
    combination of the points."""
    rng = np.random.default_rng([5, seed])
    points = rng.normal(size=(int(rng.integers(4, 40)), 3))
    points[:, int(rng.integers(1, 4)) :] = 0.0
    pose = random_pose(rng)
    spans = np.ptp(points, axis=0) > 0.0
    for _ in range(5):
        x = 0.7 * rng.normal(size=3) * spans
        P = np.vstack((points.T, np.ones(len(points))))
        inside = (
            linprog(
                np.zeros(len(points)), A_eq=P, b_eq=(*x, 1.0), bounds=(0, None)
            ).status
            == 0
        )
        depth = depth_in_hull(
            points @ pose[:3, :3].T + pose[:3, 3], pose[:3, :3] @ x + pose[:3, 3]
        )
        assert (depth > -1e-13) == inside
        assert spans.all() or depth < 1e-13


def test_input():
    for points in (
        np.zeros((0, 3)),
        np.zeros((4, 2)),
        np.zeros(3),
        np.full((4, 3), np.nan),
    ):
        with pytest.raises(InputError, match="finite points"):
            depth_in_hull(points, np.zeros(3))
    for x in (np.zeros(2), (0.0, np.inf, 0.0)):
        with pytest.raises(InputError, match="three finite numbers"):
            depth_in_hull(CUBE, x)


GRID = np.stack(np.meshgrid(*[np.linspace(0.0, 1.0, 5)] * 3), axis=-1).reshape(-1, 3)
SOLID = {
    "ball": lambda rng: rng.normal(size=(200, 3)),
    "sphere": lambda rng: (lambda u: u / np.linalg.norm(u, axis=1)[:, None])(
        rng.normal(size=(150, 3))
    ),
    "grid": lambda rng: GRID,
    "cylinder": lambda rng: np.array(
        [(*xy, z) for xy in disc(48)[:, :2] for z in (0.0, 0.1, 0.25)]
    ),
    "twice": lambda rng: np.vstack((GRID, GRID)),
    "single precision": lambda rng: (
        (GRID @ random_pose(rng)[:3, :3].T).astype(np.float32).astype(float)
    ),
    "many corners": lambda rng: (lambda u: u / np.linalg.norm(u, axis=1)[:, None])(
        rng.normal(size=(1500, 3))
    ),
}


@pytest.mark.parametrize("name", SOLID)
@pytest.mark.parametrize("seed", range(3))
def test_as_qhull_has_it(name, seed, monkeypatch):
    rng = np.random.default_rng(seed)
    pose, points = random_pose(rng), SOLID[name](rng) * rng.uniform(0.1, 1.0, 3)
    points = points @ pose[:3, :3].T
    own = Hull.of(points)
    monkeypatch.setattr("hefting.shapes.clouds.SMALL_HULL", 0)
    other = Hull.of(points)
    for x in rng.uniform(points.min(axis=0) - 0.1, points.max(axis=0) + 0.1, (50, 3)):
        assert own.depth(x) == pytest.approx(other.depth(x), abs=1e-12)


@pytest.mark.parametrize(
    ("name", "seed"),
    # of many corners once, as a hull of them takes longest
    [(n, seed) for n in SOLID for seed in range(1 if n == "many corners" else 3)],
)
def test_with_few_of_its_faces(name, seed):
    """The depth is that of the whole hull, inside, on a corner and outside."""
    rng = np.random.default_rng(seed)
    pose, points = random_pose(rng), SOLID[name](rng) * rng.uniform(0.1, 1.0, 3)
    points = points @ pose[:3, :3].T
    hull = Hull.of(points)
    inside = rng.dirichlet(np.full(len(points), 0.1), 30) @ points
    outside = rng.uniform(points.min(axis=0) - 0.1, points.max(axis=0) + 0.1, (20, 3))
    for x in (*inside, *outside, points[0], points.mean(axis=0)):
        assert depth_in_hull(points, x) == pytest.approx(hull.depth(x), abs=1e-12)
