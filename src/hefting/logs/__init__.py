"""Logs: one reader a format, each giving a `Recording`; the suffix says which, and the header.

Here are the choice of the reader, and the canonical table: one row an instant, named columns, blanks for what was not
measured.
"""

import re
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from hefting.core.errors import InputError, nearest
from hefting.core.messages import Message, warning
from hefting.core.recording import COLUMNS, JOINT_STREAMS, Recording, column_names
from hefting.logs.table import Table, checked_static, collect, in_seconds, listed, require_streams

TEXT_SUFFIXES = (".csv", ".txt", ".tsv")
"""Read as CSV."""

TABLE_SUFFIXES = (*TEXT_SUFFIXES, ".parquet")
"""Files with named columns."""

WRITTEN = (".csv", ".parquet", ".bag", ".mcap", "")
"""File name endings that can be written."""

MAX_BYTES = 2 * 1024**3
"""Largest table that is read: its numbers are held in memory, and slow motion needs far less."""

MAX_COLUMNS = 1000
FIXED = {name: columns for name, columns in COLUMNS.items() if name not in JOINT_STREAMS}
EXPECTED = ("time", *(column for columns in FIXED.values() for column in columns), "q1", "dq1")
REQUIRED = (
    ("wrench", (), "name its columns fx fy fz tx ty tz, or say which they are in a column map (`column_map`=FILE)"),
    ("orientation", ("q1",), "give columns qx qy qz qw, or joint angles q1..qn, or a column map (`column_map`=FILE)"),
)
TIME_NAMES = {"t", "ts", "s", "sec", "secs", "seconds", "ms", "us", "ns", "clock"}


def read_log(
    path: str | Path, column_map: str | Path | None = None, *, wrench_needed: bool = True, **options: Any
) -> Recording:
    """Recording in the log at `path`.

    ================================ =================================================================
    suffix                           read as
    ================================ =================================================================
    .csv, .txt, .tsv                 canonical CSV; a UR real-time record, when its header is one; or
                                     anything, through a column map
    .parquet                         the canonical table, or anything, through a column map
    .bag, .mcap, .db3, or a folder   a ROS 1 or ROS 2 bag; see `hefting.logs.ros`
    ================================ =================================================================

    The canonical table has one header row; SI units; columns `time` and those of `hefting.core.recording.COLUMNS`, of
    which the wrench and an orientation or joint positions must be there. A blank cell (Parquet: null) means "not
    measured then", so that streams of different rates fit one file. Without `time`, each row is a static pose.
    Times that count from 1970 are shifted to start at 0. A row that repeats the one before, time and values
    alike, is dropped. CSV may be separated by commas, semicolons, tabs or spaces.

    Parameters
    ----------
    column_map : a TOML file that says which columns hold what, and in which units; see `hefting.logs.column_map`.
    wrench_needed : whether a log without a wrench is refused, as one that nothing can be identified from.
    options : for bags: ``wrench_topic=`` and the others of `hefting.logs.ros.read_bag`.

    Raises `InputError`, naming file, row and column, for anything that cannot be read without guessing; what can
    be read but looks odd is in `Recording.warnings`. Rows are lines of a CSV file (the header usually is row 1),
    and are counted from 1 in Parquet.
    """
    suffix = Path(path).suffix.lower()
    given = {name: value for name, value in options.items() if value is not None}
    try:
        if suffix not in TABLE_SUFFIXES:
            return _read_bag(path, column_map, given, wrench_needed)
        for name in given:
            raise InputError(f"`{name}` is for bags", path, "leave it out")
        _check_size(path)
        return _read_table(path, suffix, column_map, wrench_needed)
    except OSError as error:
        raise InputError(f"cannot be read ({error.strerror or error})", where=path) from error


