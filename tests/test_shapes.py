"""Shapes -> point masses: laws, closed forms, and an inside test that shares no code with the library."""

import json
import os
import struct
import subprocess
import sys
from itertools import product
from pathlib import Path

import numpy as np
import pytest
import trimesh
from scipy.spatial.transform import Rotation

from hefting.errors import InputError
from hefting.inertia import InertialParameters
from hefting.shapes import PointMasses, load_shape, parse_pose
from hefting.shapes.inside import points_inside
from hefting.shapes.solid import solid_from_mesh
from hefting.spatial import pose_matrix

DATA = os.environ.get("HEFTING_DATA")
needs_data = pytest.mark.skipif(not DATA, reason="HEFTING_DATA does not name the folder of recordings")
TOOLS = sorted(Path(DATA).glob("workshop-tools/*/mesh.ply")) if DATA else []


def winding(triangles, points):
    """Generalised winding numbers by solid angles (Van Oosterom & Strackee 1983): the oracle for "inside"."""
    a, b, c = (triangles[None, :, i] - points[:, None] for i in range(3))
    la, lb, lc = (np.linalg.norm(x, axis=-1) for x in (a, b, c))
    dot = np.einsum
    above = dot("pfi,pfi->pf", a, np.cross(b, c))
    below = la * lb * lc + dot("pfi,pfi->pf", a, b) * lc
    below += dot("pfi,pfi->pf", b, c) * la + dot("pfi,pfi->pf", c, a) * lb
    return np.arctan2(above, below).sum(axis=1) / (2 * np.pi)


def rotated(mesh, seed=3):
    turned = mesh.copy()
    turned.apply_transform(np.block([[Rotation.random(rng=seed).as_matrix(), np.ones((3, 1))], [np.eye(4)[3:]]]))
    return turned


def ell():
    """An L of 40 x 40 x 20 mm with arms 10 mm wide, as two boxes that share a wall."""
    long = trimesh.creation.box(bounds=[[0, 0, 0], [0.04, 0.01, 0.02]])
    short = trimesh.creation.box(bounds=[[0, 0.01, 0], [0.01, 0.04, 0.02]])
    return trimesh.util.concatenate([long, short])


def in_ell(p):
    in_long = (p > 0).all(axis=1) & (p < [0.04, 0.01, 0.02]).all(axis=1)
    return in_long | ((p > [0, 0.009, 0]).all(axis=1) & (p < [0.01, 0.04, 0.02]).all(axis=1))


SOLIDS = {
    "box": trimesh.creation.box((0.1, 0.2, 0.05)),
    "sphere": trimesh.creation.icosphere(3, 0.05),
    "cylinder": trimesh.creation.cylinder(0.02, 0.15),
    "ring": trimesh.creation.annulus(0.03, 0.05, 0.02),
    "torus": trimesh.creation.torus(0.05, 0.01),
    "ell": ell(),
    "plate": trimesh.creation.box((0.165, 0.001, 0.02)),
    "needle": trimesh.creation.box((0.3, 0.001, 0.001)),
    "tilted plate": rotated(trimesh.creation.box((0.165, 0.001, 0.02))),
    "tilted ring": rotated(trimesh.creation.annulus(0.03, 0.05, 0.02)),
}
POSE = pose_matrix([0.1, -0.2, 0.05, *Rotation.random(rng=1).as_quat()])


# the class


def test_positions_alone_are_enough():
    shape = PointMasses([[0.0, 0, 0], [0.1, 0.2, 0.3]])
    assert shape.n == 2
    assert shape.volumes is shape.labels is shape.cell_inertia is None
    np.testing.assert_allclose(shape.extents, [0.1, 0.2, 0.3])
    np.testing.assert_allclose(shape.homogeneous.center_of_mass, [0.05, 0.1, 0.15])
    np.testing.assert_array_equal(shape.cell_matrix, shape.matrix)


def test_matrix_is_the_sum_of_point_inertias():
    rng = np.random.default_rng(0)
    p, m = rng.normal(size=(9, 3)), rng.uniform(size=9)
    J = sum(mi * (pi @ pi * np.eye(3) - np.outer(pi, pi)) for pi, mi in zip(p, m, strict=True))
    expected = [m.sum(), *(m @ p), *J[np.triu_indices(3)]]
    np.testing.assert_allclose(PointMasses(p).matrix @ m, expected, atol=1e-13)  # sums of 9 numbers of order 1


