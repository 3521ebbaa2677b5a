"""Writing a recording as a ROS 1 bag, a ROS 2 bag or an MCAP file, with the writers of
`rosbags`: messages of a topic are serialised all at once. And the file for Foxglove's
writer of MCAP."""

import os
import shutil
import sqlite3
import tempfile
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np
from numpy.typing import NDArray

from hefting.core.errors import InputError, needing
from hefting.core.files import check_replaceable
from hefting.core.recording import Recording, Stream, column_names
from hefting.core.spatial import Array
from hefting.logs.ros.layout import lay_out
from hefting.logs.ros.messages import JOINT_PATHS
from hefting.logs.ros.streams import SENSOR, WORLD

EPOCH = 1_000_000_000
"""Stamp of a recording's first sample [ns], as zero means that there is none."""

VECTORS = {
    "position": "pose.position",
    "orientation": "pose.orientation",
    "linear_velocity": "twist.linear",
    "angular_velocity": "twist.angular",
    "gyroscope": "angular_velocity",
    "accelerometer": "linear_acceleration",
}
"""Field of the message for each stream of vectors."""

Times = dict[str, NDArray[np.int64]]
"""Stamps [ns] by stream."""


@dataclass(frozen=True)
class Messages:
    """N messages of one type and topic that differ in stamps and numbers only."""

    topic: str
    type: str
    frame: str
    time: NDArray[np.int64]
    """(N,) [ns]"""
    fields: dict[str, Array]
    """numbers (N, count) by path within the message"""
    texts: tuple[str, ...] = ()
    """names of joints"""


def serialise(group: Messages, store: Any, encoding: str) -> NDArray[np.uint8]:
    """The messages' bytes (N, size): copies of one serialised message, in which the
    numbers are replaced; `store` is a type store of rosbags, `encoding` ``"ros1"`` or
    ``"cdr"``."""
    message = _blank_message(store, group.type)
    message.header.frame_id = group.frame
    if group.texts:
        message.name = list(group.texts)
        for field, values in group.fields.items():
            setattr(message, field, np.zeros(values.shape[1]))
    data = bytes(
        store.serialize_ros1(message, group.type)
        if encoding == "ros1"
        else store.serialize_cdr(message, group.type)
    )
    layout = lay_out(data, group.type, store.fielddefs, encoding)
    table = np.tile(np.frombuffer(data, np.uint8), (len(group.time), 1))
    for part, values in zip(
        ("sec", "nanosec"), np.divmod(group.time, 1_000_000_000), strict=True
    ):
        layout.write(table, f"header.stamp.{part}", values[:, None])
    for path, values in group.fields.items():
        layout.write(table, path, values)
    return table


def _blank_message(store: Any, kind: str) -> Any:
    """A message with every number 0 and every text and sequence empty."""
    values = []
    for _, (node, detail) in store.fielddefs[kind][1]:
        if node == 1:
            values.append("" if detail[0] == "string" else 0)
        elif node == 2:
            values.append(_blank_message(store, detail))
        else:
            (_, (name, _)), count = detail
            values.append(
                []
                if name == "string"
                else np.zeros(count if node == 3 else 0, dtype=name)
            )
    return store.types[kind](*values)


def channel_of(group: Messages, store: Any, context: Any) -> Any:
    """Foxglove's channel for the topic of a group, in a context of its writer; `store`
    as for `serialise`."""
    from foxglove import Channel, Schema

    text, _ = store.generate_msgdef(group.type, ros_version=2)
    schema = Schema(name=group.type, encoding="ros2msg", data=text.encode())
    return Channel(group.topic, schema=schema, message_encoding="cdr", context=context)


class McapOutput:
    """A file for Foxglove's writer, which only logs errors: the first one is kept, and
    nothing is written after it."""

    def __init__(self, stream: BinaryIO):
        self._stream = stream
        self.error: OSError | None = None

    def write(self, data: bytes | bytearray) -> int:
        """Write, unless an earlier call failed."""
        return self._attempt(len(data), self._stream.write, data)

    def seek(self, offset: int, whence: int = 0) -> int:
        """Go to a place in the file, as `write`: it may write what waits."""
        return self._attempt(offset, self._stream.seek, offset, whence)

    def flush(self) -> None:
        """Do nothing: the file is flushed when it is closed."""

    def _attempt(self, otherwise: int, step: Callable[..., int], *given: Any) -> int:
        if self.error is None:
            try:
                return step(*given)
            except OSError as error:
                self.error = error
        return otherwise


