"""Tables read block by block: named columns of numbers -> streams of groups of columns,
and their times in seconds."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, NoReturn, Protocol

import numpy as np
from numpy.typing import NDArray

from hefting.core.errors import InputError
from hefting.core.magnitudes import LARGEST_CELL, too_large
from hefting.core.messages import Message, warning
from hefting.core.recording import Stream, all_finite
from hefting.core.spatial import Array, Mask, immutable, median, own
from hefting.logs.gaps import FEW, Gaps, without_invalid_poses, without_repeats
from hefting.logs.growing import Growing, Samples

if TYPE_CHECKING:
    from hefting.logs.units import Unit

MAX_CELLS = 100_000_000
"""Largest number of numbers that are read from one file (0.8 GB): more than an hour of
twenty columns at 1 kHz."""

LONGEST_LIST = 100
"""Largest length of a list, or of an array's sample, that becomes columns."""

EPOCHS = (
    ("nanoseconds", "1e9", 1e17),
    ("microseconds", "1e6", 1e14),
    ("milliseconds", "1e3", 1e11),
)
"""Unit, divisor and smallest value of times since 1970 in other units than seconds."""

SINCE_1970 = 1e8
"""[s] Time above which times count from 1970: no controller runs for three years."""

SHORTEST_STEP = 2e-5
"""[s] Time between samples below which another unit may be meant."""


@immutable
class Block:
    """Some successive rows of a table."""

    rows: NDArray[np.int64]
    """(R,) row numbers in the file"""
    values: Mapping[int, Array]
    """(R,) values of each wanted column; arbitrary where blank"""
    blanks: Mapping[int, Mask | None]
    """(R,) mask of blank cells of each column; None for none"""


class Table(Protocol):
    """A log file with named columns, such as `CsvTable` and `ParquetTable`."""

    @property
    def source(self) -> str:
        """The file's name, for messages."""
        ...

    @property
    def names(self) -> tuple[str, ...]:
        """Names of all columns, in order; empty for a column without a name."""
        ...

    def blocks(self, columns: Sequence[int]) -> Iterator[Block]:
        """The rows, block by block, of the columns at these positions. `InputError` for
        what is not a number."""
        ...


def check_cells(count: int, source: str | Path) -> None:
    """`InputError` for more than `MAX_CELLS` numbers."""
    if count > MAX_CELLS:
        what = f"holds more than {MAX_CELLS:,} numbers, too many to read"
        raise InputError(what, source, "cut out the part of interest")


def label(table: Table, column: int) -> str:
    """A column in messages: its name, or its number counted from 1."""
    return table.names[column] or f"number {column + 1}"


def collect(
    table: Table,
    time: int | None,
    groups: Mapping[str, Sequence[int]],
    nan_is_blank: bool = False,
    nanoseconds: int | None = None,
) -> tuple[dict[str, Stream], tuple[Message, ...]]:
    """Samples of each group of columns, in the file's units, and warnings.

    A group has a sample in each row without blanks in it. Left out, with a warning, are
    groups that are blank throughout, and a few incomplete, invalid or repeated samples
    (`hefting.logs.gaps`). Without a column of `time` the rows are numbered from 0; a
    column of `nanoseconds` is added to seconds. Raises `InputError`, naming row and
    column, for a cell that is not a finite number, a group that is often incomplete, a
    blank time of a sample, and too many numbers.
    """
    wanted = sorted(
        {column for columns in groups.values() for column in columns}
        | {column for column in (time, nanoseconds) if column is not None}
    )
    samples = {name: Samples(len(columns)) for name, columns in groups.items()}
    few = getattr(table, "few", FEW)
    gaps = {
        name: Gaps(table.source, [label(table, column) for column in columns], few)
        for name, columns in groups.items()
    }
    times, rows, count = Growing(), Growing(dtype=np.int32), 0
    for block in table.blocks(wanted):
        begin, count = count, count + len(block.rows)
        if count * len(wanted) > MAX_CELLS:
            what = (
                f"holds more than {MAX_CELLS // len(wanted):,} rows, too many to read"
            )
            raise InputError(what, table.source, "cut out the part of interest")
        numbers, untimed = _read_times(block, begin, time, nanoseconds, nan_is_blank)
        times.append(numbers)
        rows.append(block.rows)
        for name, columns in groups.items():
            values, blank = _read_group(
                table, block, columns, nan_is_blank, gaps[name], numbers, untimed, time
            )
            samples[name].append(begin, values, blank)
    if count == 0:
        raise InputError(
            "there is a header but there are no samples", where=table.source
        )
    every = times.finish(), rows.finish()
    streams, warnings = {}, ()
    for name, columns in groups.items():
        warnings += gaps[name].conclude(len(samples[name]))
        if taken := samples.pop(name):
            streams[name] = taken.stream(*every)
        else:
            first, last = label(table, columns[0]), label(table, columns[-1])
            what = (
                f"columns {first}..{last} are all blank"
                if len(columns) > 1
                else f"column {first} is blank"
            )
            warnings += (warning("columns-blank", what),)
    streams, invalid = without_invalid_poses(streams)
    warnings += invalid
    if time is None:
        return streams, warnings
    streams, repeats = without_repeats(streams)
    return streams, warnings + repeats


