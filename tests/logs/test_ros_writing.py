"""Writing bags: what `write_bag` writes, `rosbags` and `read_bag` read back to the bit.
About 3 s."""

import re
import sqlite3

import numpy as np
import pytest
from rosbags.highlevel import AnyReader
from rosbags.typesys import Stores, get_typestore

from hefting.core.errors import InputError
from hefting.core.recording import COLUMNS, JOINT_STREAMS, Recording, Stream
from hefting.logs.ros import read_bag, writing
from hefting.logs.ros.containers import Contents, read_messages
from hefting.logs.ros.writing import write_bag

TARGETS = ("log.bag", "log.mcap", "log")


def recording(*streams: str, step: int = 1, n: int = 40, seed: int = 0) -> Recording:
    """Streams of random numbers at whole nanoseconds; every other takes each `step`-th
    sample only."""
    rng = np.random.default_rng(seed)
    time = np.cumsum(rng.integers(1, 30_000_000, n))
    time = (time - time[0]) / 1e9
    made = {}
    for i, name in enumerate(streams):
        width = 3 if name in JOINT_STREAMS else len(COLUMNS[name])
        values = rng.normal(size=(n, width)) * 10.0 ** rng.integers(-8, 8, (n, 1))
        if name == "orientation":
            values /= np.linalg.norm(values, axis=1)[:, None]
        kept = slice(None) if i % 2 == 0 else slice(0, None, step)
        made[name] = Stream(time[kept], values[kept])
    return Recording(
        made,
        joint_names=("a", "b/c", "dé")
        if any(name in JOINT_STREAMS for name in streams)
        else (),
    )


WRITABLE = (
    "wrench",
    *(name for name in COLUMNS if not re.search("celer|current|wrench", name)),
    "accelerometer",
)


@pytest.mark.parametrize("target", TARGETS)
@pytest.mark.parametrize(
    ("streams", "step"),
    [
        (WRITABLE, 1),
        (("wrench", "gyroscope", "orientation", "accelerometer"), 3),
        (("joint_positions", "joint_velocities", "wrench"), 2),
        (("wrench", "orientation"), 5),
    ],
)
def test_reading_gives_the_same_numbers_and_times(tmp_path, target, streams, step):
    sent = recording(*streams, step=step)
    assert write_bag(sent, tmp_path / target) == ()
    got = read_bag(tmp_path / target)
    assert list(got.streams) == list(sent.streams)
    for name, stream in sent.streams.items():
        assert (got[name].values == stream.values).all(), name
        assert (got[name].time == stream.time).all(), name
    assert got.joint_names == sent.joint_names
    assert not got.warnings
    assert [path.name for path in tmp_path.iterdir()] == [target], (
        "no temporary files stay"
    )


@pytest.mark.parametrize("target", TARGETS)
def test_rosbags_reads_what_was_written(tmp_path, target):
    sent = recording(*WRITABLE)
    path = tmp_path / target
    write_bag(sent, path)
    logged = [time for _, time, _ in read_messages(Contents(path), lambda _: True)]
    assert logged == sorted(logged), "stored in the order of time"
    seen: dict[str, list] = {}
    # rosbags opens MCAP files in bag folders, through its storage reader
    if target == "log.mcap":
        from rosbags.rosbag2.storage_mcap import McapReader

        store, reader = get_typestore(Stores.ROS2_HUMBLE), McapReader(path)
        reader.open()
        for connection, _, data in reader.messages(reader.connections):
            seen.setdefault(connection.topic, []).append(
                store.deserialize_cdr(data, connection.msgtype)
            )
        reader.bio.close()
    else:
        with AnyReader([path]) as reader:
            logged = 0
            for connection, time, data in reader.messages():
                message = reader.deserialize(data, connection.msgtype)
                seen.setdefault(connection.topic, []).append(message)
                assert (
                    time
                    == message.header.stamp.sec * 1_000_000_000
                    + message.header.stamp.nanosec
                    >= logged
                )
                logged = time
    assert sorted(seen) == ["/imu", "/joint_states", "/pose", "/twist", "/wrench"]
    for k in (0, 7, 39):
        wrench, pose, joints, imu = (
            seen[topic][k] for topic in ("/wrench", "/pose", "/joint_states", "/imu")
        )
        assert [wrench.wrench.torque.z, pose.pose.orientation.w] == [
            sent["wrench"].values[k, 5],
            sent["orientation"].values[k, 3],
        ]
        assert (joints.velocity == sent["joint_velocities"].values[k]).all()
        assert joints.name == ["a", "b/c", "dé"]
        assert imu.linear_acceleration.y == sent["accelerometer"].values[k, 1]
        assert (wrench.header.frame_id, pose.header.frame_id) == ("sensor", "world")
        assert imu.orientation_covariance[0] == -1


