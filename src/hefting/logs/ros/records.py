"""ROS 1 bags and MCAP files, read record by record from the start, without index or
footer.

Formats: http://wiki.ros.org/Bags/Format/2.0 and https://mcap.dev/spec.
"""

import struct
from collections.abc import Callable, Iterator
from pathlib import Path
from zlib import crc32

from hefting.core.errors import InputError
from hefting.logs.ros.source import Budget, Cut, Source, Topic

Message = tuple[Topic, int, bytes]
"""A message: its topic, the time when it was logged [ns], its bytes."""

Declare = Callable[[Topic], Topic | None]
"""Called with each topic that is found; returns it, or the equal one found before, if
its messages are wanted, else None."""

MCAP_MAGIC = b"\x89MCAP0\r\n"
"""First bytes of an MCAP file."""

BAG_MAGIC = b"#ROSBAG V2.0\n"
"""First bytes of a ROS 1 bag."""

RECORD = struct.Struct("<BQ")
"""Header of an MCAP record: its kind and the length of the rest [bytes]."""

MESSAGE_HEAD = struct.Struct("<HIQQ")
"""Header of an MCAP message: channel, sequence number, times when it was logged and
published [ns]."""

CHUNK_HEAD = struct.Struct("<QQQII")
"""Header of an MCAP chunk: first and last time [ns], decompressed size [bytes],
CRC-32, length of the name of its compression [bytes]."""

SCHEMA, CHANNEL, MESSAGE, CHUNK, DATA_END, FOOTER = 3, 4, 5, 6, 15, 2
"""Kinds of MCAP records that are read."""

BAG_MESSAGE, BAG_HEADER, BAG_CHUNK, BAG_CONNECTION = 2, 3, 5, 7
"""Kinds of ROS 1 bag records that are read."""

U32 = struct.Struct("<I")
"""Unsigned number of 4 bytes."""

U64 = struct.Struct("<Q")
"""Unsigned number of 8 bytes."""

TIME = struct.Struct("<II")
"""Time in a ROS 1 bag: seconds and nanoseconds."""


def full_type(name: str) -> str:
    """A message type of ROS 1 or ROS 2 as package/msg/Name."""
    package, _, message = name.partition("/")
    return name if "/" in message or not message else f"{package}/msg/{message}"


def scan_mcap(path: Path, budget: Budget, declare: Declare) -> Iterator[Message]:
    """Messages of an MCAP file in stored order. `Cut` where the rest cannot be read."""
    with Source(path) as source:
        yield from _scan_mcap(source, budget, declare)


def _scan_mcap(source: Source, budget: Budget, declare: Declare) -> Iterator[Message]:
    if source.take_most(8) != MCAP_MAGIC:
        raise InputError("is not an MCAP file", where=source.path)
    schemas: dict[int, tuple[str, str, str]] = {}
    channels: dict[int, Topic | None] = {}
    while True:
        start = source.position
        op, length = RECORD.unpack(source.take(RECORD.size))
        if op in (DATA_END, FOOTER):
            return
        if op == CHUNK:
            yield from _mcap_records(
                _chunk(source, budget, length), schemas, channels, declare
            )
            if source.position != start + RECORD.size + length:
                raise Cut("is truncated")
        elif op in (SCHEMA, CHANNEL, MESSAGE):
            record = RECORD.pack(op, length) + source.take(length)
            yield from _mcap_records(record, schemas, channels, declare)
        elif op == 0:
            raise Cut(f"is damaged at byte {start}")
        else:
            source.skip(length)


def _chunk(source: Source, budget: Budget, length: int) -> bytes:
    """Records in the next chunk, as far as it is complete."""
    start = source.position
    data = source.take_most(length)
    if len(data) < CHUNK_HEAD.size + 8:
        raise Cut("is truncated")
    _, _, size, checksum, named = CHUNK_HEAD.unpack_from(data)
    begin = CHUNK_HEAD.size + named + 8
    if begin > len(data):
        raise Cut("is truncated")
    kind = data[CHUNK_HEAD.size : begin - 8].decode()
    stored = data[begin : begin + U64.unpack_from(data, begin - 8)[0]]
    content = budget.inflate(kind, stored, size)
    if checksum and len(content) == size and crc32(content) != checksum:
        raise Cut(f"is damaged at byte {start} (wrong checksum)")
    return content