def write_log(recording: Recording, path: str | Path) -> tuple[str, ...]:
    """Write `recording`, whole or not at all: canonical .csv or .parquet, a ROS 1 bag (.bag), an .mcap file, or,
    without suffix, the folder of a ROS 2 bag.

    `read_log` gives the same numbers; of a bag, times rounded to nanoseconds that start at 0. In a table, samples
    of different streams share a row when their times are equal. Returned are the streams that the format cannot
    hold. Raises `InputError` for another suffix and where the file cannot be written.
    """
    suffix = check_output(path)
    if suffix not in (".csv", ".parquet"):
        from hefting.logs.ros.writing import write_bag

        return write_bag(recording, path)
    from hefting.logs.writing import write_csv, write_parquet

    (write_csv if suffix == ".csv" else write_parquet)(recording, path)
    return ()


def check_output(path: str | Path) -> str:
    """The suffix of a log that is to be written; `InputError` when there is no such format."""
    suffix = Path(path).suffix.lower()
    if suffix not in WRITTEN:
        fix = f"use {', '.join(WRITTEN[:-1])}, or no suffix for the folder of a ROS 2 bag"
        raise InputError(f"'{suffix}' is not a log format to write", path, fix)
    return suffix


def is_bag(path: str | Path) -> bool:
    """Whether `read_log` takes the log for a bag: by its suffix, or because it is a bag's folder."""
    if Path(path).suffix.lower() in TABLE_SUFFIXES:
        return False
    from hefting.logs.ros import is_bag

    return is_bag(path)


def _read_table(path: str | Path, suffix: str, column_map: str | Path | None, wrench_needed: bool) -> Recording:
    if column_map is not None:
        from hefting.logs.column_map import load_map
        from hefting.logs.mapped import read_mapped

        chosen = load_map(column_map, wrench_needed)
        return read_mapped(_open(path, suffix, chosen.layout), chosen, wrench_needed)
    table = _open(path, suffix)
    if any(name.startswith(("actual_", "ft_raw_")) for name in table.names):
        from hefting.logs.ur_csv import is_ur, read_ur

        if is_ur(table.names):
            return read_ur(table, wrench_needed)
    return read_canonical(table, wrench_needed)


def _open(path: str | Path, suffix: str, layout=None):
    """The table in a file; the layout matters to text only."""
    if suffix == ".parquet":
        from hefting.logs.parquet_file import open_parquet

        return open_parquet(path)
    from hefting.logs.csv_file import open_csv

    return open_csv(path, layout)


def _read_bag(
    path: str | Path, column_map: str | Path | None, options: dict[str, Any], wrench_needed: bool
) -> Recording:
    from hefting.logs.ros import BAG_SUFFIXES, read_bag

    if not is_bag(path):
        suffix = Path(path).suffix.lower()
        if not suffix and not Path(path).exists():
            raise InputError("does not exist", where=path)
        known = ", ".join((*TABLE_SUFFIXES, *BAG_SUFFIXES))
        raise InputError(f"'{suffix or 'no suffix'}' is not a log format", path, f"use {known}, or a bag's folder")
    if column_map is not None:
        raise InputError("a column map (`column_map`) is for CSV and Parquet", path, "leave it out")
    return read_bag(path, **options, wrench_needed=wrench_needed)


def _check_size(path: str | Path) -> None:
    if not Path(path).is_file():
        raise InputError("is not a file" if Path(path).exists() else "does not exist", where=path)
    size = Path(path).stat().st_size
    if size == 0:
        raise InputError("the file is empty", where=path)
    if size > MAX_BYTES:
        raise InputError(f"the file has {size / 1e9:.1f} GB, more than 2 GiB", path, "cut out the part of interest")


def read_canonical(table: Table, wrench_needed: bool = True) -> Recording:
    """Recording in a table whose columns have the canonical names; see `hefting.logs.read_log` for errors."""
    groups, warnings = known_columns(table.names, table.source, wrench_needed)
    position = {name: j for j, name in enumerate(table.names)}
    columns = {name: [position[column] for column in group] for name, group in groups.items()}
    time = position.get("time")
    streams, more = collect(table, time, columns)
    require_streams(streams, table.source, wrench_needed)
    if time is None:
        return checked_static(Recording(streams, True, table.source, warnings + more))
    streams, about_time = in_seconds(streams, table.source)
    return Recording(streams, False, table.source, warnings + more + about_time)


