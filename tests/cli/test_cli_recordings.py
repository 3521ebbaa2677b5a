"""The command line on recordings as people have them: tools, tilted bases, bags,
joints, foreign columns."""

import json
import re
import sys
from dataclasses import replace

import numpy as np
import pytest

from hefting.cli import main
from hefting.core.inertia import InertialParameters
from hefting.core.measurements import Noise
from hefting.core.recording import Recording, Stream
from hefting.core.spatial import STANDARD_GRAVITY, in_sensor_axes
from hefting.logs import write_log
from hefting.simulation import UR5, random_smooth, simulate, wield

pytestmark = pytest.mark.usefixtures("same_commands")

pytest.importorskip("rosbags", reason="bags need rosbags")

TOOL = InertialParameters.from_com(
    0.8, (0.0, 0.01, 0.05), 1e-3 * np.diag((1.2, 1.5, 1.0))
)
OBJECT = InertialParameters.from_com(
    0.5, (0.02, 0.0, 0.12), 1e-3 * np.diag((0.9, 1.1, 0.7))
)
BOTH = InertialParameters(TOOL.vector + OBJECT.vector)
BIAS = np.array((3.0, -2.0, 5.0, 0.1, -0.2, 0.05))
NOISE = Noise(force=0.1, torque=0.005)
JOINTS = random_smooth(6.0, 100.0, 1.0, seed=4)
MOTION = UR5.motion(JOINTS)
TILTED = np.array((2.0, 1.5, -9.4832))  # by 15°
NEAR = {"rel": 0.01}
"""Of masses: by 600 samples of 0.1 N one is known to 0.1 %, by a tool and an object
apart to 0.3 %."""


def log(body, seed=1, **others):
    others = {"noise": NOISE, "bias": BIAS, "seed": seed} | others
    return simulate(MOTION, body, **others)


def saved(recording, path):
    write_log(recording, path)
    return path


@pytest.fixture
def run(monkeypatch, capsys):
    """What a command prints; its one line on standard error where it fails, with the
    status it must have."""

    def run(*words, status=0):
        monkeypatch.setattr(sys, "argv", ["hefting", *map(str, words)])
        ended = 0
        try:
            main()
        except SystemExit as stop:
            ended = stop.code
        out, err = capsys.readouterr()
        assert ended == status, err
        failed = status in (1, 2)
        assert err.count("\n") == (1 if failed else 0)
        assert "Traceback" not in err
        return err if failed else out

    return run


def identified(run, *words, status=0):
    words = ("identify", *words, "--method", "OLS", "--json")
    return json.loads(run(*words, status=status))


# tools


def test_calibrate_then_subtract(run, tmp_path):
    tool = tmp_path / "tool.json"
    told = run(
        "calibrate",
        saved(log(TOOL, on_sensor=True), tmp_path / "bare.csv"),
        "--output",
        tool,
    )
    assert f"--tool {tool}" in " ".join(told.split())
    held = saved(log(BOTH, 2, on_sensor=True), tmp_path / "held.csv")
    found = identified(run, held, "--tool", tool)
    assert found["mass"] == pytest.approx(OBJECT.mass, **NEAR)
    np.testing.assert_allclose(
        found["center_of_mass"], OBJECT.center_of_mass, atol=2e-3
    )
    assert found["provenance"]["wrench"] == "on-sensor"
    np.testing.assert_allclose(found["provenance"]["tool"], TOOL.vector, atol=2e-3)
    assert "kg, which was subtracted" in run("identify", held, "--tool", tool)
    # its bias as well, in the sensor's own sign: then none is looked for
    known = identified(run, held, "--tool", tool, "--bias", tool)
    assert known["bias"] is None
    assert "tare:START,END" in run("identify", held, "--bias", "estimat", status=2)
    np.testing.assert_allclose(known["provenance"]["bias_subtracted"], BIAS, atol=0.05)
    assert known["mass"] == pytest.approx(OBJECT.mass, **NEAR)
    bare = run("identify", tmp_path / "bare.csv", "--tool", tool, status=2)
    assert "beside the tool; nothing is held" in bare


def test_calibrate_never_overwrites_and_refuses_what_is_open(run, tmp_path):
    bare = saved(log(TOOL), tmp_path / "bare.csv")
    before = bare.read_bytes()
    assert "ends in .json" in run("calibrate", bare, "--output", bare, status=2)
    named = bare.rename(tmp_path / "bare.json")
    assert "would be overwritten" in run(
        "calibrate", named, "--output", named, status=2
    )
    assert named.read_bytes() == before
    named.rename(bare)
    assert "does not exist" in run(
        "calibrate", bare, "--output", tmp_path / "no" / "tool.json", status=2
    )
    rows = np.arange(2.0)
    poses = {
        name: Stream(rows, log(TOOL)[name].values[[0, 300]])
        for name in ("orientation", "wrench")
    }
    two = saved(Recording(poses, static=True), tmp_path / "two.csv")
    assert "centre of mass open" in run(
        "calibrate", two, "--output", tmp_path / "tool.json", status=2
    )
    assert not (tmp_path / "tool.json").exists()


