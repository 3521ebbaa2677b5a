"""Arrays that grow block by block while a table is read."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from hefting.core.recording import Stream
from hefting.core.spatial import Array, Mask, own


class Growing:
    """An array that grows block by block, in place, so that memory holds one copy."""

    def __init__(self, *width: int, dtype: type = float):
        self._array = np.empty((0, *width), dtype)
        self._count = 0

    def __len__(self) -> int:
        return self._count

    def append(self, values: NDArray | Sequence[NDArray]) -> None:
        """Add an array (K,), or columns (K,) of the rows."""
        columns = None if isinstance(values, np.ndarray) else values
        end = self._count + len(values if columns is None else columns[0])
        if end > len(self._array):
            self._resize(max(end, len(self._array) * 5 // 4, 8192))
        part = self._array[self._count : end]
        if columns is None:
            part[:] = values
        else:
            for j, column in enumerate(columns):
                part[:, j] = column
        self._count = end

    def finish(self) -> NDArray:
        """The whole array, read-only; it cannot grow any more."""
        self._resize(self._count)
        return own(self._array)

    def _resize(self, rows: int) -> None:
        # `refcheck` is not needed, as no view is kept
        self._array.resize((rows, *self._array.shape[1:]), refcheck=False)


class Samples:
    """Samples of one group of columns, and the rows in which they are."""

    def __init__(self, width: int):
        self._values = Growing(width)
        self._places: Growing | None = None  # None while every row has a sample

    def __len__(self) -> int:
        return len(self._values)

    def append(self, begin: int, columns: Sequence[Array], blank: Mask | None) -> None:
        """Add the rows from `begin` on that are not blank."""
        if blank is not None and self._places is None:
            self._places = Growing(dtype=np.int32)
            self._places.append(np.arange(begin))
        if blank is not None:
            columns = [column[~blank] for column in columns]
        if self._places is not None:
            rows = (
                np.arange(len(columns[0])) if blank is None else np.flatnonzero(~blank)
            )
            self._places.append(begin + rows)
        self._values.append(columns)

    def stream(self, times: Array, rows: NDArray) -> Stream:
        """All samples; `times` [s] and numbers are those of all rows of the table, and
        shared where each has a sample."""
        values = self._values.finish()
        if self._places is None:
            return Stream(times, values, rows)
        places = self._places.finish()
        return Stream(own(times[places]), values, own(rows[places]))
