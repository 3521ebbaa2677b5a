"""The header of separated text: its column names, and the form of its rows."""

import csv
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from hefting.core.errors import InputError
from hefting.logs.csv_cells import NOTHING, NUMBER, by_iso, kind_of, list_in, lists_of
from hefting.logs.layout import SEPARATORS, Layout

MAX_HEADER = 1_000_000
"""Longest header [bytes]."""

MOST_NAMES = 10_000
"""Most names of columns that are looked at."""

MOST_LINES_BEFORE = 100
"""Number of lines in which the column names are searched."""

MOST_LINES_BETWEEN = 3
"""Largest number of lines, such as units, between the names and the numbers."""

ROWS_LOOKED_AT = 100
"""Number of rows that show lists and decimal commas."""

COMMENT = re.compile(r"^\s*(#|%|//)\s*")
"""Mark of a comment, also of column names (``# time,fx``, ``%time,field.x``)."""


@dataclass(frozen=True)
class Header:
    """Column names of separated text, and the form of its rows."""

    names: tuple[str, ...]
    """of the columns; empty for those without"""
    separator: str
    first: int
    """line of the first row of numbers, from 1"""
    decimal: str = "."
    between: tuple[str, ...] = ()
    """cells of a line of text under the names, usually units"""
    dates: Mapping[int, str] = field(default_factory=dict)
    """columns of dates and times of day, and their kind of `hefting.logs.csv_cells`"""
    other_way: bool = False
    """whether dates and times are written in another way than by ISO 8601"""
    joined: bool = False
    """whether the names are joined from lines of groups and of columns"""
    lists: Mapping[int, int] = field(default_factory=dict)
    """number of numbers of each column of lists; they have names after the others"""


def read_header(text: bytes, path: str | Path, given: Layout | None) -> Header:
    """The header in the `text` at the beginning of a file.

    The names are in the line with as many cells as the numbers below it; comments and
    other lines may precede it, and units follow. Given parts of the layout, as of a
    column map, are not searched, and the names are not joined from two lines then.
    `InputError` without a header of two or more columns.
    """
    layout = given or Layout()
    lines = _first_lines(text, path, layout.header or 0)
    row = layout.header
    if row is None:
        row = _find_names(lines, layout)
    elif row > len(lines):
        raise InputError(f"there is no line {row} with the column names", where=path)
    names, separator = _read_names(lines, row or _first_number(lines), path, layout)
    above = Rows(lines, separator, len(names))
    names, below = _fit(lines, row, names, separator, layout)
    first, units, joined = below.first_of_numbers(row), row + 1, None
    if given is None and row:
        joined = _joined([above.cells(k) for k in range(row - 1, 0, -1)], names)
        if joined is None and first and first > units:
            joined = _joined([names], below.cells(units))
            units += joined is not None
        names = joined or names
        index = below.cells(first - 1) if first and first > row + 1 else []
        groups = above.cells(row - 1) if row > 1 else []
        if len({*groups}) < len(groups) == len(index) and not any(index[1:]):
            names = (index[0], *names[1:])  # as pandas writes it under two levels
    between = below.cells(units) if row and first and first > units else []
    if first is None or layout.skip is not None:
        first = row + 1 + (layout.skip or 0)
    sample = [below.cells(k) for k in range(first, first + ROWS_LOOKED_AT)]
    names = tuple(names) if row else ("",) * len(names)
    lists = lists_of(sample, len(names))
    for j, count in lists.items():
        head, mark, unit = names[j].partition("[")
        some = (f"{head.rstrip()}_{i}{mark and ' ['}{unit}" for i in range(count))
        names += tuple(some) if row else ("",) * count
        between += between[j : j + 1] * count
    return Header(
        tuple("" if j in lists else name for j, name in enumerate(names)),
        below.separator,
        first,
        layout.decimal or ("," if _has_decimal_commas(sample) else "."),
        tuple(between),
        {j: kind for j, cell in enumerate(sample[0]) if (kind := kind_of(cell))},
        any(by_iso(cell) != cell for cell in sample[0]),
        joined is not None,
        lists,
    )


def _first_lines(text: bytes, path: str | Path, header: int) -> list[str]:
    """The lines that may hold the header, and rows; `InputError` for blank text."""
    if not text.strip():
        raise InputError("the file is empty", where=path)
    most = max(MOST_LINES_BEFORE, header) + ROWS_LOOKED_AT
    lines = text.split(b"\n", most)[:most]
    return [_text_of(line) for line in lines]


