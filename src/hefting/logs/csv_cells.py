"""Lines and cells of separated text: numbers, blanks, lists of numbers in cells, and dates
and times of day as seconds."""

import codecs
import csv
import io
import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from datetime import UTC, datetime
from itertools import islice

import numpy as np

from hefting.core.errors import InputError
from hefting.core.spatial import Array, Mask
from hefting.logs.table import LONGEST_LIST

NUMBER = re.compile(
    r"\s*+([+-]?(\d++(\.\d*+)?|\.\d++)(e[+-]?\d+)?|[+-]?(nan|inf|infinity))?\s*",
    re.IGNORECASE,
)
"""A cell that can be read: a decimal number, nan, infinity or nothing, with blanks
around it. It matches in linear time."""

NOTHING = ("N/A", "n/a", "NA", "<NA>", "null", "NULL", "None")
"""Cells that programs write where nothing was measured."""

WORDS = re.compile(r"\b(np\.)?(array|float\d\d)(?=\()|,\s*dtype=\w+(?=\)$)")
"""Words that NumPy writes around numbers."""

UNQUOTED = re.compile(
    rb"(?<![^,;\t\n ])p?[\[({](?=\s*[-+.\d\[(])"
    rb"(?:[^\[\](){}\n]|[\[(][^\[\]()\n]*[\])])*[\])}](?![^,;\t\n ])"
)
"""A list as a whole cell without quotes, as Python prints it, or a pose of URScript:
``p[0.1, ...]``."""

MARKS = str.maketrans("[](){},", 7 * " ")
"""Replaces the marks around and between numbers by blanks."""

SEVERAL_LINES = re.compile(rb'"(?:array\()?[\[(][-+.,=\s\w\[\]()]*"')
"""A list in quotes, which NumPy may write on several lines."""

UTF_16 = {b"\xff\xfe": "utf-16-le", b"\xfe\xff": "utf-16-be"}
"""Encodings of text by the mark at its beginning, as Excel and PowerShell write it; other
text is UTF-8."""

ENOUGH, ESCAPE = 2**20, "surrogateescape"
"""Size of the pieces of text [bytes], and how bytes that are no UTF-8 are read."""


def list_in(cell: str) -> list[str]:
    """The numbers of a cell with a list, nested or not, or with at least three numbers
    between blanks; empty for another cell."""
    cell, fewest = cell.strip().removeprefix("p"), 3
    if cell[-1:] in ("]", ")", "}"):
        cell = cell.replace("None", "nan")
        cell = WORDS.sub("", cell) if "(" in cell[1:] else cell
        cell, fewest = cell.translate(MARKS) if cell[0] in "[({" else "", 2
    items = cell.split() if " " in cell else []
    if not fewest <= len(items) <= LONGEST_LIST:
        return []
    try:
        return items if [*map(float, items)] else []
    except ValueError:
        return []


def lists_of(rows: Sequence[Sequence[str]], width: int) -> dict[int, int]:
    """Length of the list in the first cell that is not blank, by column with one."""
    found = {}
    for j in range(width):
        cells = (
            row[j] for row in rows if j < len(row) and row[j] not in ("", *NOTHING)
        )
        found[j] = len(list_in(next(cells, "")))
    return {j: count for j, count in found.items() if count}


def with_lists(cells: list[str], lists: Mapping[int, int]) -> list[str]:
    """A row with the numbers of its lists appended, as many for each column as `lists`
    says. These are blank for a blank cell, and copies of the cell, which cannot be read
    as numbers, for a list of another length."""
    row = [*cells]
    for j, count in lists.items():
        cell = "".join(cells[j : j + 1])
        numbers = list_in(cell)
        blank = cell.strip() in ("", "[]", "nan", *NOTHING)
        row += numbers if len(numbers) == count else ["" if blank else cell] * count
    return row


def count_lines(text: bytes) -> int:
    """Number of lines of a text, of which the last may have no line end."""
    return text.count(b"\n") + (not text.endswith(b"\n"))


