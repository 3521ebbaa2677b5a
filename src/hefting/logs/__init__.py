"""Logs: one file for each format, which reads a `Recording`; the file name tells the
format."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path
from typing import Any

from hefting.core.errors import InputError
from hefting.core.files import check_readable
from hefting.core.progress import report
from hefting.core.recording import Recording
from hefting.logs.registry import (
    READING,
    Format,
    find_format,
    find_writer,
    formats,
    join_words,
    suffix_of,
    table_formats,
)

__all__ = ["check_output", "formats", "read_log", "write_log"]

OTHERS = {
    ".gz": ("is packed with gzip", "unpack it, as zcat does"),
    ".xlsx": ("is a workbook", "save its sheet as CSV"),
    ".npy": (
        "is one array without a name",
        "write all by numpy.savez('log.npz', time=..., pose=..., wrench=...)",
    ),
}
"""What files of other endings are, and what to do with them."""
OTHERS |= {
    f".{suffix}": (
        f"is {what}",
        f"in Python: hefting.write_log(hefting.as_recording({read}), 'log.csv')",
    )
    for suffix, what, read in (
        ("hdf5", "HDF5", "h5py.File(path)"),
        ("h5", "HDF5", "h5py.File(path)"),
        ("json", "JSON, not a log format", "pandas.read_json(path)"),
        ("pkl", "a pickle, which may run code", "pandas.read_pickle(path)"),
        ("tdms", "TDMS", "nptdms.TdmsFile(path).groups()[0].as_dataframe()"),
    )
}
OTHERS |= dict.fromkeys((".xls", ".xlsm", ".ods"), OTHERS[".xlsx"])


def read_log(
    path: str | Path,
    column_map: str | Path | None = None,
    *,
    wrench_needed: bool = True,
    poses: str | Path | None = None,
    **options: Any,
) -> Recording:
    """Recording in the log at `path`.

    ====================================== ===============================================
    suffix                                 read as
    ====================================== ===============================================
    .csv, .txt, .tsv, .dat, .log, .lvm     text, separated by commas, semicolons, tabs or
                                           spaces
    .parquet                               Parquet
    .npz                                   arrays of NumPy
    .mat                                   MATLAB's, saved with ``-v7``
    .jsonl, .ndjson                        a JSON object a line, nested as ROS messages are
    .feather, .arrow                       Arrow's files
    .bag, .mcap, .db3, or a folder         a ROS 1 or ROS 2 bag; see `hefting.logs.ros`
    ====================================== ===============================================

    The canonical table has one row of names, before which comments may stand; SI units;
    columns `time` and those of `hefting.core.recording.COLUMNS`, of which the wrench and
    an orientation or joint positions must be there. A blank cell (null) means "not
    measured then", so that streams of different rates fit one file. Without `time`, each
    row is a static pose. Times that count from 1970 are shifted to start at 0. A row that
    repeats the one before, time and values alike, is dropped, and so are those with its
    time but other values, up to a tenth of all. Times may be dates (ISO 8601).

    A UR real-time record is known by its header, arrays by the names of
    `hefting.as_recording`. Other names (``Fx [N]``, ``roll_deg``) are read where they and
    the numbers tell a time, a wrench, and an orientation or joint angles;
    `Recording.warnings` say what was taken for what.

    Parameters
    ----------
    column_map : a TOML file that says which columns hold what, and in which units; see
        `hefting.logs.column_map`.
    wrench_needed : whether a log without a wrench is refused, as one that nothing can
        be identified from.
    poses : a table with the poses, or joint angles, of a log that has none: see
        `hefting.logs.two_files.read_with_poses`.
    options : for bags: ``wrench_topic=`` and the others of `hefting.logs.ros.read_bag`.

    Raises `InputError`, naming file, row and column, for what cannot be read; what can
    be read but looks odd is in `Recording.warnings`. Rows
    are lines of a CSV file (the header usually is row 1), and are counted from 1 in
    Parquet.

    Examples
    --------
    >>> recording = hefting.read_log("demo/log.csv")
    >>> recording.duration
    9.99
    """
    given = {name: value for name, value in options.items() if value is not None}
    try:
        found = find_format(path)
        if found is None:
            raise _unknown_format(path)
        check_readable(path)
        _check_options(found, path, column_map, given)
        report(READING)
        if poses is not None:
            from hefting.logs.two_files import read_with_poses

            return read_with_poses(path, poses, column_map, wrench_needed=wrench_needed)
        if found.read is not None:
            return found.read(path, **given, wrench_needed=wrench_needed)
        from hefting.logs.table_file import read_table_file

        return read_table_file(found, path, column_map, wrench_needed)
    except OSError as error:
        raise InputError(
            f"cannot be read ({error.strerror or error})", where=path
        ) from error


def write_log(recording: Recording, path: str | Path) -> tuple[str, ...]:
    """Write `recording`, whole or not at all: canonical .csv or .parquet, a ROS 1 bag
    (.bag), an .mcap file, or, without suffix, the folder of a ROS 2 bag.

    `read_log` gives the same numbers; of a bag, times rounded to nanoseconds that start
    at 0. In a table, samples of different streams share a row when their times are
    equal. Returned are the streams that the format cannot hold. Raises `InputError` for
    another suffix, for what is no `Recording`, and where the file cannot be written.

    Examples
    --------
    >>> recording = hefting.read_log("demo/log.csv")
    >>> hefting.write_log(recording, "log.parquet")
    ()
    """
    check_output(path)
    if not isinstance(recording, Recording):
        what = f"a value of type {type(recording).__name__} is no recording"
        raise InputError(what, path, "make one of it by hefting.as_recording")
    found = find_writer(path)
    assert found is not None
    assert found.write is not None
    return found.write(recording, path)


def check_output(path: str | Path) -> str:
    """The suffix of a log to write; `InputError` for one without a format."""
    suffix = suffix_of(path)
    if find_writer(path) is None:
        known = ", ".join(
            each for written in formats() for each in written.written if each
        )
        folders = [
            f", or no suffix for the folder of a {each.folder}"
            for each in formats()
            if "" in each.written
        ]
        what = f"'{suffix}' is not a log format to write"
        raise InputError(what, path, f"use {known}{''.join(folders)}")
    return suffix


def _unknown_format(path: str | Path) -> InputError:
    suffix = suffix_of(path)
    if not suffix and not Path(path).exists():
        return InputError("does not exist", where=path)
    known = ", ".join(suffix for each in formats() for suffix in each.suffixes)
    folders = "".join(
        f", or a {each.name}'s folder" for each in formats() if each.folder
    )
    what = f"'{suffix}' is not a log format" if suffix else "is not a log"
    if suffix in OTHERS:
        return InputError(OTHERS[suffix][0], path, OTHERS[suffix][1])
    if Path(path).is_dir():
        folders += "; for all logs in a folder use hefting batch"
    python = "; in Python `hefting.as_recording` takes arrays or columns"
    return InputError(what, path, f"use {known}{folders}{python}")


def _check_options(
    found: Format, path: str | Path, column_map: str | Path | None, given: Iterable[str]
) -> None:
    """`InputError` where the format `found` for the log at `path` takes no column map,
    or not one of the `given` options."""
    if column_map is not None and not found.is_table:
        tables = join_words([each.name for each in table_formats()], "and")
        raise InputError(
            f"a column map (`column_map`) is for {tables}", path, "leave it out"
        )
    for option in given:
        accepting = [each for each in formats() if option in each.options]
        if not accepting:  # no format has this option
            accepting = [each for each in formats() if each.options]
        if found not in accepting:
            owners = join_words([f"{each.name}s" for each in accepting], "and")
            raise InputError(f"`{option}` is for {owners}", path, "leave it out")
