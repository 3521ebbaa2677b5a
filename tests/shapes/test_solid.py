"""The inside of meshes against solid angles, and meshes that are broken: nearly the
same solid."""

from itertools import product

import numpy as np
import pytest
import trimesh

from hefting.shapes import Shape
from hefting.shapes.solid import solid_from_mesh
from hefting.shapes.winding import points_inside
from solids import SOLIDS, winding

# inside


@pytest.mark.parametrize("name", SOLIDS)
def test_inside_agrees_with_solid_angles(name):
    mesh = SOLIDS[name]
    lo, hi = mesh.bounds
    p = np.random.default_rng(5).uniform(
        lo - 0.1 * (hi - lo), hi + 0.1 * (hi - lo), (150, 3)
    )
    solid = solid_from_mesh(mesh.vertices, mesh.faces)
    np.testing.assert_array_equal(
        points_inside(solid.vertices[solid.faces], p), winding(mesh.triangles, p) > 0.5
    )


def test_rays_through_edges_and_corners_count_once():
    # vertices and diagonals all over the lattice below
    mesh = trimesh.creation.box((2, 2, 2)).subdivide()
    p = np.array(list(product([-1.5, -0.5, 0, 0.5, 1.5], repeat=3)))
    np.testing.assert_array_equal(
        points_inside(mesh.triangles, p), (np.abs(p) < 1).all(axis=1)
    )


# parts that overlap


def _gripper(*, thin, copies=1):
    """A housing, a plate and a rod that stick in one another, as separate parts."""
    housing = trimesh.creation.cylinder(0.04, 0.12)
    plate = trimesh.creation.box(bounds=[[-0.06, -0.03, 0.03], [0.07, 0.03, 0.08]])
    rod = trimesh.creation.cylinder(0.001 if thin else 0.015, 0.25)
    parts = [housing, plate, rod]
    together = trimesh.util.concatenate(parts * copies)
    together.vertices += np.repeat(
        np.arange(copies) * 1e-5, len(together.vertices) // copies
    )[:, None]
    return together, trimesh.boolean.union(parts, engine="manifold")


@pytest.mark.parametrize(("thin", "copies"), [(False, 1), (True, 1), (False, 2)])
def test_what_is_in_two_parts_counts_once(thin, copies):
    parts, union = _gripper(thin=thin, copies=copies)
    found, known = Shape.from_mesh(parts), Shape.from_mesh(union)
    scale = float(np.trace(known.homogeneous.inertia_at_com))
    body, points = known.homogeneous, found.cell_matrix @ found.volumes
    moved = found.homogeneous.center_of_mass - body.center_of_mass
    assert np.abs(moved).max() < 1e-4
    turned = found.homogeneous.inertia_at_com - body.inertia_at_com
    assert np.abs(turned).max() < 1e-3 * scale
    assert np.abs(points - body.vector)[1:4].max() < 2e-3
    assert np.abs(points - body.vector)[4:].max() < 5e-3 * scale


# meshes that are broken


def _without(share):
    return lambda v, f, rng: (v, f[rng.random(len(f)) > share])


def _cut(v, f, rng):
    centre = v[f].mean(axis=1)
    return v, f[centre[:, 0] < np.quantile(centre[:, 0], 0.97)]


def _half_flipped(v, f, rng):
    flip = rng.random(len(f)) < 0.4
    return v, np.where(flip[:, None], f[:, ::-1], f)


def _patches(v, f, rng):
    """Six patches that share no vertices, every other one finer: seams full of
    T-junctions."""
    mesh = trimesh.Trimesh(v, f, process=False)
    side = np.abs(mesh.face_normals).argmax(axis=1) * 2 + (
        mesh.face_normals.sum(axis=1) > 0
    )
    parts = [
        mesh.submesh([np.flatnonzero(side == s)], append=True) for s in np.unique(side)
    ]
    joined = trimesh.util.concatenate(
        [part.subdivide() if i % 2 else part for i, part in enumerate(parts)]
    )
    return joined.vertices, joined.faces


BREAKS = {
    "1% of faces missing": (_without(0.01), 1e-3),
    "10% of faces missing": (_without(0.10), 5e-3),
    "end cut off": (_cut, 0.06),
    "orientation mixed": (_half_flipped, 1e-9),
    "inside out": (lambda v, f, rng: (v, f[:, ::-1]), 1e-9),
    "no shared vertices": (
        lambda v, f, rng: (v[f].reshape(-1, 3), np.arange(3 * len(f)).reshape(-1, 3)),
        1e-9,
    ),
    "every face twice": (lambda v, f, rng: (v, np.vstack((f, f))), 1e-9),
    "both sides": (lambda v, f, rng: (v, np.vstack((f, f[:, ::-1]))), 1e-9),
    "T-junctions": (_patches, 1e-6),
}


