"""Rows of a batch, as its table has them, without identifying anything."""

import json

import numpy as np
import pyarrow as pa
from pyarrow import parquet

from hefting.batches.batch import Batch, Progress
from hefting.batches.columns import STAGES, columns, table_of
from hefting.batches.results import TABLE

SPENT = dict(zip(STAGES, (0.1, 0.2, 0.6, 0.1), strict=True))
"""[s] Of each row."""


def start(recording, **more):
    """What every row has."""
    return {
        "recording": recording,
        "name": None,
        "object": None,
        "error": None,
        "options": json.dumps({"shape": "a mug.stl", "gravity": "-1,0,-9.7"}),
        "seconds": SPENT,
    } | more


def identified(recording, mass=0.67, residual=(0.1, 0.005), **more):
    """A row with an answer."""
    return start(
        recording,
        verdict="good",
        reasons=[],
        mass=mass,
        intervals={"mass": [mass - 0.002, mass + 0.002]},
        residual=None if residual is None else list(residual),
        messages=[],
        **more,
    )


def doubted(recording, code, text, verdict="usable with care", **more):
    """A row with an answer that is in doubt."""
    told = {"code": code, "severity": "warning", "text": text, "argument": None}
    more = {"verdict": verdict, "reasons": [text], "messages": [told]} | more
    return identified(recording) | more


def failed(recording, text, error="InputError", **more):
    """A row without an answer."""
    return start(recording, error=error, error_text=f"{recording}: {text}", **more)


def batch_of(folder, rows, copies=1):
    """A batch whose folder has these rows, so many times over."""
    folder.mkdir(exist_ok=True)
    table = table_of(rows)
    with parquet.ParquetWriter(folder / TABLE, columns()) as writer:
        for copy in range(copies):
            writer.write_table(table if copies == 1 else _renamed(table, copy))
    count = len(rows) * copies
    lost = sum(row["error"] is not None for row in rows) * copies
    return Batch(folder, Progress(count, count, 0, lost), seconds=10.0)


def _renamed(table, copy):
    names = [f"{copy}/{name}" for name in table["recording"].to_pylist()]
    return table.set_column(0, table.schema.field(0), pa.array(names))


def spread(count, seed=0):
    """Rows with residuals and masses of many sizes."""
    rng = np.random.default_rng(seed)
    forces = 0.1 * np.exp(0.1 * rng.standard_normal(count))
    return [
        identified(f"day/log {k}.csv", 0.2 * (1 + k % 5), (force, 0.05 * force))
        for k, force in enumerate(forces.tolist())
    ]
