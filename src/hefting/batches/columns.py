"""Columns of the table of results, with their Arrow types.

The keys are those of ``hefting identify --json``; matrices are lists of fixed size, row
by row. A value that does not apply is null, as most of a recording that failed.
"""

import json
from collections.abc import Mapping, Sequence
from functools import cache
from typing import TYPE_CHECKING, Any

from hefting.core.estimate import Estimate

if TYPE_CHECKING:
    import pyarrow as pa

SCHEMA = "hefting.batch/1"
"""Name and version of the schema, in the metadata of the files."""
STAGES: tuple[str, ...] = ("reading", "motion", "conditioning", "solving")
"""Stages of an identification, whose times [s] are kept."""

Row = dict[str, Any]


@cache
def columns() -> "pa.Schema":
    """The columns in order, with their types."""
    import pyarrow as pa

    real, text, truth = pa.float64(), pa.string(), pa.bool_()
    texts = pa.list_(text)

    def array(size: int, of: "pa.DataType" = real) -> "pa.DataType":
        return pa.list_(of, size)

    def struct(**fields: "pa.DataType") -> "pa.DataType":
        return pa.struct(list(fields.items()))

    ten = {"mass": real, "center_of_mass": array(3), "inertia_at_com": array(9)}
    margins = dict.fromkeys(
        ("mass", "inertia", "triangle", "pseudo_inertia", "hull"), real
    )
    message = struct(code=text, severity=text, text=text, argument=text)
    left_out = struct(recording=text, error=text, error_text=text)
    return pa.schema(
        {
            "recording": text,
            "name": text,
            "object": text,
            "recordings": texts,
            "left_out": pa.list_(left_out),
            "error": text,
            "error_text": text,
            "schema": text,
            "version": text,
            "method": text,
            "frame": text,
            "verdict": text,
            "reasons": texts,
            **ten,
            "inertia_at_origin": array(9),
            "vector": array(10),
            "covariance": array(100),
            "intervals": struct(
                mass=array(2),
                center_of_mass=array(6),
                inertia_at_com=array(18),
                inertia_at_origin=array(18),
            ),
            "std": struct(**ten),
            "undetermined": struct(
                mass=truth,
                center_of_mass=array(3, truth),
                inertia_at_com=array(9, truth),
                filled_from=text,
            ),
            "accuracy": struct(mass=real, center_of_mass=real, inertia=real),
            "sufficient": truth,
            "physically_consistent": truth,
            "consistency": struct(margins=struct(**margins), violated=text),
            "certificate": struct(
                objective=real,
                bound=real,
                iterations=pa.int64(),
                converged=truth,
                gap=real,
            ),
            "bias": pa.list_(real),
            "residual": array(2),
            "point_masses": pa.list_(real),
            "samples": pa.int64(),
            "duration": real,
            "warnings": texts,
            "messages": pa.list_(message),
            "provenance": text,
            "options": text,
            "hash": text,
            "seconds": struct(**dict.fromkeys(STAGES, real)),
        }.items(),
        metadata={"hefting": SCHEMA},
    )


def filled(row: Row, estimate: Estimate) -> Row:
    """A row with an estimate, by the keys of ``hefting identify --json``."""
    found = estimate.to_dict()
    found["provenance"] = json.dumps(found["provenance"])
    found["messages"] = [
        {key: message.get(key) for key in ("code", "severity", "text", "argument")}
        for message in found["messages"]
    ]
    return row | {key: flat(value) for key, value in found.items()}


def flat(value: Any) -> Any:
    """Nested lists of numbers as one list, also inside dictionaries."""
    if isinstance(value, Mapping):
        return {key: flat(own) for key, own in value.items()}
    if isinstance(value, list) and value and isinstance(value[0], list):
        return [number for row in value for number in flat(row)]
    return value


def table_of(rows: Sequence[Row]) -> "pa.Table":
    """Rows as a table; a key that a row does not have is null."""
    import pyarrow as pa

    return pa.Table.from_pylist(list(rows), schema=columns())
