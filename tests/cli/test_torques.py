"""hefting identify and calibrate --torques, on simulated logs of a UR5e; and bad input,
each refused in one line with exit status 2. About 15 s."""

import json
import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from commands import refused
from hefting.core.inertia import InertialParameters
from hefting.core.recording import Recording, Stream
from hefting.logs import read_log, write_log
from hefting.simulation.joints import wide_smooth
from hefting.simulation.torque_scenario import TORQUE_ARMS, TorqueRobot

pytestmark = pytest.mark.usefixtures("same_commands")

BODY = InertialParameters.from_com(
    1.1, [0.02, -0.01, 0.08], np.diag([4e-3, 5e-3, 2.5e-3])
)
GAINS = np.array((11.0, 11.0, 10.0, 9.0, 8.0, 8.0))


@pytest.fixture(scope="module")
def folder(tmp_path_factory) -> Path:
    """Logs of an empty and a loaded run, and the URDF."""
    path = tmp_path_factory.mktemp("torques")
    massive = TORQUE_ARMS["ur5e"]
    (path / "arm.urdf").write_text(massive.urdf)
    robot = TorqueRobot(massive, seed=2)
    again = robot.record(wide_smooth(20.0, 50.0, 7, massive.arm), None, 30.0, seed=7)
    write_log(again, path / "again.csv")
    for name, body, start in (("empty", None, 0.0), ("loaded", BODY, 60.0)):
        joints = wide_smooth(20.0, 50.0, len(name), massive.arm)
        log = robot.record(joints, body, start, seed=len(name))
        write_log(log, path / f"{name}.csv")
        write_log(log, path / f"{name}.mcap")
        changed = {
            "joint_positions": log["joint_positions"],
            "joint_currents": Stream(
                log["joint_torques"].time, log["joint_torques"].values / GAINS
            ),
        }
        write_log(
            Recording(changed, joint_names=log.joint_names), path / f"{name}A.csv"
        )
    return path


def command(folder: Path, *words: str) -> list[str]:
    robot = ["--urdf", str(folder / "arm.urdf"), "--sensor-frame", "flange"]
    return ["identify", *words, "--torques", *robot, "--json"]


def answer(run, words: list[str]) -> tuple[int, dict]:
    status, out, err = run(*words)
    assert not err
    return status, json.loads(out)


def codes(found: dict) -> set[str]:
    return {message["code"] for message in found["messages"]}


def check(found: dict) -> None:
    """Within what 160 simulated objects showed: 90 % within 0.5 % and 2 mm."""
    assert abs(found["mass"] - BODY.mass) < 0.01 * BODY.mass
    off = np.array(found["center_of_mass"]) - BODY.center_of_mass
    assert np.linalg.norm(off) < 3e-3


@pytest.mark.parametrize("suffix", [".csv", ".mcap"])
def test_with_an_empty_run(folder, run, suffix):
    loaded, empty = (str(folder / f"{name}{suffix}") for name in ("loaded", "empty"))
    status, found = answer(run, command(folder, loaded, "--empty", empty))
    assert status == 0
    check(found)
    assert found["verdict"] == "good"
    # of the loaded run alone
    assert found["samples"] == 1000
    assert found["duration"] == pytest.approx(20.0, abs=0.02)
    low, high = found["intervals"]["mass"]
    assert low <= BODY.mass <= high


def test_a_calibration_serves_as_the_empty_run(folder, run, tmp_path):
    arm = str(tmp_path / "an arm.json")
    robot = ["--urdf", str(folder / "arm.urdf"), "--sensor-frame", "flange"]
    words = ["calibrate", str(folder / "empty.csv"), "--torques", *robot]
    status, out, _ = run(*words, "--output", arm)
    assert status == 0
    assert "base parameters" in out
    assert f"--arm '{arm}'" in " ".join(out.split())
    status, found = answer(
        run, command(folder, str(folder / "loaded.csv"), "--arm", arm)
    )
    assert status == 0
    check(found)
    held = run("identify", str(folder / "loaded.csv"), "--tool", arm)
    assert refused(held, "give it as --arm")
    # of no other robot, gravity or mount, and the same run counts once
    text = (folder / "arm.urdf").read_text()
    longer = text.replace("-0.425 ", "-0.415 ")
    assert longer != text
    other = tmp_path / "arm.urdf"
    other.write_text(longer)
    loaded = command(folder, str(folder / "loaded.csv"), "--arm", arm)
    moved = [str(other) if word.endswith("arm.urdf") else word for word in loaded]
    assert refused(run(*moved), "other joints")
    assert refused(run(*loaded, "--gravity", "0,0,-9.7"), "another gravity")
    assert refused(run(*loaded, "--empty", str(folder / "empty.csv")), "given twice")
    whole = json.loads(Path(arm).read_text())
    for key, value in (("runs", "abc"), ("mechanics", None)):
        Path(arm).write_text(json.dumps(whole | {key: value}))
        assert refused(run(*loaded), "is a damaged calibration")


