"""The estimate itself, in its frame and SI units, even if it is not consistent: as JSON,
and as a row of CSV."""

import io
import json

from hefting.core.estimate import Estimate
from hefting.core.spatial import tensor_to_vector
from hefting.export.target import Target


def write_json(estimate: Estimate, name: str) -> str:
    """JSON, which `Estimate.load` reads in sensor axes; it does not hold the name."""
    return json.dumps(estimate.to_dict(), indent=1) + "\n"


JSON = Target(
    name="json",
    description="the estimate itself, which Hefting reads back",
    suffixes=(".json",),
    write_estimate=write_json,
    is_read_back=True,
)


ENTRIES = ("xx", "xy", "xz", "yy", "yz", "zz")
AT_COM = ("mass", "cx", "cy", "cz", *(f"I{e}" for e in ENTRIES))
"""Mass [kg], COM [m], inertia about the COM [kg m²]."""
COLUMNS = (
    *("name", "method", "frame", *AT_COM),
    *(f"J{e}" for e in ENTRIES),
    *(f"std_{column}" for column in AT_COM),
    *("samples", "duration", "physically_consistent", "open"),
)
"""Columns of the CSV: J is the inertia about the frame's origin [kg m²]; std, one
standard deviation, is empty if the method has none; duration in s; open lists the
columns at the COM that neither the recording nor a shape determines, separated by
spaces."""


def write(estimate: Estimate, name: str) -> str:
    """A header, `COLUMNS`, and one row."""
    import csv

    p, std = estimate.parameters, estimate.std
    at_com = (p.mass, *p.center_of_mass, *tensor_to_vector(p.inertia_at_com))
    deviations = (None,) * 10
    if std:
        inertia = tensor_to_vector(std["inertia_at_com"])
        deviations = (std["mass"], *std["center_of_mass"], *inertia)
    values = (*at_com, *p.vector[4:], *deviations)
    flags = zip(AT_COM, estimate.undetermined.ten, strict=True)
    undetermined = [column for column, is_open in flags if is_open]
    stream = io.StringIO()
    writer = csv.writer(stream, lineterminator="\n")
    writer.writerow(COLUMNS)
    writer.writerow(
        (
            *map(_text, (name, estimate.method)),
            estimate.frame,
            *("" if value is None else repr(float(value)) for value in values),
            *(estimate.samples, estimate.duration, estimate.physically_consistent),
            " ".join(undetermined),
        )
    )
    return stream.getvalue()


def _text(cell: str) -> str:
    """A cell that spreadsheets do not take for a formula."""
    return f"'{cell}" if cell.startswith(("=", "+", "-", "@")) else cell


CSV = Target(
    name="csv",
    description="the estimate as one row of a table",
    suffixes=(".csv",),
    write_estimate=write,
)