def test_arrays_are_copies_and_read_only():
    source = np.zeros((3, 3))
    shape = PointMasses(source, volumes=np.ones(3), labels=[0, 1, 1])
    source[:] = 7
    assert not shape.positions.any()
    for array in (shape.positions, shape.volumes, shape.labels, shape.matrix, shape.pose, shape.extents):
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
        PointMasses(**arguments)


def test_import_is_light():
    heavy = "('trimesh', 'scipy.spatial', 'scipy.sparse', 'rtree')"
    code = f"import sys, hefting.shapes; print([name for name in {heavy} if name in sys.modules])"
    found = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert found.stdout.strip() == "[]"


# grids and random points


@pytest.mark.parametrize("sampling", ["grid", "random"])
@pytest.mark.parametrize("name", SOLIDS)
def test_points_are_inside(name, sampling):
    mesh = SOLIDS[name]
    shape = PointMasses.from_mesh(mesh, sampling=sampling, seed=4)
    if sampling == "random":
        assert shape.n == 56
    else:  # whole rows of cells come and go, so that symmetric shapes leave gaps in the counts
        assert 50 <= shape.n <= 64
    assert (winding(mesh.triangles, shape.positions) > 0.5).all()


def test_points_are_inside_in_closed_form():
    for sampling in ("grid", "random"):
        box = PointMasses.from_mesh(SOLIDS["box"], points=300, sampling=sampling).positions
        assert (np.abs(box) < [0.05, 0.1, 0.025]).all()
        sphere = PointMasses.from_mesh(SOLIDS["sphere"], points=300, sampling=sampling).positions
        assert (np.linalg.norm(sphere, axis=1) < 0.05).all()
        assert in_ell(PointMasses.from_mesh(SOLIDS["ell"], points=300, sampling=sampling).positions).all()


def test_grid_is_regular():
    shape = PointMasses.from_mesh(SOLIDS["ring"], points=100)
    for axis in range(3):
        layers = np.unique(np.round(shape.positions[:, axis], 9))
        steps = np.diff(layers) / np.diff(layers).min()
        np.testing.assert_allclose(steps, np.round(steps), atol=1e-5)  # positions were rounded to 1e-9 of 1e-2


def test_thin_plate_has_a_layer_through_its_middle():
    shape = PointMasses.from_mesh(SOLIDS["plate"])
    np.testing.assert_allclose(shape.positions[:, 1], 0, atol=1e-12)
    assert len(np.unique(np.round(shape.positions[:, 2], 6))) >= 2


@pytest.mark.parametrize("target", [1, 8, 75, 5000])
@pytest.mark.parametrize("name", ["ell", "sphere", "tilted plate"])
def test_count_is_near_the_wish(name, target):
    n = PointMasses.from_mesh(SOLIDS[name], points=target).n
    assert abs(n - target) <= max(2, 0.1 * target)  # a whole row of cells comes or goes at once


def test_density_is_points_over_volume():
    n = PointMasses.from_mesh(SOLIDS["box"], points_per_cm3=0.5).n  # 1000 cm³
    assert abs(n - 500) <= 25
    assert PointMasses.from_mesh(SOLIDS["box"], points_per_cm3=0.5, sampling="random").n == 500


@pytest.mark.parametrize("sampling", ["grid", "random"])
@pytest.mark.parametrize("name", ["sphere", "ell", "tilted ring", "plate"])
def test_points_converge_to_the_homogeneous_body(name, sampling):
    mesh, errors = SOLIDS[name], []
    size = np.linalg.norm(mesh.extents)
    for points in (100, 20_000):
        shape = PointMasses.from_mesh(mesh, points=points, sampling=sampling)
        body = InertialParameters(shape.matrix.mean(axis=1))  # equal masses, mere points
        c, J = body.center_of_mass - mesh.center_mass, body.inertia_at_com - mesh.moment_inertia / mesh.volume
        errors.append(max(np.abs(c).max() / size, np.abs(J).max() / size**2))
    # 20,000 random points leave a standard error of 0.3 / sqrt(20000) = 0.002 of the size; grids do better
    assert errors[1] < (2e-3 if sampling == "grid" else 6e-3)
    assert errors[1] < max(errors[0], 1e-3)


