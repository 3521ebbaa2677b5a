"""Lines and cells of separated text: numbers, blanks, and lists of numbers in cells."""

import csv
import io
import re
from collections.abc import Iterator, Mapping, Sequence
from itertools import islice

from hefting.core.errors import InputError
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

ENOUGH, ESCAPE = 2**20, "surrogateescape"
"""Size of the pieces in which text is made [bytes], and the handling of bytes that are
no UTF-8."""


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
    """Length of the list in the first cell that is not blank, by column; other columns
    are absent."""
    found = {}
    for j in range(width):
        cells = (row[j] for row in rows if row[j:] and row[j] not in ("", *NOTHING))
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
