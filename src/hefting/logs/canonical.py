"""The canonical table: one row an instant, named columns, blanks for what was not measured <-> Recording."""

import re
from collections.abc import Sequence
from dataclasses import replace
from difflib import get_close_matches
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from hefting.errors import InputError, nearest
from hefting.recording import COLUMNS, JOINT_STREAMS, Recording, Stream, column_names

if TYPE_CHECKING:
    import pyarrow as pa

MAX_CELLS = 100_000_000
"""Most numbers that are read from one file (0.8 GB): more than an hour of twenty columns at 1 kHz."""

MAX_COLUMNS = 1000
FIXED = {name: columns for name, columns in COLUMNS.items() if name not in JOINT_STREAMS}
EXPECTED = ("time", *(column for columns in FIXED.values() for column in columns), "q1", "dq1")
REQUIRED = (
    ("wrench", (), "name its columns fx fy fz tx ty tz"),
    ("orientation", ("q1",), "give columns qx qy qz qw, or joint angles q1..qn"),
)
TIME_NAMES = {"t", "ts", "s", "sec", "secs", "seconds", "ms", "us", "ns", "clock"}


def known_columns(names: Sequence[str], source: str | Path) -> tuple[dict[str, tuple[str, ...]], tuple[str, ...]]:
    """Columns of each stream that a header `names` holds, and warnings about what it holds besides.

    Raises `InputError` for repeated or misspelled names, a stream of which only a part is there, and a header
    without wrench or without orientation and joints.
    """
    if len(names) > MAX_COLUMNS:
        raise InputError(f"has {len(names)} columns, more than {MAX_COLUMNS}", where=source)
    named = [name for name in names if name]
    present = set(named)
    if len(present) < len(named):
        twice = next(name for name in named if named.count(name) > 1)
        raise InputError(f"column {_shown(twice)} is there {named.count(twice)} times", source, "keep one of them")

    groups = _groups(present)
    expected = {"time", *(column for columns in groups.values() for column in columns)}
    unknown = [name for name in named if name not in expected]
    absent = [name for name in dict.fromkeys((*EXPECTED, *sorted(expected))) if name not in present]

    for columns in groups.values():
        missing = [column for column in columns if column not in present]
        if missing and len(missing) < len(columns):
            there = " ".join(column for column in columns if column in present)
            resembling = (f"; unknown: {_shown(name)}{guess}" for name in unknown if (guess := nearest(name, missing)))
            what = f"column '{missing[0]}' is missing beside {there}{next(resembling, '')}"
            raise InputError(what, source, f"give all of {' '.join(columns)}")
    for name in unknown:
        if match := _meant(name, absent):
            unit = ", in seconds" if match == "time" else ""
            what = f"unknown column {_shown(name)} (did you mean '{match}'?)"
            raise InputError(what, source, f"rename it '{match}'{unit}")

    for stream, others, fix in REQUIRED:
        if not present & {FIXED[stream][0], *others}:
            guesses = _listed([_shown(name) + nearest(name, FIXED[stream]) for name in unknown])
            raise InputError(f"there is no {stream}{guesses and '; unknown columns: '}{guesses}", source, fix)
    found = {stream: columns for stream, columns in groups.items() if columns[0] in present}
    ignored = [_shown(name) + nearest(name, absent) for name in unknown]
    ignored += [f"number {i} without a name" for i, name in enumerate(names, 1) if not name]
    return found, (f"ignored unknown columns: {_listed(ignored)}",) if ignored else ()


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
    for column in absent:
        if letters == column.replace("_", ""):
            return column
    timely = re.search("time|stamp", letters) or letters in TIME_NAMES or get_close_matches(letters, ["time"], 1, 0.7)
    return "time" if timely and "time" in absent else None


def _shown(name: str) -> str:
    return repr(name[:40])


def _listed(items: Sequence[str]) -> str:
    return ", ".join(items[:8]) + (f" and {len(items) - 8} more" if len(items) > 8 else "")


