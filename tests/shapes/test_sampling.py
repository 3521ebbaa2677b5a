"""Grids and random points in solids: inside, regular or uniform, as many as wished, and
in the limit the body."""

import numpy as np
import pytest

from hefting.core.inertia import InertialParameters
from hefting.shapes import Shape
from solids import SOLIDS, in_ell, winding


@pytest.mark.parametrize("sampling", ["grid", "random"])
@pytest.mark.parametrize("name", SOLIDS)
def test_points_are_inside(name, sampling):
    mesh = SOLIDS[name]
    shape = Shape.from_mesh(mesh, sampling=sampling, seed=4)
    if sampling == "random":
        assert shape.n == 56
    # whole rows of cells come and go, so that symmetric shapes leave gaps in the counts
    else:
        assert 50 <= shape.n <= 64
    assert (winding(mesh.triangles, shape.positions) > 0.5).all()


def test_points_are_inside_in_closed_form():
    for sampling in ("grid", "random"):
        box = Shape.from_mesh(SOLIDS["box"], points=300, sampling=sampling).positions
        assert (np.abs(box) < [0.05, 0.1, 0.025]).all()
        sphere = Shape.from_mesh(
            SOLIDS["sphere"], points=300, sampling=sampling
        ).positions
        assert (np.linalg.norm(sphere, axis=1) < 0.05).all()
        assert in_ell(
            Shape.from_mesh(SOLIDS["ell"], points=300, sampling=sampling).positions
        ).all()


def test_grid_is_regular():
    shape = Shape.from_mesh(SOLIDS["ring"], points=100)
    for axis in range(3):
        layers = np.unique(np.round(shape.positions[:, axis], 9))
        steps = np.diff(layers) / np.diff(layers).min()
        # positions were rounded to 1e-9 of 1e-2
        np.testing.assert_allclose(steps, np.round(steps), atol=1e-5)


def test_thin_plate_has_a_layer_through_its_middle():
    shape = Shape.from_mesh(SOLIDS["plate"])
    np.testing.assert_allclose(shape.positions[:, 1], 0, atol=1e-12)
    assert len(np.unique(np.round(shape.positions[:, 2], 6))) >= 2


@pytest.mark.parametrize("target", [1, 8, 75, 5000])
@pytest.mark.parametrize("name", ["ell", "sphere", "tilted plate"])
def test_count_is_near_the_wish(name, target):
    n = Shape.from_mesh(SOLIDS[name], points=target).n
    # a whole row of cells comes or goes at once
    assert abs(n - target) <= max(2, 0.1 * target)


def test_density_is_points_over_volume():
    n = Shape.from_mesh(SOLIDS["box"], points_per_cm3=0.5).n  # 1000 cm³
    assert abs(n - 500) <= 25
    assert (
        Shape.from_mesh(SOLIDS["box"], points_per_cm3=0.5, sampling="random").n == 500
    )


@pytest.mark.parametrize("sampling", ["grid", "random"])
@pytest.mark.parametrize("name", ["sphere", "ell", "tilted ring", "plate"])
def test_points_converge_to_the_homogeneous_body(name, sampling):
    mesh, errors = SOLIDS[name], []
    size = np.linalg.norm(mesh.extents)
    for points in (100, 20_000):
        shape = Shape.from_mesh(mesh, points=points, sampling=sampling)
        # equal masses, mere points
        body = InertialParameters(shape.matrix.mean(axis=1))
        c = body.center_of_mass - mesh.center_mass
        J = body.inertia_at_com - mesh.moment_inertia / mesh.volume
        errors.append(max(np.abs(c).max() / size, np.abs(J).max() / size**2))
    # 20,000 random points leave a standard error of 0.3 / sqrt(20000) = 0.002 of the
    # size; grids do better
    assert errors[1] < (2e-3 if sampling == "grid" else 6e-3)
    assert errors[1] < max(errors[0], 1e-3)


def test_same_seed_same_points():
    draw = [
        Shape.from_mesh(SOLIDS["ring"], sampling="random", seed=s).positions
        for s in (1, 1, 2)
    ]
    np.testing.assert_array_equal(draw[0], draw[1])
    assert not np.array_equal(draw[0], draw[2])
    grids = [Shape.from_mesh(SOLIDS["ring"]).positions for _ in range(2)]
    np.testing.assert_array_equal(*grids)


def test_random_points_are_uniform():
    p = Shape.from_mesh(SOLIDS["ell"], points=20_000, sampling="random").positions
    share = (p[:, 1] < 0.01).mean()  # the long arm: 40 of 70 unit squares
    assert abs(share - 4 / 7) < 5 * np.sqrt(0.25 / 20_000)  # five standard errors


def test_a_wire_has_points_along_it():
    """A ray within rounding of the corner that 32 triangles share."""
    trimesh = pytest.importorskip("trimesh")
    shape = Shape.from_mesh(trimesh.creation.cylinder(0.0002, 0.5))
    assert np.ptp(shape.positions[:, 2]) > 0.45
