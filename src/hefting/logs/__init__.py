"""Log files: one reader a format, each giving a `Recording`; the suffix says which."""

from pathlib import Path

from hefting.errors import InputError
from hefting.recording import Recording

SUFFIXES = (".csv", ".parquet")
"""File name endings that can be read and written."""

MAX_BYTES = 2 * 1024**3
"""Largest file that is read: a log is held in memory, and slow motion needs far less."""


def read_log(path: str | Path) -> Recording:
    """Recording in the canonical CSV or Parquet file at `path`.

    One header row; SI units; columns `time` and those of `hefting.recording.COLUMNS`, of which the wrench
    and an orientation or joint positions must be there. A blank cell (Parquet: null) means "not measured
    then", so that streams of different rates fit one file. Without `time`, each row is a static pose. Times
    that count from 1970 are shifted to start at 0. CSV may be separated by commas, semicolons or tabs.

    Raises `InputError`, naming file, row and column, for anything that cannot be read without guessing; what
    can be read but looks odd is in `Recording.warnings`. Rows are lines of a CSV file (the header usually is
    row 1), and are counted from 1 in Parquet.
    """
    suffix = _suffix(path)
    try:
        if not Path(path).is_file():
            raise InputError("is not a file" if Path(path).exists() else "does not exist", where=path)
        size = Path(path).stat().st_size
        if size == 0:
            raise InputError("the file is empty", where=path)
        if size > MAX_BYTES:
            raise InputError(f"the file has {size / 1e9:.1f} GB, more than 2 GiB", path, "cut out the part of interest")
        if suffix == ".csv":
            from hefting.logs.csv_file import read_csv

            return read_csv(path)
        from hefting.logs.parquet_file import read_parquet

        return read_parquet(path)
    except OSError as error:
        raise InputError(f"cannot be read ({error.strerror or error})", where=path) from error


def write_log(recording: Recording, path: str | Path) -> None:
    """Write `recording` as canonical CSV or Parquet, whole or not at all; `read_log` gives the same numbers.

    Samples of different streams share a row when their times are equal. Raises `InputError` for another
    suffix and where the file cannot be written.
    """
    if _suffix(path) == ".csv":
        from hefting.logs.csv_file import write_csv

        write_csv(recording, path)
    else:
        from hefting.logs.parquet_file import write_parquet

        write_parquet(recording, path)


def _suffix(path: str | Path) -> str:
    suffix = Path(path).suffix.lower()
    if suffix not in SUFFIXES:
        raise InputError(f"'{suffix or 'no suffix'}' is not a log format", path, f"use {' or '.join(SUFFIXES)}")
    return suffix