# gravity


def test_gravity_of_a_tilted_base(run, tmp_path):
    tilted = saved(log(BOTH, gravity=TILTED), tmp_path / "tilted.csv")
    found = identified(run, tilted, "--gravity", "estimate")
    assert found["mass"] == pytest.approx(BOTH.mass, **NEAR)
    np.testing.assert_allclose(
        found["provenance"]["gravity"],
        TILTED / np.linalg.norm(TILTED) * 9.80665,
        atol=0.02,
    )
    assert found["provenance"]["gravity_found"]
    told = " ".join(run("inspect", tilted).split())
    assert re.search(r"suggest 14\.[789]° ± 0\.\d+° from it", told)
    assert "verdict: do not use - gravity seems to point along" in told


def test_an_accelerometer_is_used_with_the_gravity_found(run, tmp_path):
    """Read with gravity straight down it would seem to be off by 2 m/s², and have
    another place and clock."""
    recording = log(BOTH, gravity=TILTED)
    felt = wield(MOTION, BOTH, TILTED)
    noise = 0.02 * np.random.default_rng(0).normal(size=felt.gravity.shape)
    imu = Stream(MOTION.time, felt.linear_acceleration - felt.gravity + noise)
    path = saved(
        replace(recording, streams={**recording.streams, "accelerometer": imu}),
        tmp_path / "imu.csv",
    )
    notes = " ".join(
        identified(run, path, "--gravity", "estimate")["provenance"]["notes"]
    )
    assert re.search(r"accelerometer used: noise 0\.0(1[5-9]|2\d?) m", notes)
    upright = identified(run, path, status=3)
    warnings = " ".join(upright["warnings"])
    assert "give --gravity estimate" in upright["reasons"][0]
    assert "the accelerometer contradicts the poses: not used" in warnings
    assert "gravity as given?" in warnings


@pytest.mark.parametrize("case", ["one turn", "one pose", "few poses"])
def test_gravity_that_the_motion_does_not_tell_is_refused(run, tmp_path, case):
    static = case == "few poses"
    time = np.arange(8.0) if static else np.arange(300) * 0.01
    angle = {"one turn": 0.02, "one pose": 0.0, "few poses": 1.0}[case] * time
    q = np.column_stack(
        (np.sin(angle / 2.0), 0.0 * angle, 0.0 * angle, np.cos(angle / 2.0))
    )
    g = in_sensor_axes(q, np.array(STANDARD_GRAVITY))
    force = -BOTH.mass * g
    rng = np.random.default_rng(0)
    wrench = np.column_stack((force, np.cross(BOTH.center_of_mass, force)))
    wrench = wrench + np.repeat((0.1, 0.005), 3) * rng.normal(size=wrench.shape)
    poses = Recording(
        {"orientation": Stream(time, q), "wrench": Stream(time, wrench)}, static=static
    )
    path = saved(poses, tmp_path / "log.csv")
    told = run("identify", path, "--gravity", "estimate", "--bias", "none", status=2)
    assert "does not determine the direction of gravity" in told
    assert "--gravity X,Y,Z" in told


# a static pose that is wrong, a bias that drifts


def test_an_odd_pose_is_left_out(run, tmp_path):
    rng = np.random.default_rng(3)
    q = rng.normal(size=(20, 4))
    q /= np.linalg.norm(q, axis=1)[:, None]
    force = -BOTH.mass * in_sensor_axes(q, np.array(STANDARD_GRAVITY))
    wrench = np.column_stack((force, np.cross(BOTH.center_of_mass, force))) + BIAS
    wrench += np.repeat((0.1, 0.005), 3) * rng.normal(size=wrench.shape)
    clean = wrench.copy()
    wrench[6] += (0.0, 8.0, 0.0, 0.3, 0.0, 0.0)
    rows = np.arange(20.0)
    found = []
    for values in (clean, wrench):
        poses = Recording(
            {"orientation": Stream(rows, q), "wrench": Stream(rows, values)},
            static=True,
        )
        found.append(identified(run, saved(poses, tmp_path / "poses.csv")))
    assert [f["samples"] for f in found] == [20, 19]
    assert "1 odd pose (5 %) left out: 7" in found[1]["provenance"]["notes"]
    assert abs(found[1]["mass"] - found[0]["mass"]) < 2.0 * found[0]["std"]["mass"]


