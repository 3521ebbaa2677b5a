"""hefting simulate: logs of every format, the truth beside them, and identify reading
them back."""

import json
import shlex
import sys

import numpy as np
import pytest
import trimesh

from hefting.logs import read_log
from hefting.simulation import UR5, Faults, Rates, held_modular
from hefting.simulation.scenario import Scenario, named_object

pytest.importorskip(
    "mujoco", reason="MuJoCo is not installed (pip install 'hefting[sim]')"
)


@pytest.fixture(autouse=True)
def folder(monkeypatch, tmp_path):
    """Commands run in a folder of their own."""
    monkeypatch.chdir(tmp_path)


def errors_read_back(run, out):
    """Errors of `hefting identify`, by the command that was printed."""
    command = next(
        line for line in out.splitlines() if line.startswith("read it back: ")
    )
    status, out, err = run(*shlex.split(command.partition(": hefting ")[2]), "--json")
    assert status == 0, err
    return json.loads(out)["errors"]


def test_there_and_back(run, tmp_path):
    status, out, _ = run("simulate", "log.csv", "--mesh", "shape.stl", "--speed", 1.5)
    assert status == 0
    assert "wrench from MuJoCo" in out
    errors = errors_read_back(run, out)
    # with a sensor's noise and smoothed poses: found .001, .16 and 1.9 %
    assert errors["mass"] < 0.1
    assert errors["center_of_mass"] < 1.0
    assert errors["inertia_at_com"] < 8.0
    facts = json.loads((tmp_path / "log.truth.json").read_text())
    assert facts["mass"] == pytest.approx(
        held_modular("hammer").parameters.mass, rel=1e-12
    )
    assert facts["simulation"]["mean_angular_speed"] == pytest.approx(1.5, rel=1e-6)
    assert trimesh.load_mesh(tmp_path / "shape.stl").is_watertight


@pytest.mark.parametrize("output", ["log.parquet", "log.bag", "log.mcap", "bag"])
def test_every_format_holds_the_same_log(run, tmp_path, output):
    if output != "log.parquet":
        pytest.importorskip(
            "rosbags", reason="rosbags is not installed (pip install 'hefting[ros]')"
        )
    words = ["--duration", 2, "--joint-rate", 50, "--imu-rate", 200, "--seed", 3]
    assert run("simulate", "log.csv", *words)[0] == 0
    status, _, err = run("simulate", output, *words)
    assert status == 0, err
    expected, found = read_log(tmp_path / "log.csv"), read_log(tmp_path / output)
    assert set(found.streams) == set(expected.streams)
    for name, stream in expected.streams.items():
        # bags count nanoseconds
        np.testing.assert_allclose(found[name].time, stream.time, atol=1e-9)
        np.testing.assert_array_equal(found[name].values, stream.values)
    assert expected.rates()["gyroscope"] == pytest.approx(200.0)


def test_everything_wrong_at_once_is_found(run):
    """Offset, bias, drift, sign, tilt, spikes and losses: the conditioned estimate is
    still the object's."""
    status, out, err = run(
        "simulate", "log.csv", "--object", "tee", "--arm", "xarm7", "--motion", "random", "--noise", "moderate",
        "--bias", 20, "--drift", 0.5, "--offset", 0.03, "--spikes", 0.02, "--dropped", 0.05, "--tilt", 15,
        "--on-sensor", "--seed", 5, "--mesh", "shape.ply",
    )  # fmt: skip
    assert status == 0, err
    errors = errors_read_back(run, out)
    assert errors["mass"] < 1.0
    assert errors["center_of_mass"] < 5.0


