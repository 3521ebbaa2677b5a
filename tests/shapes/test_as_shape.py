"""A shape may be given as a file, a box, a mesh or points: each is the same shape that
its own reader makes."""

import numpy as np
import pytest
import trimesh

from hefting.core.errors import InputError
from hefting.core.spatial import pose_matrix
from hefting.shapes import Shape, as_shape, load_shape

BOX = trimesh.creation.box((0.1, 0.2, 0.3))
SEVEN = (0.1, 0.0, 0.2, 0.0, 0.6, 0.0, 0.8)


def same(first: Shape, second: Shape) -> bool:
    """Whether two shapes have the same points."""
    np.testing.assert_array_equal(first.positions, second.positions)
    return first.known == second.known and first.shape_std == second.shape_std


def test_meshes_scenes_and_clouds_of_trimesh():
    assert same(as_shape(BOX), Shape.from_mesh(BOX))
    assert same(as_shape(trimesh.Scene([BOX])), Shape.from_mesh(BOX))
    points = np.random.default_rng(2).uniform(-0.1, 0.1, size=(3000, 3))
    assert same(as_shape(trimesh.PointCloud(points)), Shape.from_cloud(points))


def test_points_texts_and_files(tmp_path):
    points = np.random.default_rng(1).uniform(size=(500, 3))
    assert same(as_shape(1e3 * points, "mm"), Shape.from_cloud(1e3 * points, "mm"))
    assert same(as_shape(points.tolist()), Shape.from_cloud(points))
    text = "box:0,0.1,0,0.2,0,0.3"
    assert same(as_shape(text), load_shape(text))
    BOX.export(tmp_path / "box.stl")
    for path in (tmp_path / "box.stl", str(tmp_path / "box.stl")):
        assert same(as_shape(path), load_shape(path))
    shape = Shape(points)
    assert as_shape(shape) is shape
    assert as_shape(None) is None


@pytest.mark.parametrize(
    "pose", [SEVEN, list(SEVEN), pose_matrix(SEVEN), ",".join(map(str, SEVEN))]
)
def test_a_pose_in_any_form(pose):
    expected = Shape.from_mesh(BOX, "cm", pose_matrix(SEVEN))
    assert same(as_shape(BOX, "cm", pose), expected)


@pytest.mark.parametrize(
    ("given", "match"),
    [
        ((5,), "a value of type int is not a shape; give a file"),
        (({"x": 1},), "a value of type dict is not a shape"),
        ((np.zeros(3),), "is not a shape"),
        ((np.zeros((4, 2)),), r"\(n, 3\), not \(4, 2\)"),
        ((np.full((4, 3), np.nan),), "not finite"),
        ((["a", "b"],), "is not a shape"),
        (("nothing.stl",), "nothing.stl"),
        ((BOX, "furlong"), "unknown unit"),
        ((BOX, None, np.eye(3)), "4 x 4"),
        ((None, "mm"), "`unit` and `object_pose` are those of a shape's file"),
        ((Shape(np.eye(3)), "mm"), "give them to `load_shape`"),
    ],
)
def test_what_is_no_shape_is_refused_in_one_line(given, match):
    with pytest.raises(InputError, match=match) as refused:
        as_shape(*given)
    assert "\n" not in str(refused.value)


def test_a_shape_is_short_at_a_prompt():
    assert len(repr(Shape.from_mesh(BOX))) < 300
