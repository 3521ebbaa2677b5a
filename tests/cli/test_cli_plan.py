"""hefting plan: what it prints, writes and refuses."""

import json

import numpy as np
import pytest

from commands import refused
from folding_arm import JOINTS, folding_arm
from hasty_pictures import draw_hastily
from hefting.core.estimate import Estimate
from hefting.core.inertia import InertialParameters
from hefting.core.measurements import Noise
from hefting.core.messages import Message
from hefting.core.spatial import rotation_matrices
from hefting.logs import write_log
from hefting.planning import plan
from hefting.robots import Robot
from hefting.simulation import UR5, random_smooth, simulate
from plans import search_briefly
from urdfs import UR5_URDF

BOX = np.array([[x, y, z] for x in (-0.05, 0.05) for y in (-0.05, 0.05) for z in (0.0, 0.2)])  # fmt: skip
SHAPE = ("--box", "0.1,0.1,0.2", "--object-pose", "0,0,0.1,0,0,0,1")
TORQUES = (*SHAPE, "--torques")
SPEED, LIMIT = 0.25, 1.0
"""[m/s] of corners by default, [rad/s] of the joints in the URDF"""
BODY = InertialParameters.from_com(0.8, (0.0, 0.0, 0.1), np.diag((3e-3, 3e-3, 1e-3)))


@pytest.fixture(autouse=True)
def brief(monkeypatch):
    """Searches are brief: every plan keeps its limits, whatever it tells."""
    search_briefly(monkeypatch)


@pytest.fixture
def arm(tmp_path):
    """The simulation's UR5, without geometry."""
    path = tmp_path / "ur5.urdf"
    path.write_text(UR5_URDF)
    return path


def words(urdf, *more, tip="tool0"):
    return "plan", "--urdf", urdf, "--tip", tip, "--quick", *more


def table_of(path):
    return np.loadtxt(path, delimiter=",", skiprows=1)


def corner_steps(path, urdf, tip="tool0"):
    """Ways (K - 1, 8) [m] of the box's corners from sample to sample, and their
    positions (K, 8, 3), by the robot's poses alone."""
    table = table_of(path)
    position, orientation = Robot.from_urdf(urdf, tip).poses(table[:, 1:])
    turned = np.einsum("kij,cj->kci", rotation_matrices(orientation), BOX)
    corners = position[:, None] + turned
    return np.linalg.norm(np.diff(corners, axis=0), axis=2), corners


def test_every_file_holds_the_plan_that_is_told(run, arm, tmp_path, monkeypatch):
    draw_hastily(monkeypatch)
    names = [f"m{s}" for s in (".csv", ".json", ".mcap", ".script", ".png", ".html")]
    outputs = [word for name in names for word in ("--output", tmp_path / name)]
    status, out, err = run(*words(arm, *SHAPE, "--duration", 4, "--json", *outputs))
    assert (status, err) == (0, "")
    told = json.loads(out)
    assert told["schema"] == "hefting.plan/1"
    assert told["duration"] == 4.0
    assert all((tmp_path / name).stat().st_size > 1000 for name in names)
    table = table_of(tmp_path / "m.csv")
    # nine digits after the point
    np.testing.assert_allclose(table[:, 0], told["time"], atol=1e-9)
    np.testing.assert_allclose(table[:, 1:], told["position"], atol=1e-9)
    message = json.loads((tmp_path / "m.json").read_text())
    assert message["joint_names"] == told["joints"]
    first = [point["positions"] for point in message["points"]]
    np.testing.assert_array_equal(first, told["position"])


def test_the_motion_keeps_what_is_said(run, arm, tmp_path):
    """By differences of the file's numbers: what moves at most at a speed goes no
    farther than that in each step."""
    path = tmp_path / "m.csv"
    status, out, _ = run(*words(arm, *SHAPE, "--duration", 4, "--output", path))
    assert status == 0
    assert f"wrote {path}" in " ".join(out.split())
    assert "keeps reduced speed" in out
    assert "safe" not in out
    table = table_of(path)
    step = np.diff(table[:, 0])[:, None]
    # nine digits of angles, of an arm of 1 m
    assert (corner_steps(path, arm)[0] <= SPEED * step + 1e-8).all()
    assert (np.abs(np.diff(table[:, 1:], axis=0)) <= LIMIT * step + 1e-8).all()
    still = np.abs(np.diff(table[[0, 1, -2, -1], 1:], axis=0)[[0, -1]])
    assert still.max() < 1e-4  # at rest at both ends


