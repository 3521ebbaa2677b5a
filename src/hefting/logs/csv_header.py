"""The beginning of separated text: its column names, and how its rows are written."""

import csv
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from hefting.core.errors import InputError
from hefting.logs.csv_times import is_day_first, kind_of
from hefting.logs.layout import Layout

MAX_HEADER = 1_000_000
"""Longest header [bytes]."""

MOST_LINES_BEFORE = 100
"""Lines among which the column names are looked for."""

MOST_LINES_BETWEEN = 3
"""Lines of units and the like that may stand between the names and the numbers."""

ROWS_LOOKED_AT = 100
"""Rows that tell whether decimals are written with a comma."""

COMMENT = re.compile(r"^\s*(#|%|//)\s*")
"""The mark of a comment, before column names too (``# time,fx``, ``%time,field.x``)."""

NUMBER = re.compile(
    r"\s*+([+-]?(\d++(\.\d*+)?|\.\d++)(e[+-]?\d+)?|[+-]?(nan|inf|infinity))?\s*",
    re.IGNORECASE,
)
"""A cell that can be read: a decimal number, nan, infinity or nothing, with blanks
around it; in a time that grows with its length."""


NOTHING = ("N/A", "n/a", "NA", "<NA>", "null", "NULL", "None")
"""Cells that other programs write where nothing was measured."""


@dataclass(frozen=True)
class Header:
    """What the beginning of separated text says of the rest."""

    names: tuple[str, ...]
    """of the columns; blank where there are none"""
    separator: str
    first: int
    """line of the first row of numbers, from 1"""
    decimal: str = "."
    between: tuple[str, ...] = ()
    """cells of the line under the names, where that is none of numbers: units, as a
    rule"""
    dates: Mapping[int, str] = field(default_factory=dict)
    """columns of dates and times of day, and their kind of `hefting.logs.csv_times`"""
    day_first: bool = False
    """whether dates are written as 31.01.2026"""


def read_header(text: bytes, path: str | Path, layout: Layout) -> Header:
    """The header in the `text` that begins a file.

    The names are in a line that has as many cells as the numbers below it; comments and
    other lines may stand before it, units between. What the layout says is not looked
    for. `InputError` when there is no header of at least two columns.
    """
    lines = _first_lines(text, path, layout.header or 0)
    row = layout.header
    if row is None:
        row = _find_names(lines, layout)
    elif row > len(lines):
        raise InputError(f"there is no line {row} with the column names", where=path)
    names, separator = _read_names(lines, row or _first_number(lines), path, layout)
    below = _Rows(lines, separator, len(names))
    first = below.first_of_numbers(row)
    between = below.cells(row + 1) if row and first and first > row + 1 else []
    if first is None or layout.skip is not None:
        first = row + 1 + (layout.skip or 0)
    sample = [below.cells(k) for k in range(first, first + ROWS_LOOKED_AT)]
    return Header(
        names if row else ("",) * len(names),
        separator,
        first,
        layout.decimal or ("," if _has_decimal_commas(sample, separator) else "."),
        tuple(between),
        {j: kind for j, cell in enumerate(sample[0]) if (kind := kind_of(cell))},
        any(is_day_first(cell) for cell in sample[0]),
    )


def _first_lines(text: bytes, path: str | Path, header: int) -> list[str]:
    """The lines among which the header is, from the first, and the rows that tell how
    numbers are written; `InputError` for blank text."""
    if not text.strip():
        raise InputError("the file is empty", where=path)
    most = max(MOST_LINES_BEFORE, header) + ROWS_LOOKED_AT
    lines = text.split(b"\n", most)[:most]
    return [line.decode(errors="surrogateescape") for line in lines]


def _find_names(lines: Sequence[str], layout: Layout) -> int:
    """The line (from 1) that has as many cells as the numbers below it; else the first
    one that is not blank."""
    rows = [row for row, line in enumerate(lines, 1) if line.strip()]
    for row in rows:
        if row > MOST_LINES_BEFORE:
            break
        line = _without_mark(lines[row - 1])
        separator = layout.separator or _guess_separator(line)
        try:
            names = split_cells(line, separator)
        except csv.Error:
            continue
        if len(names) < 2 or is_numbers(names, separator):
            continue
        below = _Rows(lines, separator, len(names))
        if (first := below.first_of_numbers(row)) is not None:
            return max(range(row, first), key=lambda k: below.distinct_names(k))
    return rows[0]