def _text_of(line: bytes) -> str:
    """A line decoded as UTF-8, or as Latin-1 if printable (a degree sign of an older
    Windows); other bytes as surrogates."""
    try:
        return line.decode()
    except UnicodeDecodeError:
        text = line.decode("latin-1")
        printable = text.replace("\t", "").rstrip("\r").isprintable()
        return text if printable else line.decode(errors="surrogateescape")


def _find_names(lines: Sequence[str], layout: Layout) -> int:
    """The line (from 1) with as many cells as the numbers below it; else the first that
    is not blank."""
    rows = [row for row, line in enumerate(lines, 1) if line.strip()]
    for row in rows:
        if row > MOST_LINES_BEFORE:
            break
        line = _without_mark(lines[row - 1])
        separator = layout.separator or _guess_separator(line)
        try:
            names = _split_names(line, separator)
        except csv.Error:
            continue
        if len(names) < 2 or is_numbers(names):
            continue
        _, below = _fit(lines, row, names, separator, layout)
        if (first := below.first_of_numbers(row)) is not None:
            return max(range(row, first), key=below.names_in)
    return rows[0]


def _fit(
    lines: Sequence[str], row: int, names: Sequence[str], separator: str, layout: Layout
) -> "tuple[tuple[str, ...], Rows]":
    """The names in a line, and the rows below, which may have another separator, or a
    separator at their ends where the names have none, or the reverse."""
    others = () if layout.separator else SEPARATORS.values()
    for each in dict.fromkeys((separator, *others)):
        ends = not names[-1] and _without_mark(lines[row - 1]).endswith(separator)
        shorter = (names[:-1],) if ends else ()
        for given in (names, *shorter, (*names, "")):
            below = Rows(lines, each, len(given))
            first = below.first_of_numbers(row)
            longer = len(given) > len(names)
            if first is not None and not (longer and below.cells(first)[-1]):
                return tuple(given), below
    return tuple(names), Rows(lines, separator, len(names))


def _joined(
    uppers: Sequence[Sequence[str]], lower: Sequence[str]
) -> tuple[str, ...] | None:
    """Names of groups (``Force``) joined to those of the columns under them (``X``), from
    the next upper line, or from all upper lines where names repeat otherwise.

    None where one of the first two lines names each column by itself, or where joined
    names repeat.
    """
    if _name_each(lower) or any(map(_name_each, uppers[:1])):
        return None
    joined = [*lower]
    for k, upper in enumerate(uppers):
        if len(upper) != len(lower):
            break
        group = ""
        for j, above in enumerate(upper):
            group = above or group
            if group != joined[j]:
                joined[j] = f"{group} {joined[j]}".strip()
        if k == 0 and len({*joined}) == len(joined):
            break
    return tuple(joined) if len({*joined}) == len(joined) > len({*lower}) else None


def _name_each(names: Sequence[str]) -> bool:
    """Whether names differ and few are blank."""
    named = [name for name in names if name]
    return len({*named}) == len(named) > 0.75 * len(names)


def _first_number(lines: Sequence[str]) -> int:
    """The first line (from 1) that is neither blank nor a comment, which tells the
    number of columns without names."""
    rows = enumerate(lines, 1)
    return next((k for k, line in rows if line.strip() and not COMMENT.match(line)), 1)


def _read_names(
    lines: Sequence[str], row: int, path: str | Path, layout: Layout
) -> tuple[tuple[str, ...], str]:
    """The cells of a line and their separator; `InputError` where it has no names."""
    where = f"{path}, row {row}"
    line = _without_mark(lines[row - 1])
    if len(line.encode(errors="surrogateescape")) > MAX_HEADER:
        what = f"the header has more than {MAX_HEADER:,} bytes"
        raise InputError(what, where, "export the log as CSV")
    separator = layout.separator or _guess_separator(line)
    try:
        line.encode()
        names = _split_names(line, separator)
    except (UnicodeEncodeError, csv.Error) as error:
        what = f"is not CSV text in UTF-8 ({str(error)[:80]})"
        raise InputError(what, path, "save it as CSV in UTF-8") from error
    if len(names) < 2 and not list_in("".join(names)):
        what = f"the header {line[:40]!r} is one column"
        fix = "export a table as CSV, with commas between columns"
        raise InputError(what, where, fix)
    if layout.header != 0 and _is_no_header(names, lines, row, separator):
        raise InputError(
            "is numbers, not column names",
            where,
            "give a header row: time,qx,qy,..., or a column map with header = false and "
            "the numbers of the columns (`column_map`=FILE; of a second file with poses "
            "in a table [poses] of it)",
        )
    return tuple(names), separator