def known_columns(
    names: Sequence[str], source: str | Path, wrench_needed: bool = True
) -> tuple[dict[str, tuple[str, ...]], tuple[Message, ...]]:
    """Columns of each stream that a header `names` holds, and warnings about what it holds besides.

    Raises `InputError` for repeated or misspelled names, a stream of which only a part is there, and a header
    without wrench, where it is needed, or without orientation and joints.
    """
    if len(names) > MAX_COLUMNS:
        raise InputError(f"has {len(names)} columns, more than {MAX_COLUMNS}", where=source)
    named = [name for name in names if name]
    present = set(named)
    if len(present) < len(named):
        twice = next(name for name in named if named.count(name) > 1)
        raise InputError(f"column {shown(twice)} is there {named.count(twice)} times", source, "keep one of them")

    groups = _groups(present)
    expected = {"time", *(column for columns in groups.values() for column in columns)}
    unknown = [name for name in named if name not in expected]
    absent = [name for name in dict.fromkeys((*EXPECTED, *sorted(expected))) if name not in present]

    for columns in groups.values():
        missing = [column for column in columns if column not in present]
        if missing and len(missing) < len(columns):
            there = " ".join(column for column in columns if column in present)
            resembling = (f"; unknown: {shown(name)}{guess}" for name in unknown if (guess := nearest(name, missing)))
            what = f"column '{missing[0]}' is missing beside {there}{next(resembling, '')}"
            raise InputError(what, source, f"give all of {' '.join(columns)}")
    for name in unknown:
        if match := _meant(name, absent):
            unit = ", in seconds" if match == "time" else ""
            what = f"unknown column {shown(name)} (did you mean '{match}'?)"
            raise InputError(what, source, f"rename it '{match}'{unit}, or give a column map (`column_map`=FILE)")

    for stream, others, fix in REQUIRED if wrench_needed else REQUIRED[1:]:
        if not present & {FIXED[stream][0], *others}:
            guesses = listed([shown(name) + nearest(name, FIXED[stream]) for name in unknown])
            raise InputError(f"there is no {stream}{guesses and '; unknown columns: '}{guesses}", source, fix)
    found = {stream: columns for stream, columns in groups.items() if columns[0] in present}
    ignored = [shown(name) + nearest(name, absent) for name in unknown]
    ignored += [f"number {i} without a name" for i, name in enumerate(names, 1) if not name]
    if not ignored:
        return found, ()
    return found, (warning("columns-ignored", f"ignored unknown columns: {listed(ignored)}", "column_map"),)


def shown(name: str) -> str:
    """A name of someone else's in quotes, cut short."""
    return repr(name[:40])


def _groups(present: set[str]) -> dict[str, tuple[str, ...]]:
    """The columns each stream should have, joints up to the highest number that is there."""
    groups = dict(FIXED)
    for stream in JOINT_STREAMS:
        joints = [re.fullmatch(rf"{COLUMNS[stream][0]}([1-9]\d?\d?)", name) for name in present]
        numbers = [int(joint[1]) for joint in joints if joint]
        if numbers:
            groups[stream] = column_names(stream, max(numbers))
    return groups


def _meant(name: str, absent: Sequence[str]) -> str | None:
    """The absent column that `name` surely stands for: the same letters, or another word for time."""
    letters = re.sub(r"[\W_]", "", name).lower()
    from difflib import get_close_matches

    for column in absent:
        if letters == column.replace("_", ""):
            return column
    timely = re.search("time|stamp", letters) or letters in TIME_NAMES or get_close_matches(letters, ["time"], 1, 0.7)
    return "time" if timely and "time" in absent else None
