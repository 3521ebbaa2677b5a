"""Windows: a table too large for memory as consecutive recordings, at most two of which
are in memory at once.

Each is a separate recording, with its own bias, drift and clock offset, and two more ends
of the smoothed motion. `hefting.identification.partials` identifies one object from
several.
"""

import sys
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from math import inf
from pathlib import Path

from hefting.core.errors import InputError
from hefting.core.files import check_readable, check_size
from hefting.core.recording import Recording
from hefting.core.spatial import immutable
from hefting.logs.csv_file import READ, texts
from hefting.logs.registry import Format, find_format, suffix_of, table_formats
from hefting.logs.table import Block, Table
from hefting.logs.table_file import opened

SECONDS = 45.0
"""[s] Length of a window. A drifting bias adds six unknowns to each window; in 45 s of
slow motion the object turns often enough to determine them."""
ROWS = 45_000
"""Largest number of rows of a window. The last two share their rows equally where the
last would have fewer than half as many."""
FEWEST_ROWS = 1_000
"""Smallest number of rows of a window, of whatever duration."""
LARGEST_WHOLE = 10_000_000
"""Largest number of numbers in a table that is read as a whole: some twelve minutes of
fourteen columns at 1 kHz."""
SAID_ONCE = {"time-shifted", "columns-by-name", "columns-doubtful", "end-left-out"}
"""Codes of messages about the file, which only the first window has."""

Reader = Callable[[Table], Recording]
"""Reads a recording from a table."""


