"""Arrow's own files (Feather) and streams: a table as in Parquet; see `ParquetTable`."""

import struct
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING

from hefting.logs.layout import Layout
from hefting.logs.parquet_file import ROWS, ParquetTable, flat, reading, table_of
from hefting.logs.registry import Format
from hefting.logs.table import check_cells

if TYPE_CHECKING:
    import pyarrow as pa

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


FORMAT = Format(
    name="Arrow",
    description="Feather, and Arrow's other files and streams, with columns as of Parquet",
    suffixes=(".feather", ".arrow"),
    help_names=(".feather",),
    open_table=open_arrow,
    in_blocks=False,
)
"""Columns in the form of memory, with nulls."""
