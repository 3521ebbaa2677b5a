"""LabVIEW's text measurement files (``.lvm``) as separated text: a line of names with
units, and rows of numbers; all other lines become blank."""

from collections.abc import Iterator
from itertools import chain
from pathlib import Path

from hefting.core.errors import InputError
from hefting.logs.csv_cells import seconds_of

MARK = b"LabVIEW Measurement"
"""Beginning of such a file."""
NAMES = b"X_Value"
"""Beginning of the line of names, which each segment has."""
TAGS = b"Y_Unit_Label X_Columns X_Dimension Delta_X Date Time".split()
"""First cells of the lines above the names that are read."""


def as_table(texts: Iterator[bytes], path: str | Path) -> Iterator[bytes]:
    """Text in blocks of whole lines; LabVIEW's files as a table, other text unchanged.

    Absent times are multiples of ``Delta_X``. A later segment whose first time is that of
    the first segment is shifted by its ``Date`` and ``Time``. `InputError` unless all
    channels have one time.
    """
    begin = next(texts, b"")
    texts = chain((begin,), texts)
    if not begin.startswith(MARK):
        return texts
    read = _Lines(path).read
    return (b"\n".join(map(read, text.split(b"\n"))) for text in texts)


class _Lines:
    """Converts the lines of a file, one after the other."""

    def __init__(self, path: str | Path):
        self.path = path
        self.separator = b"\t"
        self.tags = {tag: [b""] for tag in TAGS}
        self.width = 0
        """number of columns; 0 before the names"""
        self.rows = 0
        """number of rows of the segment"""
        self.first: tuple[bytes, float] | None = None
        """of the first row: time as written, and the segment's date [s]"""
        self.shift = 0.0
        """shift [s] of the segment's times"""

    def read(self, line: bytes) -> bytes:
        """A line of the table."""
        cells = line.split(self.separator)
        if cells[0] == NAMES:
            self.rows = 0
            return b"" if self.width else self._names(cells)
        if line[:1].isalpha() or line[:1] == b"*":
            self.separator = b"," if line.startswith(b"Separator,") else self.separator
            if cells[0] in self.tags:
                self.tags[cells[0]] = [*cells[1:], b""]
        elif self.width and line.strip():
            return self._numbers(cells)
        return b""

    def _names(self, cells: list[bytes]) -> bytes:
        """The line of names of the channels, with their units."""
        kind = {*self.tags[b"X_Columns"], *self.tags[b"X_Dimension"]}
        if kind - {b"", b"No", b"One", b"Time"}:
            fix = "save it with one X column, of the time"
            raise InputError("has no one time for all channels", self.path, fix)
        self.width = len(cells) - (cells[-1] in (b"", b"Comment"))
        units = [b"s", *self.tags[b"Y_Unit_Label"], *[b""] * self.width]
        pairs = zip(cells[: self.width], units, strict=False)
        named = (name + b" [%b]" % unit if unit else name for name, unit in pairs)
        return self.separator.join(named)

    def _numbers(self, cells: list[bytes]) -> bytes:
        """A row, with its time since the beginning of the file."""
        step = self.tags[b"Delta_X"][0]
        if not self.rows:
            self._begin_segment(cells[0])
        if self.shift or not cells[0]:
            time = _float(cells[0]) if cells[0] else self.rows * _float(step)
            written = str(self.shift + time).encode()
            cells[0] = written.replace(b".", b"," if b"," in step else b".")
        self.rows += 1
        return self.separator.join(cells[: self.width])

    def _begin_segment(self, time: bytes) -> None:
        stamp = b" ".join((self.tags[b"Date"][0], self.tags[b"Time"][0][:15]))
        date = seconds_of(stamp.decode(errors="replace").replace(",", ".")) or 0.0
        self.first = self.first or (time, date)
        if time == self.first[0]:
            self.shift = date - self.first[1]


def _float(cell: bytes) -> float:
    """A number; NaN for another cell, which the reader of the table refuses."""
    try:
        return float(cell.replace(b",", b"."))
    except ValueError:
        return float("nan")
