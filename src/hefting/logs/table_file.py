"""A file with named columns -> Recording: by a column map, a header that a format knows,
canonical names, or a guess from other names and numbers."""

from collections.abc import Callable
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, cast

from hefting.core.errors import InputError, nearest
from hefting.core.files import check_size
from hefting.core.messages import Message, warning
from hefting.core.recording import Recording
from hefting.logs.canonical import (
    check_names,
    columns_of_streams,
    known_columns,
    quote_name,
    read_canonical,
)
from hefting.logs.map_groups import about_estimates, others_told
from hefting.logs.registry import Format, formats
from hefting.logs.table import Table, summarize_list

if TYPE_CHECKING:
    from hefting.logs.column_map import ColumnMap
    from hefting.logs.map_guess import GuessedMap
    from hefting.logs.memory_table import MemoryTable

NEEDED = (
    "position",
    "orientation",
    "joint_positions",
    "wrench",
    "gyroscope",
    "accelerometer",
    "linear_accelerometer",
)
"""Streams whose canonical columns a guess must all use: a header with only some columns
of a stream is a mistake, for which the canonical reader has an error."""

RATES = (
    "linear_velocity",
    "angular_velocity",
    "linear_acceleration",
    "angular_acceleration",
)
"""Streams whose axes names do not tell; a guessed map does not have them."""


def reader_of(table: Table, wrench_needed: bool = True) -> Callable[[Table], Recording]:
    """The reader of a table, or of a part of it, without a column map: by a header that a
    format knows, by canonical names, or else by a guess from its names.

    `InputError` says what is missing where neither finds a time, a wrench if needed, and
    an orientation or joint angles.
    """
    if getattr(table, "holds_streams", False):
        return lambda _: cast("MemoryTable", table).recording()
    readers = (
        each.read_table
        for each in formats()
        if each.read_table and each.is_header and each.is_header(table.names)
    )
    if (read := next(readers, None)) is not None:
        return lambda part: read(part, wrench_needed)
    found = _recognise(table, wrench_needed)
    if found is None:
        return lambda part: read_canonical(part, wrench_needed)
    if isinstance(found, InputError):
        raise found
    return lambda part: _read_recognised(part, *found, wrench_needed)


def _recognise(
    table: Table, wrench_needed: bool = True
) -> "tuple[ColumnMap, tuple[Message, ...]] | InputError | None":
    """A guessed column map of a table with a wrench, or where that is not needed with
    joint torques, and warnings of it. None where the canonical names are to be used; an
    error where other names tell only a part of a recording."""
    check_names(table.names, table.source)
    try:
        streams, ignored = known_columns(table.names, table.source, wrench_needed)
    except InputError:
        streams, ignored = {}, ()
    if streams and (not ignored or set(RATES) & set(streams)):
        return None
    from hefting.logs.map_joints import JOINT_EFFORTS

    there = columns_of_streams(table.names, NEEDED) | {"time"} & {*table.names}
    try:
        guessed = _guess(table)
        of_joints = not guessed.keys.isdisjoint(JOINT_EFFORTS)
        if wrench_needed and of_joints and "wrench" not in guessed.keys:
            return _of_torques(table, guessed)
        if not wrench_needed and not of_joints:
            return None
        column_map = None
        if not guessed.missing:
            column_map = _map_of(table, guessed, wrench_needed=wrench_needed)
    except InputError as error:
        # an error without advice is that of a table without rows
        is_canonical = not table.names or there - {"time"} or error.fix
        return None if is_canonical else error
    wrench = columns_of_streams(table.names, ("wrench",))
    is_timeless = not ({"time"} & guessed.keys or guessed.missing)
    if is_timeless and len(wrench) == 6 and "qw" in there:
        return None
    is_unread = guessed.is_position_unread and there == guessed.columns
    # raw numbers are taken, not the compensated ones of canonical names beside them
    is_raw = any("raw" in name.lower() for name in guessed.columns - there)
    is_raw &= bool(streams) and guessed.keys >= streams.keys()
    is_raw &= guessed.columns >= there - wrench
    if not (there < guessed.columns or is_unread or is_raw):
        return None
    if column_map is None:
        timeless = guessed.missing[0].startswith("time")
        is_partial = not streams and (not timeless or len(guessed.missing) == 1)
        return _lacking(table, guessed) if is_partial else None
    left = columns_of_streams(table.names, RATES)
    more = f"; {summarize_list(sorted(left))} not read" if left else ""
    return column_map, taken_by_names(guessed, more=more)


def map_of_part(table: Table) -> "tuple[ColumnMap, GuessedMap]":
    """The column map guessed from names and numbers of a table of which another one
    holds the other streams."""
    guessed = _guess(table)
    return _map_of(table, guessed, is_part=True), guessed


