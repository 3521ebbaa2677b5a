"""What the command line says of a shape: mesh files, boxes and poses, and those that
are not any."""

import json
import struct
import subprocess
import sys

import numpy as np
import pytest
import trimesh
from scipy.spatial.transform import RigidTransform, Rotation

from hefting.core.errors import InputError
from hefting.shapes import Shape, as_pose, load_shape, parse_pose
from hefting.shapes.reading import read_mesh
from solids import POSE, SOLIDS


@pytest.mark.parametrize("suffix", ["stl", "obj", "ply", "off", "glb"])
def test_mesh_files(tmp_path, suffix):
    path = tmp_path / f"ell.{suffix}"
    mesh = SOLIDS["ell"].copy()
    mesh.apply_scale(1000)
    mesh.export(path)
    shape = load_shape(path, unit="mm", pose=POSE, points=40)
    expected = Shape.from_mesh(SOLIDS["ell"], pose=POSE, points=40)
    # .ply, .stl and .glb hold single precision: 6e-8 of 40 mm
    np.testing.assert_allclose(shape.positions, expected.positions, atol=1e-8)


@pytest.mark.parametrize("name", SOLIDS)
def test_a_binary_stl_is_read_as_trimesh_reads_it(tmp_path, name):
    SOLIDS[name].export(tmp_path / "mesh.stl")
    vertices, faces = read_mesh(tmp_path / "mesh.stl")
    other = trimesh.load(tmp_path / "mesh.stl", process=False)
    assert np.array_equal(vertices, other.vertices)
    assert np.array_equal(faces, other.faces)


def test_ply_meshes_of_four_corners_and_in_text(tmp_path):
    corners = np.array(list(np.ndindex(2, 2, 2)), dtype="<f4")
    sides = [
        (0, 1, 3, 2),
        (4, 6, 7, 5),
        (0, 4, 5, 1),
        (2, 3, 7, 6),
        (0, 2, 6, 4),
        (1, 5, 7, 3),
    ]
    head = "ply\nformat binary_little_endian 1.0\nelement vertex 8\n" + "".join(
        f"property float {a}\n" for a in "xyz"
    )
    head += "element face 6\nproperty list uchar int vertex_indices\nend_header\n"
    body = b"".join(struct.pack("<B4i", 4, *side) for side in sides)
    (tmp_path / "quads.ply").write_bytes(head.encode() + corners.tobytes() + body)
    (tmp_path / "text.ply").write_bytes(
        SOLIDS["box"].export(file_type="ply", encoding="ascii")
    )
    for name, volume in (("quads", 1.0), ("text", SOLIDS["box"].volume)):
        vertices, faces = read_mesh(tmp_path / f"{name}.ply")
        assert trimesh.Trimesh(vertices, faces).volume == pytest.approx(volume)


def test_a_binary_stl_may_begin_like_text(tmp_path):
    data = SOLIDS["box"].export(file_type="stl")
    for comment in (b"solid box", b"", b"\xff" * 80):
        (tmp_path / "mesh.stl").write_bytes(comment.ljust(80, b"\0") + data[80:])
        assert np.array_equal(
            read_mesh(tmp_path / "mesh.stl")[0],
            SOLIDS["box"].triangles.reshape(-1, 3).astype("f4"),
        )


def test_a_box_or_a_binary_stl_needs_numpy_alone(tmp_path):
    SOLIDS["box"].export(tmp_path / "mesh.stl")
    code = (
        "import sys; from hefting.shapes import load_shape; load_shape(sys.argv[1]); load_shape('box:0,1,0,1,0,1')\n"
        "print(*{m.split('.')[0] for m in sys.modules} & {'trimesh', 'scipy', 'pyarrow', 'rich'})"
    )
    command = [sys.executable, "-c", code, str(tmp_path / "mesh.stl")]
    assert (
        subprocess.run(
            command, check=True, capture_output=True, text=True
        ).stdout.strip()
        == ""
    )


def test_text_mesh_in_another_encoding(tmp_path):
    path = tmp_path / "box.stl"
    text = trimesh.creation.box((0.1, 0.1, 0.1)).export(file_type="stl_ascii")
    path.write_bytes(text.replace("solid ", "solid Gehäuse", 1).encode("latin-1"))
    np.testing.assert_allclose(load_shape(path).extents, 0.1)


def test_box_specification():
    shape = load_shape("box:-0.1,0.1,-0.05,0.05,0,0.2", points=80)
    expected = Shape.from_box(-0.1, 0.1, -0.05, 0.05, 0, 0.2, points=80)
    np.testing.assert_array_equal(shape.positions, expected.positions)


@pytest.mark.parametrize(
    "spec",
    [
        "box:1,2,3",
        "box:0,1,0,1,0,0",
        "box:0,inf,0,1,0,1",
        "box:a,b,c,d,e,f",
        "hammer.step",
    ],
)
def test_bad_specifications(spec):
    with pytest.raises(InputError):
        load_shape(spec)


