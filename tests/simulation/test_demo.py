"""The demonstration, and that its files let anyone repeat it."""

import json
import os
import subprocess
import sys

import numpy as np
import pytest

from hefting.core.accuracy import errors_between
from hefting.core.errors import InputError
from hefting.core.estimate import Estimate
from hefting.core.inertia import InertialParameters
from hefting.core.spatial import STANDARD_GRAVITY
from hefting.identification import identify
from hefting.shapes import Shape
from hefting.simulation import demo


@pytest.fixture(scope="module")
def result(tmp_path_factory):
    pytest.importorskip(
        "matplotlib", reason="matplotlib is not installed (pip install 'hefting[plot]')"
    )
    return demo.run(tmp_path_factory.mktemp("demo") / "new")


def test_every_file_is_there(result):
    folder = result.log.parent
    assert sorted(path.name for path in folder.iterdir()) == sorted(
        path.name for path in result.files
    )
    assert {path.suffix for path in result.pictures} == {".png", ".svg"}
    assert all(path.stat().st_size > 500 for path in result.files)


def test_the_estimate_is_good(result):
    """Limits are about twice what is reached: they guard against something breaking,
    not against a digit."""
    assert result.errors.mass < 0.3
    assert result.errors.center_of_mass < 6.0
    assert result.errors.inertia_at_com < 25.0
    assert result.estimate.physically_consistent
    assert result.speeds[0] == pytest.approx(demo.ANGULAR_SPEED, rel=1e-6)
    # of the true mass spread evenly over the shape, which scale and drawing alone would say
    shape = Shape.from_mesh(result.mesh, unit="mm", pose=demo.POSE)
    even = InertialParameters(result.truth.mass * shape.homogeneous.vector)
    axes = np.asarray(demo.POSE)[:3, :3]
    off = errors_between(even, result.truth, shape.extents, axes)
    assert off.center_of_mass > 2.0 * result.errors.center_of_mass


def test_a_user_gets_the_same_from_the_files(result):
    facts = json.loads(result.truth_file.read_text())
    shape = Shape.from_mesh(
        result.mesh, unit=facts["mesh_unit"], pose=facts["object_pose_in_sensor"]
    )
    # single precision in STL
    np.testing.assert_allclose(shape.extents, facts["mesh_extents_m"], rtol=1e-6)
    # nothing is said of gravity there, as a user would
    assert tuple(facts["gravity_world"]) == STANDARD_GRAVITY
    found = identify(result.log, shape, wrench=facts["wrench"])
    np.testing.assert_array_equal(
        found.estimate.parameters.vector, result.estimate.parameters.vector
    )
    saved = Estimate.load(result.exports[0])
    np.testing.assert_array_equal(
        saved.parameters.vector, result.estimate.parameters.vector
    )
    assert facts["mass"] == result.truth.mass


def test_urdf_is_read_by_another_library(result):
    pin = pytest.importorskip(
        "pinocchio", reason="Pinocchio is not installed (pip install 'hefting[robot]')"
    )
    model = pin.buildModelFromUrdf(str(result.exports[1]))
    inertia = model.inertias[1]
    # exports have two digits of the interval's half: half a step is 0.05 of it at most
    estimate = result.estimate
    half = 0.5 * np.diff(estimate.interval("mass"))[0]
    assert inertia.mass == pytest.approx(estimate.mass, abs=0.051 * half)
    half = 0.5 * np.diff(estimate.interval("center_of_mass"), axis=0)[0]
    assert (np.abs(inertia.lever - estimate.center_of_mass) < 0.051 * half).all()


def test_it_repeats_without_pictures(result, tmp_path):
    again = demo.run(tmp_path, pictures=False)
    assert again.pictures == ()
    for name in ("log.csv", "truth.json", "hammer.stl"):
        assert (tmp_path / name).read_bytes() == (result.log.parent / name).read_bytes()
    np.testing.assert_array_equal(
        again.estimate.parameters.vector, result.estimate.parameters.vector
    )


def test_a_file_in_the_way_is_named(tmp_path):
    (tmp_path / "taken").write_text("")
    with pytest.raises(InputError, match="taken"):
        demo.run(tmp_path / "taken")


def test_a_log_of_something_else_is_not_written_over(tmp_path):
    (tmp_path / "log.csv").write_text("mine")
    with pytest.raises(InputError, match=r"log\.csv: holds a log of something else"):
        demo.run(tmp_path)
    assert (tmp_path / "log.csv").read_text() == "mine"


def test_importing_it_loads_nothing_heavy():
    heavy = "matplotlib", "trimesh", "pyarrow", "mujoco", "pinocchio"
    modules = "hefting.simulation.demo, hefting.plots.wrench, hefting.plots.body"
    code = f"import sys, {modules}; print([m for m in {heavy!r} if m in sys.modules])"
    shown = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, env=os.environ
    )
    assert shown.stdout.strip() == "[]", shown.stderr