def test_a_faster_motion_is_told_to_be_above_reduced_speed(run, arm, tmp_path):
    path = tmp_path / "m.script"
    given = words(arm, *SHAPE, "--duration", 4, "--speed", 2, "--output", path)
    status, out, _ = run(*given)
    assert status == 0
    told = json.loads(run(*given, "--json")[1])
    fastest = 2e3 * told["usage"]["corner_speed"]
    assert fastest > 250.0
    text, above = " ".join(out.split()), "is above reduced speed (250 mm/s)"
    assert f"{above}: the fastest corner of the object" in text
    assert f"moves at {fastest:.0f} of 2000 mm/s" in text
    header = path.read_text()
    assert f"{above}: at most 2000 mm/s" in header
    assert "keeps reduced speed" not in text + header


def test_without_a_shape_the_speed_is_that_of_the_assumed_box(run, arm, tmp_path):
    path = tmp_path / "m.script"
    status, out, _ = run(*words(arm, "--duration", 4, "--output", path))
    assert status == 0
    text = " ".join(out.split())
    said = "keeps reduced speed within the assumed box"
    assert f"{said}: the fastest corner of the assumed box moves at" in text
    assert "a part of the object outside it may be faster" in text
    assert said in path.read_text()


def test_the_report_says_what_json_holds(run, arm):
    given = words(arm, *SHAPE, "--duration", 3, "--until", "mass=2%,com=20mm")
    status, out, _ = run(*given)
    assert status == 0
    told = json.loads(run(*given, "--json")[1])
    after = told["forecast"]["accuracy"][-1]
    rows = {line.split()[0]: line.split() for line in out.splitlines() if line.split()}
    assert float(rows["mass"][2]) == pytest.approx(1e2 * after["mass"], rel=0.06)
    com = 1e3 * after["center_of_mass"]
    assert float(rows["COM"][2]) == pytest.approx(com, rel=0.06)  # two digits
    assert rows["mass"][3] == "2"
    assert rows["COM"][3] == "20"
    assert f"expected after {told['time_needed']:.3g} s" in out
    for message in told["messages"]:
        assert message["text"].split(",")[0][:40] in " ".join(out.split())


def test_half_spaces_are_kept_by_object_and_links(run, tmp_path):
    arm = folding_arm(tmp_path)
    path = tmp_path / "m.csv"
    keep = ("--keep", "z>=0.3", "--keep", "1,1,0<=0.6")
    given = words(arm, *SHAPE, *keep, "--duration", 3, "--output", path, tip="tool")
    status, _, err = run(*given)
    assert (status, err) == (0, "")
    corners = corner_steps(path, arm, "tool")[1]
    assert corners[..., 2].min() >= 0.3
    assert corners[..., :2].sum(axis=2).max() <= 0.6


def test_the_seed_is_the_librarys(run, arm, tmp_path):
    """Another than the default; that each has a plan of its own is tested there."""
    path = tmp_path / "m.csv"
    given = ("--duration", 2, "--seed", 2, "--output", path)
    assert run(*words(arm, *given))[0] == 0
    found = plan(arm, "tool0", duration=2.0, effort="quick", seed=2)
    # nine digits after the point
    np.testing.assert_allclose(table_of(path)[:, 1:], found.motion.position, atol=1e-9)


def test_it_begins_with_what_an_estimate_knows(run, arm, tmp_path):
    spread = np.diag(np.repeat((0.01, 0.002, 0.01), (1, 3, 6)) ** 2)
    Estimate("Bayes", BODY, 100, covariance=spread).save(tmp_path / "now.json")
    given = ("--duration", 3, "--estimate", tmp_path / "now.json", "--json")
    status, out, _ = run(*words(arm, *given))
    assert status == 0
    before, *_, after = json.loads(out)["forecast"]["accuracy"]
    # 95 % of 0.01 kg of 0.8 kg
    assert before["mass"] == pytest.approx(1.96 * 0.01 / 0.8, rel=0.05)
    assert after["mass"] < before["mass"]


