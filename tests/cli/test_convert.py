"""hefting convert: any log in, any log out, and what it says about it."""

from inspect import signature

import numpy as np
import pytest

from commands import refused
from hefting.cli import build_parser
from hefting.core.recording import Recording, Stream
from hefting.logs import read_log, write_log
from hefting.logs.ros import read_bag
from hefting.logs.ros_bag import OPTIONS
from log_files import HEADER, ROWS, log, random_recording, same


@pytest.mark.parametrize("suffixes", [(".csv", ".parquet"), (".parquet", ".csv")])
def test_tables_keep_every_bit(run, tmp_path, suffixes):
    first, second = (tmp_path / f"log{suffix}" for suffix in suffixes)
    sent = random_recording(5)
    write_log(sent, first)
    status, out, err = run("convert", first, second)
    assert (status, err) == (0, "")
    assert same(read_log(second), sent)
    assert out.splitlines()[-1] == f"wrote {second}"
    for name, stream in sent.streams.items():
        line = next(
            line
            for line in out.splitlines()
            if line.strip().startswith(name.replace("_", " ") + "  ")
        )
        assert line.split()[-4:-2] == [str(len(stream)), "samples"]


@pytest.mark.parametrize("suffix", [".bag", ".mcap", ""])
def test_to_a_bag_and_back(run, tmp_path, suffix):
    pytest.importorskip("rosbags")
    rng = np.random.default_rng(1)
    # whole nanoseconds, the first at 0
    time = np.round(np.cumsum(rng.uniform(0.001, 0.01, 50)), 9)
    time -= time[0]
    orientation = rng.normal(size=(50, 4))
    orientation /= np.linalg.norm(orientation, axis=1)[:, None]
    values = {
        "position": rng.normal(size=(50, 3)),
        "orientation": orientation,
        "wrench": rng.normal(size=(50, 6)),
    }
    sent = Recording({name: Stream(time, array) for name, array in values.items()})
    write_log(sent, tmp_path / "log.csv")
    assert run("convert", tmp_path / "log.csv", tmp_path / f"bag{suffix}")[0] == 0
    status, out, _ = run("convert", tmp_path / f"bag{suffix}", tmp_path / "back.csv")
    assert status == 0
    assert "note: " in out
    got = read_log(tmp_path / "back.csv")
    for name, stream in sent.streams.items():
        np.testing.assert_allclose(got[name].time, stream.time, rtol=0, atol=1e-9)
        np.testing.assert_array_equal(
            got[name].values, read_log(tmp_path / "log.csv")[name].values
        )


def test_a_bag_cannot_hold_everything(run, tmp_path):
    pytest.importorskip("rosbags")
    path = log(
        tmp_path, *(f"{row},1,2,3" for row in ROWS), header=HEADER + ",alx,aly,alz"
    )
    status, out, _ = run("convert", path, tmp_path / "log.mcap")
    assert status == 0
    assert (
        "warning: not written, as the format cannot hold it: angular acceleration"
        in out
    )


def test_through_a_map_with_notes_and_warnings(run, tmp_path):
    lines = [row.replace("0.", "") for row in ROWS]  # 0, 1, 2: tenths of a second
    path = log(
        tmp_path,
        *lines,
        lines[-1],
        header=HEADER.replace("time", "tick").replace("qw", "w"),
    )
    (tmp_path / "map.toml").write_text(
        """
        time = { column = "tick", rate = 10 }
        orientation = ["qx", "qy", "qz", "w"]
        wrench = ["fx", "fy", "fz", "tx", "ty", "tz"]
        joint_positions = { columns = ["qx", "qy"], names = ["hip", "knee"], unit = "deg" }
        """
    )
    status, out, err = run(
        "convert", path, tmp_path / "out.csv", "--map", tmp_path / "map.toml"
    )
    assert (status, err) == (0, "")
    assert f"{path}: 0.2 s" in " ".join(out.split())  # a long path wraps the line
    assert "  wrench                        3 samples       10 Hz" in out
    assert "note: time from column tick [frames at 10 Hz]" in out
    assert "note: joint_positions from columns qx, qy [deg]" in out
    assert "warning: dropped 1 repeated row" in out
    assert "warning: the names of the joints are not kept: q1.. are hip, knee" in out
    assert (
        (tmp_path / "out.csv")
        .read_text()
        .startswith("time,qx,qy,qz,qw,q1,q2,fx,fy,fz,tx,ty,tz\n0,0,0,0,1,0,0,1,2,3")
    )
    assert read_log(tmp_path / "out.csv")["wrench"].time.tolist() == [0, 0.1, 0.2]