def test_a_calibration_says_what_it_took_out(folder, run, tmp_path):
    """0.2 s by which the torques came late; the run still counts once."""
    for name in ("empty", "loaded"):
        log = read_log(folder / f"{name}.csv", wrench_needed=False)
        q, torque = log["joint_positions"], log["joint_torques"]
        late = Stream(torque.time + 0.2, torque.values)
        streams = {"joint_positions": q, "joint_torques": late}
        write_log(Recording(streams), tmp_path / f"{name}.csv")
    arm, empty = str(tmp_path / "arm.json"), str(tmp_path / "empty.csv")
    robot = ["--urdf", str(folder / "arm.urdf"), "--sensor-frame", "flange"]
    status, out, err = run("calibrate", empty, "--torques", *robot, "--output", arm)
    assert (status, err) == (0, "")
    assert re.search(r"^note: torques come (18|19|20|21|22)\d ms after", out)
    loaded = command(folder, str(tmp_path / "loaded.csv"), "--arm", arm)
    status, found = answer(run, loaded)
    assert status == 0
    check(found)
    assert "torques-late" in codes(found)
    assert refused(run(*loaded, "--empty", empty), "given twice")


def test_columns_by_other_names_are_told_once(folder, run, tmp_path):
    """Each stream of each log had been a warning of its own, too."""
    for name in ("empty", "loaded"):
        lines = (folder / f"{name}.csv").read_text().splitlines(keepends=True)
        head = re.sub(r"\bq(\d)", r"position_\1", lines[0])
        head = re.sub(r"\btau(\d)", r"effort_\1", head)
        (tmp_path / f"{name}.csv").write_text("".join([head, *lines[1:]]))
    loaded, empty = (str(tmp_path / f"{name}.csv") for name in ("loaded", "empty"))
    status, found = answer(run, command(folder, loaded, "--empty", empty))
    assert status == 0
    assert [each["code"] for each in found["messages"]] == ["columns-by-name"]


def test_rows_that_a_logger_lost_are_given_their_time(folder, run, tmp_path):
    """Two of a hundred, with time made of the row number, had put masses up to 15 %
    wrong."""
    rng = np.random.default_rng(3)
    for name in ("empty", "loaded"):
        log = read_log(folder / f"{name}.csv", wrench_needed=False)
        kept = rng.random(len(log["joint_torques"])) > 0.02
        time = 0.02 * np.arange(kept.sum())
        streams = {n: Stream(time, s.values[kept]) for n, s in log.streams.items()}
        write_log(Recording(streams), tmp_path / f"{name}.csv")
    words = [str(tmp_path / "loaded.csv"), "--empty", str(tmp_path / "empty.csv")]
    status, found = answer(run, command(folder, *words))
    assert status == 0
    check(found)
    assert "rows-lost" in codes(found)


def test_currents_with_gains(folder, run):
    gains = ",".join(map(str, GAINS))
    words = [str(folder / "loadedA.csv"), "--empty", str(folder / "emptyA.csv")]
    status, found = answer(run, command(folder, *words, "--torque-gains", gains))
    assert status == 0
    check(found)


def test_the_published_arm_warns_and_is_unsure(folder, run):
    status, found = answer(run, command(folder, str(folder / "loaded.csv")))
    assert status == 0
    assert found["verdict"] == "usable with care"
    assert "arm-published" in codes(found)
    assert "record an empty run (--empty)" in found["warnings"][0]
    low, high = found["intervals"]["mass"]
    # four standard deviations of a published arm's 0.1 kg
    assert high - low > 0.3


@pytest.mark.parametrize("name", ["Bayes", "GEO", "LMI", "OLS", "PMD"])
def test_every_method_answers(folder, run, name):
    words = [str(folder / "loaded.csv"), "--empty", str(folder / "empty.csv")]
    shape = ["--box", "0.2,0.2,0.3", "--object-pose", "0,0,0.1,0,0,0,1"]
    words += shape if name in ("Bayes", "GEO", "PMD") else []
    status, found = answer(run, command(folder, *words, "--method", name))
    assert found["method"] == name
    assert status == 0
    check(found)


def test_a_compensated_payload_is_told(folder, run):
    """Two empty runs: the torques show no load."""
    words = [str(folder / "again.csv"), "--empty", str(folder / "empty.mcap")]
    status, out, err = run(*command(folder, *words))
    if status == 3:
        assert "no-load-seen" in codes(json.loads(out))
    else:
        assert status == 2
        assert "does the controller subtract a payload" in err