def write_bag(recording: Recording, path: str | Path) -> tuple[str, ...]:
    """Write `recording` by suffix: .bag (ROS 1), .mcap (MCAP file with ROS 2 messages),
    none (ROS 2 bag folder).

    Written are /wrench (WrenchStamped), /pose (PoseStamped) or else /orientation
    (QuaternionStamped), /twist (TwistStamped), /joint_states (JointState) and /imu
    (Imu), in frames "world" and "sensor". `read_bag` gives the same numbers, and times
    rounded to nanoseconds that start at 0. Returned are the streams ROS has no message
    for, which were left out.

    Whole or not at all: a file is replaced, a folder must not exist. Raises
    `InputError` where it cannot be written, for another suffix and for static poses,
    which have no times.
    """
    target = Path(os.path.realpath(path))
    if target.suffix not in (".bag", ".mcap", ""):
        what = f"'{target.suffix}' is not a bag that is written"
        raise InputError(what, path, "use .bag, .mcap or no suffix")
    if recording.static:
        what = "static poses have no times, which messages need"
        raise InputError(what, path, "write .csv or .parquet")
    if target.is_dir() or (target.exists() and not target.suffix):
        raise InputError("exists already", path, "choose another name")
    check_replaceable(path)
    groups = list(messages_of(recording))
    try:
        folder = Path(tempfile.mkdtemp(prefix=f".{target.name}.", dir=target.parent))
        try:
            os.replace(
                _write(groups, folder / (target.stem or "bag"), target.suffix), target
            )
        finally:
            shutil.rmtree(folder, ignore_errors=True)
    except (OSError, sqlite3.Error) as error:
        why = getattr(error, "strerror", None) or error
        raise InputError(f"cannot be written ({why})", where=path) from error
    written = {name for group in groups for name in streams_of(group)}
    return tuple(name for name in recording.streams if name not in written)


def messages_of(recording: Recording) -> Iterator[Messages]:
    """All messages of a recording, topic by topic; times from `EPOCH` on."""
    start = recording.start
    time = {
        name: EPOCH + np.rint((stream.time - start) * 1e9).astype(np.int64)
        for name, stream in recording.streams.items()
    }
    return messages_at(recording.streams, time, recording.joint_names)


def messages_at(
    streams: Mapping[str, Stream], time: Times, joint_names: tuple[str, ...] = ()
) -> Iterator[Messages]:
    """All messages of streams, topic by topic, with the stamps in `time` [ns]."""
    if "wrench" in streams:
        force, torque = np.split(streams["wrench"].values, 2, axis=1)
        fields = _fields(force, "wrench.force") | _fields(torque, "wrench.torque")
        kind = "geometry_msgs/msg/WrenchStamped"
        yield Messages("/wrench", kind, SENSOR, time["wrench"], fields)
    if _are_together(time, "position", "orientation"):
        fields = _split(streams, "position") | _split(streams, "orientation")
        kind = "geometry_msgs/msg/PoseStamped"
        yield Messages("/pose", kind, WORLD, time["position"], fields)
    elif "orientation" in streams:
        fields = _fields(streams["orientation"].values, "quaternion")
        kind = "geometry_msgs/msg/QuaternionStamped"
        yield Messages("/orientation", kind, WORLD, time["orientation"], fields)
    if _are_together(time, "linear_velocity", "angular_velocity"):
        fields = _split(streams, "linear_velocity")
        fields |= _split(streams, "angular_velocity")
        kind = "geometry_msgs/msg/TwistStamped"
        yield Messages("/twist", kind, WORLD, time["linear_velocity"], fields)
    yield from _build_joints(streams, time, joint_names)
    yield from _build_imu(streams, time)


def _are_together(time: Times, first: str, second: str) -> bool:
    """Whether both streams exist and have the same times."""
    return {first, second} <= set(time) and np.array_equal(time[first], time[second])


