"""Windows: a table too large for memory as consecutive recordings, of which no more
than two are held at a time.

Each is a recording of its own, with a bias, a drift and a clock offset of its own, and
what was smoothed has two more ends: what several tell of one object is found by
`hefting.identification.partials`.
"""

import sys
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from math import inf
from pathlib import Path

from hefting.core.errors import InputError
from hefting.core.files import check_readable, check_size
from hefting.core.immutable import immutable
from hefting.core.recording import Recording
from hefting.logs.csv_file import texts
from hefting.logs.registry import Format, find_format, suffix_of, table_formats
from hefting.logs.table import Block, Table
from hefting.logs.table_file import opened

SECONDS = 45.0
"""[s] Length of a window. A bias that drifts costs six unknowns a window: in 45 s of
slow motion the object turns often enough to tell them."""
ROWS = 45_000
"""Most rows of a window. The last two share theirs where the last would have fewer than
half as many."""
FEWEST_ROWS = 1_000
"""Fewest rows of a window, whatever its time."""
LARGEST_WHOLE = 10_000_000
"""Numbers in a table up to which it is read whole: some twelve minutes of fourteen
columns at 1 kHz."""
SAID_ONCE = {"time-shifted", "columns-by-name", "columns-doubtful", "end-left-out"}
"""Codes of messages about a file, which its first window has."""

Reader = Callable[[Table], Recording]
"""What makes a recording of a table."""


def windows(
    path: str | Path,
    column_map: str | Path | None = None,
    *,
    seconds: float = SECONDS,
    rows: int = ROWS,
) -> Iterator[Recording]:
    """The table at `path` as consecutive recordings, each sample in one of them.

    Parameters
    ----------
    path : path
        CSV or Parquet, of any size.
    column_map : path, optional
        As for `hefting.read_log`.
    seconds : float
        [s] Length of a window, by the pace of the first rows.
    rows : int
        Most rows of a window. Each has at least half as many as the others.

    Yields
    ------
    Recording
        Whose source names the file and the rows.

    Raises
    ------
    InputError
        As `hefting.read_log` does, at the window where it is found; for a bag.
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
    """Whether a table holds more numbers than are read whole (`LARGEST_WHOLE`), as far
    as its size tells; False of what is no table."""
    found = find_format(path)
    if found is None or not (found.is_table and found.in_blocks):
        return False
    if not Path(path).is_file():
        return False
    return _numbers(path) > LARGEST_WHOLE


def _numbers(path: str | Path) -> float:
    """Numbers in a table; of text an estimate by its first lines."""
    if suffix_of(path) == ".parquet":
        from pyarrow import ArrowException, parquet

        try:
            metadata = parquet.read_metadata(path)
        except (ArrowException, OSError):
            return 0.0  # reading it says why
        return float(metadata.num_rows * metadata.num_columns)
    first = next(texts(path), b"")
    cells = sum(first.count(mark) for mark in (b"\n", b",", b";", b"\t"))
    return cells * Path(path).stat().st_size / max(len(first), 1)


def _format_of(path: str | Path) -> Format:
    """The format of a table; `InputError` for what is none, or cannot be read."""
    found = find_format(path)
    if found is None or not (found.is_table and found.in_blocks):
        tables = " or ".join(each.name for each in table_formats() if each.in_blocks)
        raise InputError(
            f"only {tables} is read window by window",
            path,
            "convert it (hefting convert), or give `start` and `duration`",
        )
    check_readable(path)
    check_size(path, inf)
    return found


def _give_back() -> None:
    """Have pyarrow return the memory that it keeps for later tables."""
    if "pyarrow" in sys.modules:
        import pyarrow as pa

        pa.default_memory_pool().release_unused()


class _Asked(Exception):
    """Carries the columns that a reader asks a table for."""


@immutable
class _Probe:
    """A table that tells which columns are read of it, in `_Asked`."""

    source: str
    names: tuple[str, ...]

    def blocks(self, columns: Sequence[int]) -> Iterator[Block]:
        raise _Asked(columns)


@immutable
class _Part:
    """Some consecutive rows of a table."""

    table: Table
    held: Sequence[Block]
    few: float = 1.0
    """Share of its samples that may lack something: of the whole table they may be
    few."""

    @property
    def source(self) -> str:
        return self.table.source

    @property
    def names(self) -> tuple[str, ...]:
        return self.table.names

    def blocks(self, columns: Sequence[int]) -> Iterator[Block]:
        yield from self.held


class _Pace:
    """How many rows a window has, which the first rows tell, and how one is read."""

    def __init__(self, read: Reader, seconds: float, rows: int):
        self._read, self._seconds, self._first = read, seconds, True
        self.rows, self._most = rows, rows

    def set_by(self, part: _Part) -> None:
        """Take the pace of the first rows."""
        recording = self._read(part)
        if not recording.static and recording.duration > 0.0:
            pace = _count(part.held) / recording.duration
            wanted = max(int(self._seconds * pace), FEWEST_ROWS)
            self.rows = min(wanted, self._most)

    def recording(self, part: _Part) -> Recording:
        """A window as a recording; what is said of the file is said once."""
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
    """The columns that a reader takes; `InputError` where the header does not do."""
    try:
        read(_Probe(table.source, table.names))
    except _Asked as asked:
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
    """Some rows of a block, copied: the others need not be kept for them."""
    return Block(
        block.rows[chosen].copy(),
        {j: values[chosen].copy() for j, values in block.values.items()},
        {j: None if b is None else b[chosen].copy() for j, b in block.blanks.items()},
    )


def _count(blocks: Sequence[Block]) -> int:
    """Number of rows."""
    return sum(len(block.rows) for block in blocks)
