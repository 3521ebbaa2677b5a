"""Manifest: a table of recordings and the options of each.

A CSV or Parquet file has a column `recording` with the paths, and columns for options
of ``hefting identify``: `shape`, `object_pose` (or `pose`), `method`, `gravity`, `tool`,
`mass` and so on; an empty cell gives no option. A TOML file has options for all
recordings at its top, and one table ``[[recordings]]`` for each recording. Paths are
relative to the manifest.
"""

from collections import Counter
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from hefting.core.errors import InputError, nearest
from hefting.core.files import check_readable, load_toml

if TYPE_CHECKING:
    import pyarrow as pa

RECORDING = "recording"
"""Column of the paths."""
TEXTS = frozenset({RECORDING, "name"})
"""Columns that hold text."""
OWN_COLUMNS = (RECORDING, "name", "object")
"""Columns that are no options; upper and lower case are the same."""
MEANT = frozenset({"recordings", "file", "files", "filename", "path", "paths", "log"})
"""Columns that users may have named so instead of `recording`; a table with one of
these is taken for a manifest if it is no log."""
SUFFIXES = (".csv", ".parquet", ".toml")
SEPARATORS = (",", ";", "\t")
EMPTY = ("nan", "<NA>", "NaT")
"""An empty cell of pandas, as text."""
LARGEST_TOML = 20_000_000
"""Largest manifest in TOML that is read [bytes], and largest number of its cells: 100,000
recordings take half of the bytes."""
LARGEST_TABLE = 2**30
"""Largest manifest in CSV or Parquet that is read [bytes]."""
LONGEST_HEADER = 100_000
"""Bytes in which the header of a CSV manifest ends."""


def is_manifest(path: Path) -> bool:
    """Whether a file is a manifest: TOML, or a table with a column `recording`, or with
    one of `MEANT` and without a log's forces (`fx`)."""
    suffix = path.suffix.lower()
    if suffix == ".toml":
        return True
    if suffix not in SUFFIXES or not path.is_file():
        return False
    try:
        names = {name.lower() for name in _names(path)}
        return RECORDING in names or bool(MEANT & names and "fx" not in names)
    except InputError:
        return False


def read_manifest(path: Path) -> "tuple[pa.Table, dict[str, Any]]":
    """Rows of a manifest, and its options for all recordings.

    Raises `InputError` where it cannot be read, is too large, or has no column
    `recording`.
    """
    check_readable(path)
    if path.suffix.lower() == ".toml":
        return _read_toml(path)
    try:
        size = path.stat().st_size
    except OSError as error:
        raise InputError(f"cannot be read ({error.strerror})", path) from error
    check_large(size > LARGEST_TABLE, path)
    names = _names(path)
    if RECORDING not in names:
        what = f"a manifest needs a column '{RECORDING}'{nearest(RECORDING, names)}"
        raise InputError(what, path, "name the column of the paths so")
    twice = [name for name, count in Counter(names).items() if count > 1]
    if twice:
        raise InputError(f"has two columns '{twice[0]}'", path, "keep one of them")
    table = _read_table(path)
    for name in TEXTS & set(names):
        kind = table.schema.field(name).type
        if str(kind) not in ("string", "large_string", "null"):
            what = f"column '{name}' holds {kind}, not text"
            raise InputError(what, path, "write it as text")
    return table, {}


def check_large(is_large: bool, path: Path) -> None:
    """`InputError` for a manifest that is too large, or would be in memory."""
    if is_large:
        raise InputError(
            "is larger than 1 GiB, or has too many cells", path, "divide it"
        )


def _names(path: Path) -> list[str]:
    """Names of a table's columns."""
    import pyarrow as pa
    from pyarrow import parquet

    try:
        if path.suffix.lower() == ".parquet":
            names = list(parquet.read_schema(path).names)
        else:
            names = _header(path).split(_separator(path))
    except (pa.ArrowException, OSError, UnicodeDecodeError) as error:
        reason = str(error).splitlines()[0][:200] if str(error) else "not a table"
        raise InputError(f"cannot be read ({reason})", path) from error
    return [name.lower() if name.lower() in OWN_COLUMNS else name for name in names]


def _header(path: Path) -> str:
    with open(path, "rb") as stream:
        first = stream.readline(LONGEST_HEADER)
    text = first.decode("utf-8-sig", errors="replace").strip()
    return text.replace('"', "").replace(" ", "")


def _separator(path: Path) -> str:
    """The separator of a CSV file's columns: the most frequent one in its header."""
    header = _header(path)
    return max(SEPARATORS, key=header.count)


def _read_table(path: Path) -> "pa.Table":
    import pyarrow as pa
    import pyarrow.compute as pc
    from pyarrow import csv, parquet

    try:
        if path.suffix.lower() == ".parquet":
            batches, size = [], 0
            with parquet.ParquetFile(path) as file:
                for batch in file.iter_batches(1000, use_threads=False):
                    batch.validate(full=True)
                    batches.append(batch)
                    size += batch.nbytes
                    check_large(size > LARGEST_TABLE, path)
                table = pa.Table.from_batches(batches, file.schema_arrow)
            return table.rename_columns(_names(path))
        names, parsing = _names(path), csv.ParseOptions(delimiter=_separator(path))
        reading = csv.ReadOptions(column_names=names, skip_rows=1, use_threads=False)
        as_text = csv.ConvertOptions(
            column_types=dict.fromkeys(names, pa.string()), strings_can_be_null=True
        )
        try:
            table = csv.read_csv(path, reading, parsing, as_text)
        except pa.ArrowInvalid:  # Windows' own letters, as Excel writes
            reading.encoding = "cp1252"
            table = csv.read_csv(path, reading, parsing, as_text)
        trimmed = [pc.utf8_trim_whitespace(column) for column in table.columns]  # pyright: ignore[reportAttributeAccessIssue]
        return pa.table(trimmed, names)
    except (pa.ArrowException, OSError, UnicodeDecodeError) as error:
        reason = str(error).splitlines()[0][:200]
        raise InputError(f"cannot be read as a table ({reason})", path) from error


def _read_toml(path: Path) -> "tuple[pa.Table, dict[str, Any]]":
    import pyarrow as pa

    content = load_toml(path, "manifest", LARGEST_TOML)
    rows: Any = content.pop("recordings", None)
    fix = "give one table [[recordings]] for each, with its path: recording = 'a.csv'"
    if not isinstance(rows, list) or not rows:
        raise InputError("has no list `recordings`", path, fix)
    for number, row in enumerate(rows, start=1):
        if not isinstance(row, Mapping) or not isinstance(row.get(RECORDING), str):
            raise InputError(f"[[recordings]] {number} has no path", path, fix)
    names = list(dict.fromkeys(name for row in rows for name in row))
    check_large(len(rows) * len(names) > LARGEST_TOML, path)
    cells = {name: [text_of(row.get(name)) for row in rows] for name in names}
    return pa.table(cells, pa.schema({name: pa.string() for name in names}.items())), (
        content
    )


def text_of(value: Any) -> str | None:
    """A value of TOML or of a dictionary as it is written in a table; None for what
    stands for no value."""
    if isinstance(value, np.ndarray):
        value = value.ravel().tolist()
    if isinstance(value, list | tuple):
        return ",".join(map(str, value))
    text = str(value)
    is_empty = value is None or (text in EMPTY and not isinstance(value, str))
    return None if is_empty else text
