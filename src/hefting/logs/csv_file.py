"""Canonical CSV: comma, semicolon or tab separated text with one header row."""

import csv
import io
import re
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from hefting.errors import InputError
from hefting.files import write_atomically
from hefting.logs.canonical import MAX_CELLS, known_columns, recording_from_table, table_from_recording
from hefting.recording import Recording

BLANKS = [" " * n for n in range(33)]
NUMBER = re.compile(r"\s*([+-]?(\d+\.?\d*|\.\d+)(e[+-]?\d+)?|[+-]?(nan|inf|infinity))?\s*", re.IGNORECASE)


def read_csv(path: str | Path) -> Recording:
    """Recording in a CSV file; see `hefting.logs.read_log`."""
    import pyarrow as pa
    from pyarrow import csv as pacsv

    text = _text(path)
    names, separator, header_row, start = _header(text, path)
    body = memoryview(text)[start:] or memoryview(b"\n")
    groups, warnings = known_columns(names, path)
    columns = [name for name in names if name == "time" or any(name in group for group in groups.values())]
    lines = text.count(b"\n", start) + (not text.endswith(b"\n"))
    if lines * len(columns) > MAX_CELLS:
        raise InputError(f"has {lines} rows, too many to read", path, "cut out the part of interest")
    labels = [name or f" {i}" for i, name in enumerate(names)]  # names without a name must differ
    try:
        table = pacsv.read_csv(
            pa.BufferReader(body),
            read_options=pacsv.ReadOptions(column_names=labels),
            parse_options=pacsv.ParseOptions(delimiter=separator),
            convert_options=pacsv.ConvertOptions(
                column_types=dict.fromkeys(columns, pa.float64()),
                include_columns=columns,
                null_values=BLANKS,
                quoted_strings_can_be_null=True,
            ),
        )
    except pa.ArrowInvalid as error:
        raise _first_bad_cell(body, names, columns, separator, header_row, path, error) from error
    if table.num_rows == lines:
        rows = np.arange(header_row + 1, header_row + 1 + lines)
    else:
        rows = header_row + _filled_lines(body)
    if len(rows) != table.num_rows:
        raise InputError("a quoted cell goes over several lines", path, "write each row on one line")
    return recording_from_table(table, groups, rows, path, warnings)


def write_csv(recording: Recording, path: str | Path) -> None:
    """Write canonical CSV, each number with the fewest digits that give back the same bits."""
    from pyarrow import csv as pacsv

    table = table_from_recording(recording)
    stream = io.BytesIO()
    stream.write((",".join(table.column_names) + "\n").encode())
    pacsv.write_csv(table, stream, pacsv.WriteOptions(include_header=False))
    write_atomically(path, stream.getvalue())


def _text(path: str | Path) -> bytes:
    """The file's bytes without byte-order mark, lines ending in \\n; `InputError` when it is not text."""
    data = Path(path).read_bytes()
    if data[:2] in (b"\xff\xfe", b"\xfe\xff"):
        raise InputError("is UTF-16 text", path, "save it as UTF-8")
    if b"\0" in data[:65536]:
        raise InputError("is binary, not CSV text", path, "export the log as CSV")
    data = data.removeprefix(b"\xef\xbb\xbf")
    return data.replace(b"\r\n", b"\n").replace(b"\r", b"\n") if b"\r" in data else data


def _header(text: bytes, path: str | Path) -> tuple[list[str], str, int, int]:
    """Column names, separator, row of the header, and where the text after it begins."""
    begin = len(re.match(rb"(?:[ \t]*+\n)*+", text)[0])  # type: ignore[index]
    if begin == len(text):
        raise InputError("the file is empty", where=path)
    end = text.find(b"\n", begin) % (len(text) + 1)  # the end of the text when there is no other line
    row = 1 + text.count(b"\n", 0, begin)
    try:
        line = text[begin : min(end, begin + (1 << 20))].decode()
        separator = max(",;\t", key=line.count)
        names = [name.strip() for name in next(csv.reader([line], delimiter=separator))]
    except (UnicodeDecodeError, csv.Error) as error:
        raise InputError("is not CSV text in UTF-8", path, "export the log as CSV") from error
    if len(names) == 1:
        raise InputError(f"the header {line[:40]!r} is one column", f"{path}, row {row}", "put commas between columns")
    if all(NUMBER.fullmatch(name) for name in names):
        raise InputError("is numbers, not column names", f"{path}, row {row}", "give a header row: time,qx,qy,...")
    return names, separator, row, end + 1


def _filled_lines(body: memoryview) -> NDArray[np.int64]:
    """Numbers, from 1, of the lines that are not empty: empty ones are no samples."""
    ends = np.flatnonzero(np.frombuffer(body, dtype=np.uint8) == ord("\n"))
    lengths = np.diff(np.append(ends, len(body)), prepend=-1) - 1
    return 1 + np.flatnonzero(lengths)


def _first_bad_cell(body, names, columns, separator, header_row, path, error) -> InputError:
    """What is wrong with the first row that cannot be read, found by reading again slowly."""
    wanted = [j for j, name in enumerate(names) if name in columns]
    for row, line in enumerate(io.BytesIO(body), header_row + 1):
        line = line.rstrip(b"\n")
        if not line:
            continue
        try:
            cells = next(csv.reader([line.decode(errors="replace")], delimiter=separator))
        except csv.Error as reason:
            return InputError(f"is no row of cells ({reason})", f"{path}, row {row}", "export the log as CSV")
        if len(cells) != len(names):
            what = f"there are {len(cells)} cells under {len(names)} column names"
            return InputError(what, f"{path}, row {row}", "give each row one cell a column, blank if not measured")
        for j in wanted:
            if not NUMBER.fullmatch(cells[j]):
                comma = re.fullmatch(r"\s*[+-]?\d+,\d*\s*", cells[j])
                fix = "write decimals with a point" if comma else "give a number, or leave the cell blank"
                return InputError(f"{cells[j][:40]!r} is not a number", f"{path}, row {row}, column {names[j]}", fix)
    return InputError(f"cannot be read as CSV ({str(error)[:200]})", where=path)