def _mcap_records(
    data: bytes, schemas: dict, channels: dict, declare: Declare
) -> Iterator[Message]:
    position, end = 0, len(data)
    while position + RECORD.size <= end:
        op, length = RECORD.unpack_from(data, position)
        begin, position = position + RECORD.size, position + RECORD.size + length
        if position > end:
            raise Cut("is truncated")
        if op == MESSAGE and length >= MESSAGE_HEAD.size:
            channel, _, logged, _ = MESSAGE_HEAD.unpack_from(data, begin)
            topic = channels.get(channel)
            if topic is not None:
                yield topic, logged, data[begin + MESSAGE_HEAD.size : position]
        elif op == SCHEMA:
            number = int.from_bytes(data[begin : begin + 2], "little")
            name, at = _text(data, begin + 2)
            language, at = _text(data, at)
            schemas[number] = (full_type(name), language, _text(data, at)[0])
        elif op == CHANNEL:
            number, schema = struct.unpack_from("<HH", data, begin)
            name, at = _text(data, begin + 4)
            kind, language, definition = schemas.get(schema, ("", "", ""))
            channels[number] = declare(
                Topic(name, kind, _text(data, at)[0], definition, language)
            )
        else:
            raise Cut("is damaged (a chunk of something else than messages)")
    if position != end:
        raise Cut("is truncated")


def _text(data: bytes, position: int) -> tuple[str, int]:
    (length,) = U32.unpack_from(data, position)
    end = position + 4 + length
    if end > len(data):
        raise Cut("is damaged (a text longer than its record)")
    return data[position + 4 : end].decode(errors="replace"), end


def scan_bag(path: Path, budget: Budget, declare: Declare) -> Iterator[Message]:
    """Messages of a ROS 1 bag in stored order. `Cut` where the rest cannot be read."""
    with Source(path) as source:
        yield from _scan_bag(source, budget, declare)


def _scan_bag(source: Source, budget: Budget, declare: Declare) -> Iterator[Message]:
    magic = source.take_most(len(BAG_MAGIC))
    if magic != BAG_MAGIC:
        old = magic.startswith(b"#ROSBAG V")
        raise InputError(
            "is a ROS bag of another version than 2.0" if old else "is not a ROS 1 bag",
            source.path,
        )
    connections: dict[int, Topic | None] = {}
    indexed = False
    while source.left:
        header = source.take(U32.unpack(source.take(4))[0])
        fields = _fields(header, 0, len(header))
        (length,) = U32.unpack(source.take(4))
        op = fields[b"op"][0]
        if op == BAG_CHUNK:
            stored = source.take_most(length)
            (size,) = U32.unpack(fields[b"size"])
            kind = fields[b"compression"].decode()
            yield from _bag_records(
                budget.inflate(kind, stored, size), connections, declare
            )
        elif op in (BAG_MESSAGE, BAG_CONNECTION):
            record = (
                U32.pack(len(header)) + header + U32.pack(length) + source.take(length)
            )
            yield from _bag_records(record, connections, declare)
        else:
            if op == BAG_HEADER:
                (index,) = U64.unpack(fields[b"index_pos"])
                indexed = 0 < index <= source.size
                if fields.get(b"encryptor"):
                    raise InputError("is encrypted", source.path, "decrypt it first")
            source.skip(length)
    if not indexed:
        raise Cut("is truncated")


def _bag_records(data: bytes, connections: dict, declare: Declare) -> Iterator[Message]:
    position, end = 0, len(data)
    while position + 4 <= end:
        begin = position + 4
        after = begin + U32.unpack_from(data, position)[0]
        if after + 4 > end:
            raise Cut("is truncated")
        fields = _fields(data, begin, after)
        begin = after + 4
        position = begin + U32.unpack_from(data, after)[0]
        if position > end:
            raise Cut("is truncated")
        op = fields[b"op"][0]
        if op == BAG_MESSAGE:
            topic = connections.get(U32.unpack(fields[b"conn"])[0])
            if topic is not None:
                seconds, nanoseconds = TIME.unpack(fields[b"time"])
                yield topic, seconds * 1_000_000_000 + nanoseconds, data[begin:position]
        elif op == BAG_CONNECTION:
            content = _fields(data, begin, position)
            kind = content[b"type"].decode()
            definition = content.get(b"message_definition", b"")
            topic = Topic(
                fields[b"topic"].decode(),
                full_type(kind),
                "ros1",
                definition.decode(errors="replace"),
                "ros1msg",
            )
            connections[U32.unpack(fields[b"conn"])[0]] = declare(topic)
    if position != end:
        raise Cut("is truncated")


def _fields(data: bytes, position: int, end: int) -> dict[bytes, bytes]:
    """The name=value fields of a record's header."""
    fields = {}
    while position < end:
        after = position + 4 + U32.unpack_from(data, position)[0]
        if after > end:
            raise Cut("is damaged (a field longer than its record)")
        name, _, value = data[position + 4 : after].partition(b"=")
        fields[name] = value
        position = after
    return fields
