"""Entries of a column map: a table of known words, and the columns that one names."""

import re
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any

from hefting.core.errors import InputError, nearest
from hefting.logs.layout import brief, whole
from hefting.logs.table import summarize_list

MAX_NAMES = 1000
"""Most columns that one key may name."""


def parse_entry(
    value: Any, single: str, words: Sequence[str], where: str
) -> dict[str, Any]:
    """The table of a key, of these words; what is no table stands for its word
    `single`."""
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
    """``"q{0..2}"`` as ``q0, q1, q2``; other names as they are."""
    found = re.fullmatch(r"(.*)\{(\d{1,6})\.\.(\d{1,6})\}(.*)", name, re.DOTALL)
    if not found:
        return [name]
    first, last = int(found[2]), int(found[3])
    if not first <= last < first + MAX_NAMES:
        raise InputError(
            f"{brief(name)} counts no columns",
            where,
            "give the smaller number first, as in q{0..6}",
        )
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
    """`InputError` that lists all of the names that are not known."""
    unknown = [f"'{n[:40]}'{nearest(n, known)}" for n in names if n not in known]
    if unknown:
        plural = "s" if len(unknown) > 1 else ""
        raise InputError(
            f"unknown {what}{plural} {summarize_list(unknown)}",
            where,
            f"use {', '.join(known)}",
        )
