"""Serialisation of all messages of a topic at once, and the file for Foxglove's writer
of MCAP."""

from dataclasses import dataclass
from typing import Any, BinaryIO

import numpy as np
from numpy.typing import NDArray

from hefting.core.spatial import Array
from hefting.logs.ros.layout import lay_out


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
        if self.error is None:
            try:
                return self._stream.write(data)
            except OSError as error:
                self.error = error
        return len(data)

    def seek(self, offset: int, whence: int = 0) -> int:
        """Go to a place in the file."""
        return self._stream.seek(offset, whence)

    def flush(self) -> None:
        """Do nothing: the file is flushed when it is closed."""
