"""Results: a folder of Parquet files with one row for each recording, to which one
process at a time may write.

While a batch runs, rows are written as parts, each under a temporary name and then
renamed; at its end all become one file, in the order of the recordings. Of rows with
the same identity the last one counts. No file is ever incomplete.
"""

import os
import re
import socket
import time
from collections.abc import Collection, Generator, Iterable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import TYPE_CHECKING, Self

import numpy as np

from hefting.batches.columns import (
    SCHEMA,
    Digests,
    Kept,
    Row,
    columns,
    digest_of,
    digests_of,
    table_of,
)
from hefting.core.errors import InputError
from hefting.core.files import lock, replacing
from hefting.core.spatial import Indices

if TYPE_CHECKING:
    import pyarrow as pa
    from pyarrow import parquet

TABLE = "recordings.parquet"
"""File with all rows, at the end."""
PART = re.compile(r"part-(\d{6,})\.parquet")
ROWS = 500
"""Largest number of rows of a part."""
SECONDS = 5.0
"""[s] Age at which rows are written as a part, however few."""
GROUP = 1000
"""Number of rows that are in memory at once while all are gathered."""
COMPRESSION = "zstd"


Place = tuple[Path, int]
"""A file, and the number of a row group in it."""


class Results:
    """The rows in a folder, which only this process writes; see `opened`."""

    def __init__(self, folder: Path):
        self.folder = folder
        self.kept = Kept()
        """Hashes of the rows that were there when it was opened."""
        self._rows: list[Row] = []
        self._since = time.monotonic()
        self._next = 1 + max(map(_number, self._parts()), default=0)
        self._is_changed = False

    def add(self, row: Row) -> None:
        """Keep a row, and write the kept rows once they are many or old."""
        self._rows.append(row)
        late = time.monotonic() - self._since > SECONDS
        if late or len(self._rows) >= ROWS:
            self.write()

    def write(self) -> None:
        """Write the added rows as a part, whole or not at all, else `InputError`."""
        if not self._rows:
            return
        path = self.folder / f"part-{self._next:06d}.parquet"
        _write_whole(path, iter([table_of(self._rows)]))
        self._next += 1
        self._rows, self._since = [], time.monotonic()
        self._is_changed = True

    def gather(self, order: Iterable[str]) -> None:
        """Write all rows to one file, in the `order` of their identities, and remove the
        parts. `InputError` where that fails; the parts stay then."""
        self.write()
        files = self._files()
        if not self._is_changed and files == [self.folder / TABLE]:
            return
        ranked = np.fromiter(map(digest_of, order), np.uint64)
        _write_whole(self.folder / TABLE, _in_order(files, ranked))
        for path in self._parts():
            path.unlink()

    def tables(self, names: list[str] | None = None) -> "Iterator[pa.Table]":
        """The rows, a row group at a time, with the named columns or all."""
        for path in self._files():
            with _opened(path) as file:
                for group in range(file.num_row_groups):
                    yield file.read_row_group(group, names)

    def _files(self) -> list[Path]:
        """The files in the order in which they were written."""
        table = self.folder / TABLE
        return ([table] if table.exists() else []) + self._parts()

    def _parts(self) -> list[Path]:
        return sorted(
            (each for each in self.folder.iterdir() if PART.fullmatch(each.name)),
            key=_number,
        )

    @classmethod
    @contextmanager
    def opened(cls, folder: Path, resume: bool) -> Generator[Self, None, None]:
        """The results in a folder, which is made if needed; it may hold results only
        with `resume`, and no other files.

        Raises `InputError` for results without `resume` or other files there, for a
        folder that cannot be made, and while another process writes there.
        """
        try:
            folder.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise InputError(f"cannot be made ({error.strerror})", folder) from error
        _check_alone(folder)
        with locked(folder):
            for half in folder.glob(".*.parquet.*"):  # of a run that was killed
                half.unlink()
            results = cls(folder)
            if results._files() and not resume:
                fix = "give `resume` to go on with them, or choose another folder"
                raise InputError("has results already", folder, fix)
            found = results.tables(["recording", "name", "object", "hash"])
            results.kept = Kept((_identities(table), table["hash"]) for table in found)
            try:
                yield results
            finally:
                results.write()


def _check_alone(folder: Path) -> None:
    """`InputError` for files that are no results: programs that read a folder as a
    table read all its files but hidden ones."""
    names = (each.name for each in folder.iterdir() if each.name[0] not in "._")
    others = (name for name in names if name != TABLE and not PART.fullmatch(name))
    if (first := min(others, default=None)) is not None:
        what = f"holds '{first}', and results need a folder of their own"
        raise InputError(what, folder, "choose another folder")


def _number(part: Path) -> int:
    found = PART.fullmatch(part.name)
    return int(found[1]) if found else 0


@contextmanager
def _opened(path: Path) -> "Generator[parquet.ParquetFile, None, None]":
    """An open file of results. `InputError` where it cannot be read or is none."""
    import pyarrow as pa
    from pyarrow import parquet

    try:
        with parquet.ParquetFile(path, memory_map=False, pre_buffer=False) as file:
            metadata = file.schema_arrow.metadata or {}
            if metadata.get(b"hefting") != SCHEMA.encode():
                fix = "choose another folder"
                raise InputError(f"is no result of schema {SCHEMA}", path, fix)
            yield file
    except (pa.ArrowException, OSError) as error:
        reason = str(error).splitlines()[0][:200]
        fix = "remove it; `resume` makes its rows again"
        raise InputError(f"cannot be read ({reason})", path, fix) from error


