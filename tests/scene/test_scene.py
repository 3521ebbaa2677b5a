"""Scene: what is drawn, and what is left out because nobody knows it."""

import numpy as np
import pytest
import trimesh

from hefting.core.errors import InputError
from hefting.core.estimate import Estimate
from hefting.core.inertia import InertialParameters
from hefting.scene import depth_of, place_of, scene_of, surface_of
from hefting.scene.surface import coarser
from hefting.shapes import Shape
from hefting.simulation import hammer
from hefting.simulation.demo import POSE

BODY = hammer().parameters


@pytest.fixture(scope="module")
def shape():
    return Shape.from_mesh(hammer().mesh(), pose=POSE)


def estimate(inertia=1e-4, com=1e-3, parameters=BODY, **more):
    J, c = parameters.inertia_at_com, parameters.center_of_mass
    intervals = {
        "mass": np.array((0.9, 1.1)) * parameters.mass,
        "center_of_mass": np.array((c - com, c + com)),
        "inertia_at_com": np.array((J - inertia, J + inertia)),
    }
    return Estimate("test", parameters, samples=9, intervals=intervals, **more)


def test_a_meshs_surface_is_the_mesh_in_sensor_axes(shape):
    surface = surface_of(shape)
    assert surface is not None
    assert surface.is_object
    drawn = trimesh.Trimesh(surface.vertices, surface.faces)
    mesh = hammer().mesh().copy().apply_transform(POSE)
    assert drawn.volume == pytest.approx(mesh.volume, rel=1e-9)  # and faces outward
    np.testing.assert_allclose(drawn.bounds, mesh.bounds, atol=1e-12)
    assert not surface.faces.flags.writeable


def test_a_box_is_no_object_and_nothing_known_has_no_surface():
    box = surface_of(Shape.from_box(-0.1, 0.1, -0.1, 0.1, 0.0, 0.2))
    assert box is not None
    assert not box.is_object
    assert surface_of(Shape.unknown()) is None
    scene = scene_of(shape=Shape.unknown())
    assert scene.surface is None
    assert scene.points is None


def test_a_cloud_is_points_and_not_too_many():
    rng = np.random.default_rng(1)
    scene = scene_of(shape=Shape.from_cloud(rng.uniform(size=(20_000, 3)), points=50))
    assert scene.surface is None
    assert scene.points is not None
    assert scene.points.masses is None
    assert 1000 < len(scene.points.positions) <= 3000


@pytest.mark.parametrize("most", [500, 5000])
def test_a_coarser_surface_is_near_the_fine_one(most):
    """Oracle: distance to the sphere that both approximate."""
    ball = trimesh.creation.icosphere(subdivisions=6, radius=0.1)
    vertices, faces = coarser(ball.vertices, ball.faces, most)
    assert most / 20 < len(faces) <= most
    # n triangles of a grid of pitch p on a sphere of area A: n p² is about 3 A, and a
    # mean of vertices in a cell is less than a cell's diagonal from all of them
    pitch = np.sqrt(3.0 * ball.area / len(faces))
    assert np.abs(np.linalg.norm(vertices, axis=1) - 0.1).max() < np.sqrt(3.0) * pitch
    coarse = trimesh.Trimesh(vertices, faces)
    # chords of cells, and means of their vertices, lie a few times p²/8r within
    assert coarse.volume == pytest.approx(ball.volume, rel=3.0 * (pitch / 0.1) ** 2)
    assert len(np.unique(np.sort(faces, axis=1), axis=0)) == len(faces)
    same = coarser(ball.vertices, ball.faces, len(ball.faces))
    assert same[1] is ball.faces or np.array_equal(same[1], ball.faces)


def test_what_an_estimate_leaves_open_is_not_in_the_scene():
    known = scene_of({"estimate": estimate()}).bodies[0]
    assert known.ellipsoid is not None
    assert known.region is not None
    assert known.missing == ""
    doubt = 1e-4 / BODY.inertia_at_com.diagonal().max()
    assert known.inertia_doubt == pytest.approx(doubt)
    for width, said in ((np.inf, "inertia open"), (0.8, "80 %")):
        wide = width * BODY.inertia_at_com.diagonal().max()
        body = scene_of({"estimate": estimate(inertia=wide)}).bodies[0]
        assert body.ellipsoid is None
        assert said in body.missing
    open_ = estimate(com=np.array((1e-3, 1e-3, np.inf)))
    body = scene_of({"estimate": open_}).bodies[0]
    assert body.region is None
    np.testing.assert_array_equal(np.isnan(body.center), (False, False, True))
    unphysical = InertialParameters.from_com(1.0, np.zeros(3), np.diag((1.0, 1.0, 9.0)))
    body = scene_of({"estimate": estimate(parameters=unphysical)}).bodies[0]
    assert body.missing == "no body has this inertia"


def test_the_interval_of_a_com_that_is_open_in_part_is_in_the_scene():
    half = np.array((0.05, np.inf, np.inf))
    scene = scene_of({"estimate": estimate(com=half, inertia=np.inf)})
    np.testing.assert_allclose(scene.bodies[0].reach, half)
    x = scene.corners[:, 0]
    ends = BODY.center_of_mass[0] + np.array((-0.05, 0.05))
    np.testing.assert_allclose((x.min(), x.max()), ends)


def test_a_huge_region_does_not_make_all_else_tiny(shape):
    scene = scene_of({"estimate": estimate(com=10.0)}, shape)
    sizes = np.ptp(scene.corners, axis=0)
    assert sizes.max() < 4.0 * np.ptp(scene_of(shape=shape).corners, axis=0).max()


def test_masses_are_drawn_on_demand_alone(shape):
    masses = np.random.default_rng(2).uniform(0.0, 0.02, shape.n)
    found = {"estimate": estimate(point_masses=masses)}
    assert scene_of(found, shape).points is None
    points = scene_of(found, shape, masses=True).points
    assert points is not None
    np.testing.assert_array_equal(points.masses, masses)
    np.testing.assert_array_equal(points.positions, shape.positions)
    with pytest.raises(InputError, match="the shape that the estimate was made with"):
        scene_of({"estimate": estimate(point_masses=masses[1:])}, shape, masses=True)


def test_gravity_is_a_few_unit_vectors():
    rng = np.random.default_rng(3)
    gravity = 9.8 * rng.normal(size=(500, 3))
    shown = scene_of(gravity=gravity).gravity
    assert shown is not None
    assert len(shown) == 40
    np.testing.assert_allclose(np.linalg.norm(shown, axis=1), 1.0)
    np.testing.assert_allclose(np.cross(shown[-1], gravity[-1]), 0.0, atol=1e-12)
    assert scene_of(gravity=np.zeros((3, 3))).gravity is None


def test_the_place_of_a_shape_in_words(shape):
    reaches, center = place_of(shape)
    low, high = 1e3 * hammer().mesh().apply_transform(POSE).bounds
    for axis, a, b in zip("xyz", low, high, strict=True):
        assert f"{axis} {a:.1f} to {b:.1f}".replace("-", "−") in reaches
    com = 1e3 * hammer().mesh().apply_transform(POSE).center_mass
    assert f"y {com[1]:.1f}" in center


def test_the_depth_of_a_point_in_a_box():
    box = Shape.from_box(-0.1, 0.1, -0.2, 0.2, 0.0, 0.4)
    assert depth_of(box, (0.0, 0.0, 0.03)) == pytest.approx(0.03)
    assert depth_of(box, (0.0, 0.0, -0.05)) == pytest.approx(-0.05)
