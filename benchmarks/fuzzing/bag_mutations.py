"""Mutations that keep the structure of a bag: rows of SQLite files, records of MCAP
files and ROS 1 bags."""

import sqlite3
import struct
import tempfile
from pathlib import Path

import numpy as np

from benchmarks.fuzzing.bytes_mutations import (
    BYTES,
    ODD_INTEGERS,
    Mutation,
    choice,
)

STATEMENTS = (
    "UPDATE messages SET data = NULL WHERE id % 7 = {n}",
    "UPDATE messages SET data = 'text' WHERE id % 7 = {n}",
    "UPDATE messages SET data = {n} WHERE id % 7 = {n}",
    "UPDATE messages SET data = zeroblob({n}) WHERE id % 7 = 1",
    "UPDATE messages SET timestamp = NULL WHERE id % 7 = {n}",
    "UPDATE messages SET timestamp = {n} WHERE id % 7 = 1",
    "UPDATE messages SET timestamp = 1e300 WHERE id % 7 = 1",
    "UPDATE messages SET timestamp = -timestamp",
    "UPDATE messages SET topic_id = {n} WHERE id % 7 = 1",
    "UPDATE messages SET topic_id = NULL WHERE id % 7 = 1",
    "UPDATE topics SET name = NULL WHERE id = 1",
    "UPDATE topics SET type = NULL WHERE id = 1",
    "UPDATE topics SET type = 'sensor_msgs/msg/JointState'",
    "UPDATE topics SET type = 'nothing'",
    "UPDATE topics SET serialization_format = 'json'",
    "UPDATE topics SET name = zeroblob(9)",
    "UPDATE topics SET id = {n} WHERE id = 1",
    "DELETE FROM topics WHERE id = 1",
    "DELETE FROM messages WHERE id % 7 = 1",
    "INSERT INTO topics SELECT id + 90, name, type, serialization_format, offered_qos_profiles FROM topics",
    "INSERT INTO messages SELECT id + 9000, topic_id, timestamp, data FROM messages",
    "DROP TABLE topics",
    "ALTER TABLE messages RENAME COLUMN data TO content",
    "ALTER TABLE messages RENAME TO m",
    "CREATE VIEW more AS SELECT * FROM messages",
)
"""Changes of a ROS 2 bag's tables; ``{n}`` is an odd number."""


UNCONSTRAINED = "".join(
    f"CREATE TABLE other AS SELECT * FROM {table}; DROP TABLE {table};"
    f"ALTER TABLE other RENAME TO {table};"
    for table in ("messages", "topics")
)
"""Makes the tables anew, without the constraints on what their cells may hold."""


def sqlite_rows(data: bytes, rng: np.random.Generator) -> bytes:
    """An SQLite file after one to three of the `STATEMENTS`."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "bag.db3"
        path.write_bytes(data)
        database = sqlite3.connect(path, isolation_level=None)
        try:
            if rng.random() < 0.7:
                database.executescript(UNCONSTRAINED)
            for _ in range(int(rng.integers(1, 4))):
                number = choice(rng, (*range(7), *ODD_INTEGERS[:15], 2**62))
                statement = choice(rng, STATEMENTS)
                if "zeroblob" in statement:
                    number = min(number, 10_000)
                database.execute(statement.format(n=number))
        except (sqlite3.Error, OverflowError, UnicodeError):
            pass  # an earlier mutation left nothing to change
        finally:
            database.close()
        return path.read_bytes()


def sqlite_messages(data: bytes, rng: np.random.Generator) -> bytes:
    """An SQLite file with the bytes of some messages changed."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "bag.db3"
        path.write_bytes(data)
        database = sqlite3.connect(path, isolation_level=None)
        try:
            rows = list(database.execute("SELECT id, data FROM messages"))
            for number, content in rows:
                if rng.random() < 0.1 and isinstance(content, bytes) and content:
                    changed = choice(rng, BYTES)(content, rng)
                    query = "UPDATE messages SET data = ? WHERE id = ?"
                    database.execute(query, (changed, number))
        except (sqlite3.Error, OverflowError, UnicodeError):
            pass
        finally:
            database.close()
        return path.read_bytes()


def mcap_records(data: bytes, rng: np.random.Generator) -> bytes:
    """An MCAP file with records left out, repeated, in another order, of another kind,
    or changed inside, all lengths right."""
    records, position = [], 8
    while position + 9 <= len(data):
        op, length = struct.unpack_from("<BQ", data, position)
        end = position + 9 + length
        if end > len(data):
            break
        records.append((op, data[position + 9 : end]))
        position = end
    if not records:
        return data
    _change(records, rng)
    body = b"".join(
        struct.pack("<BQ", op, len(content)) + content for op, content in records
    )
    return data[:8] + body + data[position:]


def bag_records(data: bytes, rng: np.random.Generator) -> bytes:
    """A ROS 1 bag with records left out, repeated, in another order or changed inside,
    all lengths right."""
    begin = data.find(b"\n") + 1
    records, position = [], begin
    while position + 4 <= len(data):
        parts, start = [], position
        for _ in range(2):
            if position + 4 > len(data):
                break
            length = struct.unpack_from("<I", data, position)[0]
            parts.append(data[position + 4 : position + 4 + length])
            position += 4 + length
        if len(parts) < 2 or position > len(data):
            position = start
            break
        records.append(tuple(parts))
    if not records:
        return data
    which = int(rng.integers(2))
    inner = [(0, part) for record in records for part in record]
    chosen = 2 * int(rng.integers(len(records))) + which
    inner[chosen] = (0, choice(rng, BYTES)(inner[chosen][1], rng))
    parts = [part for _, part in inner]
    body = b"".join(struct.pack("<I", len(part)) + part for part in parts)
    return data[:begin] + body + data[position:]


def _change(records: list[tuple[int, bytes]], rng: np.random.Generator) -> None:
    at, to = rng.integers(len(records), size=2).tolist()
    op, content = records[at]
    kind = choice(rng, ("drop", "again", "swap", "op", "inside", "inside", "inside"))
    if kind == "drop":
        del records[at]
    elif kind == "again":
        records.insert(to, records[at])
    elif kind == "swap":
        records[at], records[to] = records[to], records[at]
    elif kind == "op":
        records[at] = (int(rng.integers(256)), content)
    else:
        records[at] = (op, choice(rng, BYTES)(content, rng))


SQLITE: tuple[Mutation, ...] = (sqlite_rows, sqlite_messages, *BYTES)
"""Mutations of ROS 2 bags in SQLite."""

MCAP: tuple[Mutation, ...] = (mcap_records, mcap_records, mcap_records, *BYTES)
"""Mutations of MCAP files."""

BAG: tuple[Mutation, ...] = (bag_records, bag_records, *BYTES)
"""Mutations of ROS 1 bags."""