@pytest.mark.parametrize("damage", BREAKS)
@pytest.mark.parametrize("name", ["torus", "cylinder"])
def test_broken_mesh_is_nearly_the_same_solid(name, damage):
    mesh, rng = SOLIDS[name].subdivide(), np.random.default_rng(6)
    whole = solid_from_mesh(mesh.vertices, mesh.faces)
    # what a flat lid over each hole may cut off the volume
    breaks, tolerance = BREAKS[damage]
    solid = solid_from_mesh(*breaks(np.array(mesh.vertices), np.array(mesh.faces), rng))
    assert abs(solid.volume / whole.volume - 1) < tolerance
    lo, hi = mesh.bounds
    p = rng.uniform(lo, hi, (2000, 3))
    before, after = (points_inside(s.vertices[s.faces], p) for s in (whole, solid))
    assert (before & after).sum() >= (1 - 2 * tolerance - 2e-3) * (before | after).sum()


def test_parts_that_are_inside_out_are_turned():
    head = trimesh.creation.box((0.1, 0.03, 0.03))
    grip = trimesh.creation.cylinder(radius=0.012, height=0.2)
    grip.apply_translation((0.0, 0.0, -0.105))
    ball = trimesh.creation.icosphere(2, 0.02).apply_translation((0.08, 0.0, -0.1))
    hole = trimesh.creation.icosphere(2, 0.01).apply_translation((0.08, 0.0, -0.1))
    hole.invert()
    parts = [head, grip, ball, hole]
    right = solid_from_mesh(*_joined(parts))
    expected = sum(part.volume for part in parts)
    assert abs(right.volume / expected - 1.0) < 1e-9
    # an instance that CAD mirrors has its normals inward, and its cavity's outward
    for mirrored in ([grip], [ball, hole], [head, grip], parts):
        for part in mirrored:
            part.invert()
        found = solid_from_mesh(*_joined(parts))
        for part in mirrored:
            part.invert()
        np.testing.assert_allclose(found.volume, right.volume, rtol=1e-9)
        np.testing.assert_allclose(found.centroid, right.centroid, atol=1e-9)


def test_a_cavity_stays_one_where_the_surface_around_it_has_a_hole():
    outer = trimesh.creation.icosphere(3, 0.05)
    inner = trimesh.creation.icosphere(3, 0.03)
    inner.invert()
    whole = solid_from_mesh(*_joined([outer, inner]))
    outer.update_faces(np.arange(len(outer.faces)) > 0)
    holed = solid_from_mesh(*_joined([outer, inner]))
    assert abs(holed.volume / whole.volume - 1.0) < 1e-3


def test_a_cavity_may_touch_the_surface_of_what_it_is_in():
    cup = trimesh.creation.cylinder(radius=0.04, height=0.1)
    room = trimesh.creation.cylinder(radius=0.035, height=0.09)
    room.apply_translation((0.0, 0.0, 0.005)).invert()
    walls = solid_from_mesh(*_joined([cup, room]))
    assert abs(walls.volume / (cup.volume + room.volume) - 1.0) < 1e-9


def _joined(parts):
    mesh = trimesh.util.concatenate(parts)
    return mesh.vertices, mesh.faces


def test_holes_give_nearly_the_same_points_and_a_warning():
    mesh = SOLIDS["torus"]
    keep = np.random.default_rng(7).random(len(mesh.faces)) > 0.1
    holed = trimesh.Trimesh(mesh.vertices, mesh.faces[keep], process=False)
    whole, broken = Shape.from_mesh(mesh), Shape.from_mesh(holed)
    assert abs(whole.n - broken.n) <= 3
    # 1 % of the diameter
    np.testing.assert_allclose(broken.homogeneous.center_of_mass, 0, atol=1e-3)
    assert not whole.warnings
    assert "holes" in broken.warnings[0]


def test_cavity_stays_empty():
    outer = trimesh.creation.icosphere(3, 0.05)
    inner = trimesh.creation.icosphere(3, 0.03)
    inner.invert()
    shape = Shape.from_mesh(trimesh.util.concatenate([outer, inner]), points=300)
    # the cavity's facets reach 1.5 % inward
    assert np.linalg.norm(shape.positions, axis=1).min() > 0.0295
