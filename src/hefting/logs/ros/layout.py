"""Positions of the numbers in a serialised ROS message, found once from its definition
for all messages with the same layout.

Serialisations: ROS 1 (packed, little-endian) and ROS 2 plain CDR (aligned, either
endianness), see https://wiki.ros.org/msg and https://www.omg.org/spec/DDSI-RTPS.
Definitions are parsed, never compiled.
"""

import struct
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hefting.core.errors import needing, printable
from hefting.logs.ros.source import LONGEST_TEXT, Topic

CODES = {
    **{"bool": "u1", "byte": "u1", "char": "u1", "float32": "f4", "float64": "f8"},
    **{
        f"{sign}int{8 * n}": f"{code}{n}"
        for sign, code in (("", "i"), ("u", "u"))
        for n in (1, 2, 4, 8)
    },
}
"""Numpy codes of the numeric types."""

MAX_DEFINITION = 100_000
"""Longest message definition that is parsed [characters]."""

MAX_STEPS = 100_000
"""Largest number of fields of a message, elements of sequences included."""

MAX_LAYOUTS = 64
"""Number of layouts that are sought in messages of one length before the others are
read one by one."""

PLACEHOLDER = "structure_needs_at_least_one_member"
"""Field that ROS 2 adds to a message type without fields."""

Definitions = Mapping[str, tuple[Any, Sequence[tuple[str, Any]]]]
"""By type: constants, and fields as (name, description), as in `rosbags.typesys`."""


class Unreadable(Exception):
    """Bytes that do not fit the definition of their message."""


class UnknownTypeError(Exception):
    """A type without a definition; the text is its name."""


@dataclass(frozen=True)
class Layout:
    """Positions in messages with the same texts and lengths of sequences."""

    numbers: dict[str, tuple[str, int, int]]
    """by path, such as "wrench.force.x": numpy code, offset [bytes], count"""
    texts: dict[str, str]
    """by path, such as "header.frame_id" or "name.0" """
    fixed: tuple[tuple[int, int], ...]
    """begin and end of the bytes that determine the layout"""

    def find(self, *endings: str) -> list[str] | None:
        """The path that ends in each of `endings`; None unless there is one each."""
        found = []
        for ending in endings:
            paths = [
                path
                for path in self.numbers
                if path == ending or path.endswith(f".{ending}")
            ]
            if len(paths) != 1 or self.numbers[paths[0]][2] != 1:
                return None
            found += paths
        return found

    def read(self, messages: NDArray[np.uint8], path: str) -> NDArray:
        """Numbers (k, count) at `path` of messages (k, size) of this layout."""
        code, offset, count = self.numbers[path]
        width = int(code[-1]) * count
        return np.ascontiguousarray(messages[:, offset : offset + width]).view(code)

    def write(self, messages: NDArray[np.uint8], path: str, values: NDArray) -> None:
        """Write `values` (k, count) at `path` of messages (k, size) of this layout."""
        code, offset, count = self.numbers[path]
        width = int(code[-1]) * count
        messages[:, offset : offset + width] = np.ascontiguousarray(
            values, dtype=code
        ).view(np.uint8)


@lru_cache
def standard_definitions(encoding: str) -> Definitions:
    """Definitions of the messages of ROS 2 Humble ("cdr") or ROS 1 Noetic ("ros1")."""
    with needing("rosbags", "ros"):
        from rosbags.typesys import Stores, get_typestore
    humble = get_typestore(Stores.ROS2_HUMBLE).fielddefs
    if encoding != "ros1":
        return humble
    transforms = humble["tf2_msgs/msg/TFMessage"]
    return {
        "tf2_msgs/msg/TFMessage": transforms,
        "tf/msg/tfMessage": transforms,
        **get_typestore(Stores.ROS1_NOETIC).fielddefs,
    }


@lru_cache(maxsize=64)
def definitions_for(topic: Topic) -> Definitions:
    """Definitions that decode `topic`: the standard ones, and for other types those in
    the bag.

    `UnknownTypeError` where neither has the topic's type.
    """
    standard = standard_definitions(topic.encoding)
    if topic.type in standard:
        return standard
    own: dict = {}
    if 0 < len(topic.definition) <= MAX_DEFINITION:
        from rosbags.typesys import TypesysError, get_types_from_idl, get_types_from_msg

        try:
            idl = topic.language == "ros2idl"
            own = dict(
                get_types_from_idl(topic.definition)
                if idl
                else get_types_from_msg(topic.definition, topic.type)
            )
        except (
            TypesysError,
            ValueError,
            RecursionError,
            AssertionError,
            KeyError,
            TypeError,
            AttributeError,
        ):
            own = {}
    if topic.type not in own:
        raise UnknownTypeError(topic.type)
    return {**own, **standard}


