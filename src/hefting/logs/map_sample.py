"""Beginning of a table without a column map: names, units and numbers of columns."""

import json
import re
from collections.abc import Sequence
from itertools import chain
from pathlib import Path

import numpy as np

from hefting.core.errors import InputError
from hefting.core.files import check_size
from hefting.core.spatial import Array, immutable
from hefting.logs.csv_cells import NUMBER, one_line, seconds_of, with_lists
from hefting.logs.csv_file import CsvTable, open_csv, texts
from hefting.logs.csv_header import Rows, is_numbers, read_header
from hefting.logs.map_groups import ASIDE, OTHER, small_words
from hefting.logs.registry import find_format
from hefting.logs.table import Table
from hefting.logs.units import ALIASES, UNITS, find_unit, squeezed

MOST_ROWS = 2000
"""Largest number of rows."""
BRACKETS = re.compile(
    r"^(?![\s\S]{200})([^\[(].*?)[\s_]*[\[(]([^\[\]()]*[^\[\]()\d][^\[\]()]*)[\])]\s*$"
)
"""A short name with its unit, as in ``Fx [N]``; a number in brackets is no unit."""
UNKNOWN = "is not known"
"""Remark on a unit that is not in `hefting.logs.units.UNITS`."""
NO_UNITS = ASIDE | OTHER | {"base", "world", "robot"}
"""Words in brackets after a name that are no units."""
COUNTS = re.compile(
    rb"(Force|Torque) Units:\W*+(\w[\w-]*+)[\s\S]*?Counts per Unit \1:\W*+([1-9]\d*(?:\.\d+)?)"
)
"""Scales that ATI's programs write above the names, for columns of whole numbers."""
LENGTH = re.compile(rb"\bLength Units,(\w+)")
"""Unit of positions that OptiTrack's Motive writes above the names."""
BY_SIZE = {"length": ("m", "mm", 10.0), "angle": ("rad", "deg", 6.5)}
"""Units of lengths and angles if none is stated: the usual one, and another for numbers
above a size."""


@immutable
class Sample:
    """The first rows of a table's columns."""

    source: str
    names: tuple[str, ...]
    """as the table has them"""
    units: tuple[str, ...]
    """as in the header, empty where it states none"""
    values: Array
    """(R, C) of the first rows, NaN where there is no number"""
    has_nan: bool = False
    """whether some cells are NaN"""
    joined: bool = False
    """whether the names are joined from two lines"""
    dates: tuple[int, ...] = ()
    """columns of dates and times of day, whose values are in seconds"""

    def words(self, column: int) -> str:
        """The name of a column without its unit."""
        name = self.names[column]
        match = BRACKETS.match(name)
        return match[1] if match else name

    def stated_unit(self, columns: Sequence[int], kind: str) -> str | None:
        """The unit of the first column in the header or its name, if of a kind."""
        if self.has_unit(columns[0], kind):
            return find_unit(self.units[columns[0]], kind, self.source).name
        words = small_words(self.names[columns[0]])[1:]
        words = [  # ``in`` of ``tool_in_base_x`` is not inches
            word
            for word, after in zip(words, [*words, ""][1:], strict=True)
            if word != "in" or after not in NO_UNITS
        ]
        known = {squeezed(name): name for name in UNITS[kind] if name != "m"}
        known |= {alias: n for alias, n in ALIASES.items() if n in UNITS[kind]}
        return next((known[word] for word in reversed(words) if word in known), None)

    def has_unit(self, column: int, kind: str) -> bool:
        """Whether the header states a unit of a kind."""
        try:
            return bool(find_unit(self.units[column], kind, self.source))
        except InputError:
            return False

    def unknown_unit(self, columns: Sequence[int]) -> str:
        """A remark on an unknown unit of the first column in the header; else empty."""
        stated = self.units[columns[0]]
        known = not re.search("[A-Za-z]", stated) or stated.lower() in NO_UNITS
        return "" if known else f"its unit {stated[:20]!r} {UNKNOWN}"

    def size(self, columns: Sequence[int]) -> float:
        """99 % quantile of absolute values, which spikes do not affect; 0 for none."""
        values = np.abs(self.values[:, list(columns)])
        values = values[np.isfinite(values)]
        return float(np.quantile(values, 0.99)) if len(values) else 0.0

    def stated_or_by_size(self, columns: Sequence[int], kind: str) -> tuple[str, str]:
        """Unit of lengths or angles by the header, or else their size, and a remark."""
        if (stated := self.stated_unit(columns, kind)) is not None:
            return stated, ""
        usual, other, limit = BY_SIZE[kind]
        size = self.size(columns)
        why = f"by its size, up to {size:.4g}" if size > limit else ""
        remarks = filter(None, (self.unknown_unit(columns), why))
        return (other if why else usual), "; ".join(remarks)

    def toml_name(self, column: int) -> str:
        """A column in a map: its name, or its number where that is not unique or not
        the file's, or has braces or unprintable signs."""
        name = self.names[column]
        if (
            not name
            or self.joined
            or self.names.count(name) > 1
            or "{" in name
            or not name.isprintable()
        ):
            return str(column + 1)
        return json.dumps(name)


