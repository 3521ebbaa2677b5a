"""Convex solids of links: they hold what they stand for, and little more."""

import numpy as np
import pytest
import trimesh

from folding_arm import folding_arm
from hefting.planning.solids import (
    MOST_SOLIDS,
    MOST_TRIANGLES,
    convex_parts,
    read_links,
    solid_of,
    solids_of_links,
)
from hefting.robots.robot import Robot
from hefting.robots.urdf import read_urdf
from hefting.shapes.clouds import Hull


def bent():
    """An L of two boxes, 0.4 m and 0.3 m long and 0.1 m thick."""
    first = trimesh.creation.box(bounds=[[0, 0, 0], [0.4, 0.1, 0.1]])
    second = trimesh.creation.box(bounds=[[0, 0.1, 0], [0.1, 0.4, 0.1]])
    return trimesh.util.concatenate([first, second])


def volume(points):
    return trimesh.convex.convex_hull(points).volume


def test_parts_of_a_bent_link_leave_its_corner_free():
    mesh = bent()
    parts = convex_parts(np.asarray(mesh.vertices), np.asarray(mesh.faces))
    # the L's own volume is 0.007 m³, its hull's 0.0115
    assert sum(map(volume, parts)) < 1.25 * mesh.volume < volume(mesh.vertices)
    corner = np.array([0.3, 0.3, 0.05])
    assert all(Hull.of(part).depth(corner) < 0.0 for part in parts)


@pytest.mark.parametrize("seed", range(2))
def test_parts_cover_the_surface(seed):
    """Random points of a random surface are in one part at least."""
    rng = np.random.default_rng(seed)
    turns = map(
        trimesh.transformations.random_rotation_matrix, rng.uniform(size=(3, 3))
    )
    rods = [trimesh.creation.cylinder(0.05, 0.5, transform=turn) for turn in turns]
    mesh = trimesh.util.concatenate(rods)
    parts = convex_parts(np.asarray(mesh.vertices), np.asarray(mesh.faces))
    assert len(parts) > 1
    points = trimesh.sample.sample_surface(mesh, 100, seed=seed)[0]
    hulls = [Hull.of(part) for part in parts]
    depth = np.array([[hull.depth(p) for hull in hulls] for p in points])
    assert depth.max(axis=1).min() > -1e-9


def test_a_convex_surface_stays_whole():
    mesh = trimesh.creation.icosphere(subdivisions=3)
    (part,) = convex_parts(np.asarray(mesh.vertices), np.asarray(mesh.faces))
    np.testing.assert_array_equal(part, mesh.vertices)


def test_a_very_fine_surface_stays_whole():
    mesh = bent()
    faces = np.tile(np.asarray(mesh.faces), (MOST_TRIANGLES // 12, 1))
    assert len(convex_parts(np.asarray(mesh.vertices), faces)) == 1


def test_round_geometries_are_inside_their_solids(tmp_path):
    radius, height = 0.2, 0.5
    path = tmp_path / "round.urdf"
    path.write_text(
        "<robot name='r'><link name='a'/><link name='b'><collision>"
        '<origin xyz="1 2 3" rpy="0.3 0.5 0.7"/>'
        f'<geometry><cylinder radius="{radius}" length="{height}"/></geometry>'
        f'</collision><collision><geometry><sphere radius="{radius}"/></geometry>'
        "</collision></link><joint name='j' type='fixed'><parent link='a'/>"
        "<child link='b'/></joint></robot>"
    )
    tree = read_urdf(path)
    solids = solids_of_links(str(path), read_links(tree, Robot.from_tree(tree, "b")))
    assert len(solids) == 2
    exact = np.pi * radius**2 * height, 4 / 3 * np.pi * radius**3
    for solid, own in zip(solids, exact, strict=True):
        hull = trimesh.Trimesh(solid.vertices, solid.faces)
        assert hull.is_watertight
        # outside, and by 7 % in volume at most: 162 points of a sphere
        assert own < hull.volume < 1.07 * own
    # the sphere itself
    rng = np.random.default_rng(0)
    on = rng.normal(size=(100, 3))
    on *= radius / np.linalg.norm(on, axis=1)[:, None]
    hull = Hull.of(solids[1].vertices)
    assert min(hull.depth(p) for p in on) > -1e-9


@pytest.mark.parametrize("points", [np.zeros((2, 3)), np.eye(3), np.zeros((9, 3))])
def test_flat_solids_have_a_thickness(points):
    solid = solid_of("flat", 0, points)
    mesh = trimesh.Trimesh(solid.vertices, solid.faces)
    assert mesh.is_watertight
    assert mesh.volume > 0.0
    distance = np.linalg.norm(solid.vertices - solid.center, axis=1)
    assert distance.max() <= solid.radius * (1 + 1e-12)


def test_a_link_of_many_parts_is_one_solid(tmp_path):
    path = folding_arm(tmp_path)
    part = '<collision><geometry><sphere radius="0.01"/></geometry></collision>'
    text = path.read_text().replace(
        '<link name="hand">', '<link name="hand">' + part * MOST_SOLIDS
    )
    path.write_text(text)
    tree = read_urdf(path)
    links = read_links(tree, Robot.from_tree(tree, "tool"))
    solids = solids_of_links(str(path), links)
    assert [solid.name for solid in solids].count("link 'hand'") == 1
