"""Tables read block by block: named columns of numbers -> the samples of groups of columns."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from hefting.errors import InputError
from hefting.recording import Stream
from hefting.spatial import Array, Mask

MAX_CELLS = 100_000_000
"""Most numbers that are read from one file (0.8 GB): more than an hour of twenty columns at 1 kHz."""


@dataclass(frozen=True, eq=False)
class Block:
    """Some successive rows of a table."""

    rows: NDArray[np.int64]
    """(R,) row numbers, as a person counts them in the file"""
    values: Mapping[int, Array]
    """(R,) of each wanted column; where it is blank, anything"""
    blanks: Mapping[int, Mask | None]
    """(R,) where the column is blank; None for nowhere"""


class Table(Protocol):
    """A log file with named columns; `CsvTable` and `ParquetTable` are such."""

    @property
    def source(self) -> str:
        """The file's name, for messages."""
        ...

    @property
    def names(self) -> tuple[str, ...]:
        """Names of all columns, in order; empty where a column has none."""
        ...

    def blocks(self, columns: Sequence[int]) -> Iterator[Block]:
        """The rows, block by block, of the columns at these positions. `InputError` for what is not a number."""
        ...


def label(table: Table, column: int) -> str:
    """What to call a column in a message: its name, or its number counted from 1."""
    return table.names[column] or f"number {column + 1}"


def collect(
    table: Table, time: int | None, groups: Mapping[str, Sequence[int]], nan_is_blank: bool = False
) -> tuple[dict[str, Stream], tuple[str, ...]]:
    """Samples of each group of columns, in the file's units, and warnings.

    A group is measured in a row where none of its cells is blank; groups that are blank throughout are left out,
    with a warning. Without a column of `time` the rows are numbered from 0. A sample that repeats the one before
    it, time and all, is dropped. Raises `InputError`, naming row and column, for a cell that is not a finite
    number, a group of which only a part is blank, a blank time beside something measured, and too many numbers.
    """
    wanted = sorted({column for columns in groups.values() for column in columns} | (set() if time is None else {time}))
    samples = {name: _Samples(len(columns)) for name, columns in groups.items()}
    count = 0
    for block in table.blocks(wanted):
        if (count + len(block.rows)) * len(wanted) > MAX_CELLS:
            what = f"holds more than {MAX_CELLS // len(wanted):,} rows, too many to read"
            raise InputError(what, table.source, "cut out the part of interest")
        numbers = np.arange(count, count + len(block.rows), dtype=float)
        count += len(block.rows)
        times, untimed = (numbers, None) if time is None else _column(block, time, nan_is_blank)
        for name, columns in groups.items():
            if (measured := _measured(table, block, columns, nan_is_blank, times, untimed, time)) is not None:
                samples[name].append(*measured)
    if count == 0:
        raise InputError("there is a header but there are no samples", where=table.source)
    streams, warnings = {}, ()
    for name, columns in groups.items():
        if taken := samples.pop(name):
            streams[name] = taken.stream()
        else:
            first, last = label(table, columns[0]), label(table, columns[-1])
            warnings += (f"columns {first}..{last} are all blank" if len(columns) > 1 else f"column {first} is blank",)
    if time is None:
        return streams, warnings
    streams, repeats = without_repeats(streams)
    return streams, warnings + repeats


def without_repeats(streams: Mapping[str, Stream]) -> tuple[dict[str, Stream], tuple[str, ...]]:
    """The streams without the samples that repeat the one before, time and values alike, and a warning of how many.

    Two different samples at one time are kept: `hefting.recording.Recording` refuses them.
    """
    kept, dropped = {}, np.empty(0, dtype=np.int64)
    for name, stream in streams.items():
        again = np.flatnonzero(stream.time[1:] == stream.time[:-1])
        again = 1 + again[(stream.values[again + 1] == stream.values[again]).all(axis=1)]
        dropped = np.union1d(dropped, stream.rows[again])
        kept[name] = stream[np.delete(np.arange(len(stream)), again)] if len(again) else stream
    if not len(dropped):
        return kept, ()
    plural = "s" if len(dropped) > 1 else ""
    return kept, (f"dropped {len(dropped)} repeated row{plural}, time and values alike (the first: row {dropped[0]})",)