@pytest.mark.parametrize("name", ["box", "sphere", "ell", "plate", "tilted plate", "tilted ring"])
def test_homogeneous_is_the_exact_body(name):
    mesh = SOLIDS[name]
    body = PointMasses.from_mesh(mesh, points=20, pose=POSE).homogeneous
    rotation = POSE[:3, :3]
    com = rotation @ mesh.center_mass + POSE[:3, 3]
    # trimesh integrates in absolute coordinates: far from its origin (1 m) it loses some digits of 1e-16
    np.testing.assert_allclose(body.center_of_mass, com, atol=1e-10)
    inertia = rotation @ (mesh.moment_inertia / mesh.volume) @ rotation.T
    np.testing.assert_allclose(body.inertia_at_com, inertia, atol=1e-9)


def test_box_in_closed_form():
    shape = PointMasses.from_box(-0.05, 0.05, 0, 0.2, 0.1, 0.15)
    com, J = [0, 0.1, 0.125], np.diag([0.2**2 + 0.05**2, 0.1**2 + 0.05**2, 0.1**2 + 0.2**2]) / 12
    for shares in (np.full(shape.n, 1 / shape.n), shape.volumes):
        body = InertialParameters(shape.cell_matrix @ shares)  # the cells fill the box: exact but for rounding
        np.testing.assert_allclose(body.center_of_mass, com, atol=1e-12)
        np.testing.assert_allclose(body.inertia_at_com, J, atol=1e-12)
    np.testing.assert_allclose(shape.extents, [0.1, 0.2, 0.05])
    assert (shape.positions > [-0.05, 0, 0.1]).all()
    assert (shape.positions < [0.05, 0.2, 0.15]).all()


@pytest.mark.parametrize(
    ("name", "gain"),
    [("ell", 0.5), ("ring", 0.5), ("tilted ring", 0.5), ("torus", 1.0)],  # one layer cannot meet the torus' height
)
def test_volumes_bring_the_points_nearer_to_the_body(name, gain):
    shape = PointMasses.from_mesh(SOLIDS[name], points=30)
    assert shape.volumes.min() > 0
    np.testing.assert_allclose(shape.volumes.sum(), 1, rtol=1e-12)
    whole = shape.homogeneous.moved(_centring(shape)).pseudo_inertia
    scale = np.append(np.sqrt(np.diag(whole)[:3]), 1)

    def mismatch(shares):
        found = InertialParameters(shape.cell_matrix @ shares).moved(_centring(shape)).pseudo_inertia
        return np.linalg.norm((found - whole) / np.outer(scale, scale))

    # the shares have ten moments to meet and thirty points to do it: they come near, but for damping
    assert mismatch(shape.volumes) < gain * mismatch(np.full(shape.n, 1 / shape.n))


def test_one_layer_with_cells_is_a_body_with_thickness():
    shape = PointMasses.from_mesh(SOLIDS["plate"])
    assert np.linalg.matrix_rank(InertialParameters(shape.matrix @ shape.volumes).pseudo_inertia) == 3
    assert np.linalg.matrix_rank(InertialParameters(shape.cell_matrix @ shape.volumes).pseudo_inertia) == 4


def _centring(shape):
    pose = np.eye(4)
    pose[:3, 3] = -shape.homogeneous.center_of_mass
    return pose


def test_pose_moves_everything_rigidly():
    still, moved = (PointMasses.from_mesh(SOLIDS["ell"], pose=pose) for pose in (None, POSE))
    np.testing.assert_allclose(moved.positions, still.positions @ POSE[:3, :3].T + POSE[:3, 3], atol=1e-14)
    np.testing.assert_allclose(moved.homogeneous.vector, still.homogeneous.moved(POSE).vector, atol=1e-14)
    ones = np.ones(still.n)
    turned = InertialParameters(still.cell_matrix @ ones).moved(POSE)
    np.testing.assert_allclose(moved.cell_matrix @ ones, turned.vector, atol=1e-12)  # sums of 56 terms below 1
    np.testing.assert_array_equal(moved.extents, still.extents)


def test_same_seed_same_points():
    draw = [PointMasses.from_mesh(SOLIDS["ring"], sampling="random", seed=s).positions for s in (1, 1, 2)]
    np.testing.assert_array_equal(draw[0], draw[1])
    assert not np.array_equal(draw[0], draw[2])
    grids = [PointMasses.from_mesh(SOLIDS["ring"]).positions for _ in range(2)]
    np.testing.assert_array_equal(*grids)