def test_an_empty_run_of_another_robot_is_told(folder, run, tmp_path):
    """Of links that weigh more, and other frictions."""
    other = TorqueRobot(TORQUE_ARMS["ur5e"], seed=5)
    joints = wide_smooth(20.0, 50.0, 9, TORQUE_ARMS["ur5e"].arm)
    write_log(other.record(joints, None), tmp_path / "other.csv")
    words = [str(folder / "loaded.csv"), "--empty", str(tmp_path / "other.csv")]
    status, found = answer(run, command(folder, *words))
    assert status == 3
    assert "empty-run-contradicts" in codes(found)


def changed(folder: Path, tmp_path: Path, name: str, change) -> str:
    """A log of the folder, its times, positions and torques changed."""
    streams = read_log(folder / f"{name}.csv", wrench_needed=False).streams
    q, tau = streams["joint_positions"], streams["joint_torques"]
    time, positions, torques = change(q.time, q.values.copy(), tau.values.copy())
    made = {
        "joint_positions": Stream(time, positions),
        "joint_torques": Stream(time, torques),
    }
    write_log(Recording(made), tmp_path / f"{name}.csv")
    return str(tmp_path / f"{name}.csv")


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (lambda t, q, tau: (t, q, 1e3 * tau), "in N m"),
        (lambda t, q, tau: (t, q, -tau), "the other sign"),
        (lambda t, q, tau: (t, np.degrees(q), tau), "name the columns 'q1 [deg]'"),
        (lambda t, q, tau: (1e3 * t, q, tau), "in milliseconds"),
        (lambda t, q, tau: (t, q, tau * (1, 1, 1, 1, 1, 0)), "of joint6 never changes"),
    ],
)
def test_torques_of_no_such_arm_are_refused(folder, run, tmp_path, change, said):
    words = [changed(folder, tmp_path, name, change) for name in ("loaded", "empty")]
    assert refused(run(*command(folder, words[0], "--empty", words[1])), said)


ORDER = [0, 2, 1, 3, 4, 5]
TURNED = np.array((1.0, 1.0, 1.0, 1.0, 1.0, -1.0))


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (lambda t, q, tau: (t, q[:, ORDER], tau[:, ORDER]), "joint2 and joint3"),
        (lambda t, q, tau: (t, TURNED * q, TURNED * tau), "joint6 of the other sign"),
        (lambda t, q, tau: (t, q, tau[:, ORDER]), "torques of joint2 and joint3"),
        (lambda t, q, tau: (t, q, 0.10197 * tau), "not kgf m"),
        (lambda t, q, tau: (t, q, 10.197 * tau), "not kgf m"),
    ],
)
def test_another_order_sign_or_unit_is_named(folder, run, tmp_path, change, said):
    """In both runs, so that they do not contradict each other."""
    words = [changed(folder, tmp_path, name, change) for name in ("loaded", "empty")]
    status, found = answer(run, command(folder, words[0], "--empty", words[1]))
    assert status == 3
    assert said in str(found["reasons"])


def test_another_gravity_is_named(folder, run):
    """An arm on a wall, of which the URDF does not know."""
    words = [str(folder / "loaded.csv"), "--empty", str(folder / "empty.csv")]
    status, found = answer(run, command(folder, *words, "--gravity", "9.81,0,0"))
    assert status == 3
    reasons = str(found["reasons"])
    assert "gravity along the z axis" in reasons
    # of the joint that tells it best, 4.1; the mean of all is 1.8
    assert float(reasons.split("up to ")[1].split()[0]) > 3.0


def test_exchanged_runs_are_told(folder, run):
    words = [str(folder / "empty.csv"), "--empty", str(folder / "loaded.csv")]
    status, out, err = run(*command(folder, *words))
    assert status in (2, 3)
    assert "loaded runs exchanged" in " ".join((out + err).split())


def test_gains_on_torques_are_told(folder, run):
    words = [str(folder / "loaded.csv"), "--empty", str(folder / "empty.csv")]
    _, found = answer(run, command(folder, *words, "--torque-gains", "2"))
    assert "gains-on-torques" in codes(found)
    assert found["verdict"] == "usable with care"
    assert found["provenance"]["torque_gains"] == [2.0]
    _, found = answer(run, command(folder, *words, "--torque-gains", "1"))
    assert "gains-on-torques" not in codes(found)


def test_the_same_motion_may_be_recorded_twice(folder, run, tmp_path):
    """As where commanded positions are logged; only the torques differ."""
    rng = np.random.default_rng(1)

    def louder(t, q, tau):
        return t, q, tau + rng.normal(scale=0.01, size=tau.shape)

    again = changed(folder, tmp_path, "empty", louder)
    words = [str(folder / "loaded.csv"), "--empty", str(folder / "empty.csv")]
    _, found = answer(run, command(folder, *words, "--empty", again))
    check(found)