def unify_line_ends(text: bytes) -> bytes:
    """Text with \\n for all line ends."""
    return text.replace(b"\r\n", b"\n").replace(b"\r", b"\n") if b"\r" in text else text


def recoder(begin: bytes) -> Callable[[bytes], bytes]:
    """Converts successive pieces of a text that begins so to UTF-8."""
    if begin[:2] not in UTF_16:
        return bytes
    decoder = codecs.getincrementaldecoder("utf-16")("replace")
    return lambda piece: decoder.decode(piece).encode()


def merge_spaces(text: bytes) -> bytes:
    """Text with one space for each run of spaces, and none at both ends of lines."""
    if (
        b"  " in text
        or b"\n " in text
        or b" \n" in text
        or text[:1] == b" "
        or text[-1:] == b" "
    ):
        text = (
            re.sub(b" +", b" ", text)
            .replace(b"\n ", b"\n")
            .replace(b" \n", b"\n")
            .strip(b" ")
        )
    return text


def quote_lists(text: bytes) -> bytes:
    """Text with quotes around each list, if it has no quotes."""
    if b'"' in text or not any(mark in text for mark in (b"[", b"(", b"{")):
        return text
    text = re.sub(rb", (?=p?[\[({])", b",", text)
    return UNQUOTED.sub(rb'"\g<0>"', text)


def one_line(text: bytes) -> bytes:
    """Text with each list on one line."""

    def join(found: re.Match[bytes]) -> bytes:
        return found[0].replace(b"\n", b" ")

    return SEVERAL_LINES.sub(join, text) if b'"' in text else text


def in_columns(
    texts: Iterator[bytes],
    lists: Mapping[int, int],
    first: int,
    width: int,
    written: tuple[str, str],
    source: str,
) -> Iterator[bytes]:
    """Text with the numbers of lists appended to each row, in the line in which the row
    begins.

    `first` is the number of the first line, `width` the number of cells of a row, and
    `written` separator and decimal mark. `InputError` for a cell that is too long.
    """
    separator, decimal = written
    lines = (line for t in texts for line in io.StringIO(t.decode(errors=ESCAPE)))
    out, last = io.StringIO(), 0
    out.writelines("\n" for _ in islice(lines, first - 1))
    writer = csv.writer(out, delimiter=separator, lineterminator="\n")
    rows = csv.reader(lines, delimiter=separator)
    try:
        for cells in rows:
            row = with_lists(cells, lists) if len(cells) == width else cells
            plain = [
                "0" if j in lists else cell.replace("\n", " ")
                for j, cell in enumerate(cells)
            ]
            writer.writerow(
                plain + [n.replace(".", decimal) for n in row[len(cells) :]]
            )
            out.write("\n" * (rows.line_num - last - 1))
            last = rows.line_num
            if out.tell() > ENOUGH:
                yield out.getvalue().encode(errors=ESCAPE)
                out.seek(out.truncate(0))
    except csv.Error as error:
        where = f"{source}, row {first + last}"
        raise InputError(f"is no row of cells ({error})", where) from error
    yield out.getvalue().encode(errors=ESCAPE)


DATE = re.compile(
    r"\s*\d{4}-\d\d-\d\d[T ]\d\d:\d\d(:\d\d(\.\d+)?)?(?P<zone>Z|[+-]\d\d:?\d\d)?\s*"
)
"""A date with a time of day in ISO 8601."""

TWELVE = re.compile(
    r"\b(\d\d?)(:\d\d:[\d.,:]+)[ \u202f]?([AP])\.?M\b\.?", re.IGNORECASE
)
"""A time of day in twelve hours: 1:31:07 PM."""