def test_random_points_are_uniform():
    p = PointMasses.from_mesh(SOLIDS["ell"], points=20_000, sampling="random").positions
    share = (p[:, 1] < 0.01).mean()  # the long arm: 40 of 70 unit squares
    assert abs(share - 4 / 7) < 5 * np.sqrt(0.25 / 20_000)  # five standard errors


@pytest.mark.parametrize(("unit", "factor"), [("m", 1), ("cm", 100), ("mm", 1000), ("in", 1 / 0.0254)])
def test_units(unit, factor):
    mesh = SOLIDS["cylinder"].copy()
    expected = PointMasses.from_mesh(mesh)
    mesh.apply_scale(factor)
    shape = PointMasses.from_mesh(mesh, unit=unit)
    np.testing.assert_allclose(shape.positions, expected.positions, atol=1e-12)
    np.testing.assert_allclose(shape.extents, [0.04, 0.04, 0.15], rtol=1e-9)


# inside, and meshes that are broken


@pytest.mark.parametrize("name", SOLIDS)
def test_inside_agrees_with_solid_angles(name):
    mesh = SOLIDS[name]
    lo, hi = mesh.bounds
    p = np.random.default_rng(5).uniform(lo - 0.1 * (hi - lo), hi + 0.1 * (hi - lo), (150, 3))
    solid = solid_from_mesh(mesh.vertices, mesh.faces)
    np.testing.assert_array_equal(points_inside(solid.vertices[solid.faces], p), winding(mesh.triangles, p) > 0.5)


def test_rays_through_edges_and_corners_count_once():
    mesh = trimesh.creation.box((2, 2, 2)).subdivide()  # vertices and diagonals all over the lattice below
    p = np.array(list(product([-1.5, -0.5, 0, 0.5, 1.5], repeat=3)))
    np.testing.assert_array_equal(points_inside(mesh.triangles, p), (np.abs(p) < 1).all(axis=1))


def _without(share):
    return lambda v, f, rng: (v, f[rng.random(len(f)) > share])


def _cut(v, f, rng):
    centre = v[f].mean(axis=1)
    return v, f[centre[:, 0] < np.quantile(centre[:, 0], 0.97)]


def _half_flipped(v, f, rng):
    flip = rng.random(len(f)) < 0.4
    return v, np.where(flip[:, None], f[:, ::-1], f)


def _patches(v, f, rng):
    """Six patches that share no vertices, every other one finer: seams full of T-junctions."""
    mesh = trimesh.Trimesh(v, f, process=False)
    side = np.abs(mesh.face_normals).argmax(axis=1) * 2 + (mesh.face_normals.sum(axis=1) > 0)
    parts = [mesh.submesh([np.flatnonzero(side == s)], append=True) for s in np.unique(side)]
    joined = trimesh.util.concatenate([part.subdivide() if i % 2 else part for i, part in enumerate(parts)])
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
    breaks, tolerance = BREAKS[damage]  # what a flat lid over each hole may cut off the volume
    solid = solid_from_mesh(*breaks(np.array(mesh.vertices), np.array(mesh.faces), rng))
    assert abs(solid.volume / whole.volume - 1) < tolerance
    lo, hi = mesh.bounds
    p = rng.uniform(lo, hi, (2000, 3))
    before, after = (points_inside(s.vertices[s.faces], p) for s in (whole, solid))
    assert (before & after).sum() >= (1 - 2 * tolerance - 2e-3) * (before | after).sum()


def test_holes_give_nearly_the_same_points_and_a_warning():
    mesh = SOLIDS["torus"]
    keep = np.random.default_rng(7).random(len(mesh.faces)) > 0.1
    holed = trimesh.Trimesh(mesh.vertices, mesh.faces[keep], process=False)
    whole, broken = PointMasses.from_mesh(mesh), PointMasses.from_mesh(holed)
    assert abs(whole.n - broken.n) <= 3
    np.testing.assert_allclose(broken.homogeneous.center_of_mass, 0, atol=1e-3)  # 1 % of the diameter
    assert not whole.warnings
    assert "holes" in broken.warnings[0]


