"""Arrow's own files (Feather) and streams: a table as in Parquet; see `MemoryTable`."""

from pathlib import Path
from typing import TYPE_CHECKING

from hefting.logs.canonical import check_names
from hefting.logs.layout import Layout
from hefting.logs.parquet_file import flat, read_error
from hefting.logs.registry import Format

if TYPE_CHECKING:
    from hefting.logs.memory_table import MemoryTable


def open_arrow(path: str | Path, _layout: Layout | None = None) -> "MemoryTable":
    """The table at `path`; the layout is not used.

    Raises `InputError` when it cannot be read, or names repeat.
    """
    import pyarrow as pa
    from pyarrow import ipc

    from hefting.logs.memory_table import MemoryTable

    try:
        with pa.OSFile(str(path)) as file:
            is_file = file.read(6) == b"ARROW1"
            file.seek(0)
            reader = ipc.open_file(file) if is_file else ipc.open_stream(file)
            table = reader.read_all()
        table.validate(full=True)  # else offsets may lead anywhere
    except (pa.ArrowException, UnicodeDecodeError, OSError) as error:
        raise read_error(path, error, "Arrow") from error
    table = flat(table)
    check_names(table.column_names, path)
    return MemoryTable.of_frame(table, table.column_names, str(path))


FORMAT = Format(
    name="Arrow",
    description="Feather, and Arrow's other files and streams, with columns as of Parquet",
    suffixes=(".feather", ".arrow"),
    help_names=(".feather",),
    open_table=open_arrow,
    in_blocks=False,
)
"""Columns in the form of memory, with nulls."""