def test_shapes_of_other_kinds_are_told_how_they_are_converted(tmp_path):
    files = trimesh.creation.box((1.0, 2.0, 3.0)).export(file_type="gltf")
    for name, data in files.items():
        (tmp_path / name).write_bytes(data)
    path = tmp_path / "model.gltf"
    with pytest.raises(InputError, match="is read; convert it: pip install") as told:
        load_shape(path)
    exec(f"import trimesh; {str(told.value).split('in Python ')[1]}")
    shape = load_shape(f"{path}.stl")
    np.testing.assert_allclose(shape.extents, (1.0, 2.0, 3.0), rtol=1e-6)  # float32
    with pytest.raises(InputError, match=r"is read; export it as \.stl, and give"):
        load_shape("bracket.STEP")


def test_box_takes_no_pose():
    with pytest.raises(InputError, match="sensor frame"):
        load_shape("box:0,1,0,1,0,1", pose=POSE)


def test_pose_as_numbers_and_files(tmp_path):
    seven = [0.1, -0.2, 0.3, *Rotation.from_euler("z", 90, degrees=True).as_quat()]
    expected = [[0, -1, 0, 0.1], [1, 0, 0, -0.2], [0, 0, 1, 0.3], [0, 0, 0, 1]]
    path = tmp_path / "pose.json"
    given = RigidTransform.from_matrix(np.array(expected, dtype=float))
    np.testing.assert_allclose(as_pose(given), expected, atol=1e-15)
    for text in (",".join(map(str, seven)), json.dumps(seven), json.dumps(expected)):
        source = text
        if text.startswith("["):
            path.write_text(text)
            source = path
        np.testing.assert_allclose(parse_pose(source), expected, atol=1e-15)


def test_pose_in_a_text_file(tmp_path):
    pose = np.eye(4)
    pose[:3, :3] = Rotation.from_euler("xyz", (0.1, 0.2, 0.3)).as_matrix()
    path = tmp_path / "pose.txt"
    for numbers in (pose, [[0.1, -0.2, 0.3]]):
        for options in ({}, {"delimiter": ","}, {"fmt": "%.6f"}):
            np.savetxt(path, numbers, **options)
            expected = pose if len(numbers) == 4 else parse_pose("0.1,-0.2,0.3")
            np.testing.assert_allclose(parse_pose(path), expected, atol=1e-6)
    np.savetxt(path, pose[:3])
    with pytest.raises(InputError, match="not a pose"):
        parse_pose(path)


@pytest.mark.parametrize(
    ("text", "turn"),
    [
        ("30mm, -6cm,0.09m,z:90", Rotation.from_euler("z", 90, degrees=True)),
        (
            "0.03,-0.06,0.09,0,0,0,1, z:90,x:-45 ",
            Rotation.from_euler("ZX", (90, -45), degrees=True),
        ),
        ("z:90,30mm,-60mm,90mm,", None),
    ],
)
def test_a_pose_by_units_and_turns(text, turn):
    """Turns are about the axes as turned so far."""
    if turn is None:
        with pytest.raises(InputError, match="neither numbers nor a file"):
            parse_pose(text)
        return
    expected = np.eye(4)
    expected[:3, :3], expected[:3, 3] = turn.as_matrix(), (0.03, -0.06, 0.09)
    np.testing.assert_allclose(parse_pose(text), expected, atol=1e-15)
    expected[:3, 3] = 0.0
    only = ",".join(word for word in text.split(",") if ":" in word)
    np.testing.assert_allclose(parse_pose(only), expected, atol=1e-15)


def test_a_pose_in_a_numpy_file(tmp_path):
    pose = np.eye(4)
    pose[:3] = RigidTransform.from_exp_coords((0.1, 0.2, 0.3, 1, 2, 3)).as_matrix()[:3]
    path = tmp_path / "pose.npy"
    np.save(path, pose)
    np.testing.assert_array_equal(parse_pose(path), pose)
    np.save(path, [0.1, -0.2, 0.3])
    np.testing.assert_array_equal(parse_pose(path), parse_pose("0.1,-0.2,0.3"))
    for other in (np.eye(3), np.eye(4) + 0j, np.array(["x"])):
        np.save(path, other)
        with pytest.raises(InputError, match="not a pose; give x,y,z"):
            parse_pose(path)
    path.write_bytes(b"\x93NUMPY\x01\x00\xff\xffdamaged")
    with pytest.raises(InputError, match="not a pose"):
        parse_pose(path)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("0,0,0,0,0,0,2", "norm 2"),
        ("0,0,0,0,0,1", "not a pose"),
        ("nan,0,0,0,0,0,1", "finite"),
        ("missing.json", "neither"),
        ("z:\\missing.json", "neither"),
        ("0,0,0,z:400", "'z:400' is no turn"),
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


def test_a_pose_of_three_numbers_is_not_turned():
    expected = np.eye(4)
    expected[:3, 3] = 0.1, -0.2, 0.3
    np.testing.assert_array_equal(parse_pose("0.1,-0.2,0.3"), expected)


def test_the_pose_of_a_file_may_be_text(tmp_path):
    path = tmp_path / "ell.stl"
    SOLIDS["ell"].export(path)
    moved = load_shape(path, pose="0.1,0,0")
    still = load_shape(path)
    along_x = np.array((0.1, 0.0, 0.0))
    np.testing.assert_allclose(moved.positions, still.positions + along_x)
    with pytest.raises(InputError, match="not a pose"):
        load_shape(path, pose="0.1,0")
    with pytest.raises(InputError, match="4 x 4"):
        Shape.from_mesh(path, pose="0.1,0,0")
