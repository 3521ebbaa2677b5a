"""The canonical table: one row for each instant, named columns in SI units, blank cells
where nothing was measured."""

import io
import re
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from hefting.core.errors import InputError, nearest
from hefting.core.messages import Message, warning
from hefting.core.recording import COLUMNS, JOINT_STREAMS, Recording, column_names
from hefting.logs.map_groups import others_told
from hefting.logs.static_poses import warn_about_static, without_unit
from hefting.logs.table import (
    Table,
    collect,
    in_seconds,
    require_streams,
    summarize_list,
)

if TYPE_CHECKING:
    import pyarrow as pa

MAX_COLUMNS = 1000
"""Largest number of columns."""

FIXED = {
    name: columns for name, columns in COLUMNS.items() if name not in JOINT_STREAMS
}
"""Columns of each stream whose number of columns does not depend on the robot."""

EXPECTED = (
    "time",
    *(column for columns in FIXED.values() for column in columns),
    "q1",
    "dq1",
)
"""Canonical names that a misspelled column may stand for, with the first joint's."""

MAPPED = "say which columns hold what in a column map (`column_map`=FILE; hefting map guesses one)"
"""Advice for columns with other names."""

REQUIRED = (
    ("wrench", (), "name the wrench's columns fx fy fz tx ty tz"),
    (
        "orientation",
        ("q1",),
        "give the orientation in columns qx qy qz qw, or joint angles in q1..qn, or "
        "another file with them (`poses`)",
    ),
)
"""Required streams: name, columns that serve instead, and the fix without either."""

TIME_NAMES = {"t", "ts", "s", "sec", "secs", "seconds", "ms", "us", "ns", "clock"}
"""Other names of the time, in small letters."""


def read_canonical(table: Table, wrench_needed: bool = True) -> Recording:
    """Recording in a table whose columns have the canonical names; see
    `hefting.logs.read_log` for errors."""
    groups, warnings = known_columns(table.names, table.source, wrench_needed)
    position = {name: j for j, name in enumerate(table.names)}
    columns = {
        name: [position[column] for column in group] for name, group in groups.items()
    }
    time = position.get("time")
    streams, more = collect(table, time, columns)
    require_streams(streams, table.source, wrench_needed)
    if time is None:
        return warn_about_static(
            Recording(streams, True, table.source, warnings + more)
        )
    streams, about_time = in_seconds(streams, table.source)
    warnings += more + about_time
    return without_unit(Recording(streams, False, table.source, warnings))


def known_columns(
    names: Sequence[str], source: str | Path, wrench_needed: bool = True
) -> tuple[dict[str, tuple[str, ...]], tuple[Message, ...]]:
    """Columns of each stream in a header `names`, and warnings about its other columns.

    Raises `InputError` for repeated or misspelled names, an incomplete stream, and a
    header without wrench, where it is needed, or without orientation and joints.
    """
    named = check_names(names, source)
    present = set(named)
    groups = _group_columns(present)
    expected = {"time", *(column for columns in groups.values() for column in columns)}
    unknown = [name for name in named if name not in expected]
    if "value" in present and not present & (expected - {"time"}):
        fix = "make each name a column, as pandas' pivot does, or give the bag"
        raise InputError("has one number a row, beside its name", source, fix)
    candidates = dict.fromkeys((*EXPECTED, *sorted(expected)))
    absent = [name for name in candidates if name not in present]

    guessed = {name: _guess_column(name, absent) for name in unknown}
    first = next((n for n in unknown if _letters(n) == "q0"), None)
    if first and "q1" in guessed.values():
        what = f"joints are numbered from 0, by {quote_name(first)}"
        raise InputError(what, source, f"number them from 1; or {MAPPED}")
    misspelled = {name: match for name, match in guessed.items() if match}
    there = present | set(misspelled.values())
    strange = [name for name in unknown if name not in misspelled]
    wrong = [
        *_explain_misspelled(misspelled),
        *_find_partly_there(groups, there),
        *_find_lacking(there, wrench_needed),
    ]
    if wrong:
        what = "; ".join(what for what, _ in wrong)
        if strange and len(wrong) > bool(misspelled):
            needed = [c for c in groups.values() if there & set(c)]
            needed += [FIXED[stream] for stream, _, _ in REQUIRED]
            missing = [c for columns in needed for c in columns if c not in there]
            what += f"; unknown columns: {summarize_list(_quoted(strange, missing))}"
            what += others_told(strange)
        fix = "; ".join(fix for _, fix in wrong)
        raise InputError(what, source, f"{fix}; or {MAPPED}")
    found = {
        stream: columns for stream, columns in groups.items() if columns[0] in present
    }
    return found, _warn_about_ignored(names, unknown, absent)


def check_names(names: Sequence[str], source: str | Path) -> list[str]:
    """The names that are not blank; `InputError` for too many or a repeated one."""
    if len(names) > MAX_COLUMNS:
        raise InputError(
            f"has {len(names)} columns, more than {MAX_COLUMNS}", where=source
        )
    named = [name for name in names if name]
    if len(set(named)) < len(named):
        twice = next(name for name in named if named.count(name) > 1)
        what = f"column {quote_name(twice)} is there {named.count(twice)} times"
        raise InputError(what, source, "keep one of them")
    return named


