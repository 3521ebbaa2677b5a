"""Positions in another unit of length."""

from collections.abc import Iterator

from hefting.ingest.rivals.case import Case
from hefting.ingest.rivals.explanation import Explanation, Undone, likeliest

CODE = "position-unit"
UNITS = {"millimetres": 1e-3, "centimetres": 1e-2, "inches": 0.0254, "feet": 0.3048}
"""Units of length [m] in which positions may be logged."""


def explain(case: Case) -> Explanation | None:
    """The likeliest unit."""
    return likeliest(_each(case, *UNITS))


def undone(case: Case) -> Iterator[Undone]:
    """Each common unit."""
    return _each(case, "millimetres", "centimetres")


def _each(case: Case, *units: str) -> Iterator[Undone]:
    """Each of the units, if accelerations are derivatives of positions."""
    if not case.recording.has("position") or case.path.kind != "smooth":
        return
    for unit in units:
        size = UNITS[unit]
        yield Undone(
            CODE,
            f"the positions seem to be in {unit}",
            f'give them in metres, or unit = "{size:g} m" of them in a column map',
            case.with_accelerations(size, 1.0),
            argument="column_map",
            is_linear=True,
        )