def in_seconds(
    streams: Mapping[str, Stream], source: str, unit: "Unit | None" = None
) -> tuple[dict[str, Stream], tuple[Message, ...]]:
    """The streams with times in seconds, where they count from 1970 shifted to start at
    0, and warnings.

    The given times are in `unit`; None: seconds. Streams keep sharing an array of times.
    `InputError` for times that cannot be in that unit.
    """
    where = f"{source}, column time"
    start = min(float(stream.time[0]) for stream in streams.values())
    seconds = unit is None or unit.name == "s"
    scale = (lambda values: values) if unit is None else unit.to_si
    began = abs(float(scale(np.array(start))))
    if began > 1e11:  # seconds since 1970 reach 1e11 in the year 5138
        _refuse_start(start, began, None if seconds else unit, where)
    warnings = []
    if began > SINCE_1970:
        streams = with_times(streams, lambda time: time - start)
        shift, resolution = (
            float(scale(np.array(value))) for value in (start, np.spacing(abs(start)))
        )
        what = f"time was shifted by {shift:.6f} s to start at 0; its resolution is {resolution:.1g} s"
        warnings.append(warning("time-shifted", what))
    if not seconds:
        streams = with_times(streams, scale)
    warnings += _check_steps(streams, seconds, where)
    return dict(streams), tuple(warnings)


def _refuse_start(
    start: float, began: float, unit: "Unit | None", where: str
) -> NoReturn:
    if unit is not None:
        raise InputError(
            f"{start:.6g} cannot be {unit.name}", where, "give the unit of time"
        )
    meant, factor = next(
        (meant, factor) for meant, factor, least in EPOCHS if began > least
    )
    fix = f"divide by {factor}, or give the unit of time in a column map (`column_map`=FILE)"
    what = f"{start:.6g} cannot be seconds; it looks like {meant} since 1970"
    raise InputError(what, where, fix)


def _check_steps(
    streams: Mapping[str, Stream], seconds: bool, where: str
) -> list[Message]:
    """Warnings of `_check_step`, once for streams that share their times."""
    firsts = {id(stream.time): name for name, stream in [*streams.items()][::-1]}
    return [
        each
        for name in firsts.values()
        for each in _check_step(name, streams[name], seconds, where)
    ]


def _check_step(name: str, stream: Stream, seconds: bool, where: str) -> list[Message]:
    """A warning of a median step unlikely for seconds; `InputError` if impossible."""
    # `Recording` refuses times that are not finite
    with np.errstate(over="ignore", invalid="ignore"):
        step = median(np.diff(stream.time)) if len(stream) > 1 else 0.0
    if step > 1000:
        what = f"the median step of {name} is {step:.4g}, not seconds"
        raise InputError(what, where, "give time in seconds")
    whole = seconds and step >= 1 and len(stream) > 21 and not (stream.time % 1).any()
    if step > 5 or whole:
        meant = "milliseconds" + (", or a count of rows" if whole and step == 1 else "")
        what = f"the median step of {name} is {step:.4g} s: is time in {meant}, not seconds?"
        return [warning("time-step-long", what)]
    # stamps that come in bursts have short steps within these only
    short = SHORTEST_STEP * (len(stream) - 1)
    if 0 < step < SHORTEST_STEP and stream.time[-1] - stream.time[0] < short:
        what = f"the median step of {name} is {step:.4g} s: is time in seconds?"
        return [warning("time-step-short", what)]
    return []