def test_wrong_gains_are_in_the_intervals(folder, run, tmp_path):
    """Each joint's of 1 %, as the standard deviation that is allowed for."""
    gains = 1.0 + 0.01 * np.random.default_rng(3).choice((-1.0, 1.0), 6)
    words = [
        changed(folder, tmp_path, name, lambda t, q, tau: (t, q, gains * tau))
        for name in ("loaded", "empty")
    ]
    rest = ("--empty", words[1])
    _, found = answer(run, command(folder, words[0], *rest))
    low, high = found["intervals"]["mass"]
    assert low <= BODY.mass <= high
    # several joints share the load, so that it is less than 1 %, but not by much
    assert 0.005 < 0.25 * (high - low) / BODY.mass < 0.011
    # and so a scale that is right does not contradict them
    mass = f"{BODY.mass:g}kg±1g"
    _, found = answer(run, command(folder, words[0], *rest, "--mass", mass))
    assert found["verdict"] == "good"
    _, found = answer(run, command(folder, words[0], *rest, "--mass", "1.5kg±1g"))
    assert "torques' constants (--torque-gains)" in str(found["reasons"])


def test_bad_input_is_one_line(folder, run, tmp_path):
    loaded, empty = str(folder / "loaded.csv"), str(folder / "empty.csv")
    lines = Path(loaded).read_text().splitlines()
    names = lines[0].split(",")

    def without(prefix: str, name: str) -> str:
        kept = [i for i, column in enumerate(names) if not column.startswith(prefix)]
        rows = [",".join(line.split(",")[i] for i in kept) for line in lines]
        (tmp_path / name).write_text("\n".join(rows) + "\n")
        return str(tmp_path / name)

    robot = command(folder, without("tau", "no.csv"), "--empty", empty)
    assert refused(run(*robot), "there are no joint torques")
    assert refused(
        run(*command(folder, str(folder / "loadedA.csv"))), "give --torque-gains"
    )
    assert refused(run(*command(folder, without("q6", "five.csv"))))
    for words, said in (
        (("--torque-gains", "1,2"), "2 gains for 6"),
        (("--torque-gains", "x"), "is not a finite number"),
        (("--tool", "tool.json"), "not for --torques"),
        (("--gravity", "estimate"), "not found from joint torques"),
        (("--method", "all"), "compared by the wrench"),
    ):
        assert refused(run(*command(folder, loaded, *words)), said)
    copied = tmp_path / "copied.csv"
    copied.write_bytes(Path(empty).read_bytes())
    for words in ((loaded, loaded), (loaded, "--empty", loaded)):
        assert refused(run(*command(folder, *words)), "is given twice")
    again = ("--empty", empty, "--empty", str(copied))
    assert refused(run(*command(folder, loaded, *again)), "copied.csv: is given twice")
    once = "as the --arm; give each recording once\n"
    assert run(*command(folder, loaded, *again))[2].endswith(once)
    assert refused(run("identify", loaded, "--torques"), "--urdf")
    assert refused(run("identify", loaded, "--empty", empty), "--torques")
    arm = tmp_path / "bad.json"
    for text, said in (
        ('{"schema": "hefting-arm-2", "joints": []}', "is of the joints"),
        ("{}", "is no calibration"),
        ("[", "is not JSON"),
    ):
        arm.write_text(text)
        assert refused(run(*command(folder, loaded, "--arm", str(arm))), said)


def test_efforts_of_a_ur_driver_need_gains(folder, run, tmp_path):
    log = read_log(folder / "loaded.mcap", wrench_needed=False)
    names = ("shoulder_pan_joint", *log.joint_names[1:])
    write_log(replace(log, joint_names=names), tmp_path / "ur.mcap")
    text = (folder / "arm.urdf").read_text().replace('"joint1"', '"shoulder_pan_joint"')
    (tmp_path / "arm.urdf").write_text(text)
    words = command(tmp_path, str(tmp_path / "ur.mcap"))
    assert refused(run(*words), "currents")


def test_a_joint_that_never_moves_is_told(folder, run, tmp_path):
    streams = dict(read_log(folder / "loaded.csv", wrench_needed=False).streams)
    q = streams["joint_positions"].values.copy()
    q[:, 0] = q[0, 0]
    streams["joint_positions"] = Stream(streams["joint_positions"].time, q)
    write_log(Recording(streams), tmp_path / "still.csv")
    words = [str(tmp_path / "still.csv"), "--empty", str(folder / "empty.csv")]
    _, found = answer(run, command(folder, *words))
    assert "joint-still" in codes(found)
