"""Recordings of a batch, from a manifest, a folder, a pattern or a list, each with its
options."""

import glob
import os
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import chain
from pathlib import Path
from typing import TYPE_CHECKING, Any

from hefting.batches.manifest import (
    OWN_COLUMNS,
    RECORDING,
    is_manifest,
    read_manifest,
    text_of,
)
from hefting.core.errors import InputError, nearest
from hefting.logs.registry import find_format, formats
from hefting.request.request import (
    Value,
    canonical_name,
    check_request,
    files_of,
    given_options,
    in_folder,
    option_kinds,
    request_of,
)
from hefting.request.settings import ABOUT_SHAPES, require_shape

if TYPE_CHECKING:
    import pyarrow as pa

FOLDER = "folder"
"""Word to group recordings by the folder that each is in."""
NO_LOGS = frozenset({".txt", ".dat", ".log"})
"""Endings of logs that are not looked for in folders, as other files have them too."""
LEFT_OUT_TEXTS = (
    "files that end in .txt, .dat or .log, as others than logs do, were left out ({}): "
    "name them, as 'FOLDER/*.txt', if they are logs"
)
"""Text with the number of files in folders that end in `NO_LOGS`."""
METADATA = "metadata.yaml"
"""File that the folder of a ROS 2 bag has, and a folder of several bags has not."""
SHAPES = {"shape", "box"}
"""Options that give a shape."""
PATTERN = frozenset("*?[")

Sources = str | Path | Sequence[str | Path | Mapping[str, Any]]


@dataclass(frozen=True)
class Entry:
    """A recording of a batch."""

    recording: str
    """Path."""
    name: str | None = None
    """Name that distinguishes it from others of the same path."""
    object: str | None = None
    """Name of the object, from the column that recordings are grouped by."""
    options: Mapping[str, Value] = field(default_factory=dict)
    """Options of ``hefting identify`` for it."""
    problem: str | None = None
    """Error in its row of the manifest."""

    @property
    def identity(self) -> str:
        """Name or path, which no other recording of the batch has."""
        return self.name or self.recording

    @property
    def row_name(self) -> str:
        """Identity of its object's row, or without an object of its own."""
        return self.object or self.identity