def test_cavity_stays_empty():
    outer, inner = trimesh.creation.icosphere(3, 0.05), trimesh.creation.icosphere(3, 0.03)
    inner.invert()
    shape = PointMasses.from_mesh(trimesh.util.concatenate([outer, inner]), points=300)
    assert np.linalg.norm(shape.positions, axis=1).min() > 0.0295  # the cavity's facets reach 1.5 % inward


# hull, cloud, parts


def test_hull_of_a_surface_cloud_is_filled():
    cloud = SOLIDS["sphere"].vertices
    shape = PointMasses.from_hull(cloud, points=200)
    assert np.linalg.norm(shape.positions, axis=1).min() < 0.02
    np.testing.assert_allclose(shape.homogeneous.center_of_mass, 0, atol=1e-12)
    ring = PointMasses.from_hull(SOLIDS["ring"], points=200)
    assert np.linalg.norm(ring.positions[:, :2], axis=1).min() < 0.02  # the hole is filled


def test_flat_hull_is_refused():
    with pytest.raises(InputError, match="flat"):
        PointMasses.from_hull(np.random.default_rng(0).random((20, 3)) * [1, 1, 0])


def test_cloud_keeps_its_own_points():
    cloud = np.random.default_rng(8).uniform(-0.05, 0.05, (5000, 3)) * [1, 2, 1]
    shape = PointMasses.from_cloud(cloud, points=100)
    assert abs(shape.n - 100) <= 15  # the number of occupied voxels jumps with the pitch
    assert {tuple(p) for p in shape.positions} <= {tuple(p) for p in cloud}
    assert PointMasses.from_cloud(cloud[:20]).n == 20
    dense = PointMasses.from_cloud(cloud, points_per_cm3=0.1)
    assert abs(dense.n - 200) <= 100  # in 2000 cm³; voxels on the border count whole
    body = PointMasses.from_cloud(cloud, points=1000).homogeneous
    np.testing.assert_allclose(body.center_of_mass, 0, atol=0.003)  # 3 % of the half side


@pytest.mark.parametrize("suffix", [".xyz", ".csv", ".txt", ".npy"])
def test_cloud_files(tmp_path, suffix):
    cloud, path = np.random.default_rng(9).random((30, 3)), tmp_path / f"cloud{suffix}"
    if suffix == ".npy":
        np.save(path, cloud)
    elif suffix == ".csv":
        rows = "\n".join(f"{i},{z!r},{y!r},{x!r}" for i, (x, y, z) in enumerate(cloud.tolist()))
        path.write_text("id,z,y,x\r\n" + rows)
    else:
        np.savetxt(path, cloud, header="x y z", fmt="%.17g")
    np.testing.assert_allclose(load_shape(path, unit="cm").positions, cloud / 100, rtol=1e-15)


@pytest.mark.parametrize("form", ["ascii", "binary_little_endian", "binary_big_endian"])
def test_parts_file(tmp_path, form):
    rows = [(0.0, 0.1, 0.2, 2.0, 1), (0.3, 0.4, 0.5, 6.0, 4)]
    header = f"ply\r\nformat {form} 1.0\r\ncomment made by hand\r\nelement vertex 2\r\n"
    header += "".join(f"property double {name}\r\n" for name in ("x", "y", "z", "volume"))
    header += "property uchar segmentation\r\nend_header\r\n"
    if form == "ascii":
        body = "\r\n".join(" ".join(map(str, row)) for row in rows).encode()
    else:
        body = b"".join(struct.pack(("<" if "little" in form else ">") + "ddddB", *row) for row in rows)
    path = tmp_path / "parts.ply"
    path.write_bytes(header.encode() + body)
    shape = load_shape(path, pose=POSE)
    np.testing.assert_array_equal(shape.labels, [1, 4])
    np.testing.assert_allclose(shape.volumes, [0.25, 0.75])
    expected = np.array([row[:3] for row in rows]) @ POSE[:3, :3].T + POSE[:3, 3]
    np.testing.assert_allclose(shape.positions, expected, atol=1e-15)
    com = POSE[:3, :3] @ [0.225, 0.325, 0.425] + POSE[:3, 3]
    np.testing.assert_allclose(shape.homogeneous.center_of_mass, com, atol=1e-15)
    path.write_bytes(header.encode() + body[:-3])
    if form != "ascii":
        with pytest.raises(InputError, match="damaged"):
            load_shape(path)


