"""Shapes that ask for much more memory or time than their file is large."""

import io
import json
import struct
import subprocess
import sys
import tracemalloc

import numpy as np
import pytest
import trimesh

from hefting.core.errors import InputError
from hefting.shapes import files, load_shape
from hefting.shapes.reading import read_mesh


def refusal(path) -> str:
    with pytest.raises(InputError) as caught:
        load_shape(path)
    message = str(caught.value)
    assert "\n" not in message
    assert message.startswith(str(path))
    return message


@pytest.mark.parametrize("kind", ["int8", "float16", "uint64", "float64"])
def test_arrays_of_too_many_points(tmp_path, kind):
    """A million int8 points and one took a traceback at 66 MB; the array is not copied
    before its size is known."""
    path = tmp_path / "cloud.npy"
    np.save(path, np.zeros((files.MAX_CLOUD + 1, 3), dtype=kind))
    tracemalloc.start()
    message = refusal(path)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert "more than 1,000,000 points" in message
    # the file itself, and nothing of its size beside it
    assert peak < path.stat().st_size + 1e6


def test_arrays_of_what_is_no_number(tmp_path):
    for number, array in enumerate((
        np.zeros((4, 3), dtype=complex),
        np.zeros((4, 3), dtype="M8[s]"),
        np.array([["1", "2", "3"]] * 4),
        np.zeros((4, 3), dtype=bool),
    )):  # fmt: skip
        path = tmp_path / f"{number}.npy"
        np.save(path, array)
        assert "not a readable" in refusal(path)
    for number, array in enumerate((np.zeros(9), np.zeros((2, 3, 4)), np.zeros(()))):
        path = tmp_path / f"shape{number}.npy"
        np.save(path, array)
        assert f"not shape {array.shape}".replace("not ", "") in refusal(path)


@pytest.mark.parametrize(
    "header",
    [
        "{'descr': '<f8', 'fortran_order': False, 'shape': (60, 3",
        "{" * 50,
        "[" * 5000,
        "(" * 300 + ")" * 300,
        "'a' * 10**9",
        "{'descr': '<f8', 'fortran_order': False, 'shape': (10**9, 3)}",
        "{'descr': '|V9', 'fortran_order': True, 'shape': (4611686018427387904,)}",
        "{'descr': '|O', 'fortran_order': False, 'shape': (2, 3)}",
        "\0\xff",
    ],
)
@pytest.mark.parametrize("version", [1, 2, 3, 9])
def test_damaged_headers_of_arrays(tmp_path, header, version):
    text = header.encode("latin-1").ljust(118) + b"\n"
    size = struct.pack("<H" if version == 1 else "<I", len(text))
    path = tmp_path / "cloud.npy"
    path.write_bytes(b"\x93NUMPY" + bytes((version, 0)) + size + text + b"\0" * 99)
    assert "not a readable .npy point cloud" in refusal(path)