def test_a_part_of_it(run, tmp_path):
    path = log(tmp_path, *ROWS)
    assert (
        run("convert", path, tmp_path / "out.csv", "--start", 0.1, "--duration", 0.1)[0]
        == 0
    )
    assert read_log(tmp_path / "out.csv")["wrench"].time.tolist() == [0.1]
    refused(
        run("convert", path, tmp_path / "no.csv", "--start", 9), "no sample from 9 s on"
    )
    words = ("convert", path, tmp_path / "no.csv", "--start", -1)
    assert refused(run(*words), "cannot start at -1 s; give a --start of 0 s or more")
    assert not (tmp_path / "no.csv").exists()


def test_static_poses(run, tmp_path):
    path = log(
        tmp_path,
        *(row.split(",", 1)[1] for row in ROWS),
        header=HEADER.removeprefix("time,"),
    )
    status, out, _ = run("convert", path, tmp_path / "out.parquet")
    assert status == 0
    assert "static poses" in " ".join(out.split())  # a long path wraps the line
    assert read_log(tmp_path / "out.parquet").static
    refused(run("convert", path, tmp_path / "out.bag"), "no times")


def test_what_is_refused(run, tmp_path):
    path = log(tmp_path, *ROWS)
    before = path.read_bytes()
    refused(run("convert", path, path), "would be overwritten")
    (tmp_path / "link.csv").symlink_to(path)
    refused(run("convert", path, tmp_path / "link.csv"), "would be overwritten")
    (tmp_path / "map.csv").touch()
    refused(
        run("convert", path, tmp_path / "map.csv", "--map", tmp_path / "map.csv"),
        "would be overwritten",
    )
    refused(
        run("convert", path, tmp_path / "out.xlsx"),
        "'.xlsx'",
        ".csv, .parquet, .bag, .mcap",
        "ROS 2 bag",
    )
    refused(
        run("convert", path, tmp_path / "absent" / "out.csv"),
        "the folder does not exist",
    )
    refused(
        run("convert", tmp_path / "absent.csv", tmp_path / "out.csv"), "does not exist"
    )
    refused(
        run("convert", tmp_path / "log.doc", tmp_path / "out.csv"),
        "'.doc' is not a log format",
        ".mcap",
    )
    assert refused(run("convert", path, "-"), "-: is no name of a file")
    refused(run("convert", path), "OUTPUT")
    refused(
        run("convert", path, tmp_path / "out.csv", "--imu-topic", "/imu"),
        "--imu-topic is for bags",
    )
    assert path.read_bytes() == before
    assert not (tmp_path / "out.csv").exists()


def test_every_option_of_the_bag_reader_is_there():
    optional = [
        name
        for name, about in signature(read_bag).parameters.items()
        if about.default is None
    ]
    assert tuple(optional) == tuple(OPTIONS)
    options = build_parser(["convert"]).parse_args(["convert", "log.bag", "log.csv"])
    assert set(OPTIONS) <= set(vars(options))


URDF = """<robot name="turner"><link name="base"/><link name="tool"/>
<joint name="wrist" type="continuous"><parent link="base"/><child link="tool"/>
<origin xyz="0 0 0.5"/><axis xyz="0 0 1"/></joint>
</robot>"""


