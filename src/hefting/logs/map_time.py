"""The time of a column map: a column in some unit, seconds and nanoseconds in two, or
rows at a rate."""

from dataclasses import dataclass
from typing import Any

from hefting.core.errors import InputError
from hefting.logs.layout import brief
from hefting.logs.map_entries import parse_entry, parse_one_column
from hefting.logs.units import SECOND, Unit, find_unit


@dataclass(frozen=True)
class MappedTime:
    """Where the times of a table come from."""

    column: str | int | None
    """None: rows are counted"""
    unit: Unit
    """of that column, or of the count"""
    nanoseconds: str | int | None = None
    """column of what comes on top of seconds [ns]"""

    @property
    def columns(self) -> list[str | int]:
        """Those that are read: of the time, and of its nanoseconds."""
        return [c for c in (self.column, self.nanoseconds) if c is not None]


def parse_time(value: Any, where: str) -> MappedTime:
    """The time that a column map gives; `InputError`, naming `where`."""
    entry = parse_entry(
        value, "column", ("column", "unit", "rate", "nanoseconds"), where
    )
    if "column" not in entry and "rate" not in entry:
        raise InputError(
            "says neither column nor rate",
            where,
            'give { column = "name" } or { rate = 1000 } in Hz',
        )
    column = None
    if "column" in entry:
        column = parse_one_column(entry["column"], where)
    if "rate" in entry:
        return MappedTime(column, _unit_of_rate(entry, where))
    unit = find_unit(entry.get("unit", "s"), "time", f"{where}.unit")
    if "nanoseconds" not in entry:
        return MappedTime(column, unit)
    if unit is not SECOND:
        raise InputError(
            f"has nanoseconds on top of {unit.name}", where, 'give unit = "s"'
        )
    more = parse_one_column(entry["nanoseconds"], f"{where}.nanoseconds")
    return MappedTime(column, unit, more)


def _unit_of_rate(entry: dict[str, Any], where: str) -> Unit:
    """The unit of a count of frames."""
    rate = entry["rate"]
    if (
        isinstance(rate, bool)
        or not isinstance(rate, int | float)
        or not 0 < rate < 1e9
    ):
        raise InputError(
            f"the rate {brief(rate)} is no positive number",
            f"{where}.rate",
            "give it in Hz",
        )
    for other in ("unit", "nanoseconds"):
        if other in entry:
            raise InputError(
                f"says both {other} and rate",
                where,
                "give the rate alone if the column counts frames",
            )
    return SECOND if rate == 1 else Unit(f"frames at {rate:g} Hz", 1.0, float(rate))
