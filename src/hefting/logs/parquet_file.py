"""Parquet, and Arrow's own files (Feather) and streams: a table with nulls where nothing
was measured, Parquet's read block by block. A column ``state`` of lists becomes columns
``state_0``, ``state_1``, ..., a column ``force`` of structures becomes columns
``force.x``, ... ."""

import io
import struct
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from functools import partial
from itertools import islice
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from hefting.core.errors import InputError
from hefting.core.files import write_atomically
from hefting.core.progress import report
from hefting.core.recording import Recording
from hefting.core.spatial import Array, immutable
from hefting.logs.canonical import table_from_recording
from hefting.logs.layout import Layout
from hefting.logs.registry import READING, Format
from hefting.logs.table import LONGEST_LIST, Block, check_cells, label

if TYPE_CHECKING:
    import pyarrow as pa

ROWS = 65_536
"""Number of rows that are read at a time, and of a written row group."""

BUFFER = 2**20
"""Part of a column that is read at a time [bytes]."""


@immutable
class ParquetTable:
    """A Parquet file after its schema was read; rows are counted from 1."""

    source: str
    names: tuple[str, ...]
    places: tuple[tuple[str, int | None], ...]
    """of each name the file's column, and the index in its lists"""
    schema: "pa.Schema"
    """of the file's columns"""
    count: int
    """Number of rows."""
    read: "Callable[[list[str]], Iterator[pa.Table]]"
    """Successive rows of the file's columns of these names."""

    def blocks(self, columns: Sequence[int]) -> Iterator[Block]:
        """The rows block by block; see `hefting.logs.table.Table`. Dates are in seconds
        since 1970, durations in seconds."""
        for j in columns:
            name, place = self.places[j]
            kind = self.schema.field(name).type
            where = f"{self.source}, column {label(self, j)}"
            _check_kind(kind if place is None else kind.value_type, where)
        before = 0
        with reading(self.source):
            for table in self.read(list({self.places[j][0]: 0 for j in columns})):
                report(READING, before / self.count)
                arrays = {j: _part(table, *self.places[j]) for j in columns}
                values = {j: _values_of(column) for j, column in arrays.items()}
                blank = {
                    j: column.is_null().to_numpy() if column.null_count else None
                    for j, column in arrays.items()
                }
                yield Block(np.arange(len(table)) + before + 1, values, blank)
                before += len(table)