@pytest.mark.parametrize(("severity", "status"), [("warning", 0), ("error", 3)])
def test_a_doubtful_estimate_is_told(run, arm, tmp_path, severity, status):
    doubt = Message("wrench-sign", "the sign is wrong", severity)
    spread = np.diag(np.repeat((0.01, 0.002, 0.01), (1, 3, 6)) ** 2)
    known = Estimate("Bayes", BODY, 100, covariance=spread, warnings=(doubt,))
    known.save(tmp_path / "now.json")
    given = words(arm, "--duration", 2, "--estimate", tmp_path / "now.json")
    own, out, _ = run(*given)
    assert own == status
    assert f"{severity}: of the estimate: {doubt}" in out


def test_noise_and_start_are_those_given(run, arm):
    start = (0.1, -1.2, 1.3, -0.4, 0.5, 0.6)
    given = ("--start", ",".join(map(str, start)), "--sensor-noise", "0.2N,4mNm")
    told = json.loads(run(*words(arm, *given, "--duration", 2, "--json"))[1])
    assert told["settings"]["noise"] == {"force": 0.2, "torque": 0.004}
    np.testing.assert_allclose(told["position"][0], start, atol=1e-12)


def test_noise_is_that_of_a_recording(run, arm, tmp_path):
    motion = UR5.motion(random_smooth(4.0, 100.0, 1.0, seed=3))
    noise = Noise(force=0.3, torque=0.02)
    log = tmp_path / "log.csv"
    write_log(simulate(motion, BODY, noise=noise, seed=1), log)
    given = ("--noise-from", log, "--duration", 2, "--json")
    settings = json.loads(run(*words(arm, *given))[1])["settings"]
    # of some 400 samples, and of motion that was smoothed with them
    assert settings["noise"]["force"] == pytest.approx(0.3, rel=0.3)
    assert settings["noise"]["torque"] == pytest.approx(0.02, rel=0.3)
    assert settings["rate"] == pytest.approx(100.0, rel=1e-6)


def test_torques_are_planned_for_with_their_noise(run, arm):
    pytest.importorskip("pinocchio")
    given = (*TORQUES, "--torque-noise", "0.2", "--duration", 3, "--json")
    status, out, err = run(*words(arm, *given))
    assert (status, err) == (0, "")
    told = json.loads(out)
    assert told["settings"]["noise"] == {"joint_torques": [0.2] * 6}
    assert "plan-empty-run-assumed" in {own["code"] for own in told["messages"]}
    before, *_, after = told["forecast"]["accuracy"]
    assert before["mass"] is None
    # 0.2 N m at 0.5 m, of some 300 samples of a few joints, is 7 g of 1 kg; offsets and
    # friction that change between the runs add several times that
    assert 0.002 < after["mass"] < 0.05


def test_stop_and_go_rests(run, arm, tmp_path):
    path = tmp_path / "m.csv"
    given = (*SHAPE, "--stop-and-go", "--duration", 8, "--output", path)
    status, out, err = run(*words(arm, *given))
    assert (status, err) == (0, "")
    table = table_of(path)
    moves = np.abs(np.diff(table[:, 1:], axis=0)).max(axis=1) > 1e-9
    rests = np.flatnonzero(np.diff(moves.astype(int)) == -1)  # after each move
    assert len(rests) >= 3
    assert (corner_steps(path, arm)[0] <= SPEED * 0.01 + 1e-8).all()
    assert "keeps reduced speed" in out


