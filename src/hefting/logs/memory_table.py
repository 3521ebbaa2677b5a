"""Named arrays, in memory or in a file of arrays, as a table; an array with several
numbers for each sample becomes as many columns."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from hefting.core.errors import InputError
from hefting.core.messages import Message, warning
from hefting.core.recording import COLUMNS, Recording
from hefting.core.spatial import Array, immutable
from hefting.logs.arrays import ARRAYS, elapsed, recording_from_arrays
from hefting.logs.map_time import names_time
from hefting.logs.table import LONGEST_LIST, Block, summarize_list


@immutable
class MemoryTable:
    """Named columns in memory; rows are counted from 0, and NaN is a blank cell.

    Columns that are not read may hold anything.
    """

    source: str
    """Name in messages."""
    names: tuple[str, ...]
    """Names of all columns, in order."""
    columns: Mapping[str, Any]
    """Values (K,) by name."""
    arrays: Mapping[str, Any]
    """The given arrays by name, with one or several numbers for each sample."""
    first: int = 0
    """Number of the first row in messages."""
    warnings: tuple[Message, ...] = ()
    """About the rest of a file."""

    @classmethod
    def of(cls, table: Any) -> MemoryTable | None:
        """The columns of a table; None for another object."""
        if hasattr(table, "fetchnumpy"):  # a relation of DuckDB
            table = table.fetchnumpy()
        if isinstance(table, Mapping):
            return cls.of_arrays("dictionary", table)
        names = getattr(getattr(table, "dtype", None), "names", None)
        if names is not None:
            return cls.of_arrays("structured array", {n: table[n] for n in names})
        if hasattr(table, "collect"):  # a lazy frame of polars
            source = type(table).__name__
            raise InputError(f"a {source} holds no values yet", fix="give .collect()")
        # of a PyArrow table `columns` are the values
        names = getattr(table, "column_names", None)
        names = getattr(table, "columns", None) if names is None else names
        if names is None or not hasattr(table, "__getitem__"):
            return None
        return cls.of_frame(table, list(names), type(table).__name__)

    @classmethod
    def of_arrays(cls, source: str, arrays: Mapping[Any, Any]) -> MemoryTable:
        """A table of named arrays, which may be in nested dictionaries.

        An array ``ft`` (K, 6) becomes columns ``ft_0`` to ``ft_5``, ``pose`` (K, 4, 4)
        columns ``pose_0`` to ``pose_15``, row by row; ``q`` in a dictionary ``robot``
        columns ``robot.q_0``, ... . K is the most frequent length of an axis of numbers;
        an array (6, K) is transposed.
        """
        flat = dict(_flat(arrays))
        lengths = Counter(
            length
            for values in flat.values()
            if getattr(getattr(values, "dtype", None), "kind", "") not in {*"OSU"}
            for length in {*_shape(values)}
        )
        samples = max(lengths, key=lambda n: (lengths[n], n), default=0)
        flat = {name: _samples_first(values, samples) for name, values in flat.items()}
        columns: dict[str, Any] = {}
        for name, values in flat.items():
            columns |= _columns(name, values)
        return cls(source, tuple(columns), columns, flat)

    @classmethod
    def of_frame(cls, frame: Any, names: list[Any], source: str) -> MemoryTable:
        """The columns of a data frame, after its index if that has a name or holds
        times. Columns of lists and of dictionaries are divided as in `of_arrays`."""
        columns: dict[str, Any] = {}
        texts = list(map(str, names))
        for name in dict.fromkeys(names):
            parts = _parts(str(name), frame[name])
            columns |= parts
            if str(name) not in parts:
                at = texts.index(str(name))
                texts[at : at + 1] = parts
        names = texts
        index = getattr(frame, "index", None)
        name = _index_name(index)
        unnamed = getattr(index, "name", None) is None
        if unnamed and any(map(names_time, columns)):
            name = ""  # the rows have their own time
        if name and name not in columns:
            columns, names = {name: index} | columns, [name, *names]
        return cls(source, tuple(names), columns, columns)

    @property
    def holds_streams(self) -> bool:
        """Whether its arrays are streams by the names of `as_recording`, and none of
        another name is a time."""
        others = [name for name in self.arrays if name not in ARRAYS]
        if not {"pose", *COLUMNS} & self.arrays.keys():
            return False
        posed = {"pose", "orientation", "joint_positions"} & self.arrays.keys()
        timed = "time" in self.arrays or not any(map(names_time, others))
        return not others or bool(posed and "wrench" in self.arrays and timed)

    def recording(self) -> Recording:
        """Recording of arrays with the names of `as_recording`, such as a position
        (K, 3); a warning names the others."""
        known = {name: self.arrays[name] for name in self.arrays if name in ARRAYS}
        try:
            found = recording_from_arrays(known, blanks="left out")
        except InputError as error:
            raise InputError(error.what, self.source, error.fix) from error
        found = replace(found, source=self.source)
        ignored = [repr(name[:40]) for name in self.arrays if name not in ARRAYS]
        if not ignored:
            return found
        what = f"ignored unknown columns: {summarize_list(ignored)}"
        about = warning("columns-ignored", what, "column_map")
        return replace(found, warnings=(*found.warnings, about))

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
        rows = self.first + np.arange(len(values[first]))
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
            fix = "give numbers, or dates as datetime64"
            raise InputError(what, self.source, fix) from error
        if column.ndim != 1:
            what = f"column '{name[:40]}' has shape {column.shape}, not (K,)"
            raise InputError(what, self.source, "give one number a row")
        return column


def _flat(arrays: Mapping[Any, Any], within: str = "") -> Iterator[tuple[str, Any]]:
    """Arrays by name as text, those in a dictionary as ``dictionary.name``."""
    for name, values in arrays.items():
        if isinstance(values, Mapping):
            yield from _flat(values, f"{within}{name}.")
        else:
            yield f"{within}{name}", values


def _shape(values: Any) -> tuple[int, ...]:
    """Shape of an array or of nested lists; empty for others."""
    try:
        return tuple(getattr(values, "shape", None) or np.shape(values))
    except ValueError:  # lists of several lengths
        return ()


def _samples_first(values: Any, samples: int) -> Any:
    """An array with its axis of `samples` as the first."""
    shape = _shape(values)
    if len(shape) not in (2, 3) or not shape[0] != samples == shape[-1]:
        return values
    masked = isinstance(values, np.ma.MaskedArray)
    return np.moveaxis(values if masked else np.asarray(values), -1, 0)


def _columns(name: str, values: Any) -> dict[str, Any]:
    """The columns of an array: itself, or one for each number of a sample."""
    if len(_shape(values)) not in (2, 3) or hasattr(values, "as_quat"):
        return {name: values}
    array = values if isinstance(values, np.ma.MaskedArray) else np.asarray(values)
    width = int(np.prod(array.shape[1:]))
    if not 0 < width <= LONGEST_LIST:
        return {name: values}
    rows = array.reshape(len(array), width)
    return {name if width == 1 else f"{name}_{j}": rows[:, j] for j in range(width)}


def _index_name(index: Any) -> str:
    """Name of a data frame's index as a column: its own, or "time" for dates, durations
    or increasing floats; empty for others, which number rows."""
    if (name := getattr(index, "name", None)) is not None:
        return str(name)
    kind = getattr(getattr(index, "dtype", None), "kind", "")
    grows = getattr(index, "is_monotonic_increasing", False)
    return "time" if kind in "mM" or (kind == "f" and grows) else ""


def _parts(name: str, column: Any) -> dict[str, Any]:
    """Columns of one of lists of numbers or of dictionaries; else the column itself."""
    first = next((row for row in column if row is not None), None)
    if not hasattr(first, "__len__") or isinstance(first, str | bytes):
        return {name: column}
    rows = column.to_pylist() if hasattr(column, "to_pylist") else list(column)
    first = next((row for row in rows if row is not None), [])
    if isinstance(first, Mapping):
        found: dict[str, Any] = {}
        for key in first:
            of_key = [(row or {}).get(key) for row in rows]
            found |= _parts(f"{name}.{key}", of_key)
        return found
    try:
        blank = np.full(np.shape(first), np.nan)
        array = np.array([np.asarray(blank if r is None else r, float) for r in rows])
    except (TypeError, ValueError):  # of several lengths, or of other things
        return {name: column}
    return _columns(name, array)


def _floats(values: Any) -> Array:
    """`values` as floats, blanks as NaN, dates in seconds from the first. Raises
    `TypeError` or `ValueError` for values that are no numbers."""
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
        # a pandas series with its own mark for blanks
        return np.asarray(values.to_numpy(dtype=float, na_value=np.nan), dtype=float)
    if array.dtype.kind not in "iufbO":
        raise TypeError(str(array.dtype))
    return array.astype(float)


def _kind(values: Any) -> str:
    """Kind of a column's values, in a word."""
    dtype = getattr(values, "dtype", None)
    if dtype is None:
        array = np.asarray(values, dtype=object).ravel()
        return f"a {type(array[0]).__name__}" if len(array) else "nothing"
    return "text" if str(dtype).lower() in ("object", "str", "string") else str(dtype)
