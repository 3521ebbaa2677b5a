"""LabVIEW's text measurement files (``.lvm``) as separated text: a line of names with
units, rows of numbers, and else blank lines."""

from collections.abc import Iterator
from itertools import chain
from pathlib import Path

from hefting.core.errors import InputError
from hefting.logs.csv_times import seconds_of

MARK = b"LabVIEW Measurement"
"""How such a file begins."""
NAMES = b"X_Value"
"""How the line of names begins, in each segment anew."""
TAGS = b"Y_Unit_Label X_Columns X_Dimension Delta_X Date Time".split()
"""How lines above the names begin that are read."""


def as_table(texts: Iterator[bytes], path: str | Path) -> Iterator[bytes]:
    """Text in blocks of whole lines; that of LabVIEW line by line as a table.

    Times that are not written are counted by ``Delta_X``; a later segment that begins as
    the first does is later by its ``Date`` and ``Time``. `InputError` unless there is one
    time for all channels.
    """
    begin = next(texts, b"")
    texts = chain((begin,), texts)
    if not begin.startswith(MARK):
        return texts
    read = _Lines(path).read
    return (b"\n".join(map(read, text.split(b"\n"))) for text in texts)


class _Lines:
    """Lines of a file, one after the other."""

    def __init__(self, path: str | Path):
        self.path = path
        self.separator = b"\t"
        self.tags = {tag: [b""] for tag in TAGS}
        self.width = 0
        """of the table; 0 before its names"""
        self.rows = 0
        """of the segment"""
        self.first: tuple[bytes, float] | None = None
        """time as written, and when it was [s], of the first row"""
        self.shift = 0.0
        """[s] of the segment's times"""

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
        """Of the channels, with their units."""
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
        """A row, whose time is that of the whole file."""
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
    """A number; NaN for what is none, which is told where it is read."""
    try:
        return float(cell.replace(b",", b"."))
    except ValueError:
        return float("nan")
