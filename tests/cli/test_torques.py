"""hefting identify and calibrate --torques, on simulated logs of a UR5e; and bad input,
each refused in one line with exit status 2. About 15 s."""

import json
from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("pinocchio")
pytest.importorskip("mujoco")

from hefting.cli import main
from hefting.core.inertia import InertialParameters
from hefting.core.recording import Recording, Stream
from hefting.logs import write_log
from hefting.simulation.arm_links import TORQUE_ARMS
from hefting.simulation.joints import wide_smooth
from hefting.simulation.torques import TorqueRobot

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
    for name, body, start in (("empty", None, 0.0), ("loaded", BODY, 60.0)):
        joints = wide_smooth(30.0, 100.0, len(name), massive.arm)
        log = robot.record(joints, body, start, seed=len(name))
        write_log(log, path / f"{name}.csv")
        write_log(log, path / f"{name}.mcap")
        changed = {
            "joint_positions": log["joint_positions"],
            "joint_currents": Stream(
                log["joint_torques"].time, log["joint_torques"].values / GAINS
            ),
        }
        write_log(Recording(changed, joint_names=log.joint_names), path / f"{name}A.csv")
    return path


def command(folder: Path, *words: str) -> list[str]:
    robot = ["--urdf", str(folder / "arm.urdf"), "--sensor-frame", "flange"]
    return ["identify", *words, "--torques", *robot, "--json"]


def answer(capsys, words: list[str]) -> tuple[int, dict]:
    status = main(words)
    return status, json.loads(capsys.readouterr().out)


def check(found: dict) -> None:
    """Within what 160 simulated objects showed: 90 % within 0.5 % and 2 mm."""
    assert abs(found["mass"] - BODY.mass) < 0.01 * BODY.mass
    off = np.array(found["center_of_mass"]) - BODY.center_of_mass
    assert np.linalg.norm(off) < 3e-3


@pytest.mark.parametrize("suffix", [".csv", ".mcap"])
def test_with_an_empty_run(folder, capsys, suffix):
    loaded, empty = (str(folder / f"{name}{suffix}") for name in ("loaded", "empty"))
    status, found = answer(capsys, command(folder, loaded, "--empty", empty))
    assert status == 0
    check(found)
    assert found["verdict"] == "good"
    low, high = found["intervals"]["mass"]
    assert low <= BODY.mass <= high


def test_a_calibration_serves_as_the_empty_run(folder, capsys, tmp_path):
    arm = str(tmp_path / "arm.json")
    robot = ["--urdf", str(folder / "arm.urdf"), "--sensor-frame", "flange"]
    words = ["calibrate", str(folder / "empty.csv"), "--torques", *robot]
    assert main([*words, "--output", arm]) == 0
    assert "base parameters" in capsys.readouterr().out
    status, found = answer(
        capsys, command(folder, str(folder / "loaded.csv"), "--arm", arm)
    )
    assert status == 0
    check(found)


def test_currents_with_gains(folder, capsys):
    gains = ",".join(map(str, GAINS))
    words = [str(folder / "loadedA.csv"), "--empty", str(folder / "emptyA.csv")]
    status, found = answer(capsys, command(folder, *words, "--torque-gains", gains))
    assert status == 0
    check(found)


def test_the_published_arm_warns_and_is_unsure(folder, capsys):
    status, found = answer(capsys, command(folder, str(folder / "loaded.csv")))
    assert status == 0
    assert found["verdict"] == "usable with care"
    assert "arm-published" in [reason["code"] for reason in found["reasons"]]
    low, high = found["intervals"]["mass"]
    assert low <= BODY.mass <= high
    assert high - low > 0.2


def test_every_method_answers(folder, capsys):
    words = [str(folder / "loaded.csv"), "--empty", str(folder / "empty.csv")]
    shape = ["--box", "0.2,0.2,0.3", "--object-pose", "0,0,0.1,0,0,0,1"]
    status = main(command(folder, *words, *shape, "--method", "all"))
    found = json.loads(capsys.readouterr().out)["results"]
    assert status == 0
    assert {each["method"] for each in found} == {"Bayes", "GEO", "LMI", "OLS", "PMD"}
    for each in found:
        check(each)


