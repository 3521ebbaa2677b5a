"""Canonical Parquet: the canonical table with nulls for what was not measured."""

import io
from pathlib import Path

import numpy as np

from hefting.errors import InputError
from hefting.files import write_atomically
from hefting.logs.canonical import MAX_CELLS, known_columns, recording_from_table, table_from_recording
from hefting.recording import Recording


def read_parquet(path: str | Path) -> Recording:
    """Recording in a Parquet file; see `hefting.logs.read_log`."""
    import pyarrow as pa
    from pyarrow import parquet

    numeric = (pa.types.is_integer, pa.types.is_floating, pa.types.is_decimal, pa.types.is_null)
    try:
        with parquet.ParquetFile(path) as file:
            schema = file.schema_arrow
            groups, warnings = known_columns(schema.names, path)
            columns = [c for c in schema.names if c == "time" or any(c in group for group in groups.values())]
            for column in columns:
                kind = schema.field(column).type
                if not any(is_kind(kind) for is_kind in numeric):
                    fix = "give seconds as numbers" if column == "time" else "give numbers"
                    raise InputError(f"holds {kind}, not numbers", f"{path}, column {column}", fix)
            if file.metadata.num_rows * len(columns) > MAX_CELLS:
                raise InputError(
                    f"has {file.metadata.num_rows} rows, too many to read",
                    path,
                    "cut out the part of interest",
                )
            table = file.read(columns=columns)
        table = table.cast(pa.schema([(column, pa.float64()) for column in table.column_names]), safe=False)
    except (pa.ArrowException, UnicodeDecodeError) as error:
        reason = str(error).splitlines()[0][:200] if str(error) else type(error).__name__
        raise InputError(f"cannot be read as Parquet ({reason})", path, "write the file again") from error
    return recording_from_table(table, groups, np.arange(1, table.num_rows + 1), path, warnings)


def write_parquet(recording: Recording, path: str | Path) -> None:
    """Write canonical Parquet."""
    from pyarrow import parquet

    stream = io.BytesIO()
    parquet.write_table(table_from_recording(recording), stream)
    write_atomically(path, stream.getvalue())