def windows(
    path: str | Path,
    column_map: str | Path | None = None,
    *,
    seconds: float = SECONDS,
    rows: int = ROWS,
) -> Iterator[Recording]:
    """The table at `path` as consecutive recordings without overlap.

    Parameters
    ----------
    path : path
        CSV or Parquet, of any size.
    column_map : path, optional
        As for `hefting.read_log`.
    seconds : float
        [s] Length of a window, by the rate of the first rows.
    rows : int
        Largest number of rows of a window; the last one has at least half as many as
        the others.

    Yields
    ------
    Recording
        Its source names the file and the rows.

    Raises
    ------
    InputError
        As `hefting.read_log`, at the window with the fault; also for a bag.
    """
    table, read = opened(_format_of(path), path, column_map, wrench_needed=True)
    columns = _columns_read(table, read)
    pace = _Pace(read, seconds, rows)
    held: list[Block] = []
    for part in _cut(table, columns, pace):
        if held and _count(part) < 0.5 * pace.rows:
            both = [*held, *part]
            held, part = _split(both, (_count(both) + 1) // 2)
            del both
        if held:
            window, held = pace.recording(_Part(table, held)), part
            _give_back()
            yield window
            del window
        held = part
    yield pace.recording(_Part(table, held))


def needs_windows(path: str | Path) -> bool:
    """Whether a table holds more than `LARGEST_WHOLE` numbers, by its size; False for
    other files."""
    found = find_format(path)
    if found is None or not (found.is_table and found.in_blocks):
        return False
    if not Path(path).is_file():
        return False
    return _numbers(path) > LARGEST_WHOLE


def _numbers(path: str | Path) -> float:
    """Number of numbers in a table; for text an estimate from its first lines."""
    if suffix_of(path) == ".parquet":
        from pyarrow import ArrowException, parquet

        try:
            metadata = parquet.read_metadata(path)
        except (ArrowException, OSError):
            return 0.0  # reading the file raises the error
        return float(metadata.num_rows * metadata.num_columns)
    first = next(texts(path), b"")
    cells = sum(first.count(mark) for mark in (b"\n", b",", b";", b"\t"))
    return cells * max(Path(path).stat().st_size / READ, 1.0)


def _format_of(path: str | Path) -> Format:
    """The format of a table; `InputError` for another or unreadable file."""
    found = find_format(path)
    if found is None or not (found.is_table and found.in_blocks):
        tables = " or ".join(each.name for each in table_formats() if each.in_blocks)
        fix = "convert it (hefting convert), or give `start` and `duration`"
        raise InputError(f"only {tables} is read window by window", path, fix)
    check_readable(path)
    check_size(path, inf)
    return found


def _give_back() -> None:
    """Make pyarrow release the memory that it keeps for later tables."""
    if "pyarrow" in sys.modules:
        import pyarrow as pa

        pa.default_memory_pool().release_unused()


class _ColumnsAsked(Exception):
    """Carries the columns that a reader reads from a table."""


@immutable
class _Probe:
    """A table that raises the columns that are read from it, in `_ColumnsAsked`."""

    source: str
    names: tuple[str, ...]

    def blocks(self, columns: Sequence[int]) -> Iterator[Block]:
        raise _ColumnsAsked(columns)


@immutable
class _Part:
    """Some consecutive rows of a table."""

    table: Table
    held: Sequence[Block]
    few: float = 1.0
    """Largest share of incomplete samples: in a window there may be many, if they are
    few in the whole table."""

    @property
    def source(self) -> str:
        return self.table.source

    @property
    def names(self) -> tuple[str, ...]:
        return self.table.names

    def blocks(self, columns: Sequence[int]) -> Iterator[Block]:
        yield from self.held


class _Pace:
    """Number of rows of a window, found from the first rows, and its reader."""

    def __init__(self, read: Reader, seconds: float, rows: int):
        self._read, self._seconds, self._first = read, seconds, True
        self.rows, self._most = rows, rows

    def set_by(self, part: _Part) -> None:
        """Set the number of rows by the rate of the first rows."""
        recording = self._read(part)
        if not recording.static and recording.duration > 0.0:
            rate = _count(part.held) / recording.duration
            wanted = max(int(self._seconds * rate), FEWEST_ROWS)
            self.rows = min(wanted, self._most)

    def recording(self, part: _Part) -> Recording:
        """A window as a recording; only the first has the messages about the file."""
        read = self._read(part)
        first, last = part.held[0].rows[0], part.held[-1].rows[-1]
        kept = [
            message
            for message in read.warnings
            if self._first or getattr(message, "code", "") not in SAID_ONCE
        ]
        self._first = False
        source = f"{read.source}, rows {first} to {last}"
        return replace(read, source=source, warnings=tuple(kept))


def _columns_read(table: Table, read: Reader) -> Sequence[int]:
    """The columns that a reader reads; `InputError` for an unsuitable header."""
    try:
        read(_Probe(table.source, table.names))
    except _ColumnsAsked as asked:
        return asked.args[0]
    raise AssertionError("a reader reads its table")


def _cut(table: Table, columns: Sequence[int], pace: _Pace) -> Iterator[list[Block]]:
    """The rows of a table in windows; the last one may be short."""
    part: list[Block] = []
    known = False
    for block in table.blocks(columns):
        part.append(block)
        if not known and _count(part) >= min(FEWEST_ROWS, pace.rows):
            pace.set_by(_Part(table, part))
            known = True
        while known and _count(part) >= pace.rows:
            whole, part = _split(part, pace.rows)
            yield whole
            del whole
    if part:
        yield part


def _split(blocks: list[Block], count: int) -> tuple[list[Block], list[Block]]:
    """The first `count` rows of blocks, and the rest."""
    first: list[Block] = []
    for i, block in enumerate(blocks):
        size = len(block.rows)
        if size >= count:
            rest = [_rows(block, slice(count, None))] if size > count else []
            first.append(_rows(block, slice(0, count)))
            return first, rest + blocks[i + 1 :]
        first.append(block)
        count -= size
    return first, []


def _rows(block: Block, chosen: slice) -> Block:
    """A copy of some rows of a block, so that the others can be freed."""
    return Block(
        block.rows[chosen].copy(),
        {j: values[chosen].copy() for j, values in block.values.items()},
        {j: None if b is None else b[chosen].copy() for j, b in block.blanks.items()},
    )


def _count(blocks: Sequence[Block]) -> int:
    return sum(len(block.rows) for block in blocks)
