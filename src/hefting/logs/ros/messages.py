"""Messages -> numbers: the role of each message type, and the fields that are read."""

from collections import defaultdict
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from hefting.core.errors import InputError
from hefting.core.spatial import Array
from hefting.logs.ros.layout import (
    Definitions,
    Layout,
    UnknownTypeError,
    alike,
    definitions_for,
)
from hefting.logs.ros.series import Series
from hefting.logs.ros.source import Topic

TYPES: dict[str, tuple[str, ...]] = {
    "wrench": ("geometry_msgs/msg/WrenchStamped", "geometry_msgs/msg/Wrench"),
    "pose": (
        "geometry_msgs/msg/PoseStamped",
        "geometry_msgs/msg/PoseWithCovarianceStamped",
        "geometry_msgs/msg/TransformStamped",
        "geometry_msgs/msg/QuaternionStamped",
        "nav_msgs/msg/Odometry",
    ),
    "twist": (
        "geometry_msgs/msg/TwistStamped",
        "geometry_msgs/msg/TwistWithCovarianceStamped",
    ),
    "joint": ("sensor_msgs/msg/JointState",),
    "imu": ("sensor_msgs/msg/Imu",),
    "tf": ("tf2_msgs/msg/TFMessage", "tf/msg/tfMessage"),
}
"""Message types of each role, for topics that are not named."""

ROLE = {kind: role for role, kinds in TYPES.items() for kind in kinds}
"""Role of each of these message types."""


def _components(name: str, axes: str = "xyz") -> tuple[str, ...]:
    return tuple(f"{name}.{axis}" for axis in axes)


PARTS: dict[str, tuple[tuple[str, tuple[str, ...]], ...]] = {
    "wrench": (("wrench", _components("force") + _components("torque")),),
    "pose": (
        ("pose", _components("position") + _components("orientation", "xyzw")),
        ("pose", _components("translation") + _components("rotation", "xyzw")),
        ("orientation", _components("quaternion", "xyzw")),
    ),
    "twist": (("twist", _components("linear") + _components("angular")),),
    "imu": (
        ("gyroscope", _components("angular_velocity")),
        ("accelerometer", _components("linear_acceleration")),
    ),
}
"""By role: quantities of a message, and the fields of each."""

MAX_BATCH = 8 * 1024**2
"""Size of a topic's waiting messages at which they are decoded [bytes]."""

MAX_NUMBERS = 2**27
"""Largest number of numbers that are kept of a bag: 1 GiB."""

OVERHEAD = 1024
"""Memory of each group of messages besides its numbers, in numbers."""

Key = tuple[str, ...]
"""A series' quantity, then the frames or joint names of its messages."""


@dataclass
class Gathered:
    """The numbers of one topic's messages."""

    topic: Topic
    role: str
    series: dict[Key, Series] = field(default_factory=dict)
    messages: int = 0
    unreadable: int = 0


class Collector:
    """Takes the messages of a bag one by one, and keeps their numbers.

    `where` names the bag in errors. `named` maps roles to topics; "none" leaves a role
    out. `span` becomes the first and last time when a message was logged [ns].
    """

    def __init__(self, where: object, named: Mapping[str, str]):
        self.where, self.named = where, named
        self.span: tuple[int, int] | None = None
        self.numbers = 0
        self.gathered: dict[Topic, Gathered] = {}
        self._parts: dict[Topic, dict[Key, list[Series]]] = {}
        self._waiting: dict[Topic, tuple[list[int], list[bytes]]] = {}
        self._bytes: dict[Topic, int] = {}

    def wants(self, topic: Topic) -> bool:
        """Whether the messages of a topic are to be added; prepares for them."""
        if topic in self.gathered:
            return True
        role = next(
            (role for role, name in self.named.items() if same_name(name, topic.name)),
            None,
        )
        if role is None:
            role = ROLE.get(topic.type)
            if role is None or role in self.named:
                return False
        self.gathered[topic] = Gathered(topic, role)
        self._parts[topic] = defaultdict(list)
        self._waiting[topic] = ([], [])
        self._bytes[topic] = 0
        return True

    def add(self, topic: Topic, logged: int, data: bytes) -> None:
        """Add one message of a wanted topic, `logged` at a time [ns]."""
        times, messages = self._waiting[topic]
        times.append(logged)
        messages.append(data)
        self._bytes[topic] += len(data) + 64
        if self._bytes[topic] > MAX_BATCH:
            self._decode(topic)

    def finish(self) -> dict[Topic, Gathered]:
        """The numbers of all topics."""
        for topic, gathered in self.gathered.items():
            self._decode(topic)
            gathered.series = {
                key: Series.joined(parts) for key, parts in self._parts[topic].items()
            }
        return self.gathered

    def _decode(self, topic: Topic) -> None:
        times, messages = self._waiting[topic]
        if not messages:
            return
        gathered = self.gathered[topic]
        first, last = min(times), max(times)
        if not 0 <= first <= last < 2**63:
            what = "holds times before 1970 or after 2262"
            raise InputError(what, f"{self.where}, {topic}", "repair its clock")
        logged = np.array(times, dtype=np.int64)
        self.span = (
            (min(self.span[0], first), max(self.span[1], last))
            if self.span
            else (first, last)
        )
        decoded = 0
        try:
            for index, layout, table in alike(
                messages, topic.type, self._definitions(topic), topic.encoding
            ):
                decoded += len(index)
                for key, chosen, stamps, values in _read_pieces(
                    gathered.role, layout, table
                ):
                    rows = gathered.messages + 1 + index[chosen]
                    self._parts[topic][key].append(
                        Series(stamps, logged[index[chosen]], rows, values)
                    )
                    self.numbers += values.size + 3 * len(values) + OVERHEAD
        except UnknownTypeError as error:
            raise self._missing_definition(topic, str(error)) from error
        if self.numbers > MAX_NUMBERS:
            what = "holds more than 1 GiB of numbers, or messages of too many kinds"
            raise InputError(what, self.where, "cut out the part of interest")
        gathered.messages += len(messages)
        gathered.unreadable += len(messages) - decoded
        self._waiting[topic], self._bytes[topic] = ([], []), 0

    def _definitions(self, topic: Topic) -> Definitions:
        if topic.encoding not in ("cdr", "ros1"):
            what = f"messages of {topic} are encoded as {topic.encoding[:20]!r}"
            fix = "record them as ROS 1 or ROS 2 (cdr) messages"
            raise InputError(what, self.where, fix)
        return definitions_for(topic)

    def _missing_definition(self, topic: Topic, name: str) -> InputError:
        kinds = TYPES[self.gathered[topic].role]
        what = (
            f"the bag holds no message definition of {name}, the type of {topic.name}"
        )
        fix = f"record as MCAP, which holds definitions, or as {kinds[0]}"
        return InputError(what, where=self.where, fix=fix)