class Recordings:
    """Recordings of a batch, as a table, each row of which becomes an entry on access.

    Parameters
    ----------
    table : pyarrow.Table
        Has a column `recording`, and others as in `hefting.batches.manifest`.
    folder : Path, optional
        Folder that paths in the table are relative to.
    options : mapping
        Options of the recordings whose rows do not have them.
    group_by : str, optional
        Column that names the object, or `FOLDER`.
    texts : int
        Number of files in folders that were left out for their ending (`NO_LOGS`).
    unreadable : mapping
        Errors of recordings whose path no table can hold, by the text in its place.

    Raises
    ------
    InputError
        For an unknown option or a value of another type, an unknown column to group by,
        and a recording that occurs twice without a name.
    """

    def __init__(
        self,
        table: "pa.Table",
        folder: Path | None = None,
        options: Mapping[str, Any] | None = None,
        group_by: str | None = None,
        texts: int = 0,
        unreadable: Mapping[str, str] | None = None,
    ):
        self._table, self._folder = table, folder
        self.texts = texts
        self._unreadable = unreadable or {}
        self._options = given_options(options or {})
        self._group_by = group_by or "object"
        self._is_grouped = group_by is not None
        kinds = option_kinds()
        self._columns = {
            name: canonical_name(name)
            for name in table.column_names
            if canonical_name(name) in kinds
        }
        if group_by not in (None, FOLDER, *table.column_names):
            known = (FOLDER, *table.column_names)
            what = f"there is no column '{group_by}'{nearest(str(group_by), known)}"
            raise InputError(what, "--group-by", f"use one of {', '.join(known)}")
        self._check_names()

    def __len__(self) -> int:
        return self._table.num_rows

    def __getitem__(self, row: int) -> Entry:
        """The entry in a row."""
        cells: dict[str, Any] = {
            name: self._table[name][row].as_py() for name in self._table.column_names
        }
        recording = cells[RECORDING] or ""
        problem = self._unreadable.get(recording)
        if self._folder is not None and recording:
            recording = str(self._folder / recording)
        options = self._options
        try:
            own = given_options(
                {option: cells[name] for name, option in self._columns.items()}
            )
            own = in_folder(own, self._folder) if self._folder else own
            if not SHAPES & (options | own).keys():  # not said of this recording
                options = {k: v for k, v in options.items() if k not in ABOUT_SHAPES}
            options = options | own
        except InputError as error:
            problem = str(error)
        if not recording:
            cells["name"] = cells.get("name") or f"row {row + 1}"
            problem = f"row {row + 1} names no recording"
        kept = cells.get("name"), self._object(cells, recording)
        name, thing = (None if each in (None, "") else str(each) for each in kept)
        return Entry(recording, name, thing, options, problem)

    def __iter__(self) -> Iterator[Entry]:
        return (self[row] for row in range(len(self)))

    def check(self, with_files: bool = True) -> None:
        """`InputError` for options of all recordings that are wrong for every one;
        options that name files are checked only `with_files`."""
        options = dict(self._options)
        for name in () if with_files else files_of(options):
            del options[name]
        check_request(request_of(options))
        if not SHAPES & set(self._columns.values()):
            require_shape(request_of(self._options))

    @property
    def unused(self) -> list[str]:
        """Columns that are no options."""
        own = {*OWN_COLUMNS, *self._columns, self._group_by}
        return [name for name in self._table.column_names if name not in own]

    def identities(self) -> Iterator[str]:
        """Identities of the rows of results, in order, by object where grouped."""
        if not self._is_grouped:
            return (entry.identity for entry in self)
        return (self[rows[0]].row_name for rows in self.in_groups())

    def in_groups(self) -> list[list[int]]:
        """Row numbers of each object, in order of their first rows; a recording without
        an object is a group of its own."""
        groups: dict[object, list[int]] = {}
        for row in range(len(self)):
            entry = self[row]
            groups.setdefault(entry.object or (row,), []).append(row)
        return list(groups.values())

    def _object(self, cells: Mapping[str, Any], recording: str) -> Any:
        if self._group_by == FOLDER and FOLDER not in cells:
            return str(Path(recording).parent)
        return cells.get(self._group_by)

    def _check_names(self) -> None:
        """`InputError` for two recordings of the same name, or path without a name."""
        found, folder = self._table[RECORDING].to_pylist(), self._folder
        if folder is not None:  # "a.csv" and "./a.csv" are the same
            found = [each and str(folder / each) for each in found]
        if "name" in self._table.column_names:
            names = self._table["name"].to_pylist()
            found = [name or path for name, path in zip(names, found, strict=True)]
        for name, count in Counter(filter(None, found)).items():
            if count > 1:
                what = "is given twice"
                fix = "give it once, or each a `name` in a column of a manifest"
                raise InputError(what, name, fix)


