"""Files of a plan, read back by others' readers."""

import json
import re

import numpy as np
import pytest

from folding_arm import folding_arm
from hefting.core.errors import InputError
from hefting.logs import read_log
from hefting.planning.files import FORMATS, write_plan
from hefting.robots import Robot, with_poses
from plans import random_plan


def test_csv_holds_time_and_positions(tmp_path):
    plan = random_plan(7)
    write_plan(plan, tmp_path / "m.csv")
    with open(tmp_path / "m.csv") as stream:
        assert stream.readline() == "time,q1,q2,q3,q4,q5,q6,q7\n"
        table = np.loadtxt(stream, delimiter=",")
    motion = plan.motion
    # nine digits after the point
    np.testing.assert_allclose(table[:, 0], motion.time, atol=1e-9)
    np.testing.assert_allclose(table[:, 1:], motion.position, atol=6e-10)


def test_csv_is_a_log(tmp_path):
    """The joint log that `hefting view` and `hefting predict` take."""
    path = folding_arm(tmp_path)
    plan = random_plan(4, source=str(path))
    write_plan(plan, tmp_path / "m.csv")
    robot = Robot.from_urdf(path, "tool")
    recording = with_poses(read_log(tmp_path / "m.csv", wrench_needed=False), robot)
    wanted = robot.poses(plan.motion.position)[0]
    # nine digits of angles, and an arm of 1 m
    np.testing.assert_allclose(recording["position"].values, wanted, atol=1e-8)


def test_json_is_a_joint_trajectory(tmp_path):
    plan = random_plan(6)
    write_plan(plan, tmp_path / "m.json")
    message = json.loads((tmp_path / "m.json").read_text())
    assert list(message) == ["header", "joint_names", "points"]
    assert message["header"] == {"stamp": {"sec": 0, "nanosec": 0}, "frame_id": ""}
    assert message["joint_names"] == list(plan.joints)
    motion = plan.motion
    assert len(message["points"]) == len(motion.time)
    for k, point in enumerate(message["points"]):
        assert list(point) == [
            "positions",
            "velocities",
            "accelerations",
            "effort",
            "time_from_start",
        ]
        # numbers are written as they are
        np.testing.assert_array_equal(point["positions"], motion.position[k])
        np.testing.assert_array_equal(point["velocities"], motion.velocity[k])
        np.testing.assert_array_equal(point["accelerations"], motion.acceleration[k])
        assert point["effort"] == []
        when = point["time_from_start"]
        assert 0 <= when["nanosec"] < 10**9
        # nanoseconds
        assert when["sec"] + 1e-9 * when["nanosec"] == pytest.approx(
            motion.time[k], abs=1e-9
        )
    for end in (message["points"][0], message["points"][-1]):
        np.testing.assert_allclose(end["velocities"], 0.0, atol=1e-9)
        np.testing.assert_allclose(end["accelerations"], 0.0, atol=1e-9)


def test_mcap_holds_the_same_message(tmp_path):
    """Read by rosbags, and its frame by mcap itself."""
    from mcap.reader import make_reader
    from rosbags.typesys import Stores, get_typestore

    plan = random_plan(7)
    write_plan(plan, tmp_path / "m.mcap")
    write_plan(plan, tmp_path / "m.json")
    wanted = json.loads((tmp_path / "m.json").read_text())
    with open(tmp_path / "m.mcap", "rb") as stream:
        ((schema, channel, raw),) = make_reader(stream).iter_messages()
    assert schema.name == "trajectory_msgs/msg/JointTrajectory"
    assert channel.topic == "/joint_trajectory_controller/joint_trajectory"
    assert channel.message_encoding == "cdr"
    store = get_typestore(Stores.ROS2_HUMBLE)
    message = store.deserialize_cdr(raw.data, schema.name)
    assert message.joint_names == wanted["joint_names"]
    assert (message.header.stamp.sec, message.header.frame_id) == (0, "")
    for point, other in zip(message.points, wanted["points"], strict=True):
        for name in ("positions", "velocities", "accelerations", "effort"):
            np.testing.assert_array_equal(getattr(point, name), other[name])
        when = point.time_from_start
        assert {"sec": when.sec, "nanosec": when.nanosec} == other["time_from_start"]


def test_urscript_streams_the_positions(tmp_path):
    plan = random_plan(6, duration=1.001)
    write_plan(plan, tmp_path / "m.script")
    lines = (tmp_path / "m.script").read_text().splitlines()
    code = [line.strip() for line in lines if not line.startswith("#")]
    assert code[0] == "def hefting_plan():"
    assert code[-1] == "end"
    blocks = sum(line.startswith("def ") for line in code)
    assert code.count("end") == blocks
    (servoj,) = (line for line in code if line.startswith("servoj("))
    # q, a and v without use, t, lookahead_time, gain
    assert (servoj.split(", ")[:3], servoj[-5:]) == (["servoj(q", "0", "0"], " 300)")
    step = float(servoj.split(", ")[3])
    numbers = [
        [float(x) for x in re.search(r"\[(.*)\]", line)[1].split(",")]
        for line in code
        if line.startswith(("movej(", "go(["))
    ]
    # the start by movej, then one position each step, the end among them
    time = step * np.arange(len(numbers))
    assert time[-2] < plan.duration <= time[-1]
    # seven digits after the point
    np.testing.assert_allclose(numbers, plan.at(time).position, atol=6e-8)
    comments = " ".join(line for line in lines if line.startswith("#"))
    for words in ("rad", "keeps reduced speed", "250 mm/s", "simulation first"):
        assert words in comments
    assert "safe" not in comments


def test_names_cannot_leave_their_comment(tmp_path):
    """A URDF's names are hostile: a line break in one would be code."""
    plan = random_plan(6, source="x\nset_digital_out(0, True)\n.urdf")
    write_plan(plan, tmp_path / "m.script")
    lines = (tmp_path / "m.script").read_text().splitlines()
    assert not any(line.startswith("set_digital_out") for line in lines)


def test_urscript_is_for_six_joints(tmp_path):
    with pytest.raises(InputError, match="arms of 6 joints, not 7; write"):
        write_plan(random_plan(7), tmp_path / "m.script")
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("suffix", FORMATS)
def test_the_same_plan_gives_the_same_bytes(tmp_path, suffix):
    for name in "ab":
        write_plan(random_plan(6), tmp_path / f"{name}{suffix}")
    first, second = ((tmp_path / f"{name}{suffix}").read_bytes() for name in "ab")
    assert first == second


def test_other_suffixes_are_refused(tmp_path):
    with pytest.raises(InputError, match=r"'\.txt'.*use \.csv, \.json, \.mcap"):
        write_plan(random_plan(6), tmp_path / "m.txt")