def test_own_meshes_and_a_urdf(run, tmp_path):
    """A body of two materials on an arm by URDF, of which the log has the joint angles
    alone."""
    trimesh.creation.box((80, 40, 40)).apply_translation((40, 0, 60)).export(
        tmp_path / "head.stl"
    )
    trimesh.creation.box((30, 30, 30)).apply_translation((0, 0, 25)).export(
        tmp_path / "grip.stl"
    )
    chain = '<link name="base"/>'
    for i, axis in enumerate(("0 0 1", "0 1 0", "0 0 1", "0 1 0", "1 0 0"), 1):
        parent = "base" if i == 1 else f"l{i - 1}"
        chain += (
            f'<link name="l{i}"/><joint name="j{i}" type="revolute"><parent link="{parent}"/><child link="l{i}"/>'
            f'<origin xyz="0.05 0 0.2"/><axis xyz="{axis}"/><limit lower="-2" upper="2.5"/></joint>'
        )
    (tmp_path / "arm.urdf").write_text(f'<robot name="five">{chain}</robot>')
    status, out, err = run(
        "simulate", "log.csv", "--object", "head.stl,grip.stl", "--density", "7850,680", "--unit", "mm",
        "--arm", "arm.urdf", "--sensor-frame", "l5", "--pose-rate", 0, "--joint-rate", 100, "--motion", "stop-and-go",
    )  # fmt: skip
    assert status == 0, err
    assert set(read_log(tmp_path / "log.csv").streams) == {"wrench", "joint_positions"}
    facts = json.loads((tmp_path / "log.truth.json").read_text())
    assert facts["mass"] == pytest.approx(7850 * 128e-6 + 680 * 27e-6, rel=1e-6)
    assert facts["mesh_extents_m"] == pytest.approx((0.095, 0.04, 0.07), rel=1e-6)
    assert "--urdf arm.urdf --sensor-frame l5" in out
    assert errors_read_back(run, out)["mass"] < 0.2


@pytest.mark.parametrize("joints", [0, 100])
def test_a_log_without_poses_has_no_line_that_reads_it_back(run, joints):
    """Nor with joint angles: of the arms that are built in there is no URDF."""
    words = ("--duration", 1, "--pose-rate", 0, "--joint-rate", joints)
    status, out, err = run("simulate", "log.csv", *words)
    assert status == 0, err
    assert "read it back:" not in out
    assert "cannot read it back, as it has no poses: leave out --pose-rate 0" in out


def test_speed_and_joints_are_told(run):
    out = run("simulate", "log.csv", "--speed", 4, "--duration", 5)[1]
    assert "warning: joint6 turns at up to" in out
    assert "ISO 10218-1 allows 0.25 m/s" in out
    out = run(
        "simulate", "log.csv", "--speed", 4, "--duration", 5, "--speed-limit", 0.25
    )[1]
    assert "warning" not in out


@pytest.mark.parametrize(
    ("words", "expected"),
    [
        (["log.txt"], "'.txt' is not a log format to write"),
        (["no/log.csv"], "no/log.csv: the folder does not exist"),
        ([".", "--torques"], "hefting: .: exists already; choose another name"),
        (["./"], "exists already; choose another name"),
        (["/"], "hefting: /: exists already; choose another name"),
        (["-"], "hefting: -: is no name of a file; choose another name"),
        (["log.csv", "--truth", "-"], "-: is no name of a file"),
        (["log.csv", "--truth", "log.csv"], "two results would have this name"),
        (["log.csv", "--mesh", "shape.doc"], "is not a mesh format"),
        (["log.csv", "--object", "hamer"], "did you mean 'hammer'"),
        (["log.csv", "--object", "box.stl"], "0 densities for 1 mesh(es)"),
        (
            ["log.csv", "--object", "box.stl", "--density", "1000"],
            "box.stl: no such file",
        ),
        (
            ["log.csv", "--object", "tee", "--density", "1000"],
            "what 'tee' is made of is known",
        ),
        (["log.csv", "--arm", "ur6"], "did you mean 'ur5'"),
        (["log.csv", "--arm", "arm.urdf"], "give --sensor-frame NAME"),
        (
            ["log.csv", "--arm", "ur5", "--sensor-frame", "tool0"],
            "has its sensor at its flange",
        ),
        (["log.csv", "--motion", "randm"], "did you mean 'random'"),
        (
            ["log.csv", "--motion", "stop-and-go", "--speed", "2"],
            "stop-and-go has no speed",
        ),
        (
            ["log.csv", "--speed", "-1"],
            "must be positive, but are 10 s, 100 Hz and -1 rad/s",
        ),
        (["log.csv", "--duration", "0.011"], "less than two samples; simulate longer"),
        (["log.csv", "--duration", "nan"], "samples"),
        (
            ["log.csv", "--rate", "99.7", "--pose-rate", "125.3", "--duration", "1000"],
            "more than 5,000,000 samples",
        ),
        (["log.csv", "--rate", "0", "--pose-rate", "0"], "nothing is to be recorded"),
        (["log.csv", "--rate", "inf"], "the wrench rate is inf Hz"),
        (["log.csv", "--noise", "ft30"], "did you mean 'ft300'"),
        (["log.csv", "--bias", "1,2,3"], "is not 6 finite numbers"),
        (
            ["log.csv", "--dropped", "1.5"],
            "dropped is 1.5; give a share from 0 to below 1",
        ),
        (["log.csv", "--tilt", "nan"], "--tilt: 'nan' is not an angle"),
        (["log.csv", "--seed", "-3"], "--seed: '-3' is negative"),
    ],
)
def test_bad_input_is_one_line(run, tmp_path, words, expected):
    status, _, err = run("simulate", *words)
    assert status == 2
    assert expected in err
    assert err.count("\n") == 1
    assert not list(tmp_path.iterdir())


