"""LabVIEW's text measurement files (``.lvm``) as separated text with a header."""

from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path

from hefting.core.errors import InputError
from hefting.logs.csv_times import seconds_of

MARK = b"LabVIEW Measurement"
"""How such a file begins."""

TAGS = b"Y_Unit_Label X_Columns X_Dimension Delta_X Date Time Decimal_Separator".split()
"""How lines above the names begin that are read."""


def as_table(texts: Iterator[bytes], path: str | Path) -> Iterator[bytes]:
    """Rows of numbers without comments, each in its line; before them the names of the
    channels, and in the line that had these their units; else blank lines.

    Times that are not written are counted by ``Delta_X``; a later segment that begins as
    the first does is later by its ``Date`` and ``Time``. `InputError` unless there is one
    time for all channels.
    """
    names: list[bytes] = []
    tags = {tag: [b""] for tag in TAGS}
    separator, rows, shift, first = b"\t", 0, 0.0, None
    for text in texts:
        lines: list[bytes] = []
        for line in text.split(b"\n"):
            cells, row = line.split(separator), b""
            if cells[0] == b"X_Value":
                if lines and not names:
                    kind = {*tags[b"X_Columns"], *tags[b"X_Dimension"]}
                    if kind - {b"", b"No", b"One", b"Time"}:
                        fix = "save it with one X column, of the time"
                        raise InputError("has no one time for all channels", path, fix)
                    names = cells[: -1 if cells[-1] in (b"", b"Comment") else None]
                    lines[-1] = separator.join(names)
                    units = [b"s", *tags[b"Y_Unit_Label"], *names]
                    row = separator.join(units[: len(names)])
                rows = 0
            elif line[:1].isalpha() or line[:1] == b"*":
                separator = b"," if line.startswith(b"Separator,") else separator
                tags |= {cells[0]: [*cells[1:], b""]} if cells[0] in tags else {}
            elif names and line.strip():
                x, step = (
                    c.replace(b",", b".") for c in (cells[0], tags[b"Delta_X"][0])
                )
                if not rows:
                    stamp = b" ".join((tags[b"Date"][0], tags[b"Time"][0][:15]))
                    start = seconds_of(stamp.decode(errors="replace").replace(",", "."))
                    first = first or (x, start or 0.0)
                    shift = (start or 0.0) - first[1] if x == first[0] else shift
                if shift or not x:
                    with suppress(
                        ValueError
                    ):  # what is no number is told where it is read
                        time = shift + (float(x) if x else rows * float(step))
                        comma = b"," in tags[b"Decimal_Separator"]
                        cells[0] = (
                            str(time).replace(".", "," if comma else ".").encode()
                        )
                rows += 1
                row = separator.join(cells[: len(names)])
            lines.append(row)
        yield b"\n".join(lines)
