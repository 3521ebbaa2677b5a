"""CSV: separated text with a header row, read block by block, never as a whole."""

import contextlib
import csv
import io
import os
import re
import sys
import warnings
from collections.abc import Generator, Iterator, Mapping, Sequence
from dataclasses import field, replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from hefting.core.errors import InputError
from hefting.core.files import write_atomically
from hefting.core.messages import Message
from hefting.core.progress import report
from hefting.core.recording import Recording
from hefting.core.spatial import Array, Mask, immutable
from hefting.logs.canonical import csv_of, table_from_recording
from hefting.logs.csv_cells import (
    NOTHING,
    NUMBER,
    WRITTEN,
    Midnights,
    by_iso,
    count_lines,
    in_columns,
    kind_of,
    merge_spaces,
    one_line,
    quote_lists,
    recoder,
    unify_line_ends,
)
from hefting.logs.csv_end import find_end
from hefting.logs.csv_header import read_header
from hefting.logs.layout import Layout
from hefting.logs.lvm_text import as_table
from hefting.logs.registry import READING, Format
from hefting.logs.table import Block, label

if TYPE_CHECKING:
    import pyarrow as pa

BLOCK = 8 * 2**20
"""Largest text in memory, and longest row [bytes]."""

READ = 2**22
"""Text that is read at a time [bytes]; with less, the overhead of blocks dominates."""

SHORT = 1_000_000
"""Size [bytes] of files up to which NumPy reads numbers: six times slower than pyarrow,
without the time to import that."""

PLAIN = b"0123456789.eE+-,\n"
"""Characters of plain numbers between commas."""

BLANKS = [" " * n for n in range(33)]
"""Blank cells: up to 32 spaces."""


