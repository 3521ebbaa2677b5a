"""Parts thinner than a cell of the grid: they have points, and the homogeneous body is
represented exactly; solids without such parts keep their points."""

import numpy as np
import pytest
import trimesh
from scipy.spatial.transform import Rotation

from hefting.core.inertia import InertialParameters
from hefting.shapes import Shape, sampling
from hefting.shapes.solid import solid_from_mesh
from solids import SOLIDS, winding

AXES = {0: np.eye(3)} | {
    seed: Rotation.random(rng=seed).as_matrix() for seed in (1, 2, 3)
}
"""The axes of the file, and three others."""


def moved(mesh, offset):
    mesh.apply_translation(offset)
    return mesh


def cylinder(radius, height, z, sections=48):
    return moved(trimesh.creation.cylinder(radius, height, sections), (0, 0, z))


def prism(radius, height, sections=48):
    """Volume, second moment across and along of a prism with a regular polygon."""
    angle = 2 * np.pi / sections
    area = 0.5 * sections * radius**2 * np.sin(angle)
    polar = area * radius**2 * (2 + np.cos(angle)) / 6
    return area * height, polar * height / 2 + area * height**3 / 12, polar * height


def assembly(name):
    """Mesh, and a function of points (n, 3) that tells those of the thin part."""
    if name == "handle with a rod":
        parts = cylinder(0.02, 0.25, 0.0), cylinder(0.003, 0.76, 0.505)
        return parts, lambda p: p[:, 2] > 0.125
    if name == "block with a plate":
        plate = moved(trimesh.creation.box((0.3, 0.2, 0.001)), (0.2, 0, 0.02))
        return (trimesh.creation.box((0.1, 0.1, 0.1)), plate), lambda p: p[:, 0] > 0.05
    if name == "block with a wire":
        wire = cylinder(0.0005, 0.3, 0.2, 16)
        return (trimesh.creation.box((0.1, 0.1, 0.1)), wire), lambda p: p[:, 2] > 0.05
    if name == "two blocks apart":
        far = moved(trimesh.creation.box((0.004, 0.1, 0.1)), (0.5, 0, 0))
        return (trimesh.creation.box((0.1, 0.1, 0.1)), far), lambda p: p[:, 0] > 0.4
    upright = moved(trimesh.creation.box((0.2, 0.002, 0.3)), (0, -0.149, 0.151))
    return (trimesh.creation.box((0.2, 0.3, 0.002)), upright), lambda p: p[:, 2] > 0.01


NAMES = (
    "handle with a rod",
    "block with a plate",
    "block with a wire",
    "two blocks apart",
    "L of plates",
)


@pytest.mark.parametrize("axes", AXES)
@pytest.mark.parametrize("name", NAMES)
def test_every_part_has_points_that_suit_its_volume(name, axes):
    parts, is_thin = assembly(name)
    mesh, R = trimesh.util.concatenate(parts), AXES[axes]
    mesh.apply_transform(np.block([[R, np.zeros((3, 1))], [np.eye(4)[3:]]]))
    shape = Shape.from_mesh(mesh)
    thin = is_thin(shape.positions @ R)
    share = parts[1].volume / (parts[0].volume + parts[1].volume)
    assert shape.volumes is not None
    # what is in the cells of the block around it belongs to that
    found = shape.volumes[thin].sum()
    assert 0.6 * share < found < 1.01 * share
    # a part too thin for one point has two at least; none has five times its share
    assert max(1, 0.25 * share * shape.n) < thin.sum() <= 5 * share * shape.n + 4
    assert 50 <= shape.n <= 120
    assert not shape.warnings
    apart = parts[1].vertices[:, None] - (shape.positions @ R)[thin]
    assert np.linalg.norm(apart, axis=2).min(axis=1).max() < 0.2


@pytest.mark.parametrize("axes", AXES)
@pytest.mark.parametrize("name", NAMES)
def test_the_homogeneous_body_is_exact(name, axes):
    parts, _ = assembly(name)
    mesh = trimesh.util.concatenate(parts)
    mesh.apply_transform(np.block([[AXES[axes], np.ones((3, 1))], [np.eye(4)[3:]]]))
    shape = Shape.from_mesh(mesh)
    found = shape.cell_matrix @ shape.volumes
    # rounding of coordinates near 1 m
    np.testing.assert_allclose(found, shape.homogeneous.vector, atol=1e-11)
    for inertia in shape.cell_inertia:
        moments = np.linalg.eigvalsh(inertia[[0, 1, 2, 1, 3, 4, 2, 4, 5]].reshape(3, 3))
        assert moments[0] > 0.0
        assert moments[2] <= moments[0] + moments[1] + 1e-12


