"""ROS 2 bags in SQLite files (.db3), read row by row as far as the file goes."""

import shutil
import sqlite3
import tempfile
from collections.abc import Iterator
from pathlib import Path
from urllib.parse import quote

from hefting.core.errors import InputError
from hefting.logs.ros.records import Declare, Message, full_type
from hefting.logs.ros.source import MAX_CHUNK, Budget, Cut, Source, Topic

MAGIC = b"SQLite format 3\0"
"""First bytes of an SQLite file."""

ROW_BYTES = 8
"""The least a row takes in the file [bytes]: a file with more rows than fit is damaged
or made to harm."""

STEP = 100_000
"""Virtual machine instructions between two checks that the database does not run in
circles."""


def scan_sqlite(path: Path, _budget: Budget, declare: Declare) -> Iterator[Message]:
    """Messages of a .db3 file in the order they were written. `Cut` where it cannot be
    read on.

    A file shorter than it says is read up to its end. What is still in a write-ahead
    log beside it is not read: `Cut` after the last row tells.
    """
    with Source(path) as source:
        header = source.take_most(32)
        if header[:16] != MAGIC:
            raise InputError("is not an SQLite file", where=path)
        page = int.from_bytes(header[16:18], "big") or 1
        page, size = 65536 if page == 1 else page, source.size
    if part := size % page:  # SQLite would take the rest of the last page for zeros
        with tempfile.TemporaryDirectory() as folder:
            whole = Path(folder) / path.name
            with path.open("rb") as data, whole.open("wb") as copy:
                shutil.copyfileobj(data, copy)
                copy.truncate(size - part)
            yield from _scan(whole, declare)
        raise Cut("is truncated")
    yield from _scan(path, declare)
    if path.with_name(f"{path.name}-wal").is_file():
        raise Cut(f"lacks what is still in {path.name}-wal")


def _scan(path: Path, declare: Declare) -> Iterator[Message]:
    size = path.stat().st_size
    database = sqlite3.connect(
        f"file:{quote(str(path.resolve()))}?mode=ro&immutable=1", uri=True
    )
    try:
        database.setlimit(
            sqlite3.SQLITE_LIMIT_LENGTH, max(min(size, MAX_CHUNK), 10_000)
        )
        database.execute("PRAGMA trusted_schema=OFF")
        # the only way to open a file that lost its end
        database.execute("PRAGMA writable_schema=ON")
        steps = iter(range(100 + size // STEP * 10))
        database.set_progress_handler(lambda: next(steps, None) is None, STEP)
        yield from _rows(database, path, size, declare)
    except (sqlite3.Error, OverflowError, UnicodeDecodeError) as error:
        raise Cut("is truncated or damaged") from error
    finally:
        database.close()


def _rows(
    database: sqlite3.Connection, path: Path, size: int, declare: Declare
) -> Iterator[Message]:
    database.text_factory = lambda text: text.decode(errors="replace")
    tables = dict(
        database.execute("SELECT name, sql FROM sqlite_master WHERE type = 'table'")
    )
    if not {"topics", "messages"} <= set(tables):
        raise InputError(
            "is an SQLite file without the tables of a ROS 2 bag", where=path
        )
    if any("VIRTUAL" in str(tables[name]).upper() for name in ("topics", "messages")):
        raise InputError("holds virtual tables, which no ROS 2 bag does", where=path)
    definitions = {}
    if "message_definitions" in tables:
        query = "SELECT topic_type, encoding, encoded_message_definition FROM message_definitions"
        definitions = {
            str(kind): (str(text), str(language))
            for kind, language, text in database.execute(query)
        }
    topics = {}
    for number, name, kind, encoding in database.execute(
        "SELECT id, name, type, serialization_format FROM topics"
    ):
        definition, language = definitions.get(str(kind), ("", ""))
        topic = declare(
            Topic(str(name), full_type(str(kind)), str(encoding), definition, language)
        )
        if topic is not None and isinstance(number, int):
            topics[number] = topic
    wanted = ",".join(str(number) for number in topics)
    rows = data_bytes = 0
    for number, logged, data in database.execute(
        f"SELECT topic_id, timestamp, data FROM messages NOT INDEXED WHERE topic_id IN ({wanted})"
    ):
        if not isinstance(logged, int) or not isinstance(data, bytes):
            raise Cut("is damaged")
        rows, data_bytes = rows + 1, data_bytes + len(data)
        if rows * ROW_BYTES > size or data_bytes > size:
            raise Cut("is damaged")
        yield topics[number], logged, data
