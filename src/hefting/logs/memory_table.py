"""Tables held in memory: a dictionary of columns, a data frame or a structured array.

Data frames are taken by what they do, so that pandas, polars and PyArrow are not
imported: a list of column names, and a column by its name.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from hefting.core.errors import InputError
from hefting.core.spatial import Array
from hefting.logs.arrays import elapsed
from hefting.logs.table import Block


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
    def of(cls, table: Any) -> "MemoryTable | None":
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
    def _of_frame(cls, frame: Any, names: list[Any]) -> "MemoryTable":
        """The columns of a data frame, before them its index where that has a name or
        holds times."""
        columns = _by_text(frame, dict.fromkeys(names))
        index = getattr(frame, "index", None)
        name = _index_name(index)
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