# what the command line says


@pytest.mark.parametrize("suffix", ["stl", "obj", "ply", "off", "glb"])
def test_mesh_files(tmp_path, suffix):
    path = tmp_path / f"ell.{suffix}"
    mesh = SOLIDS["ell"].copy()
    mesh.apply_scale(1000)
    mesh.export(path)
    shape = load_shape(path, unit="mm", pose=POSE, points=40)
    expected = PointMasses.from_mesh(SOLIDS["ell"], pose=POSE, points=40)
    # .ply, .stl and .glb hold single precision: 6e-8 of 40 mm
    np.testing.assert_allclose(shape.positions, expected.positions, atol=1e-8)


def test_text_mesh_in_another_encoding(tmp_path):
    path = tmp_path / "box.stl"
    text = trimesh.creation.box((0.1, 0.1, 0.1)).export(file_type="stl_ascii")
    path.write_bytes(text.replace("solid ", "solid Gehäuse", 1).encode("latin-1"))
    np.testing.assert_allclose(load_shape(path).extents, 0.1)


def test_box_specification():
    shape = load_shape("box:-0.1,0.1,-0.05,0.05,0,0.2", points=80)
    expected = PointMasses.from_box(-0.1, 0.1, -0.05, 0.05, 0, 0.2, points=80)
    np.testing.assert_array_equal(shape.positions, expected.positions)


@pytest.mark.parametrize(
    "spec", ["box:1,2,3", "box:0,1,0,1,0,0", "box:0,inf,0,1,0,1", "box:a,b,c,d,e,f", "hammer.step"]
)
def test_bad_specifications(spec):
    with pytest.raises(InputError):
        load_shape(spec)


def test_box_takes_no_pose():
    with pytest.raises(InputError, match="sensor frame"):
        load_shape("box:0,1,0,1,0,1", pose=POSE)


def test_pose_as_numbers_and_files(tmp_path):
    seven = [0.1, -0.2, 0.3, *Rotation.from_euler("z", 90, degrees=True).as_quat()]
    expected = [[0, -1, 0, 0.1], [1, 0, 0, -0.2], [0, 0, 1, 0.3], [0, 0, 0, 1]]
    path = tmp_path / "pose.json"
    for text in (",".join(map(str, seven)), json.dumps(seven), json.dumps(expected)):
        source = text
        if text.startswith("["):
            path.write_text(text)
            source = path
        np.testing.assert_allclose(parse_pose(source), expected, atol=1e-15)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("0,0,0,0,0,0,2", "norm 2"),
        ("0,0,0,0,0,1", "not a pose"),
        ("nan,0,0,0,0,0,1", "finite"),
        ("missing.json", "neither"),
        ("[[1,0,0,0],[0,1,0,0],[0,0,-1,0],[0,0,0,1]]", "proper"),
        ("[[1,0,0],[0,1,0],[0,0,1]]", "not a pose"),
        ('{"a": 1}', "not a pose"),
        ("[1, 2", "JSON"),
        ("[" * 99_000, "JSON"),
    ],
)
def test_bad_poses(tmp_path, text, message):
    if text[0] in "[{":
        (tmp_path / "pose.json").write_text(text)
        text = tmp_path / "pose.json"
    with pytest.raises(InputError, match=message):
        parse_pose(text)


# suspicious and hostile input


def test_millimetres_read_as_metres_are_noticed():
    mesh = SOLIDS["box"].copy()
    mesh.apply_scale(1000)
    assert "unit='mm'" in PointMasses.from_mesh(mesh).warnings[0]
    assert "unit='mm'" in PointMasses.from_mesh(mesh, unit=None).warnings[0]
    assert not PointMasses.from_mesh(mesh, unit="mm").warnings
    assert "too small" in PointMasses.from_mesh(SOLIDS["plate"], unit="mm").warnings[0]


def test_distant_shapes_are_noticed():
    for metres, noticed in ((0.1, False), (0.9, False), (2.0, True)):
        warnings = PointMasses.from_mesh(SOLIDS["box"], pose=pose_matrix([metres, 0, 0, 0, 0, 0, 1])).warnings
        assert bool(warnings) == noticed
    (warning,) = PointMasses.from_box(0.8, 0.85, 0, 0.05, 0, 0.05).warnings  # nine of its diagonals away
    assert "0.8 m away" in warning