def require_streams(streams: Mapping[str, Stream], source: str, wrench_needed: bool = True) -> None:
    """`InputError` unless something was measured of the wrench, if needed, and of orientation or joint angles."""
    wrench_lacks = wrench_needed and "wrench" not in streams
    if wrench_lacks or not {"orientation", "joint_positions"} & set(streams):
        lacking = "wrench" if wrench_lacks else "orientation"
        raise InputError(f"there is no {lacking}: all its cells are blank", where=source)


def listed(items: Sequence[str]) -> str:
    """The first eight of some items in one line, and how many more there are."""
    return ", ".join(items[:8]) + (f" and {len(items) - 8} more" if len(items) > 8 else "")


class _Samples:
    """Samples that are added block by block, in one array that doubles: small pieces would leave holes in memory."""

    def __init__(self, width: int):
        self._array = np.empty((0, width + 2))
        self._count = 0

    def __len__(self) -> int:
        return self._count

    def append(self, time: Array, values: Array, rows: NDArray[np.int64]) -> None:
        """Add samples (K,), (K, d), (K,)."""
        end = self._count + len(time)
        if end > len(self._array):
            larger = np.empty((max(end, 2 * len(self._array), 65_536), self._array.shape[1]))
            larger[: self._count] = self._array[: self._count]
            self._array = larger
        part = self._array[self._count : end]
        part[:, 0], part[:, 1], part[:, 2:] = time, rows, values  # numbers of rows are exact up to 2**53
        self._count = end

    def stream(self) -> Stream:
        """All samples."""
        taken = self._array[: self._count]
        return Stream(taken[:, 0], taken[:, 2:], taken[:, 1].astype(np.int64))


def _column(block: Block, column: int, nan_is_blank: bool) -> tuple[Array, Mask | None]:
    values, blank = block.values[column], block.blanks[column]
    if nan_is_blank and (nan := np.isnan(values)).any():
        blank = nan if blank is None else blank | nan
    return values, blank


def _measured(
    table: Table,
    block: Block,
    columns: Sequence[int],
    nan_is_blank: bool,
    times: Array,
    untimed: Mask | None,
    time: int | None,
) -> tuple[Array, Array, NDArray[np.int64]] | None:
    """Times, values and rows at which a group was measured in a block; None if nowhere."""
    values, blanks = zip(*(_column(block, column, nan_is_blank) for column in columns), strict=True)
    blank = _agreed(table, block, columns, blanks)
    if blank is not None and blank.all():
        return None
    chosen: slice | Mask = slice(None) if blank is None else ~blank
    rows, at = block.rows[chosen], times[chosen]
    if untimed is not None and untimed[chosen].any():
        row = rows[np.argmax(untimed[chosen])]
        where = f"{table.source}, row {row}, column {label(table, time or 0)}"
        raise InputError("the time is blank", where, "give the row its time")
    matrix = np.stack([column[chosen] for column in values], axis=1)
    for numbers, those in ((at[:, None], [time or 0]), (matrix, columns)):
        if not np.isfinite(numbers).all():
            k, j = np.argwhere(~np.isfinite(numbers))[0]
            where = f"{table.source}, row {rows[k]}, column {label(table, those[j])}"
            raise InputError(f"the value is {numbers[k, j]}", where, "leave the cell blank where nothing was measured")
    return at, matrix, rows


def _agreed(table: Table, block: Block, columns: Sequence[int], blanks: Sequence[Mask | None]) -> Mask | None:
    """Where (R,) a group was not measured: a row holds all of a group or nothing."""
    if all(blank is None for blank in blanks):
        return None
    first, *others = (np.zeros(len(block.rows), dtype=bool) if blank is None else blank for blank in blanks)
    for column, blank in zip(columns[1:], others, strict=True):
        if (blank != first).any():
            k = np.argmax(blank != first)
            where = f"{table.source}, row {block.rows[k]}, column {label(table, column if blank[k] else columns[0])}"
            names = [label(table, each) for each in columns]
            those = " ".join(names) if len(names) < 8 else f"{names[0]}..{names[-1]}"
            raise InputError("the cell is blank", where, f"give all of {those} in a row or none")
    return first