def test_what_ros_has_no_message_for_is_named(tmp_path):
    sent = recording(
        "wrench",
        "orientation",
        "position",
        "linear_velocity",
        "linear_accelerometer",
        step=2,
    )
    assert write_bag(sent, tmp_path / "log.mcap") == (
        "position",
        "linear_velocity",
        "linear_accelerometer",
    )
    assert list(read_bag(tmp_path / "log.mcap").streams) == ["orientation", "wrench"]


def test_times_start_at_zero_and_are_rounded_to_nanoseconds(tmp_path):
    rng = np.random.default_rng(3)
    time = 5e3 + np.cumsum(rng.uniform(1e-3, 2e-3, 50))
    sent = recording("wrench", "orientation", n=50)
    moved = Recording(
        {name: Stream(time, stream.values) for name, stream in sent.streams.items()}
    )
    write_bag(moved, tmp_path / "log.bag")
    # half a nanosecond, and the spacing of floats at 5000 s, which is 1e-12 s
    np.testing.assert_allclose(
        read_bag(tmp_path / "log.bag")["wrench"].time,
        time - time[0],
        rtol=0,
        atol=5.02e-10,
    )


FULL = (
    OSError(28, "No space left on device"),
    sqlite3.OperationalError("database or disk is full"),
)


@pytest.mark.parametrize("full", FULL)
def test_whole_or_not_at_all(tmp_path, monkeypatch, full):
    sent = recording("wrench", "orientation")
    (tmp_path / "log.bag").write_bytes(b"old")
    (tmp_path / "folder").mkdir()
    (tmp_path / "file").touch()

    def fail(*_):
        raise full

    with monkeypatch.context() as patch:
        patch.setattr(writing, "serialise", fail)
        for target in TARGETS:
            with pytest.raises(InputError, match="cannot be written"):
                write_bag(sent, tmp_path / target)
    assert (tmp_path / "log.bag").read_bytes() == b"old"
    assert sorted(path.name for path in tmp_path.iterdir()) == [
        "file",
        "folder",
        "log.bag",
    ]
    write_bag(sent, tmp_path / "log.bag")
    assert len(read_bag(tmp_path / "log.bag")["wrench"]) == 40
    for target in ("folder", "file"):
        with pytest.raises(InputError, match="exists already"):
            write_bag(sent, tmp_path / target)
    with pytest.raises(InputError, match="cannot be written"):
        write_bag(sent, tmp_path / "absent" / "log.mcap")
    with pytest.raises(InputError, match=r"'\.db3' is not a bag that is written"):
        write_bag(sent, tmp_path / "log.db3")
    with pytest.raises(InputError, match="static poses have no times"):
        write_bag(Recording(sent.streams, static=True), tmp_path / "log.mcap")


def test_joint_names_are_as_many_as_joints():
    streams = recording("wrench", "joint_positions").streams
    with pytest.raises(InputError, match="2 joint names for 3 joint columns"):
        Recording(streams, joint_names=("a", "b"))
    assert Recording(streams, joint_names=("a", "b", "c")).joint_names == (
        "a",
        "b",
        "c",
    )
