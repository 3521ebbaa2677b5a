"""Arrow's own files (Feather) and streams: a table as in Parquet; see `ParquetTable`."""

import struct
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import TYPE_CHECKING

from hefting.core.immutable import immutable
from hefting.logs.layout import Layout
from hefting.logs.parquet_file import ROWS, ParquetTable, divided, flat, reading
from hefting.logs.registry import Format
from hefting.logs.table import check_cells

if TYPE_CHECKING:
    import pyarrow as pa

MARK = b"ARROW1"
"""First and last bytes of a file, which holds a stream from byte 8 on."""


@immutable
class ArrowTable(ParquetTable):
    """A table in memory."""

    held: "pa.Table"

    def _tables(self, stored: Iterable[str]) -> "Iterator[pa.Table]":
        import pyarrow as pa

        for batch in self.held.select([*stored]).to_batches(ROWS):
            yield pa.Table.from_batches([batch])


def open_arrow(path: str | Path, _layout: Layout | None = None) -> ArrowTable:
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
        cells = 0
        for message in ipc.MessageReader.open_stream(file):
            cells += _unpacked(message) // 8
            check_cells(cells, path)
        file.seek(start)
        table = ipc.open_stream(file).read_all()
        table.validate(full=True)  # else offsets may lead anywhere
        if start and not file.read().endswith(MARK):
            raise pa.ArrowInvalid("it ends too early")
        check_cells(table.num_rows, path)  # nulls take no bytes
        table = flat(table)
        names, places = divided(table.schema, lambda _: table, path)
        return ArrowTable(str(path), names, places, table.schema, len(table), table)


def _unpacked(message: "pa.Message") -> int:
    """Size [bytes] of a message's buffers when they are decompressed, by its metadata
    (source: Arrow Columnar Format, Message.fbs)."""
    if message.type == "schema" or not message.body:
        return 0
    data, body = message.metadata.to_pybytes(), message.body.to_pybytes()
    batch = _linked(data, _fields(data, _linked(data, 0))[2])
    if message.type == "dictionary":
        batch = _linked(data, _fields(data, batch)[1])
    fields = _fields(data, batch)
    if 3 not in fields:  # not compressed
        return len(body)
    at, size = _linked(data, fields[2]), 0
    (count,) = struct.unpack_from("<I", data, at)
    for begin, length in struct.iter_unpack("<qq", data[at + 4 : at + 4 + 16 * count]):
        size += max(struct.unpack_from("<q", body, begin)[0], length) if length else 0
    return size


def _fields(data: bytes, at: int) -> dict[int, int]:
    """Positions of the fields, by number, of a table of FlatBuffers."""
    table = at - struct.unpack_from("<i", data, at)[0]
    (size,) = struct.unpack_from("<H", data, table)
    own = struct.unpack_from(f"<{size // 2 - 2}H", data, table + 4)
    return {k: at + offset for k, offset in enumerate(own) if offset}


def _linked(data: bytes, at: int) -> int:
    """Position to which the offset at a position leads."""
    return at + struct.unpack_from("<I", data, at)[0]


FORMAT = Format(
    name="Arrow",
    description="Feather, and Arrow's other files and streams, with columns as of Parquet",
    suffixes=(".feather", ".arrow"),
    help_names=(".feather",),
    open_table=open_arrow,
    in_blocks=False,
)
"""Columns in the form of memory, with nulls."""