@pytest.mark.parametrize(
    "arguments",
    [
        {"points": 0},
        {"points": 10**9},
        {"points": 3.5},
        {"points": 5, "points_per_cm3": 1.0},
        {"points_per_cm3": -1.0},
        {"points_per_cm3": 1e9},
        {"unit": "mmm"},
        {"sampling": "sobol"},
        {"pose": np.diag([2.0, 1, 1, 1])},
    ],
)
def test_bad_arguments(arguments):
    with pytest.raises(InputError):
        PointMasses.from_mesh(SOLIDS["box"], **arguments)


def _glb(document, payload=b""):
    text = json.dumps(document).encode()
    text += b" " * (-len(text) % 4)
    body = struct.pack("<II", len(text), 0x4E4F534A) + text + struct.pack("<II", len(payload), 0x004E4942) + payload
    return struct.pack("<III", 0x46546C67, 2, 12 + len(body)) + body


def _scene(**changes):
    views = [{"buffer": 0, "byteLength": 36}, {"buffer": 0, "byteOffset": 36, "byteLength": 12}]
    accessors = [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3"}]
    accessors.append({"bufferView": 1, "componentType": 5125, "count": 3, "type": "SCALAR"})
    meshes = [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}]
    start = {
        "asset": {"version": "2.0"},
        "buffers": [{"byteLength": 48}],
        "bufferViews": views,
        "meshes": meshes,
    }
    start |= {"accessors": accessors, "nodes": [{"mesh": 0}], "scene": 0, "scenes": [{"nodes": [0]}]}
    return start | changes


PLY = b"ply\nformat %s 1.0\nelement vertex %d\nproperty float x\nproperty float y\nproperty float z\n"
FACE = b"element face %d\nproperty list %s int vertex_indices\nend_header\n"
TETRA = "f 1 2 3\nf 1 3 4\nf 1 2 4\nf 2 3 4\n"
HOSTILE = {
    "empty.stl": b"",
    "page.stl": b"<!DOCTYPE html><html>404</html>",
    "pointer.stl": b"version https://git-lfs.github.com/spec/v1\n",
    "noise.stl": np.random.default_rng(0).bytes(3000),
    "noise.ply": np.random.default_rng(1).bytes(3000),
    "noise.obj": np.random.default_rng(2).bytes(3000),
    "noise.off": np.random.default_rng(3).bytes(3000),
    "noise.glb": np.random.default_rng(4).bytes(3000),
    "cut.stl": SOLIDS["box"].export(file_type="stl")[:300],
    "cut.ply": SOLIDS["box"].export(file_type="ply")[:-100],
    "cut.glb": SOLIDS["box"].export(file_type="glb")[:500],
    "no_faces.stl": b"solid\nendsolid\n",
    "count.stl": bytes(80) + struct.pack("<I", 4_000_000_000) + bytes(50),
    "count.off": b"OFF\n99999999999 99999999999 0\n0 0 0\n",
    "count_ascii.ply": PLY % (b"ascii", 10**11) + FACE % (10**11, b"uchar") + b"0 0 0\n",
    "count_binary.ply": PLY % (b"binary_little_endian", 10**12) + FACE % (3, b"uchar") + b"000",
    "list.ply": PLY % (b"binary_little_endian", 3) + FACE % (1, b"uint") + bytes(36) + b"\xff" * 4 + bytes(40),
    "nan.obj": f"v nan 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\n{TETRA}".encode(),
    "huge.obj": f"v 0 0 0\nv 1e308 0 0\nv 0 1e308 0\nv 0 0 1e308\n{TETRA}".encode(),
    "index.obj": b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 9\n",
    "flat.obj": b"v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\nf 1 2 3\nf 2 4 3\n",
    "sliver.obj": b"v 0 0 0\nv 1 0 0\nv 1 0 0\nf 1 2 3\n",
    "point.obj": f"v 0 0 0\nv 0 0 0\nv 0 0 0\nv 0 0 0\n{TETRA}".encode(),
    "zeros.glb": _glb(
        _scene(accessors=[{"componentType": 5126, "count": 10**10, "type": "VEC3"}, _scene()["accessors"][1]]),
        bytes(48),
    ),
    "cycle.glb": _glb(_scene(nodes=[{"children": [1]}, {"children": [0], "mesh": 0}]), bytes(48)),
    "outside.glb": _glb(_scene(buffers=[{"byteLength": 48, "uri": "../../etc/passwd"}])),
    "ragged.csv": b"x,y,z\n1,2\n",
    "nan.csv": b"x,y,z\n1,2,nan\n",
    "words.xyz": b"a b c\n",
    "comment.xyz": b"# nothing\n",
    "count.npy": b"\x93NUMPY\x01\0v\0"
    + b"{'descr': '<f8', 'fortran_order': False, 'shape': (9999999999, 3), }".ljust(118),
}


