"""The header of separated text: its line, its separator and the names in it."""

import csv
import re
from pathlib import Path

from hefting.core.errors import InputError
from hefting.logs.layout import Layout

MAX_HEADER = 1_000_000
"""Longest header [bytes]."""

NUMBER = re.compile(
    r"\s*([+-]?(\d+\.?\d*|\.\d+)(e[+-]?\d+)?|[+-]?(nan|inf|infinity))?\s*",
    re.IGNORECASE,
)
"""A cell that can be read: a decimal number, nan, infinity or nothing, with blanks
around it."""


def read_header(
    text: bytes, path: str | Path, layout: Layout
) -> tuple[tuple[str, ...], str, int]:
    """Names of the columns, separator, and row of the first numbers, from the `text`
    that begins a file.

    Names are blank where the layout says that there is no header. `InputError` when
    that is no header of at least two columns.
    """
    row, data = _find_line(text, path, layout)
    where = f"{path}, row {row}"
    if len(data) > MAX_HEADER:
        raise InputError(
            f"the header has more than {MAX_HEADER:,} bytes",
            where,
            "export the log as CSV",
        )
    try:
        line = data.decode().strip(" \r")
        separator = layout.separator or _guess_separator(line)
        line = re.sub(" +", " ", line) if separator == " " else line
        names = _split_names(line, separator)
    except (UnicodeDecodeError, csv.Error) as error:
        raise InputError(
            "is not CSV text in UTF-8", path, "export the log as CSV"
        ) from error
    if len(names) < 2:
        raise InputError(
            f"the header {line[:40]!r} is one column",
            where,
            "put commas between columns",
        )
    if layout.header == 0:
        return ("",) * len(names), separator, 1 + layout.skip
    if all(NUMBER.fullmatch(name) for name in names):
        raise InputError(
            "is numbers, not column names", where, "give a header row: time,qx,qy,..."
        )
    return tuple(names), separator, row + 1 + layout.skip


def _find_line(text: bytes, path: str | Path, layout: Layout) -> tuple[int, bytes]:
    """Row of the line that has the names, or else the first numbers, and the line."""
    lead = re.match(rb"(?:[ \t]*+\n)*+", text)
    if lead is None or len(lead[0]) == len(text):
        raise InputError("the file is empty", where=path)
    row = layout.header or 1 + (0 if layout.header == 0 else lead[0].count(b"\n"))
    lines = text.split(b"\n", row)
    if len(lines) < row:
        raise InputError(f"there is no line {row} with the column names", where=path)
    return row, lines[row - 1]


def _split_names(line: str, separator: str) -> list[str]:
    """The names in a line, without the mark of a comment before them."""
    rows = csv.reader([re.sub(r"^#\s*", "", line)], delimiter=separator)
    return [name.strip() for name in next(rows, [])]


def _guess_separator(line: str) -> str:
    """The separator that is there most often; a space where there is none."""
    separator = max(",;\t", key=line.count)
    return separator if separator in line else " "