def read_sample(path: str | Path) -> Sample:
    """The beginning of the table at `path`. `InputError` where it cannot be read, has
    no named columns, or is no table."""
    found = find_format(path)
    if found is not None and not found.is_table:
        raise InputError(
            f"is a {found.name}, which needs no column map", path, "read it as it is"
        )
    check_size(path)
    opening = open_csv if found is None else found.open_table
    assert opening is not None
    return sample_of(opening(path, None))


def sample_of(table: Table) -> Sample:
    """The beginning of a table; `InputError` where it holds no numbers."""
    if isinstance(table, CsvTable):
        return _of_text(table.source)
    columns = [_first_numbers(table, j) for j in range(len(table.names))]
    rows = max((len(column) for column in columns), default=0)
    if rows == 0:
        raise InputError("there are no samples", table.source)
    values = np.full((rows, len(columns)), np.nan)
    for j, column in enumerate(columns):
        values[: len(column), j] = column
    return Sample(table.source, table.names, _units(table.names, ()), values)


def _first_numbers(table: Table, column: int) -> Array:
    """Values (R,) of a column, NaN where blank; empty for a column without numbers."""
    try:
        block = next(iter(table.blocks([column])), None)
    except InputError:
        block = None
    if block is None:
        return np.zeros(0)
    values, blank = block.values[column], block.blanks[column]
    return (values if blank is None else np.where(blank, np.nan, values))[:MOST_ROWS]


def _of_text(path: str | Path) -> Sample:
    text = one_line(next(texts(path), b""))
    header = read_header(text, path, None)
    names, separator, decimal = header.names, header.separator, header.decimal
    lines = Rows(text.decode(errors="replace").split("\n"), separator, len(names))
    rows = [lines.cells(header.first + k) for k in range(MOST_ROWS)]
    rows = [with_lists(row, header.lists) for row in rows if row]
    rows = [row for row in rows if len(row) == len(names)]
    if not any(is_numbers(row) for row in rows):
        what = "there are no rows of numbers below the header"
        for cell in [c for c in chain(*rows) if np.isnan(_number(c, decimal))][:1]:
            what += f": {cell[:40]!r} is not a number; write numbers in its cells"
        raise InputError(what, path)
    values = np.array([[_number(cell, decimal) for cell in row] for row in rows])
    units = [*_units(names, header.between)]
    for kind, unit, count in COUNTS.findall(text[:9999]):
        for j, name in enumerate(names):
            if re.fullmatch(f"{kind.decode()[0]}[xyz]", name):
                whole = (values[:, j] == np.floor(values[:, j])).all()
                factor = f"{1.0 / float(count):.9g} " if whole else ""
                units[j] = factor + unit.decode()
    for unit in LENGTH.findall(text[:9999]):
        for j, name in enumerate(names):
            if re.search(r"\bPosition [XYZ]$", name):
                units[j] = units[j] or unit.decode()
    has_nan = any(cell.lower() == "nan" for row in rows for cell in row)
    dates = (*header.dates,)
    return Sample(str(path), names, (*units,), values, has_nan, header.joined, dates)


def _number(cell: str, decimal: str) -> float:
    """A number, or a date [s], in a cell; else NaN."""
    if (date := seconds_of(cell)) is not None:
        return date
    cell = cell.replace(decimal, ".")
    return float(cell) if cell.strip() and NUMBER.fullmatch(cell) else np.nan


def _units(names: Sequence[str], below: Sequence[str]) -> tuple[str, ...]:
    """Units in brackets after each name, or else in the line below."""
    after = [BRACKETS.match(name) for name in names]
    under = [cell.strip("[]()") for cell in below] or [""] * len(names)
    return tuple(m[2].strip() if m else u for m, u in zip(after, under, strict=True))
