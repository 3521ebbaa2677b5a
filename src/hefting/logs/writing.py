"""A recording as a canonical table, which CSV and Parquet are written from."""

from typing import TYPE_CHECKING

import numpy as np

from hefting.core.recording import Recording, column_names

if TYPE_CHECKING:
    import pyarrow as pa


def table_from_recording(recording: Recording) -> "pa.Table":
    """The canonical table of a recording: a row for each instant at which any stream
    has a sample."""
    import pyarrow as pa

    times = np.unique(
        np.concatenate([stream.time for stream in recording.streams.values()])
    )
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