@immutable
class CsvTable:
    """A CSV file after its header was read; rows are lines of the file, from 1."""

    source: str
    names: tuple[str, ...]
    separator: str
    first: int
    """line of the first row of data, from 1"""
    decimal: str = "."
    dates: Mapping[int, str] = field(default_factory=dict)
    """columns of dates and times of day, read as seconds, and their kind of
    `hefting.logs.csv_cells`"""
    other_way: bool = False
    """whether dates and times are written in another way than by ISO 8601"""
    lists: Mapping[int, int] = field(default_factory=dict)
    """number of numbers of each column of lists; they have columns after the others"""
    end: int | None = None
    """position of the end of the last row [bytes]; None: the end of the file"""
    warnings: tuple[Message, ...] = ()
    """about the rest of the file"""

    @property
    def width(self) -> int:
        """Number of cells of a row in the file."""
        return len(self.names) - sum(self.lists.values())

    def blocks(self, columns: Sequence[int]) -> Iterator[Block]:
        """The rows block by block; see `hefting.logs.table.Table`."""
        clocks = {j: Midnights() for j in columns if self.dates.get(j) == "time of day"}
        for block in self._blocks(columns):
            unfolded = {
                j: clock.unfold(block.values[j], block.blanks[j])
                for j, clock in clocks.items()
            }
            yield replace(block, values={**block.values, **unfolded})

    def _blocks(self, columns: Sequence[int]) -> Iterator[Block]:
        before, short = 0, Path(self.source).stat().st_size <= SHORT
        blocks = texts(self.source, self.end)
        if self.lists:
            how = self.lists, self.first, self.width, (self.separator, self.decimal)
            blocks = in_columns(blocks, *how, self.source)
        for text in blocks:
            if before < self.first - 1:
                count = count_lines(text)
                skipped = min(self.first - 1 - before, count)
                text = text.split(b"\n", skipped)[-1] if skipped < count else b""
                before += skipped
            if not text:
                continue
            if short and (block := self._read_plain(text, before, columns)) is not None:
                yield block
                before += len(block.rows)
            else:
                before += yield from self._read_blocks(text, before, columns)

    def _read_plain(
        self, text: bytes, before: int, columns: Sequence[int]
    ) -> Block | None:
        """The rows in a short text if all its cells are plain numbers, else None; this
        avoids the import of pyarrow."""
        if self.separator != "," or self.decimal != "." or text.translate(None, PLAIN):
            return None
        marks = np.frombuffer(text if text.endswith(b"\n") else text + b"\n", np.uint8)
        marks = marks[(marks == ord(",")) | (marks == ord("\n"))]
        width = len(self.names)
        if len(marks) % width:
            return None
        ends = marks.reshape(-1, width) == ord("\n")
        if not ends[:, -1].all() or ends[:, :-1].any():
            return None
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            try:
                values = np.fromstring(text.replace(b"\n", b","), sep=",")
            except (DeprecationWarning, ValueError):
                return None
        if len(values) != len(marks):
            return None
        values = values.reshape(-1, width)
        rows = np.arange(before + 1, before + 1 + len(values))
        return Block(rows, {j: values[:, j] for j in columns}, dict.fromkeys(columns))

    def _read_blocks(
        self, text: bytes, before: int, columns: Sequence[int]
    ) -> Generator[Block, None, int]:
        """The rows in `text`, which follows `before` lines, and its number of lines."""
        import pyarrow as pa

        if self.other_way:
            words = text.decode(errors="surrogateescape")
            text = by_iso(words, self.separator).encode(errors="surrogateescape")
        if self.separator == " ":
            text = merge_spaces(text)
        if not text.lstrip(b"\n"):
            return len(text)
        table = None
        if b'"' not in text:  # each line must be a row
            with contextlib.suppress(pa.ArrowInvalid):
                table = self._parse_rows(text, columns, skip_empty=False)
        if table is not None:
            lines = table.num_rows
            rows = np.arange(before + 1, before + 1 + lines)
        else:
            try:
                table = self._parse_rows(text, columns, skip_empty=True)
            except pa.ArrowInvalid as error:
                raise self._explain_first_bad_cell(
                    text, before, columns, error
                ) from error
            lines = count_lines(text)
            rows = np.arange(before + 1, before + 1 + lines)
            if table.num_rows != lines:  # pyarrow has skipped empty lines
                ends = np.flatnonzero(np.frombuffer(text, dtype=np.uint8) == ord("\n"))
                lengths = np.diff(np.append(ends, len(text)), prepend=-1)[:lines]
                rows = rows[: len(ends) + 1][lengths > 1]
            if len(rows) != table.num_rows:
                what = "a quoted cell goes over several lines"
                raise InputError(what, self.source, "write each row on one line")
        first = 0
        for batch in table.to_batches():
            last = first + len(batch)
            arrays = dict(zip(columns, batch.columns, strict=True))
            yield Block(
                rows[first:last],
                {j: _values_of(array) for j, array in arrays.items()},
                {j: _blanks_of(array) for j, array in arrays.items()},
            )
            first = last
        return lines

    def _parse_rows(
        self, text: bytes, columns: Sequence[int], skip_empty: bool
    ) -> "pa.Table":
        import pyarrow as pa
        from pyarrow import csv as pacsv

        labels = [str(j) for j in columns]
        kinds = {label: pa.float64() for label in labels}
        of_dates = {
            "date": pa.timestamp("ns"),
            "date with zone": pa.timestamp("ns", tz="UTC"),
            "time of day": pa.time64("ns"),
        }
        kinds |= {str(j): of_dates[kind] for j, kind in self.dates.items()}
        return pacsv.read_csv(
            pa.BufferReader(text),
            read_options=pacsv.ReadOptions(
                column_names=[str(j) for j in range(len(self.names))]
            ),
            parse_options=pacsv.ParseOptions(
                delimiter=self.separator, ignore_empty_lines=skip_empty
            ),
            convert_options=pacsv.ConvertOptions(
                column_types=kinds,
                include_columns=labels,
                null_values=[*BLANKS, *NOTHING],
                quoted_strings_can_be_null=True,
                decimal_point=self.decimal,
            ),
        )

    def _explain_first_bad_cell(
        self, text: bytes, before: int, columns: Sequence[int], error: Exception
    ) -> InputError:
        """The error for the first row that cannot be read, found by a slower reading."""
        for row, line in enumerate(io.BytesIO(text), before + 1):
            line = line.rstrip(b"\n")
            if not line:
                continue
            where = f"{self.source}, row {row}"
            try:
                words = [line.decode(errors="replace")]
                cells = next(csv.reader(words, delimiter=self.separator))
            except csv.Error as reason:
                return InputError(
                    f"is no row of cells ({reason})", where, "export the log as CSV"
                )
            if tuple(cell.strip() for cell in cells) == self.names:
                what = "the column names stand there again: another recording begins"
                return InputError(what, where, "cut the log in two, and give both")
            if len(cells) != len(self.names):
                what = f"there are {len(cells)} cells under {self.width} column names"
                fix = "give each row one cell a column, blank if not measured"
                return InputError(what, where, fix)
            for j in columns:
                wrong = self._explain_cell(cells[j], j, where)
                if wrong is not None:
                    return wrong
        return InputError(
            f"cannot be read as CSV ({str(error)[:200]})", where=self.source
        )

    def _explain_cell(self, text: str, column: int, where: str) -> InputError | None:
        """The error for a cell of a column; None where it can be read."""
        fix = "give a number, or leave the cell blank"
        what = f"{text[:40]!r} is not a number"
        if column in self.dates:
            kind = self.dates[column]
            if not text.strip() or kind_of(text) == kind:
                return None
            what = f"{text[:40]!r} is no {kind.removesuffix(' with zone')} like those before"
            fix = f"write each as {WRITTEN}"
        else:
            number = text
            if self.decimal == ",":
                number = text.replace(".", "?").replace(",", ".")
            if NUMBER.fullmatch(number) or text in NOTHING:
                return None
            if re.search(r"\d[:/]\d", text):
                fix = f"write times in seconds, or as {WRITTEN}"
            if re.fullmatch(r"\s*[+-]?\d+([., ']\d{3})+[.,]\d*\s*", text):
                fix = "write numbers without marks between thousands"
            if self.decimal == "." and re.fullmatch(r"\s*[+-]?\d+,\d*\s*", text):
                fix = (
                    'write decimals with a point, or give decimal = "," in a column map '
                    "(`column_map`=FILE)"
                )
        return InputError(what, f"{where}, column {label(self, column)}", fix)


