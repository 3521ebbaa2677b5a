"""A file with named columns -> Recording: by a column map, by a header that a format
knows, or canonical."""

from collections.abc import Callable
from pathlib import Path

from hefting.core.errors import InputError
from hefting.core.recording import Recording
from hefting.logs.canonical import read_canonical
from hefting.logs.registry import Format, formats
from hefting.logs.table import Table

MAX_BYTES = 2 * 1024**3
"""Largest table that is read [bytes]: its numbers are held in memory, and slow motion
needs far less."""


def read_table_file(
    file_format: Format,
    path: str | Path,
    column_map: str | Path | None = None,
    wrench_needed: bool = True,
) -> Recording:
    """Recording in the table at `path`; `InputError` for what `hefting.logs.read_log`
    refuses."""
    check_size(path)
    table, read = opened(file_format, path, column_map, wrench_needed)
    return read(table)


def opened(
    file_format: Format,
    path: str | Path,
    column_map: str | Path | None,
    wrench_needed: bool,
) -> tuple[Table, Callable[[Table], Recording]]:
    """The table at `path`, and what makes a recording of it or of a part of it; errors
    as for `read_table_file`."""
    assert file_format.open_table is not None
    if column_map is not None:
        from hefting.logs.column_map import load_map
        from hefting.logs.mapped import read_mapped

        chosen = load_map(column_map, wrench_needed)
        table = file_format.open_table(path, chosen.layout)
        return table, lambda part: read_mapped(part, chosen, wrench_needed)
    table = file_format.open_table(path, None)
    readers = (
        each.read_table
        for each in formats()
        if each.read_table and each.is_header and each.is_header(table.names)
    )
    read = next(readers, read_canonical)
    return table, lambda part: read(part, wrench_needed)


def check_size(path: str | Path, largest: float | None = None) -> None:
    """`InputError` unless there is a file that is neither empty nor larger than
    `largest` [bytes], by default `MAX_BYTES`."""
    if not Path(path).is_file():
        raise InputError(
            "is not a file" if Path(path).exists() else "does not exist", where=path
        )
    size = Path(path).stat().st_size
    if size == 0:
        raise InputError("the file is empty", where=path)
    if size > (MAX_BYTES if largest is None else largest):
        raise InputError(
            f"the file has {size / 1e9:.1f} GB, more than 2 GiB",
            path,
            "cut out the part of interest",
        )