def with_times(
    streams: Mapping[str, Stream], change: Callable[[Array], Array]
) -> dict[str, Stream]:
    """The streams with changed times; they keep sharing an array of times."""
    changed: dict[int, Array] = {}
    for stream in streams.values():
        if id(stream.time) not in changed:
            changed[id(stream.time)] = own(change(stream.time))
    return {
        name: replace(stream, time=changed[id(stream.time)])
        for name, stream in streams.items()
    }


def require_streams(
    streams: Mapping[str, Stream], source: str, wrench_needed: bool = True
) -> None:
    """`InputError` unless there are samples of the wrench, if needed, and of orientation
    or joint angles."""
    wrench_lacks = wrench_needed and "wrench" not in streams
    if wrench_lacks or not {"orientation", "joint_positions"} & set(streams):
        lacking = "wrench" if wrench_lacks else "orientation"
        raise InputError(
            f"there is no {lacking}: all its cells are blank", where=source
        )


def summarize_list(items: Sequence[str], between: str = ", ") -> str:
    """The first eight items in one line, and the number of the others."""
    return between.join(items[:8]) + (
        f" and {len(items) - 8} more" if len(items) > 8 else ""
    )


def _read_column(
    block: Block, column: int, nan_is_blank: bool
) -> tuple[Array, Mask | None, Mask | None]:
    """Values (R,) of a column, masks of blank cells and of NaN that do not mean blank;
    None for none."""
    values, blank = block.values[column], block.blanks[column]
    if all_finite(values) or not (nan := np.isnan(values)).any():
        return values, blank, None
    if nan_is_blank:
        return values, nan if blank is None else blank | nan, None
    return values, blank, nan if blank is None else nan & ~blank


def _read_times(
    block: Block,
    begin: int,
    time: int | None,
    nanoseconds: int | None,
    nan_is_blank: bool,
) -> tuple[NDArray, Mask | None]:
    """Times (R,) of a block, or row numbers from `begin` on without a column of `time`,
    and a mask of blank times."""
    if time is None:
        return np.arange(begin, begin + len(block.rows)), None
    times, untimed, _ = _read_column(block, time, nan_is_blank)
    if nanoseconds is None:
        return times, untimed
    more, blank, _ = _read_column(block, nanoseconds, nan_is_blank)
    if blank is not None:
        more = np.where(blank, 0.0, more)
    return times + 1e-9 * more, untimed


def _read_group(
    table: Table,
    block: Block,
    columns: Sequence[int],
    nan_is_blank: bool,
    gaps: Gaps,
    times: NDArray,
    untimed: Mask | None,
    time: int | None,
) -> tuple[Sequence[Array], Mask | None]:
    """Columns (R,) of a group in a block, and a mask of rows without a sample.
    `InputError` for invalid samples."""
    values, blanks, nans = zip(
        *(_read_column(block, column, nan_is_blank) for column in columns), strict=True
    )
    blank = gaps.find(block.rows, blanks, nans)
    lost = untimed if untimed is None or blank is None else untimed & ~blank
    if lost is not None and lost.any():
        row = block.rows[np.argmax(lost)]
        where = f"{table.source}, row {row}, column {label(table, time or 0)}"
        raise InputError("the time is blank", where, "give the row its time")
    for numbers, names in (((times,), [time or 0]), (values, columns)):
        if not any(_is_wrong(column) for column in numbers):
            continue
        matrix = np.stack(
            [column if blank is None else column[~blank] for column in numbers], axis=1
        )
        wrong = np.argwhere(~(np.abs(matrix) <= LARGEST_CELL))
        if len(wrong):
            k, j = wrong[0]
            row = (block.rows if blank is None else block.rows[~blank])[k]
            where = f"{table.source}, row {row}, column {label(table, names[j])}"
            fix = "leave the cell blank where nothing was measured"
            if names == [time or 0]:
                fix = "give the row its time, or leave it out"
            raise InputError(f"the value is {matrix[k, j]}", where, fix)
    return values, blank


def _is_wrong(column: Array) -> bool:
    return len(column) > 0 and (
        not all_finite(column) or too_large(column, LARGEST_CELL)
    )