def recording_from_table(
    table: "pa.Table",
    groups: dict[str, tuple[str, ...]],
    rows: NDArray[np.int64],
    source: str | Path,
    warnings: tuple[str, ...] = (),
) -> Recording:
    """Recording from a table of 64-bit floats whose columns are those of `groups` and perhaps `time`.

    `rows` (R,) are the row numbers for messages. Nulls are "not measured"; `InputError` where a null breaks a
    group, and for what `Recording` refuses.
    """
    if table.num_rows == 0:
        raise InputError("there is a header but there are no samples", where=source)
    static = "time" not in table.column_names
    no_blanks = np.zeros(table.num_rows, dtype=bool)
    time, untimed = (np.arange(table.num_rows, dtype=float), no_blanks) if static else _column(table, "time", no_blanks)
    streams = {}
    for name, columns in groups.items():
        values, blanks = zip(*(_column(table, column, no_blanks) for column in columns), strict=True)
        measured = _measured(columns, blanks, rows, source)
        if not measured.any():
            warnings += (f"columns {columns[0]}..{columns[-1]} are all blank",)
            continue
        if (measured & untimed).any():
            row = rows[np.argmax(measured & untimed)]
            raise InputError("the time is blank", f"{source}, row {row}, column time", "give the row its time")
        chosen = slice(None) if measured.all() else measured
        streams[name] = Stream(time[chosen], np.stack(values, axis=1)[chosen], rows[chosen])
    if "wrench" not in streams or not {"orientation", "joint_positions"} & set(streams):
        lacking = "orientation" if "wrench" in streams else "wrench"
        raise InputError(f"there is no {lacking}: all its cells are blank", where=source)
    recording = Recording(streams, static, str(source), warnings)
    return _checked_static(recording) if static else _in_seconds(recording)


def table_from_recording(recording: Recording) -> "pa.Table":
    """The canonical table of a recording: a row for each instant at which any stream has a sample."""
    import pyarrow as pa

    times = np.unique(np.concatenate([stream.time for stream in recording.streams.values()]))
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


def _column(table: "pa.Table", name: str, no_blanks: NDArray) -> tuple[NDArray, NDArray]:
    """Values (R,) of a column and a mask of the blank ones."""
    column = table[name]
    return column.to_numpy(), column.is_null().to_numpy() if column.null_count else no_blanks


def _measured(columns: Sequence[str], blanks: Sequence[NDArray], rows: NDArray, source: str | Path) -> NDArray:
    """Mask (R,) of the rows in which a group was measured; a row holds all of a group or nothing."""
    for column, blank in zip(columns, blanks, strict=True):
        if blank is not blanks[0] and (blank != blanks[0]).any():
            k = np.argmax(blank != blanks[0])
            where = f"{source}, row {rows[k]}, column {column if blank[k] else columns[0]}"
            raise InputError("the cell is blank", where, f"give all of {' '.join(columns)} in a row or none")
    return ~blanks[0]


def _checked_static(recording: Recording) -> Recording:
    """The recording, with a warning when its rows hardly are static poses."""
    poses = ("position", "orientation", "joint_positions", "wrench", "accelerometer")
    moving = [name for name in recording.streams if name not in poses]
    count = max(len(stream) for stream in recording.streams.values())
    if not moving and count <= 1000:
        return recording
    also = f", although there is {', '.join(moving)}" if moving else ""
    warning = f"there is no column time: each of {count} rows is taken as a static pose{also}"
    return replace(recording, warnings=(*recording.warnings, warning))


def _in_seconds(recording: Recording) -> Recording:
    """The recording with epoch times shifted to start at 0, and warnings; `InputError` if not in seconds."""
    where = f"{recording.source}, column time"
    start, streams, warnings = recording.start, recording.streams, list(recording.warnings)
    if abs(start) > 1e11:  # seconds since 1970 reach 1e11 in the year 5138
        unit, factor = next((unit, factor) for unit, factor, least in EPOCHS if abs(start) > least)
        raise InputError(
            f"{start:.6g} cannot be seconds; it looks like {unit} since 1970", where, f"divide by {factor}"
        )
    if abs(start) > 1e8:
        streams = {name: replace(stream, time=stream.time - start) for name, stream in streams.items()}
        resolution = np.spacing(abs(start))
        warnings.append(f"time was shifted by {start:.6f} s to start at 0; it resolves {resolution:.1g} s")
    for name, stream in streams.items():
        steps = np.diff(stream.time)
        step = float(np.median(steps)) if len(steps) else 0.0
        if step > 1000:
            raise InputError(f"the median step of {name} is {step:.4g}, not seconds", where, "give time in seconds")
        whole = step >= 1 and len(steps) > 20 and not (stream.time % 1).any()
        if step > 5 or whole:
            warnings.append(f"the median step of {name} is {step:.4g} s: is time in milliseconds, not seconds?")
        elif 0 < step < 2e-5:
            warnings.append(f"the median step of {name} is {step:.4g} s: is time in seconds?")
    if len(warnings) == len(recording.warnings):
        return recording
    return replace(recording, streams=streams, warnings=tuple(warnings))


EPOCHS = (("nanoseconds", "1e9", 1e17), ("microseconds", "1e6", 1e14), ("milliseconds", "1e3", 1e11))
"""Unit, divisor and least value of times since 1970 that are not in seconds."""