def recordings_of(
    sources: Sources,
    options: Mapping[str, Any] | None = None,
    group_by: str | None = None,
) -> Recordings:
    """The recordings at paths, or of rows.

    Parameters
    ----------
    sources : path, or list of paths or of dictionaries
        A manifest (CSV, Parquet, TOML), a folder with all logs below it, a pattern such
        as ``"day*/*.csv"``, or a log; a list of these without manifests; or rows of a
        manifest, as dictionaries.
    options : mapping, optional
        Options of ``hefting identify`` for recordings that do not have them.
    group_by : str, optional
        Column of the manifest that names the object, or ``"folder"``.

    Raises
    ------
    InputError
        Where there are no recordings or a name is empty, and as `Recordings`.
    """
    import pyarrow as pa

    listed = [sources] if isinstance(sources, str | Path) else list(sources)
    if listed and all(isinstance(each, Mapping) for each in listed):
        names = dict.fromkeys(chain.from_iterable(listed))  # type: ignore[arg-type]
        if RECORDING not in names:
            fix = "give each the path of its log under the key 'recording'"
            raise InputError(f"rows have no '{RECORDING}'", fix=fix)
        cells = {n: [text_of(each.get(n)) for each in listed] for n in names}  # type: ignore[union-attr]
        return Recordings(pa.table(cells), None, options, group_by)
    if "" in map(str, listed):  # Path("") is the current folder
        raise InputError("a name is empty", fix="name a manifest, logs or a folder")
    paths = [Path(str(each)) for each in listed]
    if len(paths) == 1 and is_manifest(paths[0]):
        table, given = read_manifest(paths[0])
        if not table.num_rows:
            raise InputError("there are no recordings", paths[0], "name some in rows")
        folder = paths[0].parent
        own = in_folder(given_options(given), folder) if given else {}
        return Recordings(table, folder, own | given_options(options or {}), group_by)
    logs = [log for path in paths for log in logs_at(path)]
    if paths and logs == [str(paths[0])] and not paths[0].exists():
        raise InputError(
            "does not exist", paths[0], "name a manifest, logs or a folder"
        )
    below = (file for path in paths if path.is_dir() for file in path.rglob("*"))
    texts = sum(file.suffix.lower() in NO_LOGS for file in below)
    if not logs:
        where = ", ".join(map(str, paths[:3])) or None
        fix = LEFT_OUT_TEXTS.format(texts) if texts else "name logs or a folder"
        raise InputError("there are no recordings", where, fix)
    names = [os.fsencode(log).decode(errors="backslashreplace") for log in logs]
    what = "the name is not UTF-8, so no table can hold it; rename the file"
    odd = {n: f"{n}: {what}" for n, log in zip(names, logs, strict=True) if n != log}
    return Recordings(pa.table({RECORDING: names}), None, options, group_by, texts, odd)


def logs_at(path: Path) -> list[str]:
    """Sorted paths of logs in a folder or of a pattern; else the path itself."""
    if path.is_dir():
        return [str(path)] if _is_log(path) else sorted(_logs_below(path))
    if not path.exists() and PATTERN & set(str(path)):
        return sorted(glob.glob(str(path), recursive=True))
    return [str(path)]


def _logs_below(folder: Path) -> Iterator[str]:
    """Logs in a folder and below, which may be folders themselves; not results of
    batches, nor hidden files."""
    endings = {ending for each in formats() for ending in each.suffixes} - NO_LOGS
    for where, folders, files in os.walk(folder):
        for name in [each for each in folders if each.startswith(".")]:
            folders.remove(name)
        for name in list(folders):
            if _is_log(Path(where, name)):
                folders.remove(name)
                yield os.path.join(where, name)
        for name in files:
            path = Path(where, name)
            if name.startswith(".") or path.suffix.lower() not in endings:
                continue
            if path.suffix.lower() != ".parquet" or not _is_result(path):
                yield str(path)


def _is_result(path: Path) -> bool:
    """Whether a Parquet file is the table of a batch."""
    import pyarrow as pa
    from pyarrow import parquet

    from hefting.batches.columns import SCHEMA

    name, _, _ = SCHEMA.partition("/")  # of any version
    try:
        metadata = parquet.read_schema(path).metadata if path.is_file() else None
    except (OSError, pa.ArrowException):
        return False  # reading it as a log raises the error
    return (metadata or {}).get(b"hefting", b"").startswith(f"{name}/".encode())


def _is_log(folder: Path) -> bool:
    """Whether a folder is one log: a bag with metadata, not several bags."""
    return (folder / METADATA).is_file() and find_format(folder) is not None
