"""Standard input in place of a file, for ``-``."""

import contextlib
import os
import sys
from collections.abc import Iterator
from pathlib import Path

from hefting.core.errors import InputError

NAME = "standard input"

KINDS = (
    (b"PAR1", ".parquet"),
    (b"PK\x03\x04", ".npz"),
    (b"\x89MCAP0", ".mcap"),
    (b"#ROSBAG", ".bag"),
    (b"SQLite format 3", ".db3"),
    (b"MATLAB 5", ".mat"),
    (b"ARROW1", ".arrow"),
    (b"{", ".json"),
    (b"\x1f\x8b", ".gz"),
)
"""First bytes of each kind of input, and the suffix of its name; others are CSV."""

MAX_BYTES = 2 * 1024**3
"""Largest input, as for a log [bytes]."""


@contextlib.contextmanager
def input_file(path: str) -> Iterator[str]:
    """The path itself; for ``-`` that of a temporary file with all of standard input.

    An `InputError` within the block names standard input then. `InputError` where that is
    a terminal, or too large.
    """
    if path != "-":
        yield path
        return
    if sys.stdin is None or sys.stdin.isatty():
        raise InputError("is a terminal", NAME, "pipe a file into it, or name the file")
    from tempfile import TemporaryDirectory

    with TemporaryDirectory(prefix="hefting-") as folder:
        file = _copy(Path(folder))
        try:
            yield str(file)
        except InputError as error:
            where = str(error.where).replace(str(file), NAME)
            what = error.what.replace(str(file), NAME)
            raise InputError(what, where, error.fix) from error


def _copy(folder: Path) -> Path:
    """Copy standard input to a file with the suffix of its content; its path."""
    copy = folder / "copy"
    begin, count = b"", 0
    with open(copy, "wb") as target:
        while block := os.read(sys.stdin.fileno(), 2**20):
            begin, count = begin or block, count + len(block)
            if count > MAX_BYTES:
                raise InputError(f"has more than {MAX_BYTES // 2**30} GiB", NAME)
            target.write(block)
    if not count:
        raise InputError("is empty", NAME)
    ending = next((end for mark, end in KINDS if begin.startswith(mark)), ".csv")
    if ending == ".json" and b"}\n{" in begin:
        ending = ".jsonl"
    return copy.rename(folder / f"input{ending}")