OTHER_WAYS = (
    (
        r"\b(?:0 days |(?:\d\d?([/-])\d\d?\1\d{4}|\d{8}|\d\d-[A-Z][a-z]{2}-\d{4}"
        r"|[A-Z][a-z]{2} \d\d?, \d{4},?)[T ])(?=\d\d?:)|(?<=\d) sec\b",
        "",
    ),
    (r"\b(\d\d)\.(\d\d)\.(\d{4})(?=[T ]\d\d?:)", r"\3-\2-\1"),
    (r"\b(\d{4})/(\d\d)/(\d\d)(?=[T ]\d\d?:)", r"\1-\2-\3"),
    (r"(?<![\d:.])(\d:\d\d:\d\d)", r"0\1"),
    (r"(?<![\d:.])(\d\d:\d\d\.\d)", r"00:\1"),
    (r"\b(\d\d:\d\d:\d\d):(\d{1,9})\b", r"\1.\2"),
)
"""Patterns of other dates and times of day, and their replacement in ISO 8601:
31.01.2026, 2026/01/31, pandas' ``0 days 00:00:01``, MATLAB's ``0.01 sec``, 9:05:00,
Excel's 05:01.2 of minutes and seconds, and 12:00:00:123. The date is dropped, and the
time of day kept, of 3/4/2026, where day or month may come first, of 20260131, MATLAB's
31-Jan-2026 and Java's Jan 31, 2026."""

WITH_COMMA = (r"(:\d\d),(\d{1,9})\b", r"\1.\2")
"""The same for 12:00:00,123, where commas do not separate cells."""

TIME_OF_DAY = re.compile(r"\s*([01]\d|2[0-3]):([0-5]\d):([0-5]\d(\.\d{1,9})?)\s*")
"""A time of day without a date."""

YEARS = range(1678, 2262)
"""Years whose nanoseconds since 1970 fit into 64 bits."""

DAY = 86_400.0
"""[s]"""

WRITTEN = "2026-01-31T12:00:00.000, or 12:00:00.000"
"""Examples of readable times, for messages."""


def kind_of(cell: str) -> str:
    """Kind of a cell: "date", "date with zone", "time of day", or empty for others."""
    if TIME_OF_DAY.fullmatch(by_iso(cell)):
        return "time of day"
    if seconds_of(cell) is None:
        return ""
    zone = DATE.fullmatch(by_iso(cell))["zone"]  # type: ignore[index]
    return "date with zone" if zone else "date"


def seconds_of(cell: str) -> float | None:
    """A date in seconds since 1970, a time of day since midnight; None for others."""
    cell = by_iso(cell)
    if time := TIME_OF_DAY.fullmatch(cell):
        return 3600.0 * int(time[1]) + 60.0 * int(time[2]) + float(time[3])
    if not DATE.fullmatch(cell):
        return None
    try:
        date = datetime.fromisoformat(cell.strip())
    except ValueError:  # such as month 13
        return None
    date = date if date.tzinfo else date.replace(tzinfo=UTC)
    return date.timestamp() if date.year in YEARS else None


def by_iso(text: str, separator: str = "") -> str:
    """A cell, or a text of cells with this separator, with times in ISO 8601."""
    if ":" not in text and " sec" not in text:
        return text
    text = TWELVE.sub(
        lambda at: f"{int(at[1]) % 12 + 12 * (at[3] in 'pP'):02}{at[2]}", text
    )
    # blanks separate the date from the time, and a comma ends a cell
    ways = OTHER_WAYS[1:] if separator == " " else OTHER_WAYS
    for pattern, written in ways if separator == "," else (WITH_COMMA, *ways):
        text = re.sub(pattern, written, text)
    return text


class Midnights:
    """Makes times of day increase beyond midnight, block by block."""

    def __init__(self):
        self._last, self._days = -np.inf, 0

    def unfold(self, values: Array, blank: Mask | None) -> Array:
        """Times (R,) [s] since the first midnight; arbitrary where blank."""
        known = np.ones(len(values), dtype=bool) if blank is None else ~blank
        if not known.any():
            return values
        begins = np.diff(values[known], prepend=self._last) < -0.5 * DAY
        days = self._days + np.cumsum(begins)
        self._last, self._days = values[known][-1], days[-1]
        unfolded = values.copy()
        unfolded[known] += DAY * days
        return unfolded
