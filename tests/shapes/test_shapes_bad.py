"""Suspicious shapes give a warning; bad arguments and hostile files are refused in one
line."""

import json
import struct

import numpy as np
import pytest
import trimesh

from hefting.core.errors import InputError
from hefting.core.spatial import pose_matrix
from hefting.shapes import Shape, load_shape
from solids import SOLIDS

# suspicious


def test_millimetres_read_as_metres_are_noticed():
    mesh = SOLIDS["box"].copy()
    mesh.apply_scale(1000)
    assert "mm (0." in Shape.from_mesh(mesh).warnings[0]
    assert "mm (0." in Shape.from_mesh(mesh, unit=None).warnings[0]
    assert not Shape.from_mesh(mesh, unit="mm").warnings
    small = SOLIDS["plate"]
    assert "`unit` m (" in Shape.from_mesh(small, unit="mm").warnings[0]


def test_distant_shapes_are_noticed():
    for metres, noticed in ((0.1, False), (0.9, False), (2.0, True)):
        warnings = Shape.from_mesh(
            SOLIDS["box"], pose=pose_matrix([metres, 0, 0, 0, 0, 0, 1])
        ).warnings
        assert bool(warnings) == noticed
    # nine of its diagonals away
    (warning,) = Shape.from_box(0.8, 0.85, 0, 0.05, 0, 0.05).warnings
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
        Shape.from_mesh(SOLIDS["box"], **arguments)


# hostile


def _glb(document, payload=b""):
    text = json.dumps(document).encode()
    text += b" " * (-len(text) % 4)
    body = (
        struct.pack("<II", len(text), 0x4E4F534A)
        + text
        + struct.pack("<II", len(payload), 0x004E4942)
        + payload
    )
    return struct.pack("<III", 0x46546C67, 2, 12 + len(body)) + body


def _scene(**changes):
    views = [
        {"buffer": 0, "byteLength": 36},
        {"buffer": 0, "byteOffset": 36, "byteLength": 12},
    ]
    accessors = [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3"}]
    accessors.append(
        {"bufferView": 1, "componentType": 5125, "count": 3, "type": "SCALAR"}
    )
    meshes = [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}]
    start = {
        "asset": {"version": "2.0"},
        "buffers": [{"byteLength": 48}],
        "bufferViews": views,
        "meshes": meshes,
    }
    start |= {
        "accessors": accessors,
        "nodes": [{"mesh": 0}],
        "scene": 0,
        "scenes": [{"nodes": [0]}],
    }
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
    "nothing.stl": bytes(84),
    "nan.stl": bytes(80) + struct.pack("<I", 4) + b"\1\0\x80\x7f" * 50,  # signalling
    "inf.stl": bytes(80) + struct.pack("<I", 4) + b"\0\0\x80\x7f" * 50,
    "point.stl": bytes(80) + struct.pack("<I", 4) + bytes(200),
    "count.off": b"OFF\n99999999999 99999999999 0\n0 0 0\n",
    "count_ascii.ply": PLY % (b"ascii", 10**11)
    + FACE % (10**11, b"uchar")
    + b"0 0 0\n",
    "count_binary.ply": PLY % (b"binary_little_endian", 10**12)
    + FACE % (3, b"uchar")
    + b"000",
    "list.ply": PLY % (b"binary_little_endian", 3)
    + FACE % (1, b"uint")
    + bytes(36)
    + b"\xff" * 4
    + bytes(40),
    "nan.obj": f"v nan 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\n{TETRA}".encode(),
    "huge.obj": f"v 0 0 0\nv 1e308 0 0\nv 0 1e308 0\nv 0 0 1e308\n{TETRA}".encode(),
    "index.obj": b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 9\n",
    "flat.obj": b"v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\nf 1 2 3\nf 2 4 3\n",
    "sliver.obj": b"v 0 0 0\nv 1 0 0\nv 1 0 0\nf 1 2 3\n",
    "point.obj": f"v 0 0 0\nv 0 0 0\nv 0 0 0\nv 0 0 0\n{TETRA}".encode(),
    "zeros.glb": _glb(
        _scene(
            accessors=[
                {"componentType": 5126, "count": 10**10, "type": "VEC3"},
                _scene()["accessors"][1],
            ]
        ),
        bytes(48),
    ),
    "cycle.glb": _glb(
        _scene(nodes=[{"children": [1]}, {"children": [0], "mesh": 0}]), bytes(48)
    ),
    "outside.glb": _glb(
        _scene(buffers=[{"byteLength": 48, "uri": "../../etc/passwd"}])
    ),
    "ragged.csv": b"x,y,z\n1,2\n",
    "nan.csv": b"x,y,z\n1,2,nan\n",
    "words.xyz": b"a b c\n",
    "comment.xyz": b"# nothing\n",
    "count.npy": b"\x93NUMPY\x01\0v\0"
    + b"{'descr': '<f8', 'fortran_order': False, 'shape': (9999999999, 3), }".ljust(
        118
    ),
}


def test_what_is_wrong_with_a_whole_file_is_said(tmp_path):
    stl = SOLIDS["box"].export(file_type="stl")
    for name, data, what in (
        ("more.stl", stl + b"xyz", "has 3 bytes after its 12 triangles"),
        ("far.obj", f"v 1e20 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\n{TETRA}", "beyond 1e9 m"),
        ("far.xyz", "1e20 0 0\n0 1 0\n0 0 1\n1 1 1\n", "beyond 1e9 m"),
    ):
        path = tmp_path / name
        path.write_bytes(data if isinstance(data, bytes) else data.encode())
        with pytest.raises(InputError, match=what):
            load_shape(path)


def test_a_binary_stl_of_too_many_triangles(tmp_path, monkeypatch):
    monkeypatch.setattr("hefting.shapes.reading.MAX_FACES", 11)
    (tmp_path / "box.stl").write_bytes(SOLIDS["box"].export(file_type="stl"))
    with pytest.raises(
        InputError, match=r"box\.stl: the mesh has more than 11 triangles; simplify it"
    ):
        load_shape(tmp_path / "box.stl")


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
    (tmp_path / "loop.stl").symlink_to(tmp_path / "loop.stl")
    for name, what in (
        ("missing.stl", "no such file"),
        ("folder.stl", "is not a file"),
        ("loop.stl", "is not a file"),
    ):
        with pytest.raises(InputError, match=what):
            load_shape(tmp_path / name)


def test_big_files_are_refused(tmp_path, monkeypatch):
    path = tmp_path / "box.stl"
    SOLIDS["box"].export(path)
    monkeypatch.setattr("hefting.shapes.files.MAX_BYTES", 100)
    with pytest.raises(InputError, match="larger than"):
        load_shape(path)


def test_many_instances_are_refused(tmp_path, monkeypatch):
    path = tmp_path / "scene.glb"
    scene = trimesh.Scene()
    scene.add_geometry(SOLIDS["box"], node_name="first")
    for i in range(5):
        scene.graph.update(
            frame_to=f"n{i}", frame_from="first", geometry=next(iter(scene.geometry))
        )
    scene.export(path)
    # six boxes have 72 faces
    monkeypatch.setattr("hefting.shapes.reading.MAX_FACES", 50)
    with pytest.raises(InputError, match="more than"):
        load_shape(path)
