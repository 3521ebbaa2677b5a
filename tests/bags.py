"""Bags for tests, written by `rosbags` message by message, and MCAP files written by
hand."""

import struct
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

import numpy as np
from rosbags import rosbag1, rosbag2
from rosbags.typesys import Stores, get_typestore

ROS1, ROS2 = get_typestore(Stores.ROS1_NOETIC), get_typestore(Stores.ROS2_HUMBLE)
ROS1.fielddefs["tf2_msgs/msg/TFMessage"] = ROS2.fielddefs["tf2_msgs/msg/TFMessage"]
ROS1.types["tf2_msgs/msg/TFMessage"] = ROS2.types["tf2_msgs/msg/TFMessage"]

FORMATS = (
    *("ros1.bag", "ros1-bz2.bag", "ros1-lz4.bag"),
    *(
        "db3",
        "db3-file",
        "db3-message",
        "mcap",
        "mcap-storage",
        "mcap-file",
        "mcap-message",
    ),
    *("bare.mcap", "bare-storage.mcap", "bare.db3"),
)
"""Kinds of bags `write` knows; those without a suffix are folders."""

Entry = tuple[str, str, int, Mapping[str, Any] | bytes]
"""Topic, type as geometry_msgs/WrenchStamped, logged [ns], fields by path or the
serialised message."""


def message(store, kind: str, fields: Mapping[str, Any]):
    """A message whose fields are zero and empty but for `fields`, by path; `stamp` [ns]
    and `frame` of the header."""
    values = []
    for _, (node, detail) in store.fielddefs[kind][1]:
        if node == 1:
            values.append("" if detail[0] == "string" else 0)
        elif node == 2:
            values.append(message(store, detail, {}))
        else:
            (element, inner), count = detail
            numeric = element == 1 and inner[0] != "string"
            values.append(
                np.zeros(count if node == 3 else 0, dtype=inner[0]) if numeric else []
            )
    made = store.types[kind](*values)
    for path, value in fields.items():
        if path == "stamp":
            made.header.stamp.sec, made.header.stamp.nanosec = divmod(
                value, 1_000_000_000
            )
        elif path == "frame":
            made.header.frame_id = value
        elif path == "transforms":
            made.transforms = [
                message(store, "geometry_msgs/msg/TransformStamped", one)
                for one in value
            ]
        else:
            *parents, name = path.split(".")
            target = made
            for parent in parents:
                target = getattr(target, parent)
            old = getattr(target, name)
            if hasattr(old, "__dataclass_fields__"):
                for field, number in zip(
                    list(old.__dataclass_fields__), value, strict=False
                ):
                    setattr(old, field, float(number))
            else:
                setattr(target, name, value)
    return made


def serialised(
    kind: str, fields: Mapping[str, Any], ros1: bool = False, little_endian: bool = True
) -> bytes:
    """The bytes of one message."""
    if ros1:
        return bytes(ROS1.serialize_ros1(message(ROS1, kind, fields), kind))
    return bytes(
        ROS2.serialize_cdr(
            message(ROS2, kind, fields), kind, little_endian=little_endian
        )
    )


def write(folder: Path, form: str, entries: Iterable[Entry]) -> Path:
    """A bag of one of the `FORMATS` in `folder`; the path to read."""
    if form.startswith("ros1"):
        path = folder / form
        writer: Any = rosbag1.Writer(path)
        if "-" in form:
            writer.set_compression(rosbag1.Writer.CompressionFormat[form[5:8].upper()])
    else:
        path = folder / form.replace(".", "-")
        plugin = (
            rosbag2.StoragePlugin.MCAP
            if "mcap" in form
            else rosbag2.StoragePlugin.SQLITE3
        )
        writer = rosbag2.Writer(path, version=8, storage_plugin=plugin)
        mode = form.partition(".")[0].partition("-")[2]
        if mode:
            writer.set_compression(
                rosbag2.CompressionMode[mode.upper()], rosbag2.CompressionFormat.ZSTD
            )
    ros1 = form.startswith("ros1")
    connections = {}
    with writer:
        for topic, kind, logged, fields in entries:
            kind = kind.replace("/", "/msg/")
            if (topic, kind) not in connections:
                connections[topic, kind] = writer.add_connection(
                    topic, kind, typestore=ROS1 if ros1 else ROS2
                )
            data = (
                fields if isinstance(fields, bytes) else serialised(kind, fields, ros1)
            )
            writer.write(connections[topic, kind], logged, data)
    if "." in form and not ros1:
        path = next(path.glob("*.mcap" if "mcap" in form else "*.db3"))
    return path


def mcap(records: Iterable[tuple[int, bytes]]) -> bytes:
    """An MCAP file of records (opcode, content), without chunks."""
    records = [(1, text("ros2") + text("")), *records, (15, b"\0" * 4), (2, b"\0" * 20)]
    body = b"".join(
        struct.pack("<BQ", op, len(content)) + content for op, content in records
    )
    return b"\x89MCAP0\r\n" + body + b"\x89MCAP0\r\n"


def mcap_topic(
    number: int,
    topic: str,
    kind: str,
    encoding: str = "cdr",
    language: str = "ros2msg",
    definition="",
):
    """Records of a schema and a channel, both with this number."""
    schema = struct.pack("<H", number) + text(kind) + text(language) + text(definition)
    channel = (
        struct.pack("<HH", number, number)
        + text(topic)
        + text(encoding)
        + struct.pack("<I", 0)
    )
    return [(3, schema), (4, channel)]


def mcap_message(number: int, logged: int, data: bytes) -> tuple[int, bytes]:
    """Record of one message."""
    return 5, struct.pack("<HIQQ", number, 0, logged, logged) + data


def text(value: str) -> bytes:
    """A text as MCAP writes it."""
    return struct.pack("<I", len(value)) + value.encode()