def same_name(one: str, other: str) -> bool:
    """Whether two names of topics or frames are the same but for slashes around them."""
    return one.strip("/") == other.strip("/")


def without_slashes(name: str | None) -> str | None:
    """The name of a frame without slashes around it; None for None or an empty one."""
    return name.strip("/") if name else None


JOINT_PATHS = {
    "joint_positions": "position",
    "joint_velocities": "velocity",
    "joint_torques": "effort",
}
"""Field of a JointState that holds each stream."""

Piece = tuple[Key, slice | NDArray, NDArray[np.int64], Array]
"""A quantity of k messages: key, their indices, stamps (k,) [ns], values (k, d)."""


def _read_pieces(
    role: str, layout: Layout, table: NDArray[np.uint8]
) -> Iterator[Piece]:
    """The quantities in messages (k, size) of one layout."""
    if role == "tf":
        yield from _read_transforms(layout, table)
        return
    stamps = _read_stamps(layout, table, "header.stamp")
    if role == "joint":
        yield from _read_joints(layout, table, stamps)
        return
    frame = layout.texts.get("header.frame_id", "").strip("/")
    child = layout.texts.get("child_frame_id", "").strip("/")
    # an Odometry message has its twist in the axes of the child frame
    if role == "twist" and child:
        frame = child
    for what, endings in PARTS[role]:
        paths = layout.find(*endings)
        if paths is None:
            continue
        measured = slice(None)
        covariance = f"{endings[0].rpartition('.')[0]}_covariance"
        # REP 145: -1 says "not measured"
        if role == "imu" and layout.numbers.get(covariance, ("", 0, 0))[2]:
            measured = np.flatnonzero(layout.read(table, covariance)[:, 0] != -1)
            if not len(measured):
                continue
        values = np.concatenate(
            [layout.read(table, path) for path in paths], axis=1
        ).astype(float)
        yield (what, frame, child), measured, stamps[measured], values[measured]


def _read_joints(
    layout: Layout, table: NDArray[np.uint8], stamps: NDArray[np.int64]
) -> Iterator[Piece]:
    count = sum(key.startswith("name.") for key in layout.texts)
    names = [layout.texts[f"name.{i}"] for i in range(count)]
    for what, path in JOINT_PATHS.items():
        if path not in layout.numbers or not names:
            continue
        if layout.numbers[path][2] != len(names):
            continue
        values, chosen = layout.read(table, path).astype(float), slice(None)
        # drivers without torques publish NaN
        if what == "joint_torques" and not np.isfinite(values).all():
            chosen = np.flatnonzero(np.isfinite(values).all(axis=1))
            if not len(chosen):
                continue
        yield (what, *names), chosen, stamps[chosen], values[chosen]


def _read_transforms(layout: Layout, table: NDArray[np.uint8]) -> Iterator[Piece]:
    i = 0
    while (start := f"transforms.{i}") + ".child_frame_id" in layout.texts:
        i += 1
        parent, child = (
            layout.texts[f"{start}.{name}"].strip("/")
            for name in ("header.frame_id", "child_frame_id")
        )
        places = [
            f"{start}.transform.{name}"
            for name in _components("translation") + _components("rotation", "xyzw")
        ]
        values = np.concatenate(
            [layout.read(table, path) for path in places], axis=1
        ).astype(float)
        yield (
            ("tf", parent, child),
            slice(None),
            _read_stamps(layout, table, f"{start}.header.stamp"),
            values,
        )


def _read_stamps(
    layout: Layout, table: NDArray[np.uint8], path: str
) -> NDArray[np.int64]:
    """Stamps (k,) [ns] of messages; zeros for messages without stamps."""
    if [
        layout.numbers.get(f"{path}.{part}", ("", 0, 0))[2]
        for part in ("sec", "nanosec")
    ] != [1, 1]:
        return np.zeros(len(table), dtype=np.int64)
    seconds, nanoseconds = (
        layout.read(table, f"{path}.{part}")[:, 0].astype(np.int64)
        for part in ("sec", "nanosec")
    )
    return seconds * 1_000_000_000 + nanoseconds