@pytest.mark.parametrize(
    ("name", "head", "unit"),
    [
        ("a.xyz", b"", b"1 1 1\n"),
        ("b.xyz", b"", b"1\n"),
        ("c.csv", b"x,y,z\n", b"1,1,1\n"),
        ("d.xyz", b"", b"1 "),
        ("e.xyz", b"1 1 1", b"\n"),
        ("f.obj", b"v 0 0 0\nv 1 0 0\nv 0 1 0\n", b"f 1 2 3\n"),
        ("g.obj", b"", b"v 1 1 1\n"),
        ("h.off", b"OFF\n3 9 0\n", b"3 0 1 2\n"),
        ("i.stl", b"solid\n", b"vertex 0 0 0\n"),
        (
            "j.ply",
            b"ply\nformat ascii 1.0\nelement vertex 9\nproperty float x\n"
            b"property float y\nproperty float z\nend_header\n",
            b"1 1 1\n",
        ),
    ],
)
def test_texts_of_too_many_words(tmp_path, monkeypatch, name, head, unit):
    """Refused before anything is made of them. The limit is lowered: the files would be
    of 24 MB."""
    monkeypatch.setattr(files, "MAX_WORDS", 20_000)
    path = tmp_path / name
    path.write_bytes(head + unit * (20_001 // max(len(unit.split()), 1) + 5))
    assert "words of text" in refusal(path)


@pytest.mark.parametrize("part", [1, 2, 7, 2**20])
def test_words_are_counted_across_parts(tmp_path, monkeypatch, part):
    monkeypatch.setattr(files, "PART", part)
    text = b"  12 3,4\n\n5\t6;7 \r\n89"
    for most, refused in ((6, True), (7, False), (8, False)):
        monkeypatch.setattr(files, "MAX_WORDS", most)
        if refused:
            with pytest.raises(InputError):
                files.check_text(text, "x")
        else:
            files.check_text(text, "x")


def test_long_rows_and_many_points_of_texts(tmp_path):
    path = tmp_path / "cloud.xyz"
    path.write_bytes(b"1 2 3 " * 5000 + b"\n" + b"1 2 3\n")
    assert "not a readable" in refusal(path)
    path.write_bytes(b"1 2 3\n" * (files.MAX_CLOUD + 1))
    assert "more than 1,000,000 points" in refusal(path)


def test_vertices_with_too_many_properties(tmp_path, monkeypatch):
    monkeypatch.setattr("hefting.shapes.files.MAX_NUMBERS", 1000)
    lines = ["ply", "format binary_little_endian 1.0", "element vertex 200"]
    lines += [f"property uchar {name}" for name in "xyzabc"]
    path = tmp_path / "cloud.ply"
    path.write_bytes("\n".join([*lines, "end_header\n"]).encode() + b"\1" * 1200)
    assert "damaged PLY" in refusal(path)


def scene_with(**changes) -> bytes:
    """A box as binary glTF, with changes to its header."""
    data = trimesh.creation.box().export(file_type="glb")
    assert isinstance(data, bytes)
    length = struct.unpack_from("<I", data, 12)[0]
    header = json.loads(data[20 : 20 + length]) | changes
    text = json.dumps(header).encode()
    text += b" " * (-len(text) % 4)
    out = io.BytesIO()
    out.write(data[:8] + struct.pack("<II", len(text) + 20, len(text)) + data[16:20])
    out.write(text + data[20 + length :])
    return out.getvalue()


def test_scenes_larger_than_their_file(tmp_path):
    path = tmp_path / "scene.glb"
    path.write_bytes(scene_with())
    load_shape(path)  # as it is it can be read
    nothing = {"componentType": 5126, "type": "VEC3", "count": 10**9}
    chain = [{"children": [i + 1]} for i in range(files.MAX_NODES + 1)] + [{"mesh": 0}]
    for changes in ({"accessors": [nothing] * 2}, {"nodes": chain}):
        path.write_bytes(scene_with(**changes))
        assert "not a readable .glb mesh" in refusal(path)


def test_damaged_meshes_print_nothing(tmp_path):
    """trimesh logs what it makes of them, which Python prints where nobody listens: in
    a process of its own, as the tests do listen."""
    path = tmp_path / "shape.stl"
    text = trimesh.creation.box().export(file_type="stl_ascii")
    assert isinstance(text, str)
    path.write_text(text.replace("normal ", "normal x", 1))
    code = (
        "import sys; from hefting.shapes import load_shape\n"
        "from hefting.core.errors import InputError\n"
        "try: load_shape(sys.argv[1])\n"
        "except InputError: pass"
    )
    done = subprocess.run(
        [sys.executable, "-c", code, str(path)], capture_output=True, text=True
    )
    assert (done.returncode, done.stdout, done.stderr) == (0, "", "")


def test_properties_before_any_element(tmp_path):
    path = tmp_path / "shape.ply"
    path.write_bytes(b"ply\nformat ascii 1.0\nproperty float x\nend_header\n1 2 3\n")
    assert "damaged PLY" in refusal(path)
    with pytest.raises(InputError, match="not a readable"):
        read_mesh(path)


def test_scenes_that_use_their_arrays_too_often(tmp_path, monkeypatch):
    """A thousand parts of the same 100,000 vertices took 7 GB; nodes that place a mesh
    again and again 8 GB; a chain of 10,000 nodes minutes."""
    path = tmp_path / "scene.glb"
    scene = scene_with()
    header = json.loads(scene[20 : 20 + struct.unpack_from("<I", scene, 12)[0]])
    (part,) = header["meshes"][0]["primitives"]
    node = next(each for each in header["nodes"] if "mesh" in each)
    chain = [{"children": [i + 1]} for i in range(files.MAX_LEVELS)] + [node]
    cycle = [{**node, "children": [1]}, {"children": [0]}]
    many = [{"primitives": [part] * 10_001}]
    for changes in ({"nodes": chain}, {"nodes": cycle}, {"meshes": many}):
        path.write_bytes(scene_with(**changes))
        assert "not a readable .glb mesh" in refusal(path)
    monkeypatch.setattr(files, "MAX_USED", 999)
    own = {**part, "attributes": {f"_{i}": 0 for i in range(999)} | part["attributes"]}
    for parts in ([part] * 100, [own]):
        path.write_bytes(scene_with(meshes=[{"primitives": parts}]))
        assert "not a readable .glb mesh" in refusal(path)
    monkeypatch.setattr("hefting.shapes.reading.MAX_FACES", 99)
    path.write_bytes(scene_with(nodes=[node] * 10, scenes=[{"nodes": [*range(10)]}]))
    assert "more than 99 triangles" in refusal(path)


def test_texts_of_many_solids_and_groups_are_read_at_once(tmp_path):
    """Two megabytes of either took minutes."""
    box = trimesh.creation.box()
    text = box.export(file_type="stl_ascii")
    (tmp_path / "a.stl").write_text(text + "solid\nendsolid\n" * 50_000 + text.upper())
    vertices, faces = read_mesh(tmp_path / "a.stl")
    np.testing.assert_allclose(vertices[faces][:12], box.triangles, atol=1e-6)
    np.testing.assert_array_equal(vertices[faces][12:], vertices[faces][:12])
    lines = [f"v {x} {y} {z} 1.0" for x, y, z in box.vertices]
    corners = [[f"{v + 1}/1/1" for v in face] for face in box.faces]
    for k, (a, b, c) in enumerate(corners):
        lines += [f"g part{k}", f"f {a} {b} \\\n{c}", "usemtl paint"] * 500
    (tmp_path / "a.obj").write_text("mtllib /etc/passwd\n" + "\n".join(lines))
    vertices, faces = read_mesh(tmp_path / "a.obj")
    np.testing.assert_array_equal(vertices, box.vertices)
    np.testing.assert_array_equal(faces[::500], box.faces)


def test_polygons_and_vertices_counted_from_the_last(tmp_path):
    path = tmp_path / "a.obj"
    square = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n"
    path.write_text(f"{square}f -4 -3 -2 -1\n{square}f 1 2 7 8\n")
    assert read_mesh(path)[1].tolist() == [[0, 1, 2], [0, 2, 3], [0, 1, 6], [0, 6, 7]]
    for line in ("f 0 1 2", "f a b c", "v 1 2", "f 1 2 99999999999999999999"):
        path.write_text(f"{square}{line}\n")
        with pytest.raises(InputError, match=r"not a readable \.obj mesh"):
            read_mesh(path)