def test_joint_angles_become_poses(run, tmp_path):
    path = tmp_path / "joints.csv"
    path.write_text(
        "time,q1,fx,fy,fz,tx,ty,tz\n"
        + "".join(f"{k / 100},{k / 50},0,0,9.81,0,0,0\n" for k in range(9))
    )
    (tmp_path / "robot.urdf").write_text(URDF)
    options = ("--urdf", tmp_path / "robot.urdf", "--sensor-frame")
    status, text, _ = run("convert", path, tmp_path / "poses.csv", *options, "tool")
    assert status == 0
    assert "poses of 'tool' in 'base' from wrist" in text
    poses = read_log(tmp_path / "poses.csv")
    np.testing.assert_allclose(
        poses["position"].values, np.tile((0.0, 0.0, 0.5), (9, 1))
    )
    half = np.arange(9) / 100  # a quaternion holds half the angle
    np.testing.assert_allclose(
        poses["orientation"].values[:, 2:],
        np.column_stack((np.sin(half), np.cos(half))),
    )


def test_columns_without_names_go_along_the_chain_not_as_the_file_lists_the_joints(
    run, tmp_path
):
    lift = '<joint name="lift" type="prismatic"><parent link="tool"/><child link="top"/><axis xyz="0 0 1"/></joint>'
    (tmp_path / "robot.urdf").write_text(
        URDF.replace("<joint", f'<link name="top"/>{lift}<joint', 1)
    )
    path = tmp_path / "joints.csv"
    path.write_text("time,q1,q2,fx,fy,fz,tx,ty,tz\n0,0.5,0.25,0,0,9.81,0,0,0\n")
    run(
        "convert",
        path,
        tmp_path / "out.csv",
        "--urdf",
        tmp_path / "robot.urdf",
        "--sensor-frame",
        "top",
    )
    poses = read_log(tmp_path / "out.csv")
    np.testing.assert_allclose(poses["position"].values, [(0, 0, 0.75)])
    np.testing.assert_allclose(
        poses["orientation"].values, [(0, 0, np.sin(0.25), np.cos(0.25))]
    )


def test_with_a_robot_a_bag_gives_no_poses_and_the_sensor_frame_is_the_robot_s(
    run, tmp_path
):
    """What the bag holds of poses cannot be ambiguous then; a wrench in another frame
    is still told."""
    pytest.importorskip("rosbags")
    from bags import write

    kinds = {
        "/w": "geometry_msgs/WrenchStamped",
        "/a": "geometry_msgs/PoseStamped",
        "/b": "geometry_msgs/PoseStamped",
    }
    entries = [
        (topic, kind, k, {"stamp": k, "frame": "flange"})
        for k in range(1, 9)
        for topic, kind in kinds.items()
    ]

    def angles(k):
        return {
            "stamp": k,
            "name": ["wrist", "other"],
            "position": np.array([0.01 * k, 9.0]),
        }

    entries += [
        ("/joints", "sensor_msgs/JointState", k, angles(k)) for k in range(1, 9)
    ]
    path = write(tmp_path, "bare.mcap", entries)
    (tmp_path / "robot.urdf").write_text(URDF)
    options = ("--urdf", tmp_path / "robot.urdf", "--sensor-frame", "tool")
    status, text, err = run("convert", path, tmp_path / "poses.csv", *options)
    assert (status, err) == (0, "")
    assert (
        "warning: the wrench says it is in frame flange; it is taken to be in tool, as asked"
        in " ".join(text.split())
    )
    np.testing.assert_allclose(
        read_log(tmp_path / "poses.csv")["position"].values,
        np.tile((0, 0, 0.5), (8, 1)),
    )
    refused(
        run("convert", path, tmp_path / "no.csv", *options, "--joint-topic", "none"),
        "no joint positions",
    )


def test_robot_and_frame_go_together(run, tmp_path):
    path = log(tmp_path, *ROWS)
    (tmp_path / "robot.urdf").write_text(URDF)
    out = tmp_path / "out.csv"
    refused(
        run("convert", path, out, "--sensor-frame", "tool"),
        "--sensor-frame is for bags and for --urdf",
    )
    refused(
        run("convert", path, out, "--urdf", tmp_path / "robot.urdf"),
        "which link holds the sensor?",
        "--sensor-frame",
    )
    frames = (
        "no frame is named 'tol' (did you mean 'tool'?)",
        "choose one of: base, tool",
    )
    refused(
        run(
            "convert",
            path,
            out,
            "--urdf",
            tmp_path / "robot.urdf",
            "--sensor-frame",
            "tol",
        ),
        *frames,
    )