def rows_named(
    table: "pa.Table", names: Collection[str]
) -> "Iterator[tuple[str, Row]]":
    """Identity and row, of the rows whose identity is one of `names`."""
    for place, name in enumerate(_identities(table).to_pylist()):
        if name in names:
            yield name, table.slice(place, 1).to_pylist()[0]


def _identities(table: "pa.Table") -> "pa.ChunkedArray":
    """Identity of each row: its name, path or, of several recordings, object."""
    import pyarrow.compute as pc

    return pc.coalesce(table["name"], table["recording"], table["object"])  # pyright: ignore[reportAttributeAccessIssue]


def _write_whole(path: Path, tables: "Iterator[pa.Table]") -> None:
    """Write tables as the row groups of one file, completely or not at all."""
    from pyarrow import parquet

    try:
        with (
            replacing(path) as stream,
            parquet.ParquetWriter(stream, columns(), compression=COMPRESSION) as writer,
        ):
            for table in tables:
                writer.write_table(table)
    except InputError as error:
        fix = "what was written before is kept: make room, then give `resume`"
        raise InputError(error.what, error.where, fix) from error


def _in_order(files: list[Path], order: Digests) -> "Iterator[pa.Table]":
    """The last row of each identity in the files, in the `order` of digests of the
    identities; rows that are not in it come at the end."""
    places: list[Place] = []
    found: list[Digests] = []
    for path in files:
        with _opened(path) as file:
            for group in range(file.num_row_groups):
                own = ["recording", "name", "object"]
                found.append(digests_of(_identities(file.read_row_group(group, own))))
                places.append((path, group))
    lengths = [len(each) for each in found]
    where = np.repeat(np.arange(len(lengths)), lengths)
    rows = np.concatenate([np.arange(n) for n in lengths])
    digests = np.concatenate(found)
    _, from_end = np.unique(digests[::-1], return_index=True)
    latest = len(digests) - 1 - from_end
    ranks = _ranks(digests[latest], order)
    chosen = latest[np.argsort(ranks, kind="stable")]
    for first in range(0, len(chosen), GROUP):
        part = chosen[first : first + GROUP]
        yield _rows_at(places, where[part], rows[part])


def _ranks(digests: Digests, order: Digests) -> Indices:
    """(n,) Index of each digest in `order`; its length for those not in it."""
    by_digest = np.argsort(order, kind="stable")
    at = np.searchsorted(order, digests, sorter=by_digest)
    at = by_digest[np.minimum(at, len(order) - 1)] if len(order) else at
    is_there = order[at] == digests if len(order) else np.zeros(len(at), bool)
    return np.where(is_there, at, len(order))


def _rows_at(places: list[Place], where: Indices, rows: Indices) -> "pa.Table":
    """The row with number `rows[k]` of the place with number `where[k]`, for each k."""
    import pyarrow as pa

    tables, order = [], []
    for number in np.unique(where):
        wanted = np.flatnonzero(where == number)
        path, group = places[number]
        with _opened(path) as file:
            tables.append(file.read_row_group(group).take(rows[wanted]))
        order.append(wanted)
    # by place so far; now in the order asked for
    return pa.concat_tables(tables).take(np.argsort(np.concatenate(order)))


LOCK = ".lock"
"""File in the folder that is locked; the system unlocks it when the process ends."""


@contextmanager
def locked(folder: Path) -> Generator[None, None, None]:
    """Lock a folder for this process within the block.

    Raises `InputError` when another process has it, or when it cannot be written.
    """
    path = folder / LOCK
    try:
        handle = _opened_lock(path)
    except OSError as error:
        raise InputError(f"cannot be written ({error.strerror})", folder) from error
    try:
        with suppress(OSError):  # a full disk
            os.ftruncate(handle, 0)
            os.pwrite(
                handle, f"process {os.getpid()} of {socket.gethostname()}".encode(), 0
            )
        yield
        with suppress(OSError):
            path.unlink()
    finally:
        os.close(handle)


def _opened_lock(path: Path) -> int:
    """Handle of the file, locked by this process. Raises `InputError` when another one
    has it, and `OSError` when it cannot be written."""
    while True:
        handle = os.open(path, os.O_RDWR | os.O_CREAT, 0o666)
        if not lock(handle):
            who = os.pread(handle, 200, 0).decode(errors="replace") or "another run"
            os.close(handle)
            what = f"{who} is writing there"
            fix = "wait for it, or choose another folder"
            raise InputError(what, path.parent, fix)
        if _is_there(path, handle):
            return handle
        os.close(handle)  # the process that had it removed it meanwhile


def _is_there(path: Path, handle: int) -> bool:
    """Whether the path is that of the open file, which may have been removed."""
    try:
        return os.path.samestat(os.stat(path), os.fstat(handle))
    except FileNotFoundError:
        return False
