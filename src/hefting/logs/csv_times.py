"""Dates and times of day in text cells, as seconds."""

import re
from datetime import UTC, datetime

import numpy as np

from hefting.core.spatial import Array, Mask

DATE = re.compile(
    r"\s*\d{4}-\d\d-\d\d[T ]\d\d:\d\d(:\d\d(\.\d+)?)?(?P<zone>Z|[+-]\d\d:?\d\d)?\s*"
)
"""A date with a time of day in ISO 8601."""

TWELVE = re.compile(
    r"\b(\d\d?)(:\d\d:[\d.,:]+)[ \u202f]?([AP])\.?M\b\.?", re.IGNORECASE
)
"""A time of day in twelve hours: 1:31:07 PM."""

OTHER_WAYS = (
    (
        r"\b(?:0 days |(?:\d\d?([/-])\d\d?\1\d{4}|\d{8}|\d\d-[A-Z][a-z]{2}-\d{4}"
        r"|[A-Z][a-z]{2} \d\d?, \d{4},?)[T ])(?=\d\d?:)|(?<=\d) sec\b",
        "",
    ),
    (r"\b(\d\d)\.(\d\d)\.(\d{4})(?=[T ]\d\d?:)", r"\3-\2-\1"),
    (r"\b(\d{4})/(\d\d)/(\d\d)(?=[T ]\d\d?:)", r"\1-\2-\3"),
    (r"(?<![\d:.])(\d:\d\d:\d\d)", r"0\1"),
    (r"\b(\d\d:\d\d:\d\d):(\d{1,9})\b", r"\1.\2"),
)
"""Patterns of other dates and times of day, and their replacement in ISO 8601:
31.01.2026, 2026/01/31, pandas' ``0 days 00:00:01``, MATLAB's ``0.01 sec``, 9:05:00 and
12:00:00:123. The date is dropped, and the time of day kept, of 3/4/2026, where day or
month may come first, of 20260131, MATLAB's 31-Jan-2026 and Java's Jan 31, 2026."""

WITH_COMMA = (r"(\d\d:\d\d:\d\d),(\d{1,9})\b", r"\1.\2")
"""The same for 12:00:00,123, where commas do not separate cells."""

TIME_OF_DAY = re.compile(r"\s*([01]\d|2[0-3]):([0-5]\d):([0-5]\d(\.\d{1,9})?)\s*")
"""A time of day without a date."""

YEARS = range(1678, 2262)
"""Years whose nanoseconds since 1970 fit into 64 bits."""

DAY = 86_400.0
"""[s]"""

WRITTEN = "2026-01-31T12:00:00.000, or 12:00:00.000"
"""Examples of readable times, for messages."""


def kind_of(cell: str) -> str:
    """Kind of a cell: "date", "date with zone", "time of day", or empty for others."""
    if TIME_OF_DAY.fullmatch(by_iso(cell)):
        return "time of day"
    if seconds_of(cell) is None:
        return ""
    zone = DATE.fullmatch(by_iso(cell))["zone"]  # type: ignore[index]
    return "date with zone" if zone else "date"


def seconds_of(cell: str) -> float | None:
    """A date in seconds since 1970, a time of day in seconds since midnight; None for
    others."""
    cell = by_iso(cell)
    if time := TIME_OF_DAY.fullmatch(cell):
        return 3600.0 * int(time[1]) + 60.0 * int(time[2]) + float(time[3])
    if not DATE.fullmatch(cell):
        return None
    try:
        date = datetime.fromisoformat(cell.strip())
    except ValueError:  # such as month 13
        return None
    date = date if date.tzinfo else date.replace(tzinfo=UTC)
    return date.timestamp() if date.year in YEARS else None


def by_iso(text: str, separator: str = "") -> str:
    """A cell, or a text whose cells have this separator, with dates and times of day in
    ISO 8601."""
    if ":" not in text and " sec" not in text:
        return text
    text = TWELVE.sub(
        lambda at: f"{int(at[1]) % 12 + 12 * (at[3] in 'pP'):02}{at[2]}", text
    )
    # blanks separate the date from the time, and a comma ends a cell
    ways = OTHER_WAYS[1:] if separator == " " else OTHER_WAYS
    for pattern, written in ways if separator == "," else (*ways, WITH_COMMA):
        text = re.sub(pattern, written, text)
    return text


class Midnights:
    """Makes times of day increase beyond midnight, block by block."""

    def __init__(self):
        self._last, self._days = -np.inf, 0

    def unfold(self, values: Array, blank: Mask | None) -> Array:
        """Times (R,) [s] since the first midnight; arbitrary where blank."""
        known = np.ones(len(values), dtype=bool) if blank is None else ~blank
        if not known.any():
            return values
        begins = np.diff(values[known], prepend=self._last) < -0.5 * DAY
        days = self._days + np.cumsum(begins)
        self._last, self._days = values[known][-1], days[-1]
        unfolded = values.copy()
        unfolded[known] += DAY * days
        return unfolded
