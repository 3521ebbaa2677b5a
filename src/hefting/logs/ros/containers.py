"""Files of ROS data: ROS 1 bags, MCAP and SQLite files, and ROS 2 folders of these."""

import re
import shutil
import sqlite3
import struct
import tempfile
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from pathlib import Path
from urllib.parse import quote

from hefting.core.errors import InputError
from hefting.logs.ros.records import Declare, Message, full_type, scan_bag, scan_mcap
from hefting.logs.ros.source import MAX_CHUNK, Budget, Cut, Source, Topic, zstandard

MAGIC = b"SQLite format 3\0"
"""First bytes of an SQLite file."""

ROW_BYTES = 8
"""Smallest size of a row in the file [bytes]; a file with more rows than fit is damaged
or malicious."""

STEP = 100_000
"""Virtual machine instructions between two checks against endless loops in a database."""


def scan_sqlite(path: Path, _budget: Budget, declare: Declare) -> Iterator[Message]:
    """Messages of a .db3 file in the order in which they were written. `Cut` where the
    rest cannot be read.

    A truncated file is read up to its end. A write-ahead log beside it is not read:
    `Cut` is raised after the last row then.
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
            yield from _scan_tables(whole, declare)
        raise Cut("is truncated")
    yield from _scan_tables(path, declare)
    if path.with_name(f"{path.name}-wal").is_file():
        raise Cut(f"lacks what is still in {path.name}-wal")


def _scan_tables(path: Path, declare: Declare) -> Iterator[Message]:
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


SCANS = {".bag": scan_bag, ".db3": scan_sqlite}
"""Reader of each suffix; other files are MCAP."""

ZSTD_MAGIC = b"\x28\xb5\x2f\xfd"
"""First bytes of data that are compressed with zstd."""

MAX_METADATA = 1_000_000
"""Part of a bag's metadata.yaml that is read [bytes]."""

MAX_INFLATED = 4 * 1024**3
"""Largest decompressed size, on disk, of a file that is compressed as a whole [bytes]."""


@dataclass
class Contents:
    """Topics of a bag, and faults of its files, found so far."""

    path: Path
    topics: list[Topic] = field(default_factory=list)
    cuts: list[str] = field(default_factory=list)
    """files that could not be read to their end: "name is truncated" """
    expected: float | None = None
    """duration by the bag's metadata [s]"""


def read_messages(
    contents: Contents, wanted: Callable[[Topic], bool]
) -> Iterator[Message]:
    """Messages of the wanted topics of a bag, file by file, as far as each can be read.

    Fills `contents`. Raises `InputError` for a path that is no bag.
    """
    known: dict[tuple[str, str, str], Topic] = {}

    def declare(topic: Topic) -> Topic | None:
        first = known.setdefault((topic.name, topic.type, topic.encoding), topic)
        if first is topic:
            contents.topics.append(topic)
        return first if wanted(first) else None

    for path in _find_files(contents):
        try:
            yield from _scan(path, declare)
        except Cut as cut:
            contents.cuts.append(f"{path.name} {cut}")


def _find_files(contents: Contents) -> list[Path]:
    path = contents.path
    if not path.exists():
        raise InputError("does not exist", where=path)
    if path.is_file():
        return [path]
    if not path.is_dir():
        raise InputError("is neither a file nor a folder", where=path)
    present, named = storage_files(path), []
    metadata = path / "metadata.yaml"
    if metadata.is_file():
        with metadata.open("rb") as file:
            text = file.read(MAX_METADATA).decode(errors="replace")
        names = re.search(
            r"^ *relative_file_paths:[ \r]*\n((?: *- *\S[^\n]*\n)+)", text, re.MULTILINE
        )
        named = (
            [path / Path(n.strip(" -'\"\r")).name for n in names[1].splitlines()]
            if names
            else []
        )
        duration = re.search(
            r"^ *duration:[ \r]*\n *nanoseconds: *(\d{1,18})\b", text, re.MULTILINE
        )
        contents.expected = int(duration[1]) * 1e-9 if duration else None
    else:
        contents.cuts.append("metadata.yaml is missing")
    contents.cuts += [
        f"{file.name} is missing" for file in named if file not in present
    ]
    files = [file for file in named if file in present] if named else present
    if not files:
        raise InputError("the folder holds no .db3 or .mcap file", where=path)
    return files


def _scan(path: Path, declare: Declare) -> Iterator[Message]:
    if path.suffix == ".zstd":
        with tempfile.TemporaryDirectory() as folder:
            inflated = Path(folder) / path.stem
            whole = _inflate_file(path, inflated)
            yield from _scan(inflated, declare)
        if not whole:
            raise Cut("is truncated")
        return
    size = path.stat().st_size
    if size == 0:
        raise InputError("the file is empty", where=path)
    budget = Budget(path, size)
    try:
        for topic, logged, data in SCANS.get(path.suffix.lower(), scan_mcap)(
            path, budget, declare
        ):
            compressed = topic.encoding == "cdr" and data[:4] == ZSTD_MAGIC
            yield topic, logged, budget.inflate("zstd", data) if compressed else data
    except (struct.error, KeyError, IndexError, UnicodeDecodeError) as error:
        raise Cut("is damaged") from error


def _inflate_file(path: Path, target: Path) -> bool:
    """Decompress a file; returns whether it was complete. `InputError` where it is not
    compressed with zstd."""
    zstd = zstandard()
    decompressor, budget = zstd.ZstdDecompressor(), Budget(path, path.stat().st_size)
    with Source(path) as source, target.open("wb") as out:
        try:
            while not decompressor.eof:
                data = source.take_most(1 << 20) if decompressor.needs_input else b""
                if not data and decompressor.needs_input:
                    return False
                inflated = decompressor.decompress(data, max_length=1 << 24)
                budget.spend(len(inflated))
                out.write(inflated)
                if out.tell() > MAX_INFLATED:
                    raise InputError(
                        "decompresses to more than 4 GiB", path, "decompress it first"
                    )
        except zstd.ZstdError as error:
            if not out.tell():
                raise InputError("is not compressed with zstd", where=path) from error
            return False
    return True


def storage_files(folder: Path) -> list[Path]:
    """Files of a ROS 2 bag in a folder, by name and number."""
    names = (
        file
        for suffix in ("db3", "mcap")
        for end in ("", ".zstd")
        for file in folder.glob(f"*.{suffix}{end}")
    )
    return sorted(
        names,
        key=lambda file: [
            int(p) if k % 2 else p for k, p in enumerate(re.split(r"(\d+)", file.name))
        ],
    )