def test_a_compensated_payload_is_told(folder, capsys):
    """Two empty runs: the torques show no load."""
    words = [str(folder / "empty.csv"), "--empty", str(folder / "emptyA.csv")]
    gains = ["--torque-gains", "1"]
    words = [str(folder / "empty.csv"), "--empty", str(folder / "empty.mcap"), *gains]
    status = main([*command(folder, *words)])
    out = capsys.readouterr()
    if status == 3:
        codes = [reason["code"] for reason in json.loads(out.out)["reasons"]]
        assert "no-load-seen" in codes
    else:
        assert status == 2
        assert "compensate" in out.err or "subtract" in out.err


def test_an_empty_run_of_another_robot_is_told(folder, capsys, tmp_path):
    """Of links that weigh more, and other frictions."""
    other = TorqueRobot(TORQUE_ARMS["ur5e"], seed=5)
    joints = wide_smooth(30.0, 100.0, 9, TORQUE_ARMS["ur5e"].arm)
    write_log(other.record(joints, None), tmp_path / "other.csv")
    words = [str(folder / "loaded.csv"), "--empty", str(tmp_path / "other.csv")]
    status, found = answer(capsys, command(folder, *words))
    assert status == 3
    assert "empty-run-contradicts" in [each["code"] for each in found["reasons"]]


def refused(capsys, words: list[str]) -> str:
    assert main(words) == 2
    out = capsys.readouterr()
    assert out.out == ""
    assert out.err.count("\n") == 1
    return out.err


def test_bad_input_is_one_line(folder, capsys, tmp_path):
    loaded, empty = str(folder / "loaded.csv"), str(folder / "empty.csv")
    lines = Path(loaded).read_text().splitlines()
    names = lines[0].split(",")

    def without(prefix: str, name: str) -> str:
        kept = [i for i, column in enumerate(names) if not column.startswith(prefix)]
        rows = [",".join(line.split(",")[i] for i in kept) for line in lines]
        (tmp_path / name).write_text("\n".join(rows) + "\n")
        return str(tmp_path / name)

    said = refused(capsys, command(folder, without("tau", "no.csv"), "--empty", empty))
    assert "no joint torques" in said
    said = refused(capsys, command(folder, str(folder / "loadedA.csv")))
    assert "amperes" in said
    five = without("q6", "five.csv")
    assert refused(capsys, command(folder, five, "--empty", empty))
    gains = ["--torque-gains", "1,2"]
    assert "2 gains for 6" in refused(capsys, command(folder, loaded, *gains))
    gains = ["--torque-gains", "x"]
    assert "no numbers" in refused(capsys, command(folder, loaded, *gains))
    words = ["identify", loaded, "--torques"]
    assert "--urdf" in refused(capsys, words)
    assert "--torques" in refused(capsys, ["identify", loaded, "--empty", empty])
    tool = ["--tool", "tool.json"]
    assert "not for --torques" in refused(capsys, command(folder, loaded, *tool))
    (tmp_path / "bad.json").write_text('{"schema": "hefting-arm-1", "joints": []}')
    arm = ["--arm", str(tmp_path / "bad.json")]
    assert "is of the joints" in refused(capsys, command(folder, loaded, *arm))
    (tmp_path / "bad.json").write_text("{}")
    assert "no calibration" in refused(capsys, command(folder, loaded, *arm))


def test_efforts_of_a_ur_driver_need_gains(folder, capsys, tmp_path):
    from dataclasses import replace

    from hefting.logs import read_log

    log = read_log(folder / "loaded.mcap", wrench_needed=False)
    names = ("shoulder_pan_joint", *log.joint_names[1:])
    write_log(replace(log, joint_names=names), tmp_path / "ur.mcap")
    text = (folder / "arm.urdf").read_text().replace('"joint1"', '"shoulder_pan_joint"')
    (tmp_path / "arm.urdf").write_text(text)
    words = command(tmp_path, str(tmp_path / "ur.mcap"))
    assert "currents" in refused(capsys, words)


def test_a_joint_that_never_moves_is_told(folder, capsys, tmp_path):
    from hefting.logs import read_log

    streams = dict(read_log(folder / "loaded.csv", wrench_needed=False).streams)
    q = streams["joint_positions"].values.copy()
    q[:, 0] = q[0, 0]
    streams["joint_positions"] = Stream(streams["joint_positions"].time, q)
    write_log(Recording(streams), tmp_path / "still.csv")
    words = [str(tmp_path / "still.csv"), "--empty", str(folder / "empty.csv")]
    _, found = answer(capsys, command(folder, *words))
    texts = [each["text"] if isinstance(each, dict) else each for each in found["warnings"]]
    assert any("never moves" in text for text in texts)
