"""A file with named columns -> Recording: by a column map, by a header that a format
knows, by canonical names, or by what other names tell."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

from hefting.core.files import check_size
from hefting.core.recording import Recording
from hefting.logs.recognised import reader_of
from hefting.logs.registry import Format, formats
from hefting.logs.table import Table


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
    table, read = _opened(file_format, path, column_map, wrench_needed)
    if not (said := getattr(table, "said", ())):
        return table, read

    def read_and_say(part: Table) -> Recording:
        recording = read(part)
        return replace(recording, warnings=(*said, *recording.warnings))

    return table, read_and_say


def _opened(
    file_format: Format,
    path: str | Path,
    column_map: str | Path | None,
    wrench_needed: bool,
) -> tuple[Table, Callable[[Table], Recording]]:
    """The same without what is said of the file."""
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
    read = next(readers, None)
    if read is None:
        return table, reader_of(table, wrench_needed)
    return table, lambda part: read(part, wrench_needed)