def _values_of(array: "pa.Array") -> Array:
    """Values (R,) of a column of numbers, or of dates and times [s]; arbitrary where
    blank. `to_numpy` of pyarrow would import pandas."""
    import pyarrow as pa

    dates = pa.types.is_temporal(array.type)
    values = np.frombuffer(
        array.buffers()[1],
        dtype=np.int64 if dates else float,
        count=len(array),
        offset=8 * array.offset,
    )
    return values / 1e9 if dates else values


def _blanks_of(array: "pa.Array") -> Mask | None:
    """Mask (R,) of blank cells; None for none."""
    if not array.null_count:
        return None
    bits = np.frombuffer(array.buffers()[0], dtype=np.uint8)
    known = np.unpackbits(bits, bitorder="little")[
        array.offset : array.offset + len(array)
    ]
    return known == 0


def open_csv(path: str | Path, layout: Layout | None = None) -> CsvTable:
    """The CSV file at `path`. `InputError` without a header of two or more columns."""
    text = one_line(next(texts(path), b""))
    header = read_header(text, path, layout)
    first_row = b"".join(text.split(b"\n", header.first)[header.first - 1 :][:1])
    return CsvTable(
        str(path),
        header.names,
        header.separator,
        header.first,
        header.decimal,
        header.dates,
        header.other_way,
        header.lists,
        *find_end(path, header, first_row.decode(errors="replace")),
    )


def texts(path: str | Path, end: int | None = None) -> Iterator[bytes]:
    """The text of a file, LabVIEW's as a table, with lists in quotes; see `_texts`."""
    return map(quote_lists, as_table(_texts(path, end), path))


def _texts(path: str | Path, end: int | None) -> Iterator[bytes]:
    """The text of a file up to byte `end` as UTF-8, in blocks of whole lines that end in
    \\n, without byte-order mark. `InputError` for binary files and lines over `BLOCK`."""
    rest, held = b"", b""
    with open(path, "rb", buffering=0) as stream:
        size = os.fstat(stream.fileno()).st_size
        last = sys.maxsize if end is None else end
        recode = None
        while data := stream.read(min(READ, BLOCK, last - stream.tell())):
            report(READING, stream.tell() / max(size, 1))
            begun, recode = recode is not None, recode or recoder(data)
            data = recode(data)
            if not begun:
                if b"\0" in data[:64] or b"\0" in data[:65536].rstrip(b"\0"):
                    fix = "export the log as CSV in UTF-8"
                    raise InputError("is binary, not CSV text", path, fix)
                data = data.removeprefix(b"\xef\xbb\xbf")
            data = held + data
            # it may be half of a line end
            held = b"\r" if data.endswith(b"\r") else b""
            data = unify_line_ends(data.removesuffix(held))
            if cut := data.rfind(b"\n") + 1:
                yield b"".join((rest, memoryview(data)[:cut]))
                rest = data[cut:]
            elif len(rest := rest + data) > BLOCK:
                what = f"has a line of more than {BLOCK:,} bytes"
                raise InputError(what, path, "export the log as CSV")
    if rest or held:
        yield unify_line_ends(rest + held)


def write_csv(recording: Recording, path: str | Path) -> tuple[str, ...]:
    """Write canonical CSV, each number with the fewest digits that give back the same
    bits; all streams fit."""
    write_atomically(path, csv_of(table_from_recording(recording)))
    return ()


FORMAT = Format(
    name="CSV",
    description="CSV with the columns below, or others by name or column map",
    suffixes=(".csv", ".txt", ".tsv", ".dat", ".log", ".lvm"),
    help_names=(".csv",),
    open_table=open_csv,
    written=(".csv",),
    write=write_csv,
)
"""Separated text with a header row."""
