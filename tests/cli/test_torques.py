"""hefting identify and calibrate --torques, on simulated logs of a UR5e; and bad input,
each refused in one line with exit status 2. About 15 s."""

import json
from pathlib import Path

import numpy as np
import pytest

from commands import refused
from hefting.core.inertia import InertialParameters
from hefting.core.recording import Recording, Stream
from hefting.identification.by_torques import ByTorques
from hefting.logs import write_log
from hefting.simulation.arm_links import TORQUE_ARMS
from hefting.simulation.joints import wide_smooth
from hefting.simulation.torque_scenario import TorqueRobot

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
    again = robot.record(wide_smooth(20.0, 100.0, 7, massive.arm), None, 30.0, seed=7)
    write_log(again, path / "again.csv")
    for name, body, start in (("empty", None, 0.0), ("loaded", BODY, 60.0)):
        joints = wide_smooth(20.0, 100.0, len(name), massive.arm)
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
    assert found["samples"] == 2000
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


@pytest.fixture(scope="module")
def fitted_once():
    """In place of `ByTorques.of`: the same equations serve every method."""
    fit, found = ByTorques.of, []

    def once(*arguments, **more):
        if not found:
            found.append(fit(*arguments, **more))
        return found[0]

    return once


@pytest.mark.parametrize("name", ["Bayes", "GEO", "LMI", "OLS", "PMD"])
def test_every_method_answers(folder, run, name, fitted_once, monkeypatch):
    monkeypatch.setattr(ByTorques, "of", fitted_once)
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
    joints = wide_smooth(20.0, 100.0, 9, TORQUE_ARMS["ur5e"].arm)
    write_log(other.record(joints, None), tmp_path / "other.csv")
    words = [str(folder / "loaded.csv"), "--empty", str(tmp_path / "other.csv")]
    status, found = answer(run, command(folder, *words))
    assert status == 3
    assert "empty-run-contradicts" in codes(found)


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
        (("--torque-gains", "x"), "no numbers"),
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
    assert refused(run("identify", loaded, "--torques"), "--urdf")
    assert refused(run("identify", loaded, "--empty", empty), "--torques")
    arm = tmp_path / "bad.json"
    for text, said in (
        ('{"schema": "hefting-arm-1", "joints": []}', "is of the joints"),
        ("{}", "is no calibration"),
        ("[", "is not JSON"),
    ):
        arm.write_text(text)
        assert refused(run(*command(folder, loaded, "--arm", str(arm))), said)


def test_efforts_of_a_ur_driver_need_gains(folder, run, tmp_path):
    from dataclasses import replace

    from hefting.logs import read_log

    log = read_log(folder / "loaded.mcap", wrench_needed=False)
    names = ("shoulder_pan_joint", *log.joint_names[1:])
    write_log(replace(log, joint_names=names), tmp_path / "ur.mcap")
    text = (folder / "arm.urdf").read_text().replace('"joint1"', '"shoulder_pan_joint"')
    (tmp_path / "arm.urdf").write_text(text)
    words = command(tmp_path, str(tmp_path / "ur.mcap"))
    assert refused(run(*words), "currents")


def test_a_joint_that_never_moves_is_told(folder, run, tmp_path):
    from hefting.logs import read_log

    streams = dict(read_log(folder / "loaded.csv", wrench_needed=False).streams)
    q = streams["joint_positions"].values.copy()
    q[:, 0] = q[0, 0]
    streams["joint_positions"] = Stream(streams["joint_positions"].time, q)
    write_log(Recording(streams), tmp_path / "still.csv")
    words = [str(tmp_path / "still.csv"), "--empty", str(folder / "empty.csv")]
    _, found = answer(run, command(folder, *words))
    assert "joint-still" in codes(found)
