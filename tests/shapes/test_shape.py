"""Point masses as a body: their inertia, the exact one of the solid, pose, units, and
bad arrays."""

import subprocess
import sys
from dataclasses import replace

import numpy as np
import pytest

from hefting.core.errors import InputError
from hefting.core.inertia import InertialParameters
from hefting.shapes import Shape
from solids import POSE, SOLIDS

# the class


def test_positions_alone_are_enough():
    shape = Shape([[0.0, 0, 0], [0.1, 0.2, 0.3]])
    assert shape.n == 2
    assert shape.volumes is shape.labels is shape.cell_inertia is None
    np.testing.assert_allclose(shape.extents, [0.1, 0.2, 0.3])
    np.testing.assert_allclose(shape.homogeneous.center_of_mass, [0.05, 0.1, 0.15])
    np.testing.assert_array_equal(shape.cell_matrix, shape.matrix)
    np.testing.assert_array_equal(shape.shares, [0.5, 0.5])
    assert (unequal := replace(shape, volumes=[1.0, 3.0])).shares is unequal.volumes


def test_matrix_is_the_sum_of_point_inertias():
    rng = np.random.default_rng(0)
    p, m = rng.normal(size=(9, 3)), rng.uniform(size=9)
    J = sum(
        mi * (pi @ pi * np.eye(3) - np.outer(pi, pi))
        for pi, mi in zip(p, m, strict=True)
    )
    expected = [m.sum(), *(m @ p), *J[np.triu_indices(3)]]
    # sums of 9 numbers of order 1
    np.testing.assert_allclose(Shape(p).matrix @ m, expected, atol=1e-13)


def test_arrays_are_copies_and_read_only():
    source = np.zeros((3, 3))
    shape = Shape(source, volumes=np.ones(3), labels=[0, 1, 1])
    source[:] = 7
    assert not shape.positions.any()
    for array in (
        shape.positions,
        shape.volumes,
        shape.labels,
        shape.matrix,
        shape.pose,
        shape.extents,
    ):
        assert not array.flags.writeable


@pytest.mark.parametrize(
    "arguments",
    [
        {"positions": np.zeros((0, 3))},
        {"positions": np.zeros((4, 2))},
        {"positions": [[np.nan, 0, 0]]},
        {"positions": np.zeros((2, 3)), "volumes": [1.0]},
        {"positions": np.zeros((2, 3)), "volumes": [1.0, -1.0]},
        {"positions": np.zeros((2, 3)), "volumes": [0.0, 0.0]},
        {"positions": np.zeros((2, 3)), "labels": [1]},
        {"positions": np.zeros((2, 3)), "pose": np.diag([1.0, 1, -1, 1])},
    ],
)
def test_bad_arrays_are_refused(arguments):
    with pytest.raises(InputError):
        Shape(**arguments)


def test_import_is_light():
    heavy = "('trimesh', 'scipy.spatial', 'scipy.sparse', 'rtree')"
    code = f"import sys, hefting.shapes; print([name for name in {heavy} if name in sys.modules])"
    found = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=True
    )
    assert found.stdout.strip() == "[]"


# the body


@pytest.mark.parametrize(
    "name", ["box", "sphere", "ell", "plate", "tilted plate", "tilted ring"]
)
def test_homogeneous_is_the_exact_body(name):
    mesh = SOLIDS[name]
    body = Shape.from_mesh(mesh, points=20, pose=POSE).homogeneous
    rotation = POSE[:3, :3]
    com = rotation @ mesh.center_mass + POSE[:3, 3]
    # trimesh integrates in absolute coordinates: far from its origin (1 m) it loses
    # some digits of 1e-16
    np.testing.assert_allclose(body.center_of_mass, com, atol=1e-10)
    inertia = rotation @ (mesh.moment_inertia / mesh.volume) @ rotation.T
    np.testing.assert_allclose(body.inertia_at_com, inertia, atol=1e-9)