def _split(
    streams: Mapping[str, Stream], name: str, index: Any = slice(None)
) -> dict[str, Array]:
    """Components of a stream of vectors, by field."""
    return _fields(streams[name].values[index], VECTORS[name])


def _fields(values: Array, place: str) -> dict[str, Array]:
    """Columns of vectors or quaternions, by field within the field `place`."""
    columns = zip("xyzw", values.T, strict=False)
    return {f"{place}.{axis}": column[:, None] for axis, column in columns}


def _find_combinations(
    time: Times, *names: str
) -> Iterator[tuple[list[str], NDArray[np.int64]]]:
    """Each combination of streams, with the times at which just these have samples."""
    present = [name for name in names if name in time]
    if not present:
        return
    every = np.unique(np.concatenate([time[name] for name in present]))
    pattern = np.stack([np.isin(every, time[name]) for name in present], axis=1)
    for combination in np.unique(pattern, axis=0):
        chosen = every[(pattern == combination).all(axis=1)]
        those = zip(present, combination, strict=True)
        yield [name for name, there in those if there], chosen


def _build_joints(
    streams: Mapping[str, Stream], time: Times, joint_names: tuple[str, ...]
) -> Iterator[Messages]:
    """Joint positions and velocities, each combination of them."""
    for names, when in _find_combinations(time, *JOINT_PATHS):
        labels = joint_names or column_names(
            "joint_positions", streams[names[0]].values.shape[1]
        )
        fields = {
            field: streams[name].values[np.searchsorted(time[name], when)]
            for name, field in JOINT_PATHS.items()
            if name in names
        }
        yield Messages(
            "/joint_states", "sensor_msgs/msg/JointState", "", when, fields, labels
        )


def _build_imu(streams: Mapping[str, Stream], time: Times) -> Iterator[Messages]:
    """Gyroscope and accelerometer, each combination of them."""
    for names, when in _find_combinations(time, "gyroscope", "accelerometer"):
        unmeasured = np.tile([-1.0, *[0.0] * 8], (len(when), 1))  # REP 145
        fields = {"orientation_covariance": unmeasured}
        for name in ("gyroscope", "accelerometer"):
            if name in names:
                fields |= _split(streams, name, np.searchsorted(time[name], when))
            else:
                fields[f"{VECTORS[name]}_covariance"] = unmeasured
        yield Messages("/imu", "sensor_msgs/msg/Imu", SENSOR, when, fields)


def streams_of(group: Messages) -> list[str]:
    """Names of the streams a group of messages holds."""
    if group.topic in ("/wrench", "/orientation"):
        return [group.topic[1:]]
    if group.topic == "/joint_states":
        return [name for name, field in JOINT_PATHS.items() if field in group.fields]
    return [name for name, place in VECTORS.items() if f"{place}.x" in group.fields]


def _write(groups: list[Messages], path: Path, suffix: str) -> Path:
    """Write a new bag at `path`; the file or folder that is it."""
    with needing("rosbags", "ros"):
        from rosbags import rosbag1, rosbag2
        from rosbags.typesys import Stores, get_typestore
    ros1 = suffix == ".bag"
    store = get_typestore(Stores.ROS1_NOETIC if ros1 else Stores.ROS2_HUMBLE)
    plugin = rosbag2.StoragePlugin.MCAP if suffix else rosbag2.StoragePlugin.SQLITE3
    writer = (
        rosbag1.Writer(path)
        if ros1
        else rosbag2.Writer(path, version=8, storage_plugin=plugin)
    )
    with writer:
        connections: dict[str, Any] = {}
        for group in groups:
            if group.topic not in connections:
                connections[group.topic] = writer.add_connection(
                    group.topic, group.type, typestore=store
                )
        tables = [
            serialise(group, store, "ros1" if ros1 else "cdr") for group in groups
        ]
        which = np.concatenate(
            [np.full(len(group.time), i) for i, group in enumerate(groups)]
        )
        index = np.concatenate([np.arange(len(group.time)) for group in groups])
        time = np.concatenate([group.time for group in groups])
        for k in np.argsort(time, kind="stable"):
            connection = connections[groups[which[k]].topic]
            message = tables[which[k]][index[k]].tobytes()
            writer.write(connection, int(time[k]), message)
    return path / f"{path.name}.mcap" if suffix == ".mcap" else path
