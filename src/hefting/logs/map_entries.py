"""Entries of a column map: a table of known words, the columns of a key, and the time: a
column in a unit, two columns of seconds and nanoseconds, or rows at a rate."""

import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from hefting.core.errors import InputError, nearest
from hefting.logs.layout import brief, whole
from hefting.logs.table import summarize_list
from hefting.logs.units import SECOND, Unit, find_unit

MAX_NAMES = 1000
"""Largest number of columns of one key."""


def parse_entry(
    value: Any, single: str, words: Sequence[str], where: str
) -> dict[str, Any]:
    """The table of a key, with these words; another value is of the word `single`."""
    entry = value if isinstance(value, dict) else {single: value}
    check_known(entry, words, where, "word")
    return entry


def parse_columns(value: Any, where: str) -> tuple[str | int, ...]:
    """Names and numbers of columns, ranges expanded."""
    columns: list[str | int] = []
    for item in value if isinstance(value, list) else [value]:
        if isinstance(item, str) and item:
            columns += _expand_range(item, where)
        elif whole(item, 1):
            columns.append(item)
        else:
            fix = "give its name, or its number counted from 1"
            raise InputError(f"{brief(item)} is no column", where, fix)
        if len(columns) > MAX_NAMES:
            raise InputError(f"names more than {MAX_NAMES} columns", where)
    if not columns:
        raise InputError("names no column", where)
    return tuple(columns)


def _expand_range(name: str, where: str) -> Sequence[str]:
    """``"q{0..2}"`` as ``q0, q1, q2``; other names unchanged."""
    found = re.fullmatch(r"(.*)\{(\d{1,6})\.\.(\d{1,6})\}(.*)", name, re.DOTALL)
    if not found:
        return [name]
    first, last = int(found[2]), int(found[3])
    if not first <= last < first + MAX_NAMES:
        what = f"{brief(name)} counts no columns"
        raise InputError(what, where, "give the smaller number first, as in q{0..6}")
    return [f"{found[1]}{number}{found[4]}" for number in range(first, last + 1)]


def parse_one_column(value: Any, where: str) -> str | int:
    """Name or number of a single column."""
    column, *others = parse_columns(value, where)
    if others:
        raise InputError(f"names {1 + len(others)} columns, time is one", where)
    return column


def check_known(
    names: Iterable[str], known: Sequence[str], where: str | Path, what: str
) -> None:
    """`InputError` that lists all unknown names."""
    unknown = [f"'{n[:40]}'{nearest(n, known)}" for n in names if n not in known]
    if unknown:
        plural = "s" if len(unknown) > 1 else ""
        raise InputError(
            f"unknown {what}{plural} {summarize_list(unknown)}",
            where,
            f"use {', '.join(known)}",
        )


@dataclass(frozen=True)
class MappedTime:
    """The time of a table's rows."""

    column: str | int | None
    """None: rows are counted"""
    unit: Unit
    """of that column, or of the count"""
    nanoseconds: str | int | None = None
    """column with the fraction of the seconds [ns]"""

    @property
    def columns(self) -> list[str | int]:
        """The columns that are read."""
        return [c for c in (self.column, self.nanoseconds) if c is not None]


def parse_time(value: Any, where: str) -> MappedTime:
    """The time that a column map gives; `InputError`, naming `where`."""
    entry = parse_entry(
        value, "column", ("column", "unit", "rate", "nanoseconds"), where
    )
    if "column" not in entry and "rate" not in entry:
        fix = 'give { column = "name" } or { rate = 1000 } in Hz'
        raise InputError("says neither column nor rate", where, fix)
    column = None
    if "column" in entry:
        column = parse_one_column(entry["column"], where)
    if "rate" in entry:
        return MappedTime(column, _unit_of_rate(entry, where))
    unit = find_unit(entry.get("unit", "s"), "time", f"{where}.unit")
    if "nanoseconds" not in entry:
        return MappedTime(column, unit)
    if unit is not SECOND:
        raise InputError(
            f"has nanoseconds on top of {unit.name}", where, 'give unit = "s"'
        )
    more = parse_one_column(entry["nanoseconds"], f"{where}.nanoseconds")
    return MappedTime(column, unit, more)


def _unit_of_rate(entry: dict[str, Any], where: str) -> Unit:
    rate = entry["rate"]
    if (
        isinstance(rate, bool)
        or not isinstance(rate, int | float)
        or not 0 < rate < 1e9
    ):
        what = f"the rate {brief(rate)} is no positive number"
        raise InputError(what, f"{where}.rate", "give it in Hz")
    for other in ("unit", "nanoseconds"):
        if other in entry:
            fix = "give the rate alone if the column counts frames"
            raise InputError(f"says both {other} and rate", where, fix)
    return SECOND if rate == 1 else Unit(f"frames at {rate:g} Hz", 1.0, float(rate))