def test_a_recording_given_as_the_truth_is_kept(run, tmp_path):
    """For other commands --truth is an input."""
    (tmp_path / "own.csv").write_text("a recording")
    status, _, err = run("simulate", "log.csv", "--duration", 1, "--truth", "own.csv")
    assert status == 2
    assert err == (
        "hefting: own.csv: '.csv' is not JSON, as which --truth is written; "
        "give it a name that ends in .json\n"
    )
    assert [path.name for path in tmp_path.iterdir()] == ["own.csv"]
    assert (tmp_path / "own.csv").read_text() == "a recording"
    status, _, err = run("simulate", "log.csv", "--duration", 1, "--truth", "own")
    assert status == 0, err


def test_without_mujoco_the_way_to_get_it_is_said(run, monkeypatch, tmp_path):
    monkeypatch.setitem(sys.modules, "mujoco", None)
    status, _, err = run("simulate", "log.csv")
    assert status == 1
    assert err == "hefting: mujoco is not installed; run: pip install 'hefting[sim]'\n"
    assert not list(tmp_path.iterdir())


# the library beneath


def test_a_scenario_is_its_seed():
    held = named_object("corners")
    scenario = Scenario(
        held, UR5, "random", duration=3.0, faults=Faults(spikes=0.1), seed=9
    )
    first, again = scenario.run(), scenario.run()
    for name in first.recording.streams:
        np.testing.assert_array_equal(
            first.recording[name].values, again.recording[name].values
        )
    assert json.dumps(first.facts) == json.dumps(again.facts)
    np.testing.assert_array_equal(
        first.facts["inertia_at_sensor"], held.parameters.inertia_at_origin
    )


def test_rates_that_are_no_multiples_of_each_other():
    """The motion is computed at their lowest common multiple: nothing is
    interpolated."""
    scenario = Scenario(
        named_object("empty"),
        duration=2.0,
        rates=Rates(wrench=100.0, pose=125.0, joints=0.0, imu=0.0),
    )
    made = scenario.run()
    assert len(made.wielding.motion.time) == 1000
    assert len(made.recording["wrench"]) == 200
    assert len(made.recording["position"]) == 250


def test_the_joiners_hammer_and_another_grasp():
    assert named_object("joiners-hammer").parameters.mass == pytest.approx(
        0.670, abs=1e-3
    )
    pose = np.eye(4)
    pose[:3, 3] = (0.1, 0.2, 0.3)
    moved = named_object("tee", pose=pose)
    np.testing.assert_allclose(
        moved.parameters.center_of_mass,
        moved.in_object.center_of_mass + pose[:3, 3],
        atol=1e-15,
    )
