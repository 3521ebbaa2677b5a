"""The beginning of a table nobody has described: names, units and numbers of its
columns."""

import csv
import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from hefting.core.errors import InputError
from hefting.core.spatial import Array
from hefting.logs.csv_file import texts
from hefting.logs.csv_header import NUMBER, read_header
from hefting.logs.layout import Layout
from hefting.logs.registry import find_format
from hefting.logs.table_file import check_size

MOST_ROWS = 2000
"""Rows that are looked at."""
MOST_LINES = 3
"""Lines after the header that may be units and the like."""
BRACKETS = re.compile(r"^(.*?)[\s_]*[\[(]([^\[\]()]*[^\[\]()\d][^\[\]()]*)[\])]\s*$")
"""A name with its unit behind it, as in ``Fx [N]``; a number in brackets is none."""


@dataclass(frozen=True, eq=False)
class Sample:
    """Columns of a table."""

    source: str
    names: tuple[str, ...]
    """as the table has them"""
    units: tuple[str, ...]
    """as the header says, empty where it does not"""
    values: Array
    """(R, C) of the first rows, NaN where there is no number"""
    layout: tuple[str, ...] = ()
    """lines of a column map that say how the text is laid out"""

    def words(self, column: int) -> str:
        """The name of a column without its unit."""
        name = self.names[column]
        match = BRACKETS.match(name)
        return match[1] if match else name


def read_sample(path: str | Path) -> Sample:
    """The beginning of the table at `path`. `InputError` where it cannot be read, has
    no named columns, or is no table."""
    found = find_format(path)
    if found is not None and not found.is_table:
        raise InputError(
            f"is a {found.name}, which needs no column map", path, "read it as it is"
        )
    check_size(path)
    if found is None or found.name == "CSV":
        return _of_text(path)
    assert found.open_table is not None
    table = found.open_table(path, None)
    block = next(iter(table.blocks(range(len(table.names)))), None)
    if block is None:
        raise InputError("there are no samples", path)
    columns = [
        np.where(blank, np.nan, block.values[j])
        if blank is not None
        else block.values[j]
        for j, blank in ((j, block.blanks[j]) for j in range(len(table.names)))
    ]
    values = np.stack(columns, axis=1)[:MOST_ROWS]
    return Sample(str(path), table.names, _units(table.names, ()), values)


def _of_text(path: str | Path) -> Sample:
    """The beginning of separated text."""
    text = next(texts(path), b"")
    names, separator, first = read_header(text, path, Layout())
    lines = text.decode(errors="replace").split("\n")[first - 1 : first + MOST_ROWS]
    cells = csv.reader(_merged(lines, separator), delimiter=separator)
    rows = [row for row in cells if len(row) == len(names)]
    decimal = "," if separator != "," and _has_decimal_commas(rows) else "."
    skip = 0
    while skip < min(len(rows), MOST_LINES) and not _is_numbers(rows[skip], decimal):
        skip += 1
    numbers = rows[skip:]
    if not numbers:
        raise InputError("there are no rows of numbers below the header", path)
    values = np.array([[_number(cell, decimal) for cell in row] for row in numbers])
    layout = [f"skip = {skip}"] if skip else []
    layout += ['separator = ";"'] if separator == ";" and decimal == "," else []
    layout += ['decimal = ","'] if decimal == "," else []
    layout += ['nan = "blank"'] if _has_nan(numbers) else []
    below = [cell.strip() for cell in rows[0]] if skip else ()
    return Sample(str(path), names, _units(names, below), values, tuple(layout))


def _merged(lines: Sequence[str], separator: str) -> list[str]:
    """Lines without the blanks around cells that blanks separate."""
    if separator != " ":
        return list(lines)
    return [re.sub(" +", " ", line.strip(" \r")) for line in lines]


def _has_decimal_commas(rows: Sequence[Sequence[str]]) -> bool:
    cells = [cell for row in rows[:100] for cell in row]
    commas = sum(bool(re.fullmatch(r"\s*[+-]?\d*,\d+\s*", cell)) for cell in cells)
    return commas > sum("." in cell for cell in cells)


def _is_numbers(row: Sequence[str], decimal: str) -> bool:
    """Whether most cells of a row can be read, and some are not blank."""
    cells = [cell.replace(decimal, ".") for cell in row if cell.strip()]
    readable = sum(bool(NUMBER.fullmatch(cell)) for cell in cells)
    return bool(cells) and readable > len(cells) / 2


def _has_nan(rows: Sequence[Sequence[str]]) -> bool:
    return any(cell.strip().lower() == "nan" for row in rows for cell in row)


def _number(cell: str, decimal: str) -> float:
    cell = cell.replace(decimal, ".")
    return float(cell) if cell.strip() and NUMBER.fullmatch(cell) else np.nan


def _units(names: Sequence[str], below: Sequence[str]) -> tuple[str, ...]:
    """What stands in brackets behind a name, or below it."""
    said = [BRACKETS.match(name) for name in names]
    under = [cell.strip("[]()") for cell in below] or [""] * len(names)
    return tuple(m[2].strip() if m else u for m, u in zip(said, under, strict=True))