def lay_out(
    message: bytes, topic_type: str, definitions: Definitions, encoding: str
) -> Layout:
    """The layout of one message. `Unreadable` when its bytes do not fit,
    `UnknownTypeError` for an unknown part."""
    walk = _Walk(message, definitions, cdr=encoding == "cdr")
    try:
        walk.structure("", topic_type, 0)
    except struct.error as error:
        raise Unreadable("the message is too short") from error
    if not 0 <= len(message) - walk.position <= (3 if walk.cdr else 0):
        raise Unreadable("the message is longer than its definition")
    return Layout(walk.numbers, walk.texts, tuple(walk.fixed))


class _Walk:
    """Finds the layout of a message, field by field."""

    def __init__(self, message: bytes, definitions: Definitions, cdr: bool):
        self.message, self.definitions, self.cdr = message, definitions, cdr
        self.numbers: dict[str, tuple[str, int, int]] = {}
        self.texts: dict[str, str] = {}
        self.fixed: list[tuple[int, int]] = []
        self.position, self.steps, self.order = 0, 0, "<"
        if cdr:
            if message[:2] not in (b"\0\0", b"\0\1"):
                raise Unreadable("the encapsulation is not plain CDR")
            self.order = "<" if message[1] else ">"
            self.fixed.append((0, 2))
            self.position = 4

    def structure(self, path: str, name: str, depth: int) -> None:
        if name not in self.definitions:
            raise UnknownTypeError(name)
        if depth > 16:
            raise Unreadable("the definition has no end")
        for field, (kind, detail) in self.definitions[name][1]:
            if field != PLACEHOLDER or self.cdr:
                self.field(
                    f"{path}.{field}" if path else field, int(kind), detail, depth
                )

    def field(self, path: str, kind: int, detail: Any, depth: int) -> None:
        self.steps += 1
        if self.steps > MAX_STEPS:
            raise Unreadable("the message has too many fields")
        if kind == 1:  # a base type
            if detail[0] == "string":
                self.text(path)
            else:
                self.array(path, detail[0], 1)
        elif kind == 2:  # another message
            self.structure(path, detail, depth + 1)
        else:  # an array of fixed length, or a sequence
            (element, content), count = detail
            count = count if kind == 3 else self.length()
            if int(element) == 1 and content[0] != "string":
                self.array(path, content[0], count)
            else:
                for i in range(min(count, MAX_STEPS + 1)):
                    self.field(f"{path}.{i}", int(element), content, depth)

    def array(self, path: str, name: str, count: int) -> None:
        if name not in CODES:
            raise Unreadable(f"{name} is not read")
        code = CODES[name]
        width = int(code[-1])
        if count:
            self.align(width)
        self.numbers[path] = (self.order + code, self.position, count)
        self.advance(width * count)

    def length(self) -> int:
        self.align(4)
        begin = self.position
        self.advance(4)
        self.fixed.append((begin, begin + 4))
        return struct.unpack_from(f"{self.order}I", self.message, begin)[0]

    def text(self, path: str) -> None:
        length = self.length()
        begin = self.position
        self.advance(length)
        self.fixed[-1] = (begin - 4, begin + length)
        text = self.message[begin : begin + length].rstrip(b"\0")
        self.texts[path] = printable(text.decode(errors="replace")[:LONGEST_TEXT])

    def align(self, width: int) -> None:
        if self.cdr:
            self.position += -(self.position - 4) % width

    def advance(self, count: int) -> None:
        self.position += count
        if self.position > len(self.message):
            raise Unreadable("the message is too short")


def alike(
    messages: Sequence[bytes], topic_type: str, definitions: Definitions, encoding: str
) -> Iterator[tuple[NDArray[np.intp], Layout, NDArray[np.uint8]]]:
    """Groups of messages of one layout: their indices (k,), the layout, and their bytes
    (k, size).

    Messages that do not fit the definition are in no group.
    """
    lengths = np.array([len(message) for message in messages])
    for size in np.unique(lengths):
        left = np.flatnonzero(lengths == size)
        table = np.frombuffer(
            b"".join([messages[int(i)] for i in left]), np.uint8
        ).reshape(len(left), size)
        layouts = 0
        while len(left):
            layouts += 1
            try:
                layout = lay_out(
                    messages[int(left[0])], topic_type, definitions, encoding
                )
            except Unreadable:
                left, table = left[1:], table[1:]
                continue
            if layouts > MAX_LAYOUTS:
                yield left[:1], layout, table[:1]
                left, table = left[1:], table[1:]
                continue
            same = np.ones(len(left), dtype=bool)
            for begin, end in layout.fixed:
                same &= (table[:, begin:end] == table[0, begin:end]).all(axis=1)
            yield left[same], layout, table[same]
            left, table = left[~same], table[~same]
