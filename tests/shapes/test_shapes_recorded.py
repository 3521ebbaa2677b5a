"""Shapes of the twelve workshop tools: points inside the meshes, extents and parts as
the data set has them."""

import json

import numpy as np
import pytest
import trimesh

from hefting.shapes import Shape, load_shape
from recordings import TOOL_FOLDERS, needs_recordings
from solids import winding

MESHES = [folder / "mesh.ply" for folder in TOOL_FOLDERS]


@needs_recordings
@pytest.mark.parametrize("path", MESHES, ids=lambda path: path.parent.name)
def test_workshop_tool(path):
    truth = json.loads((path.parent / "truth.json").read_text())
    pose = np.array(truth["object_pose_in_sensor"])
    shape = Shape.from_mesh(path, unit="mm", pose=pose)
    assert 50 <= shape.n <= 75
    assert not shape.warnings
    # the data set rounds the sides to 0.1 mm
    np.testing.assert_allclose(shape.extents, truth["mesh_extents_m"], atol=1e-4)
    mesh = trimesh.load_mesh(path)
    local = (shape.positions - pose[:3, 3]) @ pose[:3, :3] * 1000
    # every fourth point, to save time
    assert (winding(mesh.triangles, local[::4]) > 0.5).all()
    # with equal masses the grid has the solid's COM within a tenth of each side, mostly
    # far nearer
    com = (shape.positions.mean(axis=0) - shape.homogeneous.center_of_mass) @ pose[
        :3, :3
    ]
    assert (np.abs(com) < 0.1 * shape.extents).all()
    random = Shape.from_mesh(path, unit="mm", points=10, sampling="random")
    assert random.n == 10
    assert (winding(mesh.triangles, random.positions * 1000) > 0.5).all()


@needs_recordings
@pytest.mark.parametrize("path", MESHES, ids=lambda path: path.parent.name)
def test_workshop_tool_parts(path):
    truth = json.loads((path.parent / "truth.json").read_text())
    shape = load_shape(path.with_name("parts.ply"), pose=truth["object_pose_in_sensor"])
    assert shape.n > 1000
    assert set(np.unique(shape.labels)) == {0, 1, 2, 3}
    # the parts cover the mesh's box, but for tetrahedra that stick out or stay within
    # by a few millimetres
    np.testing.assert_allclose(shape.extents, truth["mesh_extents_m"], atol=0.011)
    assert not shape.warnings