def _first_number(lines: Sequence[str]) -> int:
    """The first line (from 1) that is neither blank nor a comment; where there are no
    names, its cells are counted."""
    rows = enumerate(lines, 1)
    return next((k for k, line in rows if line.strip() and not COMMENT.match(line)), 1)


def _read_names(
    lines: Sequence[str], row: int, path: str | Path, layout: Layout
) -> tuple[tuple[str, ...], str]:
    """The cells of a line and their separator; `InputError` where it has no names."""
    where = f"{path}, row {row}"
    line = _without_mark(lines[row - 1])
    if len(line.encode(errors="surrogateescape")) > MAX_HEADER:
        raise InputError(
            f"the header has more than {MAX_HEADER:,} bytes",
            where,
            "export the log as CSV",
        )
    separator = layout.separator or _guess_separator(line)
    try:
        line.encode()
        names = split_cells(line, separator)
    except (UnicodeEncodeError, csv.Error) as error:
        raise InputError(
            "is not CSV text in UTF-8", path, "export the log as CSV"
        ) from error
    if len(names) < 2:
        raise InputError(
            f"the header {line[:40]!r} is one column",
            where,
            "put commas between columns",
        )
    if layout.header != 0 and all(NUMBER.fullmatch(name) for name in names):
        raise InputError(
            "is numbers, not column names", where, "give a header row: time,qx,qy,..."
        )
    return tuple(names), separator


@dataclass(frozen=True)
class _Rows:
    """Lines of text as rows of cells."""

    lines: Sequence[str]
    separator: str
    width: int
    """cells of a row"""

    def cells(self, row: int) -> list[str]:
        """The cells of a line, from 1; none beyond the last."""
        if row > len(self.lines):
            return []
        try:
            return split_cells(self.lines[row - 1], self.separator)
        except csv.Error:
            return []

    def distinct_names(self, row: int) -> int:
        """How many different names a line has: names of groups over those of the
        columns, and units under them, repeat."""
        return len(set(filter(None, self.cells(row))))

    def first_of_numbers(self, names: int) -> int | None:
        """The first line of numbers after that of the names (0: there are none); None
        where something else follows."""
        between = 0
        for row in range(names + 1, len(self.lines) + 1):
            line = self.lines[row - 1]
            if not line.strip() or COMMENT.match(line):
                continue
            cells = self.cells(row)
            if len(cells) != self.width:
                return None
            if is_numbers(cells, self.separator):
                return row
            between += 1
            if between > MOST_LINES_BETWEEN:
                return None
        return None


def split_cells(line: str, separator: str) -> list[str]:
    """The cells of a line, without blanks around them."""
    line = line.strip(" \r")
    line = re.sub(" +", " ", line) if separator == " " else line
    return [cell.strip() for cell in next(csv.reader([line], delimiter=separator), [])]


def is_numbers(cells: Sequence[str], separator: str) -> bool:
    """Whether most cells of a row are numbers or dates, and some are not blank."""
    known = [cell for cell in cells if cell and cell not in NOTHING]
    if separator != ",":
        known = [cell.replace(",", ".") for cell in known]
    readable = sum(NUMBER.fullmatch(c) is not None or bool(kind_of(c)) for c in known)
    return bool(known) and readable > len(known) / 2


def _has_decimal_commas(rows: Sequence[Sequence[str]], separator: str) -> bool:
    """Whether rows are written with a decimal comma, more than with a point."""
    if separator == ",":
        return False
    cells = [cell for row in rows for cell in row]
    commas = sum(
        bool(re.fullmatch(r"[+-]?\d*,\d+(e[+-]?\d+)?", c.lower())) for c in cells
    )
    return commas > sum("." in cell for cell in cells)


def _without_mark(line: str) -> str:
    """A line without the mark of a comment before it."""
    return COMMENT.sub("", line).strip(" \r")


def _guess_separator(line: str) -> str:
    """The separator that is there most often; a space where there is none."""
    separator = max(",;\t", key=line.count)
    return separator if separator in line else " "
