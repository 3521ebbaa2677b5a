"""What a user has -> Recording: a log's path, a table or arrays in memory."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from hefting.core.errors import InputError
from hefting.core.messages import warning
from hefting.core.recording import COLUMNS, Recording
from hefting.core.spatial import Array
from hefting.logs import read_log
from hefting.logs.arrays import ARRAYS, elapsed, recording_from_arrays
from hefting.logs.map_guess import names_time
from hefting.logs.table import Block, summarize_list
from hefting.logs.table_file import reader_of

FORMS = (
    "give the path of a log, a dictionary of columns, a data frame, a structured array, "
    "a Recording, or `time`, `orientation`, `position`, `wrench`"
)
"""What a recording may be given as."""


def as_recording(
    source: Any = None,
    *,
    column_map: str | Path | None = None,
    time: ArrayLike | None = None,
    position: ArrayLike | None = None,
    orientation: Any = None,
    pose: ArrayLike | None = None,
    wrench: ArrayLike | None = None,
    wrench_time: ArrayLike | None = None,
    wrench_needed: bool = True,
    **streams: ArrayLike | None,
) -> Recording:
    """Recording of whatever holds one: a path, a table in memory, or arrays.

    Parameters
    ----------
    source : path, mapping, data frame, structured array or Recording, optional
        A log's path; columns of the canonical names (`hefting.read_log`) in a
        dictionary, a data frame of pandas or polars, a PyArrow table or a structured
        array, where NaN and null mean "not measured then"; or a dictionary of the
        arrays below by their names. A `Recording` is returned as it is.
    column_map : path, optional
        TOML file that says which columns hold what; see `hefting.logs.column_map`.
    time : (K,), optional
        [s], increasing; dates count from the first. Without it each sample is a static
        pose.
    position : (K, 3), optional
        Of the sensor origin in the world [m]. Without it only gravity is modelled.
    orientation : (K, 4), (K, 3, 3) or scipy Rotation
        Of the sensor in the world: quaternions x, y, z, w, or matrices that turn
        sensor axes into world axes.
    pose : (K, 4, 4) or (K, 7), optional
        Both at once: matrices, or x, y, z [m] and a quaternion x, y, z, w.
    wrench : (N, 6)
        Force [N], then torque [N m], in sensor axes about the sensor origin.
    wrench_time : (N,), optional
        Of the wrench [s], on the clock of `time`, where it has times of its own.
    wrench_needed : bool
        Whether a recording without a wrench is refused.
    **streams : (K, d), optional
        Other streams of a `Recording`, such as ``gyroscope``, at `time`.

    Returns
    -------
    Recording

    Raises
    ------
    InputError
        For what cannot be read without guessing, naming row or sample, which are
        counted from 0 in memory.

    Examples
    --------
    >>> import numpy as np
    >>> time = np.arange(0.0, 2.0, 0.01)
    >>> pose = np.tile(np.eye(4), (200, 1, 1))
    >>> recording = hefting.as_recording(time=time, pose=pose, wrench=np.ones((200, 6)))
    >>> recording.duration
    1.99
    """
    arrays = {
        "time": time,
        "position": position,
        "orientation": orientation,
        "pose": pose,
        "wrench": wrench,
        "wrench_time": wrench_time,
    } | streams
    given = {name: value for name, value in arrays.items() if value is not None}
    if source is None:
        if not given:
            raise InputError("no recording is given", fix=FORMS)
        recording = recording_from_arrays(given)
    elif given:
        what = f"both a recording and `{next(iter(given))}` are given"
        raise InputError(what, fix="give one of them")
    else:
        recording = _from_source(source, column_map, wrench_needed)
    if wrench_needed and not recording.has("wrench"):
        raise InputError("there is no wrench", recording.source, "give `wrench` (N, 6)")
    return recording


def _from_source(
    source: Any, column_map: str | Path | None, wrench_needed: bool
) -> Recording:
    """Recording of a path, a table in memory or a Recording."""
    if isinstance(source, Recording):
        return source
    if isinstance(source, str | Path):
        return read_log(source, column_map, wrench_needed=wrench_needed)
    table = MemoryTable.of(source)
    if table is None:
        shape = getattr(source, "shape", None)
        what = f"a value of type {type(source).__name__} is not a recording"
        if shape is not None:
            what = f"an array {shape} without column names is not a recording"
        raise InputError(what, fix=FORMS)
    if {"pose", *COLUMNS} & set(table.names):
        return _from_named_arrays(table)
    if column_map is not None:
        from hefting.logs.column_map import load_map
        from hefting.logs.mapped import read_mapped

        chosen = load_map(column_map, wrench_needed)
        return read_mapped(table, chosen, wrench_needed)
    return reader_of(table, wrench_needed)(table)


def _from_named_arrays(table: MemoryTable) -> Recording:
    """Recording of a table whose columns are whole arrays, such as a position (K, 3)."""
    known: Mapping[str, Any] = {k: v for k, v in table.columns.items() if k in ARRAYS}
    recording = recording_from_arrays(known, blanks="left out")
    ignored = [repr(name[:40]) for name in table.names if name not in ARRAYS]
    if not ignored:
        return recording
    what = f"ignored unknown columns: {summarize_list(ignored)}"
    said = warning("columns-ignored", what, "column_map")
    return replace(recording, warnings=(*recording.warnings, said))


@dataclass(frozen=True, eq=False)
class MemoryTable:
    """Named columns in memory; rows are counted from 0, and NaN is a blank cell.

    Columns that are not asked for may hold anything.
    """

    source: str
    """What messages call it."""
    names: tuple[str, ...]
    """Names of all columns, in order."""
    columns: Mapping[str, Any]
    """Values (K,) by name."""

    @classmethod
    def of(cls, table: Any) -> MemoryTable | None:
        """The columns of a table; None for what is no table."""
        if isinstance(table, Mapping):
            return cls("dictionary", tuple(map(str, table)), _by_text(table, table))
        names = getattr(getattr(table, "dtype", None), "names", None)
        if names is not None:
            return cls("structured array", tuple(names), _by_text(table, names))
        if hasattr(table, "collect"):  # of polars, not yet read
            source = type(table).__name__
            raise InputError(f"a {source} holds no values yet", fix="give .collect()")
        # of a PyArrow table `columns` are the values
        names = getattr(table, "column_names", None)
        names = getattr(table, "columns", None) if names is None else names
        if names is None or not hasattr(table, "__getitem__"):
            return None
        return cls._of_frame(table, list(names))

    @classmethod
    def _of_frame(cls, frame: Any, names: list[Any]) -> MemoryTable:
        """The columns of a data frame, before them its index where that has a name or
        holds times."""
        columns = _by_text(frame, dict.fromkeys(names))
        index = getattr(frame, "index", None)
        name = _index_name(index)
        unnamed = getattr(index, "name", None) is None
        if unnamed and any(map(names_time, columns)):
            name = ""  # the rows have their own time
        if name and name not in columns:
            columns, names = {name: index} | columns, [name, *names]
        return cls(type(frame).__name__, tuple(map(str, names)), columns)

    def blocks(self, columns: Sequence[int]) -> Iterator[Block]:
        """All rows at once, of the columns at these positions. `InputError` for what is
        not a number, and for columns of different lengths."""
        values = {j: self._numbers(self.names[j]) for j in columns}
        first = columns[0]
        for j, column in values.items():
            if len(column) != len(values[first]):
                what = (
                    f"column '{self.names[j]}' has {len(column)} values, "
                    f"but '{self.names[first]}' has {len(values[first])}"
                )
                raise InputError(what, self.source, "give columns of one length")
        if not len(values[first]):
            raise InputError("there are no samples", self.source)
        blanks = {j: np.isnan(column) for j, column in values.items()}
        rows = np.arange(len(values[first]))
        yield Block(
            rows, values, {j: b if b.any() else None for j, b in blanks.items()}
        )

    def _numbers(self, name: str) -> Array:
        """Column (K,) as numbers, NaN where it is blank."""
        try:
            column = _floats(self.columns[name])
        except (TypeError, ValueError, OverflowError) as error:
            what = (
                f"column '{name[:40]}' holds {_kind(self.columns[name])}, not numbers"
            )
            raise InputError(what, self.source) from error
        if column.ndim != 1:
            what = f"column '{name[:40]}' has shape {column.shape}, not (K,)"
            raise InputError(what, self.source, "give one number a row")
        return column


def _index_name(index: Any) -> str:
    """What the index of a data frame is called as a column: by its name, or time where
    it holds dates, durations or numbers with decimals that grow; empty for others,
    which count or pick rows."""
    if (name := getattr(index, "name", None)) is not None:
        return str(name)
    kind = getattr(getattr(index, "dtype", None), "kind", "")
    grows = getattr(index, "is_monotonic_increasing", False)
    return "time" if kind in "mM" or (kind == "f" and grows) else ""


def _by_text(table: Any, names: Any) -> dict[str, Any]:
    """Columns by their names as text."""
    return {str(name): table[name] for name in names}


def _floats(values: Any) -> Array:
    """`values` as floats, blanks as NaN, times of a date in seconds from the first.

    Raises `TypeError` or `ValueError` for what is no number.
    """
    if getattr(getattr(values, "dtype", None), "tz", None) is not None:
        values = values.to_numpy("datetime64[ns]")  # of pandas, with a time zone
    masked = isinstance(values, np.ma.MaskedArray)
    array = np.ma.asarray(values, dtype=float).filled(np.nan) if masked else values
    array = np.asarray(array)
    if array.dtype.kind == "M":
        return elapsed(array - array[0]) if len(array) else array.astype(float)
    if array.dtype.kind == "m":
        return elapsed(array)
    if array.dtype.kind == "O" and hasattr(values, "to_numpy"):
        # a series of pandas that has its own mark for blanks
        return np.asarray(values.to_numpy(dtype=float, na_value=np.nan), dtype=float)
    if array.dtype.kind not in "iufbO":
        raise TypeError(str(array.dtype))
    return array.astype(float)


def _kind(values: Any) -> str:
    """What a column holds, in a word."""
    dtype = getattr(values, "dtype", None)
    if dtype is None:
        array = np.asarray(values, dtype=object).ravel()
        return f"a {type(array[0]).__name__}" if len(array) else "nothing"
    return "text" if str(dtype).lower() in ("object", "str", "string") else str(dtype)