def _rows(
    path: str | Path, columns: Sequence[str], rows: int = ROWS
) -> "Iterator[pa.Table]":
    """Columns of a file, so many rows at a time; `InputError` for a part of it that is
    too large once it is unpacked."""
    import pyarrow as pa
    from pyarrow import parquet

    begins = tuple(f"{name}." for name in columns)
    with parquet.ParquetFile(path, buffer_size=BUFFER, pre_buffer=False) as file:
        for group in map(file.metadata.row_group, range(file.num_row_groups)):
            parts = map(group.column, range(group.num_columns))
            sizes = (
                max(part.num_values, part.total_uncompressed_size // 8)
                for part in parts
                if f"{part.path_in_schema}.".startswith(begins)
            )
            check_cells(sum(sizes), path)
        for batch in file.iter_batches(rows, columns=columns):
            yield flat(pa.Table.from_batches([batch]))


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
    from pyarrow import parquet

    with reading(path), parquet.ParquetFile(path) as file:
        schema = flat(file.schema_arrow.empty_table()).schema
        return table_of(path, schema, file.metadata.num_rows, partial(_rows, path), 1)


def table_of(
    path: str | Path,
    schema: "pa.Schema",
    count: int,
    read: "Callable[..., Iterator[pa.Table]]",
    looked: int,
) -> ParquetTable:
    """A table of this schema and number of rows, whose columns of lists are divided by
    the first one that is not null of so many rows that are `looked` at, if it is neither
    empty nor longer than `LONGEST_LIST`. `InputError` for repeated names."""
    import pyarrow as pa
    from pyarrow import compute

    lists = (pa.types.is_list, pa.types.is_large_list, pa.types.is_fixed_size_list)
    places: list[tuple[str, int | None]] = []
    for field in schema:
        length, is_list = 0, any(of(field.type) for of in lists)
        for table in islice(read([field.name], rows=looked), int(is_list)):
            lengths = compute.call_function("list_value_length", [table[field.name]])
            length = next(iter(lengths.drop_null().slice(0, 1).to_pylist()), 0)
        divides = 0 < length <= LONGEST_LIST
        places += [(field.name, k) for k in (range(length) if divides else [None])]
    names = tuple(n if place is None else f"{n}_{place}" for n, place in places)
    twice = [(name, count) for name, count in Counter(names).items() if count > 1]
    if twice:
        what = f"column {twice[0][0][:40]!r} is there {twice[0][1]} times"
        raise InputError(what, path, "keep one of them")
    return ParquetTable(str(path), names, tuple(places), schema, count, read)


def flat(table: "pa.Table") -> "pa.Table":
    """The table with fields of structures as columns."""
    import pyarrow as pa

    while any(pa.types.is_struct(kind) for kind in table.schema.types):
        table = table.flatten()
    return table


@contextmanager
def reading(path: str | Path, kind: str = "Parquet") -> Iterator[None]:
    """Context in which errors of pyarrow are `InputError`s of a file of a `kind`."""
    import pyarrow as pa

    damaged = UnicodeDecodeError, OSError, LookupError, struct.error
    try:
        yield
    except (pa.ArrowException, *damaged) as error:
        reason = (str(error) or type(error).__name__).splitlines()[0][:200]
        raise InputError(
            f"cannot be read as {kind} ({reason})", path, "write the file again"
        ) from error


MARK = b"ARROW1"
"""First and last bytes of a file, which holds a stream from byte 8 on."""


def open_arrow(path: str | Path, _layout: Layout | None = None) -> ParquetTable:
    """The table at `path`; the layout is not used.

    Raises `InputError` when it cannot be read, holds more than `MAX_CELLS` numbers, or
    names repeat.
    """
    import pyarrow as pa
    from pyarrow import ipc

    check_cells(Path(path).stat().st_size // 8, path)
    with reading(path, "Arrow"), pa.OSFile(str(path)) as file:
        start = 8 if file.read(6) == MARK else 0
        file.seek(start)
        messages = ipc.MessageReader.open_stream(file)
        check_cells(sum(map(_unpacked, messages)) // 8, path)
        file.seek(start)
        table = ipc.open_stream(file).read_all()
        table.validate(full=True)  # else offsets may lead anywhere
        if start and not file.read().endswith(MARK):
            raise pa.ArrowInvalid("it ends too early")
        check_cells(table.num_rows, path)  # nulls take no bytes
        table = flat(table)

    def read(columns: list[str], rows: int = ROWS) -> "Iterator[pa.Table]":
        own = table.select(columns)
        yield from (own.slice(k, rows) for k in range(0, len(own), rows))

    return table_of(path, table.schema, len(table), read, len(table))


def _unpacked(message: "pa.Message") -> int:
    """Size [bytes] of a message's compressed buffers when they are decompressed, by its
    metadata (source: Arrow Columnar Format, Message.fbs)."""
    if not message.body:
        return 0
    data, body = message.metadata.to_pybytes(), memoryview(message.body)
    batch = _place(data, struct.unpack_from("<I", data)[0], 2)
    if message.type == "dictionary":
        batch = _place(data, batch, 1)
    if not _place(data, batch, 3):  # they are not compressed
        return 0
    at, size = _place(data, batch, 2), 0
    (count,) = struct.unpack_from("<I", data, at)
    for begin, length in struct.iter_unpack("<qq", data[at + 4 : at + 4 + 16 * count]):
        size += max(struct.unpack_from("<q", body, begin)[0], length) if length else 0
    return size


def _place(data: bytes, table: int, field: int) -> int:
    """Position to which a field leads of a table of FlatBuffers; 0 without the field."""
    known = table - struct.unpack_from("<i", data, table)[0]
    size, *fields = struct.unpack_from(f"<H2x{field + 1}H", data, known)
    place = table + fields[field] if 4 + 2 * field < size and fields[field] else 0
    return place and place + struct.unpack_from("<I", data, place)[0]


def write_parquet(recording: Recording, path: str | Path) -> tuple[str, ...]:
    """Write canonical Parquet, which all streams fit into."""
    from pyarrow import parquet

    stream = io.BytesIO()
    parquet.write_table(table_from_recording(recording), stream, row_group_size=ROWS)
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

ARROW = Format(
    name="Arrow",
    description="Feather, and Arrow's other files and streams, with columns as of Parquet",
    suffixes=(".feather", ".arrow"),
    help_names=(".feather",),
    open_table=open_arrow,
    in_blocks=False,
)
"""Columns in the form of memory, with nulls."""