@pytest.mark.parametrize(
    ("given", "said"),
    [
        (("--tip", "tol0"), ("no frame is named 'tol0'", "did you mean 'tool0'")),
        (("--start", "7,0,0,0,0,0"), ("'joint_1' starts at 7 rad", "--start")),
        (("--start", "0,0"), ("--start", "joint_1, joint_2")),
        (("--until", "mass=1e-6%"), ("nor by any longer motion", "sensor")),
        (("--until", "inertia=10%"), ("out of reach within 2 s", "plan for about")),
        (("--until", "weight=1"), ("--until", "mass=1%")),
        (("--keep", "z>0"), ("'z>0' is no half-space", "z>=0.05")),
        (("--speed", "0"), ("--speed", "not positive")),
        (("--speed", "250"), ("--speed", "at 250 m/s", "give m/s, as in 0.25")),
        (("--duration", "0.1"), ("--duration", "1 to 120 s")),
        (("--seed", "-1"), ("--seed", "negative")),
        (("--rate", "0"), ("--rate", "10 to 10,000 Hz")),
        (("--sensor-noise", "0N,1Nm"), ("--sensor-noise", "is not positive")),
        (("--sensor-noise", "1,2"), ("--sensor-noise", "N, mN")),
        (("--sensor-range", "1"), ("--sensor-range", "100N,5Nm")),
        (("--sensor-range", "1N,5Nm"), ("the sensor's range of force", "relax")),
        (
            ("--acceleration", "1,2"),
            ("--acceleration: is not", "6 of them, one for each joint"),
        ),
        (("--jerk", "x"), ("--jerk", "is not a finite number")),
        (("--jerk", "1,x"), ("--jerk", "2 finite numbers")),
        (("--gravity", "0,0,0"), ("gravity", "not all zero")),
        (("--output", "motion.txt"), ("'.txt' is not an output format", ".csv")),
        (("--stop-and-go", "--until", "inertia=9%"), ("rests do not show an inertia",)),
        (("--estimate", "none.json"), ("none.json",)),
        (("--srdf", "none.srdf"), ("none.srdf",)),
        (("--shape", "none.stl"), ("none.stl",)),
        (("--torques",), ("without a shape", "--shape FILE or --box")),
        (("--torque-noise", "0.1"), ("--torque-noise", "give --torques as well")),
        ((*TORQUES, "--sensor-noise", "1N,1Nm"), ("--sensor-noise: is of a wrench",)),
        ((*TORQUES, "--noise-from", "a.csv"), ("--noise-from: is of a wrench",)),
        ((*TORQUES, "--sensor-range", "1N,1Nm"), ("--sensor-range: is of a wrench",)),
        ((*TORQUES, "--stop-and-go"), ("torques of joints at rest are of no use",)),
        ((*TORQUES, "--torque-noise", "0.1,0.1"), ("of all or of 6 joints",)),
        ((*TORQUES, "--torque-noise", "0"), ("not positive",)),
        (
            (*TORQUES, "--torque-noise", "x"),
            ("--torque-noise", "is not a finite number"),
        ),
    ],
)
def test_what_cannot_be_is_one_line(run, arm, given, said):
    assert refused(run(*words(arm, "--duration", 2, *given)), *said)


def test_limits_that_are_missing_are_named(run, tmp_path):
    bent = JOINTS[2].replace('velocity="2"', "")
    path = folding_arm(tmp_path, joints=(*JOINTS[:2], bent, *JOINTS[3:]))
    result = run(*words(path, tip="tool"))
    assert refused(result, "joint 'bend'", "limit of its speed", "velocity=")
    endless = JOINTS[2].replace('lower="-2.9" upper="2.9"', "")
    path = folding_arm(tmp_path, joints=(*JOINTS[:2], endless, *JOINTS[3:]))
    result = run(*words(path, tip="tool"))
    assert refused(result, "joint 'bend'", "no lower and upper limit")


def test_a_start_in_collision_names_what_touches(run, tmp_path):
    path = folding_arm(tmp_path)
    start = ("--start", "0,0,2.9,0")
    result = run(*words(path, *SHAPE, *start, tip="tool"))
    assert refused(
        result,
        "the start is in collision by 40 mm: link 'base' and the object",
        "--start",
    )


def test_an_estimate_without_covariance_is_refused(run, arm, tmp_path):
    Estimate("PMD", BODY, 100).save(tmp_path / "now.json")
    result = run(*words(arm, "--estimate", tmp_path / "now.json"))
    assert refused(result, "no covariance to plan from", "identify with Bayes")


def test_nothing_is_written_where_a_file_cannot_be(run, tmp_path, monkeypatch):
    """URScript is for six joints, which is told before the search; the CSV before it is
    not written either."""
    monkeypatch.delattr("hefting.planning.plan")
    path = folding_arm(tmp_path)
    outputs = ("--output", tmp_path / "m.csv", "--output", tmp_path / "m.script")
    result = run(*words(path, "--duration", 2, *outputs, tip="tool"))
    assert refused(result, "6 joints", "write .csv")
    assert not (tmp_path / "m.csv").exists()


def test_inputs_are_not_overwritten(run, arm):
    assert refused(run(*words(arm, "--output", arm)), "is not an output format")