def test_box_in_closed_form():
    shape = Shape.from_box(-0.05, 0.05, 0, 0.2, 0.1, 0.15)
    com = [0, 0.1, 0.125]
    J = np.diag([0.2**2 + 0.05**2, 0.1**2 + 0.05**2, 0.1**2 + 0.2**2]) / 12
    for shares in (np.full(shape.n, 1 / shape.n), shape.volumes):
        # the cells fill the box: exact but for rounding
        body = InertialParameters(shape.cell_matrix @ shares)
        np.testing.assert_allclose(body.center_of_mass, com, atol=1e-12)
        np.testing.assert_allclose(body.inertia_at_com, J, atol=1e-12)
    np.testing.assert_allclose(shape.extents, [0.1, 0.2, 0.05])
    assert (shape.positions > [-0.05, 0, 0.1]).all()
    assert (shape.positions < [0.05, 0.2, 0.15]).all()


@pytest.mark.parametrize(
    ("name", "gain"),
    # one layer cannot meet the torus' height
    [("ell", 0.5), ("ring", 0.5), ("tilted ring", 0.5), ("torus", 1.0)],
)
def test_volumes_bring_the_points_nearer_to_the_body(name, gain):
    shape = Shape.from_mesh(SOLIDS[name], points=30)
    assert shape.volumes.min() > 0
    np.testing.assert_allclose(shape.volumes.sum(), 1, rtol=1e-12)
    whole = shape.homogeneous.moved(_centring(shape)).pseudo_inertia
    scale = np.append(np.sqrt(np.diag(whole)[:3]), 1)

    def mismatch(shares):
        found = (
            InertialParameters(shape.cell_matrix @ shares)
            .moved(_centring(shape))
            .pseudo_inertia
        )
        return np.linalg.norm((found - whole) / np.outer(scale, scale))

    # the shares have ten moments to meet and thirty points to do it: they come near,
    # but for damping
    assert mismatch(shape.volumes) < gain * mismatch(np.full(shape.n, 1 / shape.n))


def test_one_layer_with_cells_is_a_body_with_thickness():
    shape = Shape.from_mesh(SOLIDS["plate"])
    assert (
        np.linalg.matrix_rank(
            InertialParameters(shape.matrix @ shape.volumes).pseudo_inertia
        )
        == 3
    )
    assert (
        np.linalg.matrix_rank(
            InertialParameters(shape.cell_matrix @ shape.volumes).pseudo_inertia
        )
        == 4
    )


def _centring(shape):
    pose = np.eye(4)
    pose[:3, 3] = -shape.homogeneous.center_of_mass
    return pose


def test_the_volume_is_that_of_the_surface_or_else_of_the_bounding_box():
    """In either orientation of the faces, wherever it is."""
    mesh = SOLIDS["ell"]
    shape = Shape.from_mesh(mesh, pose=POSE)
    assert shape.volume == pytest.approx(mesh.volume, rel=1e-9)
    assert shape.faces is not None
    turned = replace(shape, faces=shape.faces[:, ::-1])
    assert turned.volume == pytest.approx(mesh.volume, rel=1e-9)
    assert Shape(shape.positions, extents=(0.1, 0.2, 0.3)).volume == 0.1 * 0.2 * 0.3


def test_pose_moves_everything_rigidly():
    still, moved = (Shape.from_mesh(SOLIDS["ell"], pose=pose) for pose in (None, POSE))
    np.testing.assert_allclose(
        moved.positions, still.positions @ POSE[:3, :3].T + POSE[:3, 3], atol=1e-14
    )
    np.testing.assert_allclose(
        moved.homogeneous.vector, still.homogeneous.moved(POSE).vector, atol=1e-14
    )
    ones = np.ones(still.n)
    turned = InertialParameters(still.cell_matrix @ ones).moved(POSE)
    # sums of 56 terms below 1
    np.testing.assert_allclose(moved.cell_matrix @ ones, turned.vector, atol=1e-12)
    np.testing.assert_array_equal(moved.extents, still.extents)


@pytest.mark.parametrize(
    ("unit", "factor"), [("m", 1), ("cm", 100), ("mm", 1000), ("in", 1 / 0.0254)]
)
def test_units(unit, factor):
    mesh = SOLIDS["cylinder"].copy()
    expected = Shape.from_mesh(mesh)
    mesh.apply_scale(factor)
    shape = Shape.from_mesh(mesh, unit=unit)
    np.testing.assert_allclose(shape.positions, expected.positions, atol=1e-12)
    np.testing.assert_allclose(shape.extents, [0.04, 0.04, 0.15], rtol=1e-9)