@pytest.mark.parametrize("name", HOSTILE)
def test_hostile_files_are_refused_in_one_line(tmp_path, name):
    path = tmp_path / name
    path.write_bytes(HOSTILE[name])
    with pytest.raises(InputError) as caught:
        load_shape(path)
    assert name in str(caught.value)
    assert "\n" not in str(caught.value)


def test_pickles_are_not_opened(tmp_path):
    path = tmp_path / "objects.npy"
    np.save(path, np.array([{}], dtype=object), allow_pickle=True)
    with pytest.raises(InputError, match="not a readable"):
        load_shape(path)


def test_missing_files_and_folders(tmp_path):
    (tmp_path / "folder.stl").mkdir()
    for name in ("missing.stl", "folder.stl"):
        with pytest.raises(InputError, match="no such file"):
            load_shape(tmp_path / name)


def test_big_files_are_refused(tmp_path, monkeypatch):
    path = tmp_path / "box.stl"
    SOLIDS["box"].export(path)
    monkeypatch.setattr("hefting.shapes.reading.MAX_BYTES", 100)
    with pytest.raises(InputError, match="larger than"):
        load_shape(path)


def test_many_instances_are_refused(tmp_path, monkeypatch):
    path = tmp_path / "scene.glb"
    scene = trimesh.Scene()
    scene.add_geometry(SOLIDS["box"], node_name="first")
    for i in range(5):
        scene.graph.update(frame_to=f"n{i}", frame_from="first", geometry=next(iter(scene.geometry)))
    scene.export(path)
    monkeypatch.setattr("hefting.shapes.reading.MAX_FACES", 50)  # six boxes have 72 faces
    with pytest.raises(InputError, match="more than"):
        load_shape(path)


# the twelve workshop tools


@needs_data
@pytest.mark.parametrize("path", TOOLS, ids=lambda path: path.parent.name)
def test_workshop_tool(path):
    truth = json.loads((path.parent / "truth.json").read_text())
    pose = np.array(truth["object_pose_in_sensor"])
    shape = PointMasses.from_mesh(path, unit="mm", pose=pose)
    assert 50 <= shape.n <= 75
    assert not shape.warnings
    # the data set rounds the sides to 0.1 mm
    np.testing.assert_allclose(shape.extents, truth["mesh_extents_m"], atol=1e-4)
    mesh = trimesh.load_mesh(path)
    local = (shape.positions - pose[:3, 3]) @ pose[:3, :3] * 1000
    assert (winding(mesh.triangles, local[::4]) > 0.5).all()  # every fourth point, to save time
    # with equal masses the grid has the solid's COM within a tenth of each side, mostly far nearer
    com = (shape.positions.mean(axis=0) - shape.homogeneous.center_of_mass) @ pose[:3, :3]
    assert (np.abs(com) < 0.1 * shape.extents).all()
    random = PointMasses.from_mesh(path, unit="mm", points=10, sampling="random")
    assert random.n == 10
    assert (winding(mesh.triangles, random.positions * 1000) > 0.5).all()


@needs_data
@pytest.mark.parametrize("path", TOOLS, ids=lambda path: path.parent.name)
def test_workshop_tool_parts(path):
    truth = json.loads((path.parent / "truth.json").read_text())
    shape = load_shape(path.with_name("parts.ply"), pose=truth["object_pose_in_sensor"])
    assert shape.n > 1000
    assert set(np.unique(shape.labels)) == {0, 1, 2, 3}
    # the parts cover the mesh's box, but for tetrahedra that stick out or stay within by a few millimetres
    np.testing.assert_allclose(shape.extents, truth["mesh_extents_m"], atol=0.011)
    assert not shape.warnings
