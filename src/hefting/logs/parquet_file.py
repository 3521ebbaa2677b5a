"""Parquet: a table with nulls where nothing was measured, read block by block. A column
``state`` of lists becomes columns ``state_0``, ``state_1``, ..., a column ``force`` of
structures becomes columns ``force.x``, ... ."""

import io
from collections import Counter
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from hefting.core.errors import InputError
from hefting.core.files import write_atomically
from hefting.core.immutable import immutable
from hefting.core.progress import report
from hefting.core.recording import Recording
from hefting.core.spatial import Array
from hefting.logs.canonical import table_from_recording
from hefting.logs.layout import Layout
from hefting.logs.registry import READING, Format
from hefting.logs.table import LONGEST_LIST, Block, label

if TYPE_CHECKING:
    import pyarrow as pa
    from pyarrow import parquet

ROWS = 65_536
"""Number of rows that are read at a time."""

GROUP = 65_536
"""Number of rows of a written row group."""

BUFFER = 2**20
"""Part of a column that is read at a time [bytes]."""


@immutable
class ParquetTable:
    """A Parquet file after its schema was read; rows are counted from 1."""

    source: str
    names: tuple[str, ...]
    places: tuple[tuple[str, int | None], ...]
    """of each name the file's column, and the index in its lists"""

    def blocks(self, columns: Sequence[int]) -> Iterator[Block]:
        """The rows block by block; see `hefting.logs.table.Table`. Dates are in seconds
        since 1970, durations in seconds."""
        import pyarrow as pa
        from pyarrow import parquet

        stored = list(dict.fromkeys(self.places[j][0] for j in columns))
        before = 0
        try:
            with parquet.ParquetFile(
                self.source, buffer_size=BUFFER, pre_buffer=False
            ) as file:
                kinds = flat(file.schema_arrow.empty_table()).schema
                for j in columns:
                    name, place = self.places[j]
                    kind = kinds.field(name).type
                    where = f"{self.source}, column {label(self, j)}"
                    _check_kind(kind if place is None else kind.value_type, where)
                rows = max(file.metadata.num_rows, 1)
                for batch in file.iter_batches(ROWS, columns=stored):
                    report(READING, before / rows)
                    table = flat(pa.Table.from_batches([batch]))
                    arrays = {j: _part(table, *self.places[j]) for j in columns}
                    values = {j: _values_of(column) for j, column in arrays.items()}
                    blank = {
                        j: column.is_null().to_numpy() if column.null_count else None
                        for j, column in arrays.items()
                    }
                    yield Block(np.arange(len(batch)) + before + 1, values, blank)
                    before += len(batch)
        except (pa.ArrowException, UnicodeDecodeError, OSError) as error:
            raise read_error(self.source, error) from error


def _part(table: "pa.Table", name: str, place: int | None) -> "pa.ChunkedArray":
    """A column, or the elements at index `place` of its lists; `ArrowException` where a
    list is too short."""
    import pyarrow as pa
    from pyarrow import compute

    column = table[name]
    if place is None:
        return column
    return compute.call_function("list_element", [column, pa.scalar(place)])


def _check_kind(kind: "pa.DataType", where: str) -> None:
    """`InputError` for a column of other values than numbers, dates and durations."""
    import pyarrow as pa

    known = (
        pa.types.is_integer,
        pa.types.is_floating,
        pa.types.is_decimal,
        pa.types.is_null,
        pa.types.is_timestamp,
        pa.types.is_duration,
    )
    if any(is_kind(kind) for is_kind in known):
        return
    fix = "give seconds as numbers" if pa.types.is_temporal(kind) else "give numbers"
    raise InputError(f"holds {kind}, not numbers", where, fix)


def _values_of(column: "pa.ChunkedArray") -> Array:
    """Values (R,) of a column of numbers, dates (seconds since 1970) or durations [s];
    NaN for null."""
    import pyarrow as pa

    kind = column.type
    if pa.types.is_timestamp(kind):
        column = column.cast(pa.timestamp("ns", kind.tz)).cast(pa.int64())
    elif pa.types.is_duration(kind):
        column = column.cast(pa.duration("ns")).cast(pa.int64())
    values = column.cast(pa.float64(), safe=False).to_numpy()
    return values / 1e9 if pa.types.is_temporal(kind) else values


def open_parquet(path: str | Path, _layout: Layout | None = None) -> ParquetTable:
    """The Parquet file at `path`; the layout is not used.

    Raises `InputError` when it cannot be read, or names repeat.
    """
    import pyarrow as pa
    from pyarrow import parquet

    try:
        with parquet.ParquetFile(path) as file:
            lengths = _lengths_of_lists(file)
    except (pa.ArrowException, UnicodeDecodeError, OSError) as error:
        raise read_error(path, error) from error
    places = [
        (name, place)
        for name, length in lengths
        for place in ([None] if length is None else range(length))
    ]
    names = [n if place is None else f"{n}_{place}" for n, place in places]
    twice = [(name, count) for name, count in Counter(names).items() if count > 1]
    if twice:
        what = f"column {twice[0][0][:40]!r} is there {twice[0][1]} times"
        raise InputError(what, path, "keep one of them")
    return ParquetTable(str(path), tuple(names), tuple(places))


def _lengths_of_lists(file: "parquet.ParquetFile") -> list[tuple[str, int | None]]:
    """Each column of a file with the length of its first list; None for other columns,
    and for lists that are empty or longer than `LONGEST_LIST`."""
    import pyarrow as pa

    lists = (pa.types.is_list, pa.types.is_large_list, pa.types.is_fixed_size_list)
    schema = flat(file.schema_arrow.empty_table()).schema
    known = [field.name for field in schema if any(of(field.type) for of in lists)]
    first = next(file.iter_batches(1, columns=known), None) if known else None
    rows = [] if first is None else flat(pa.Table.from_batches([first])).to_pylist()
    lengths = {name: len(row[name] or ()) for row in rows for name in known}
    return [
        (n, lengths[n] if 0 < lengths.get(n, 0) <= LONGEST_LIST else None)
        for n in schema.names
    ]


def flat(table: "pa.Table") -> "pa.Table":
    """The table with fields of structures as columns."""
    import pyarrow as pa

    while any(pa.types.is_struct(kind) for kind in table.schema.types):
        table = table.flatten()
    return table


def read_error(path: str | Path, error: Exception, kind: str = "Parquet") -> InputError:
    """The error of a file of a `kind` that pyarrow cannot read."""
    reason = str(error).splitlines()[0][:200] if str(error) else type(error).__name__
    return InputError(
        f"cannot be read as {kind} ({reason})", path, "write the file again"
    )


def write_parquet(recording: Recording, path: str | Path) -> tuple[str, ...]:
    """Write canonical Parquet, which all streams fit into."""
    from pyarrow import parquet

    stream = io.BytesIO()
    parquet.write_table(table_from_recording(recording), stream, row_group_size=GROUP)
    write_atomically(path, stream.getvalue())
    return ()


FORMAT = Format(
    name="Parquet",
    description="Parquet with the columns below, or others by name or column map",
    suffixes=(".parquet",),
    help_names=(".parquet",),
    open_table=open_parquet,
    written=(".parquet",),
    write=write_parquet,
)
"""Columns in binary form, with nulls."""