def _guess(table: Table) -> "GuessedMap":
    from hefting.logs.map_guess import guess_map_of
    from hefting.logs.map_sample import sample_of

    return guess_map_of(sample_of(table))


def _map_of(
    table: Table,
    guessed: "GuessedMap",
    *,
    is_part: bool = False,
    wrench_needed: bool = True,
) -> "ColumnMap":
    import tomllib

    from hefting.logs.column_map import column_map_of

    content = tomllib.loads(guessed.text)
    return column_map_of(content, table.source, wrench_needed, is_part=is_part)


def _lacking(table: Table, guessed: "GuessedMap") -> InputError:
    from hefting.logs.map_guess import TIME_EXAMPLE

    absent = [line.split(" = ")[0] for line in guessed.missing]
    others = [n for n in table.names if n and n not in guessed.columns]
    what = f"no column seems to be the {' or the '.join(absent)}"
    if others:
        wanted = {"time"} & {*absent}
        names = [quote_name(n) + nearest(n, wanted) for n in others]
        what += f": unknown are {summarize_list(names)}{others_told(others)}"
    taken = f"; taken by their names would be {guessed.summary}"
    fix = "name the others' columns in a column map (`column_map`=FILE; hefting map writes one of what is known)"
    if "time" in absent:
        fix += f", as {TIME_EXAMPLE}; rows of a map without it are static poses"
    if "wrench" in absent:
        fix += ", or give a table with it, and this one as `poses`"
    if "orientation" in absent:
        fix += ", or give another table with the poses (`poses`)"
        if {*"UVW"} <= {name[:2].rstrip("[(_ ") for name in others}:
            fix += '; U, V, W of Epson have form = "euler", order = "ZYX", unit = "deg"'
    return InputError(what + taken, table.source, fix)


def _of_torques(table: Table, guessed: "GuessedMap") -> InputError:
    what = f"there is no wrench, but of joints: {guessed.summary}"
    fix = (
        "identify from joint torques: hefting identify --torques, with --urdf and "
        "--sensor-frame; or name the wrench's columns in a column map (`column_map`=FILE)"
    )
    return InputError(what, table.source, fix)


def taken_by_names(
    guessed: "GuessedMap", of: str = "", more: str = ""
) -> tuple[Message, ...]:
    """Warnings that columns, `of` some file, are taken by their names."""
    what = (
        f"the columns{of} are taken by their names: {guessed.summary}{more}; "
        "give `column_map` where that is wrong (hefting map writes one)"
    )
    taken = warning("columns-by-name", what, "column_map")
    if not guessed.doubts:
        return (taken,)
    what = f"check the columns{of}, in a column map: {'; '.join(guessed.doubts)}"
    return taken, warning("columns-doubtful", what, "column_map")


def _read_recognised(
    table: Table,
    column_map: "ColumnMap",
    warnings: tuple[Message, ...],
    wrench_needed: bool,
) -> Recording:
    from hefting.logs.mapped import read_mapped

    recording = read_mapped(table, column_map, wrench_needed)
    wrench = column_map.quantities.get("wrench")
    if wrench is not None:
        warnings += about_estimates(str(wrench.columns[0]))
    return replace(recording, warnings=(*warnings, *recording.warnings))


def read_table_file(
    file_format: Format,
    path: str | Path,
    column_map: str | Path | None = None,
    wrench_needed: bool = True,
) -> Recording:
    """Recording in the table at `path`; `InputError` as of `hefting.logs.read_log`."""
    check_size(path)
    table, read = opened(file_format, path, column_map, wrench_needed)
    return read(table)


def opened(
    file_format: Format,
    path: str | Path,
    column_map: str | Path | None,
    wrench_needed: bool,
) -> tuple[Table, Callable[[Table], Recording]]:
    """The table at `path`, and the reader of it or of a part of it; errors as for
    `read_table_file`."""
    assert file_format.open_table is not None
    if column_map is not None:
        from hefting.logs.column_map import load_map
        from hefting.logs.mapped import read_mapped

        chosen = load_map(column_map, wrench_needed)
        table = file_format.open_table(path, chosen.layout)
        read = partial(read_mapped, column_map=chosen, wrench_needed=wrench_needed)
    else:
        table = file_format.open_table(path, None)
        read = reader_of(table, wrench_needed)
    if not (warnings := getattr(table, "warnings", ())):
        return table, read

    def read_and_warn(part: Table) -> Recording:
        recording = read(part)
        return replace(recording, warnings=(*warnings, *recording.warnings))

    return table, read_and_warn
