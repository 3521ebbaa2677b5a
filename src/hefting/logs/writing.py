"""A recording as a canonical table: CSV or Parquet."""

import io
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from hefting.core.files import write_atomically
from hefting.core.recording import Recording, column_names

if TYPE_CHECKING:
    import pyarrow as pa

GROUP = 65_536
"""Rows of Parquet that are written as a group."""


def write_csv(recording: Recording, path: str | Path) -> None:
    """Write canonical CSV, each number with the fewest digits that give back the same bits."""
    from pyarrow import csv as pacsv

    table = table_from_recording(recording)
    stream = io.BytesIO()
    stream.write((",".join(table.column_names) + "\n").encode())
    pacsv.write_csv(table, stream, pacsv.WriteOptions(include_header=False))
    del table
    write_atomically(path, stream.getvalue())


def write_parquet(recording: Recording, path: str | Path) -> None:
    """Write canonical Parquet."""
    from pyarrow import parquet

    stream = io.BytesIO()
    parquet.write_table(table_from_recording(recording), stream, row_group_size=GROUP)
    write_atomically(path, stream.getvalue())


def table_from_recording(recording: Recording) -> "pa.Table":
    """The canonical table of a recording: a row for each instant at which any stream has a sample."""
    import pyarrow as pa

    times = np.unique(np.concatenate([stream.time for stream in recording.streams.values()]))
    columns = {} if recording.static else {"time": pa.array(times)}
    for name, stream in recording.streams.items():
        at = np.searchsorted(times, stream.time)
        blank = np.ones(len(times), dtype=bool)
        blank[at] = False
        for j, column in enumerate(column_names(name, stream.values.shape[1])):
            values = np.zeros(len(times))
            values[at] = stream.values[:, j]
            columns[column] = pa.array(values, mask=blank)
    return pa.table(columns)