def columns_of_streams(names: Sequence[str], streams: Sequence[str]) -> set[str]:
    """The canonical names of these streams that are in `names`."""
    groups = _group_columns(set(names))
    columns = {column for each in streams for column in groups.get(each, ())}
    return columns & set(names)


def _find_partly_there(
    groups: Mapping[str, Sequence[str]], present: set[str]
) -> Iterator[tuple[str, str]]:
    """An error and its fix where only some columns of a stream are present."""
    partly = [
        columns
        for columns in groups.values()
        if present & set(columns) and not set(columns) <= present
    ]
    if not partly:
        return
    missing = [c for columns in partly for c in columns if c not in present]
    there = [c for columns in partly for c in columns if c in present]
    names = summarize_list([f"'{name}'" for name in missing])
    verb = "columns {} are" if len(missing) > 1 else "column {} is"
    what = f"{verb.format(names)} missing beside {summarize_list(there, between=' ')}"
    whole = [summarize_list(columns, between=" ") for columns in partly]
    yield what, f"give all of {', and '.join(whole)}"


def _explain_misspelled(misspelled: Mapping[str, str]) -> Iterator[tuple[str, str]]:
    """An error and its fix where columns are misspelled; `misspelled` maps the names to
    the canonical ones."""
    if not misspelled:
        return
    pairs = misspelled.items()
    names = [f"{quote_name(n)} (did you mean '{match}'?)" for n, match in pairs]
    several = len(misspelled) > 1
    what = f"unknown column{'s' if several else ''} {summarize_list(names)}"
    it = "them" if several else f"it '{next(iter(misspelled.values()))}'"
    unit = ", with time in seconds" if "time" in misspelled.values() else ""
    yield what, f"rename {it}{unit}"


def _quoted(unknown: Sequence[str], missing: Sequence[str]) -> list[str]:
    """Unknown columns, each with the missing one that it resembles."""
    return [
        quote_name(name) + (nearest(name, missing) if len(name) > 1 else "")
        for name in unknown
    ]


def _find_lacking(present: set[str], wrench_needed: bool) -> Iterator[tuple[str, str]]:
    """An error and its fix where required streams are absent."""
    lacking = [
        (stream, fix)
        for stream, others, fix in (REQUIRED if wrench_needed else REQUIRED[1:])
        if not present & {*FIXED[stream], *others}
    ]
    if not lacking:
        return
    what = f"there is no {' and no '.join(stream for stream, _ in lacking)}"
    fixes = [fix for _, fix in lacking]
    if "tau1" in present:
        fixes.insert(0, "of joint torques: hefting identify --torques")
    yield what, "; ".join(fixes)


def _warn_about_ignored(
    names: Sequence[str], unknown: Sequence[str], absent: Sequence[str]
) -> tuple[Message, ...]:
    blank = [f"number {i} without a name" for i, n in enumerate(names, 1) if not n]
    ignored = _quoted(unknown, absent) + blank
    if not ignored:
        return ()
    what = f"ignored unknown columns: {summarize_list(ignored)}"
    return (warning("columns-ignored", what, "column_map"),)


def quote_name(name: str) -> str:
    """The first 40 characters of a name, in quotes."""
    return repr(name[:40])


def _group_columns(present: set[str]) -> dict[str, tuple[str, ...]]:
    """The columns of each stream; for joints up to the highest present number."""
    groups = dict(FIXED)
    for stream in JOINT_STREAMS:
        joints = [
            re.fullmatch(rf"{COLUMNS[stream][0]}([1-9]\d?\d?)", name)
            for name in present
        ]
        numbers = [int(joint[1]) for joint in joints if joint]
        if numbers:
            groups[stream] = column_names(stream, max(numbers))
    return groups


def _letters(name: str) -> str:
    return re.sub(r"[\W_]", "", name).lower()


def _guess_column(name: str, absent: Sequence[str]) -> str | None:
    """The absent column with the same letters as `name`, or time for another word for
    it; else None."""
    letters = _letters(name)
    from difflib import get_close_matches

    for column in absent:
        if letters == column.replace("_", ""):
            return column
    timely = (
        re.search("time|stamp", letters)
        or letters in TIME_NAMES
        or get_close_matches(letters, ["time"], 1, 0.7)
    )
    return "time" if timely and "time" in absent else None


def table_from_recording(recording: Recording) -> "pa.Table":
    """The canonical table of a recording, with a row for each instant of a sample."""
    import pyarrow as pa

    times = np.unique(
        np.concatenate([stream.time for stream in recording.streams.values()])
    )
    columns = {} if recording.static else {"time": pa.array(times)}
    for name, stream in recording.streams.items():
        at = np.searchsorted(times, stream.time)
        blank = np.ones(len(times), dtype=bool)
        blank[at] = False
        for j, column in enumerate(column_names(name, stream.values.shape[1])):
            values = np.zeros(len(times))
            values[at] = stream.values[:, j]
            columns[column] = pa.array(values, mask=blank)
    return pa.table(columns)


def csv_of(table: "pa.Table") -> bytes:
    """A table as CSV, its names without quotes."""
    from pyarrow import csv as pacsv

    stream = io.BytesIO()
    stream.write((",".join(table.column_names) + "\n").encode())
    pacsv.write_csv(table, stream, pacsv.WriteOptions(include_header=False))
    return stream.getvalue()