def test_a_drift_that_a_given_bias_leaves_in_is_said(run, tmp_path):
    recording = simulate(
        UR5.motion(random_smooth(12.0, 100.0, 1.0, 4)), BOTH, noise=NOISE, seed=1
    )
    wrench = recording["wrench"]
    values = (
        wrench.values + np.array((2.0, 0, 0, 0, 0, 0)) * (wrench.time / 12.0)[:, None]
    )
    drifting = replace(
        recording,
        streams={**recording.streams, "wrench": replace(wrench, values=values)},
    )
    path = saved(drifting, tmp_path / "log.csv")
    assert "leaves its drift in" in " ".join(
        identified(run, path, "--bias", "none")["warnings"]
    )
    free = identified(run, path)
    assert any(
        line.startswith("the bias drifts by") for line in free["provenance"]["notes"]
    )
    assert not any("drift" in line for line in free["warnings"])
    assert free["mass"] == pytest.approx(BOTH.mass, **NEAR)


# formats


def test_a_bag(run, tmp_path):
    path = saved(log(BOTH), tmp_path / "log.mcap")
    found = identified(run, path)
    assert found["mass"] == pytest.approx(BOTH.mass, **NEAR)
    assert any("/wrench" in line for line in found["provenance"]["notes"])
    said = run("identify", path, "--wrench-topic", "/ft", status=2)
    assert "/wrench" in said.partition("'/ft'")[2]
    data = path.read_bytes()
    path.write_bytes(data[: int(0.7 * len(data))])
    assert "truncated" in run("identify", path)
    assert "truncated" in run("inspect", path)


def test_two_topics_that_may_be_meant(run, tmp_path):
    from bag_messages import basic, pose, wrench
    from bags import write

    path = write(
        tmp_path,
        "bare.mcap",
        basic(wrench, lambda k: wrench(k, topic="/ft/filtered"), pose),
    )
    said = run("identify", path, status=2)
    assert all(
        word in said for word in ("/ft/wrench", "/ft/filtered", "--wrench-topic")
    )


def test_joints_and_a_robot(run, tmp_path):
    pytest.importorskip("pinocchio", reason="kinematics needs pinocchio")
    from urdfs import UR5_URDF

    robot = tmp_path / "robot.urdf"
    robot.write_text(UR5_URDF)
    recording = log(BOTH)
    streams = {
        "joint_positions": Stream(MOTION.time, JOINTS.position),
        "wrench": recording["wrench"],
    }
    path = saved(Recording(streams), tmp_path / "joints.csv")
    found = identified(run, path, "--urdf", robot, "--sensor-frame", "tool0")
    np.testing.assert_allclose(found["center_of_mass"], BOTH.center_of_mass, atol=1e-3)
    said = run("identify", path, "--urdf", robot, "--sensor-frame", "wrist", status=2)
    assert "tool0" in said.partition("wrist")[2]
    assert "--sensor-frame" in run("identify", path, "--urdf", robot, status=2)
    assert "--urdf" in run("inspect", path)


def test_a_column_map(run, tmp_path):
    recording = log(BOTH)
    p, q, w = (recording[name].values for name in ("position", "orientation", "wrench"))
    table = np.column_stack(
        (1e3 * MOTION.time, 1e3 * p, q[:, [3, 0, 1, 2]], w[:, :3], 1e3 * w[:, 3:])
    )
    names = "ms,x,y,z,q0,q1,q2,q3," + ",".join(f"ft_{i}" for i in range(6))
    np.savetxt(tmp_path / "theirs.csv", table, delimiter=",", header=names, comments="")
    (tmp_path / "map.toml").write_text(
        'time = { column = "ms", unit = "ms" }\nposition = { columns = ["x", "y", "z"], unit = "mm" }\n'
        'orientation = { columns = "q{0..3}", form = "wxyz" }\n'
        'wrench = { columns = "ft_{0..5}", unit = ["N", "N mm"] }\n'
    )
    found = identified(run, tmp_path / "theirs.csv", "--map", tmp_path / "map.toml")
    assert found["mass"] == pytest.approx(BOTH.mass, **NEAR)
    np.testing.assert_allclose(found["center_of_mass"], BOTH.center_of_mass, atol=1e-3)


def test_a_payload_the_controller_has_removed(run, tmp_path):
    from ur_records import COUNT, FORCE_ONLY, record

    path = record(tmp_path / "ur.csv", *FORCE_ONLY, payload=np.full((COUNT, 1), 1.25))
    assert "already removed a payload of 1.25 kg" in run("identify", path, status=2)