def test_a_handle_with_a_rod_in_closed_form():
    (handle, across, along), (rod, rod_across, rod_along) = (
        prism(0.02, 0.25),
        prism(0.003, 0.76),
    )
    volume = handle + rod
    z = 0.505 * rod / volume
    xx = across + handle * z**2 + rod_across + rod * (0.505 - z) ** 2
    mesh = trimesh.util.concatenate(assembly("handle with a rod")[0])
    shape = Shape.from_mesh(mesh)
    body = InertialParameters(shape.cell_matrix @ shape.volumes)
    np.testing.assert_allclose(body.center_of_mass, (0, 0, z), atol=1e-9)
    expected = np.diag((xx, xx, along + rod_along)) / volume
    np.testing.assert_allclose(body.inertia_at_com, expected, rtol=1e-6, atol=1e-9)


def test_points_along_the_rod_are_in_it():
    mesh = trimesh.util.concatenate(assembly("handle with a rod")[0])
    points = Shape.from_mesh(mesh).positions
    thin = points[points[:, 2] > 0.14]
    assert (winding(mesh.triangles, thin) > 0.5).all()
    assert (np.diff(np.sort(thin[:, 2])) < 0.2).all()
    assert thin[:, 2].max() > 0.75


@pytest.mark.parametrize("name", SOLIDS)
def test_without_thin_parts_nothing_changes(name, monkeypatch):
    mesh = SOLIDS[name]
    one = Shape.from_mesh(mesh)
    monkeypatch.setattr(sampling, "misses_a_part", lambda *_: False)
    other = Shape.from_mesh(mesh)
    np.testing.assert_array_equal(one.positions, other.positions)
    np.testing.assert_array_equal(one.volumes, other.volumes)


def test_more_points_make_the_rod_thick():
    """From some count on the grid itself has points in it; always in proportion."""
    mesh = trimesh.util.concatenate(assembly("handle with a rod")[0])
    for points in (8, 500, 20_000):
        shape = Shape.from_mesh(mesh, points=points)
        thin = shape.positions[:, 2] > 0.125
        assert thin.any()
        assert shape.volumes[thin].sum() == pytest.approx(0.064, rel=0.45)


def test_a_solid_that_no_grid_point_meets_has_points():
    """Four walls of 0.2 mm, askew."""
    walls = []
    for k in range(4):
        wall = moved(trimesh.creation.box((0.2, 0.0002, 0.1)), (0, 0.1, 0))
        turn = Rotation.from_euler("z", k * np.pi / 2).as_matrix()
        wall.apply_transform(np.block([[turn, np.zeros((3, 1))], [np.eye(4)[3:]]]))
        walls.append(wall)
    mesh = trimesh.util.concatenate(walls)
    solid = solid_from_mesh(mesh.vertices, mesh.faces)
    box = sampling.working_box(solid)
    samples = sampling._cells_alone(box, 56)
    assert 45 <= len(samples.positions) <= 200
    np.testing.assert_allclose(
        samples.volumes @ samples.positions, solid.centroid, atol=1e-12
    )
    shape = Shape.from_mesh(mesh)
    angle = np.arctan2(shape.positions[:, 1], shape.positions[:, 0])
    quarter = np.round(angle / (np.pi / 2)).astype(int) % 4
    assert (np.bincount(quarter, shape.volumes, 4) > 0.15).all()


def test_a_part_too_fine_to_be_looked_for_is_told(monkeypatch):
    monkeypatch.setattr(sampling, "MOST_DIVIDED_CELLS", 10)
    mesh = trimesh.util.concatenate(assembly("handle with a rod")[0])
    (told,) = Shape.from_mesh(mesh).warnings
    assert told.code == "thin-parts"


def test_an_open_shell_is_told():
    """A cup without thickness: it is closed by a lid, and said to have holes."""
    cup = trimesh.creation.cylinder(0.05, 0.1)
    cup.update_faces(cup.triangles_center[:, 2] < 0.049)
    shape = Shape.from_mesh(cup)
    assert [told.code for told in shape.warnings] == ["mesh-holes"]