@dataclass(frozen=True)
class Rows:
    """Lines of text as rows of cells."""

    lines: Sequence[str]
    separator: str
    width: int
    """cells of a row"""

    def cells(self, row: int) -> list[str]:
        """The cells of a line, counted from 1; none after the last."""
        if row > len(self.lines):
            return []
        try:
            return split_cells(self.lines[row - 1], self.separator)
        except csv.Error:
            return []

    def names_in(self, row: int) -> tuple[bool, int]:
        """Whether the first and most cells of a line are not blank, and the number of
        different ones, which is lower in lines of groups or units."""
        cells = self.cells(row)
        names = [*filter(None, cells)]
        return bool(cells and cells[0]) and 2 * len(names) > len(cells), len({*names})

    def first_of_numbers(self, names: int) -> int | None:
        """The first line of numbers after the line of the names (0: no names); None
        where other text follows."""
        between = 0
        for row in range(names + 1, len(self.lines) + 1):
            line = self.lines[row - 1]
            if not line.strip() or COMMENT.match(line):
                continue
            cells = self.cells(row)
            if len(cells) != self.width:
                return None
            below = map(self.cells, range(row + 1, row + 4))
            if is_numbers(cells) and (
                cells[0] or all(is_numbers(c) for c in below if any(c))
            ):
                return row  # not a line of marker numbers above more names
            between += 1
            if between > MOST_LINES_BETWEEN:
                return None
        return None


def _is_no_header(
    names: Sequence[str], lines: Sequence[str], row: int, separator: str
) -> bool:
    """Whether a line is a row of data: all numbers, or most, in the columns in which the
    next line has numbers."""
    known = [bool(NUMBER.fullmatch(name)) for name in names]
    below = Rows(lines, separator, len(names)).cells(row + 1)
    same = known == [bool(NUMBER.fullmatch(cell)) for cell in below]
    return all(known) or (is_numbers(names) and same)


def _split_names(line: str, separator: str) -> list[str]:
    """The cells of a line of names; ``Fx [N]`` is one, also with spaces as separator."""
    line = re.sub(r"(?<! ) ++(?=[\[(])", "", line) if separator == " " else line
    names = split_cells(line, separator)
    if len(names) > MOST_NAMES:
        raise csv.Error(f"more than {MOST_NAMES:,} names of columns")
    return names


def split_cells(line: str, separator: str) -> list[str]:
    """The cells of a line, without blanks around them."""
    line = line.strip(" \r")
    line = re.sub(" +", " ", line) if separator == " " else line
    return [cell.strip() for cell in next(csv.reader([line], delimiter=separator), [])]


def is_numbers(cells: Sequence[str]) -> bool:
    """Whether most cells of a row are numbers or dates, and some are not blank."""
    known = [cell for cell in cells if cell not in ("", *NOTHING)]
    numbers = (cell.replace(",", ".") for cell in known)
    readable = sum(
        bool(NUMBER.fullmatch(number) or kind_of(number) or list_in(cell))
        for cell, number in zip(known, numbers, strict=True)
    )
    return bool(known) and readable > len(known) / 2


def _has_decimal_commas(rows: Sequence[Sequence[str]]) -> bool:
    """Whether more numbers have a decimal comma than a point; with commas as separator
    such cells are in quotes."""
    cells = [cell for row in rows for cell in row]
    with_comma = [cell.lower() for cell in cells if "," in cell]
    number = re.compile(r"[+-]?\d*,\d+(e[+-]?\d+)?")
    commas = sum(bool(number.fullmatch(cell)) for cell in with_comma)
    if not commas:
        return False
    return commas > sum("." in c and not (" " in c and list_in(c)) for c in cells)


def _without_mark(line: str) -> str:
    return COMMENT.sub("", line).strip(" \r")


def _guess_separator(line: str) -> str:
    separator = max(",;\t|", key=line.count)
    return separator if separator in line else " "
