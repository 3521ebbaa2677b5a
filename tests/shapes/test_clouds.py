"""Point clouds: their hull is filled, their own points are kept, and files of clouds
and of parts are read."""

import struct

import numpy as np
import pytest
import trimesh

from hefting.core.errors import InputError
from hefting.core.messages import codes
from hefting.shapes import Shape, load_shape
from solids import POSE, SOLIDS


def test_hull_of_a_surface_cloud_is_filled():
    cloud = SOLIDS["sphere"].vertices
    shape = Shape.from_hull(cloud, points=200)
    assert np.linalg.norm(shape.positions, axis=1).min() < 0.02
    np.testing.assert_allclose(shape.homogeneous.center_of_mass, 0, atol=1e-12)
    ring = Shape.from_hull(SOLIDS["ring"], points=200)
    # the hole is filled
    assert np.linalg.norm(ring.positions[:, :2], axis=1).min() < 0.02


def test_flat_hull_is_refused():
    with pytest.raises(InputError, match="flat"):
        Shape.from_hull(np.random.default_rng(0).random((20, 3)) * [1, 1, 0])


def test_cloud_keeps_its_own_points():
    cloud = np.random.default_rng(8).uniform(-0.05, 0.05, (5000, 3)) * [1, 2, 1]
    shape = Shape.from_cloud(cloud, points=100)
    # the number of occupied voxels jumps with the pitch
    assert abs(shape.n - 100) <= 15
    assert {tuple(p) for p in shape.positions} <= {tuple(p) for p in cloud}
    assert Shape.from_cloud(cloud[:20]).n == 20
    dense = Shape.from_cloud(cloud, points_per_cm3=0.1)
    assert abs(dense.n - 200) <= 100  # in 2000 cm³; voxels on the border count whole
    body = Shape.from_cloud(cloud, points=1000).homogeneous
    # 3 % of the half side
    np.testing.assert_allclose(body.center_of_mass, 0, atol=0.003)


@pytest.mark.parametrize("suffix", [".xyz", ".csv", ".txt", ".npy"])
def test_cloud_files(tmp_path, suffix):
    cloud, path = np.random.default_rng(9).random((30, 3)), tmp_path / f"cloud{suffix}"
    if suffix == ".npy":
        np.save(path, cloud)
    elif suffix == ".csv":
        rows = "\n".join(
            f"{i},{z!r},{y!r},{x!r}" for i, (x, y, z) in enumerate(cloud.tolist())
        )
        path.write_text("id,z,y,x\r\n" + rows)
    else:
        np.savetxt(path, cloud, header="x y z", fmt="%.17g")
    np.testing.assert_allclose(
        load_shape(path, unit="cm").positions, cloud / 100, rtol=1e-15
    )


@pytest.mark.parametrize("form", ["ascii", "binary_little_endian", "binary_big_endian"])
def test_parts_file(tmp_path, form):
    rows = [(0.0, 0.1, 0.2, 2.0, 1), (0.3, 0.4, 0.5, 6.0, 4)]
    header = f"ply\r\nformat {form} 1.0\r\ncomment made by hand\r\nelement vertex 2\r\n"
    header += "".join(
        f"property double {name}\r\n" for name in ("x", "y", "z", "volume")
    )
    header += "property uchar segmentation\r\nend_header\r\n"
    if form == "ascii":
        body = "\r\n".join(" ".join(map(str, row)) for row in rows).encode()
    else:
        body = b"".join(
            struct.pack(("<" if "little" in form else ">") + "ddddB", *row)
            for row in rows
        )
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


@pytest.mark.parametrize("name", ["sphere", "ring", "box"])
def test_a_cloud_of_a_surface_is_told(name):
    """From a scan with noise, and stray points; not where the points fill the object, on
    a grid or at random, and not of those in the hole of a ring."""
    rng = np.random.default_rng(4)
    mesh = SOLIDS[name]
    mesh = trimesh.Trimesh(mesh.vertices, mesh.faces)
    scan = np.asarray(trimesh.sample.sample_surface(mesh, 4000, seed=1)[0])
    scan = scan + rng.normal(size=scan.shape) * 0.005 * mesh.scale
    stray = rng.uniform(-1.0, 1.0, (5, 3)) * mesh.scale
    for points in (scan, np.vstack((scan, stray))):
        assert codes(Shape.from_cloud(points).warnings) == {"cloud-hollow"}
    for sampling in ("grid", "random"):
        filled = Shape.from_mesh(mesh, points=3000, sampling=sampling).positions
        assert not Shape.from_cloud(filled).warnings
        assert not Shape.from_cloud(filled[:40]).warnings
