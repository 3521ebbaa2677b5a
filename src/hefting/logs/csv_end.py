"""The end of separated text after its last whole row, where a program or the power was
cut, or a program wrote a summary."""

import csv
import re
from pathlib import Path
from typing import BinaryIO

from hefting.core.messages import Message, warning
from hefting.logs.csv_cells import (
    NOTHING,
    NUMBER,
    UTF_16,
    kind_of,
    quote_lists,
    with_lists,
)
from hefting.logs.csv_header import Header, is_numbers, split_cells

MOST_BYTES = 65_536
"""Length of the text at the end that is searched [bytes]."""

MOST_LINES = 20
"""Largest number of lines after the last whole row."""

CUT = re.compile(r"\s*[+-]|\s*[+-]?[\d.]++e[+-]?|p?[\[({].*", re.IGNORECASE)
"""A list, or a number, that was cut: the number before its digits or exponent."""

MOST_NUL = 2**26
"""Longest tail of NUL [bytes], which file systems leave where the power was cut."""


def find_end(
    path: str | Path, header: Header, first_row: str
) -> tuple[int | None, tuple[Message, ...]]:
    """Position [bytes] of the end of the last whole row, and a warning.

    Position None where only blank lines follow, where there are no two whole rows or too
    many lines follow, or where the first row has a cell of more than 128 KiB.
    `first_row` is the first line of data; a whole row has numbers where it has.
    """
    with open(path, "rb") as stream:
        codec = UTF_16.get(stream.read(2), "")
        size = stream.seek(0, 2)
        end = _before_nul(stream, size)
        end += end % 2 if codec else 0
        begin = max(end - MOST_BYTES, 0)
        stream.seek(begin)
        tail = stream.read(end - begin)
    if codec:
        tail = tail.decode(codec, "replace").encode()
    lines = tail.splitlines(keepends=True)
    length = (lambda line: len(line.decode().encode(codec))) if codec else len
    rest: list[str] = []
    is_cut = end < size
    if lines and is_cut and not lines[-1].endswith((b"\n", b"\r")):
        end -= length(lines[-1])  # the incomplete row
        rest = [lines.pop().decode(errors="replace")]
    try:
        first = with_lists(split_cells(first_row, header.separator), header.lists)
    except csv.Error:  # a cell is too long, such as an image
        return None, ()
    found = None
    for line in reversed(lines[begin > 0 :]):
        text = quote_lists(line).decode(errors="replace")
        if text.strip(f" \r\n{header.separator}"):
            whole = _is_whole(text, first, header)
            if found is not None:
                return found if whole else (None, ())
            if whole:
                found = _end_and_warning(end, rest, is_cut)
            elif len(rest) > MOST_LINES or (text.count('"') % 2 and text[-1] in "\r\n"):
                break
            else:
                rest.append(text)
        end -= length(line)
    return None, ()


def _before_nul(stream: BinaryIO, size: int) -> int:
    """Position [bytes] where the zero bytes at the end of a file begin, else its size."""
    end = size
    while end > max(size - MOST_NUL, 0):
        begin = max(end - MOST_BYTES, 0)
        stream.seek(begin)
        if kept := len(stream.read(end - begin).rstrip(b"\0")):
            return begin + kept
        end = begin
    return size


def _end_and_warning(
    end: int, rest: list[str], is_cut: bool
) -> tuple[int | None, tuple[Message, ...]]:
    """The end and a warning of the `rest`, its last line first; None for no rest."""
    if not rest and not is_cut:
        return None, ()
    left = repr(rest[-1].strip()[:40]) if rest else "NUL"
    what = f"left out what follows the last whole row: {left}"
    return end, (warning("end-left-out", what),)


def _is_whole(line: str, first: list[str], header: Header) -> bool:
    """Whether a line is a row like the `first` one, or a row with a mistake: one with
    more cells, or of numbers with a wrong cell, in which it was not cut."""
    try:
        cells = split_cells(line.rstrip("\r\n"), header.separator)
    except csv.Error:
        return False
    cells = with_lists(cells, header.lists)
    if len(cells) != len(header.names):
        return len(cells) > len(header.names)
    as_before = all(
        _is_number(cell, header) or not _is_number(before, header)
        for cell, before in zip(cells, first, strict=False)
    )
    last = cells[-1].replace(header.decimal, ".")
    is_cut = not line.endswith(("\n", "\r")) and CUT.fullmatch(last)
    return as_before or (not is_cut and is_numbers(cells))


def _is_number(cell: str, header: Header) -> bool:
    """Whether a cell can be read as a number or a date, or is blank."""
    number = cell.replace(header.decimal, ".")
    return cell in NOTHING or bool(NUMBER.fullmatch(number) or kind_of(cell))
