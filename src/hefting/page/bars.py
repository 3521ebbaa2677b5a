"""Bars: intervals, or counts, of one kind above one another, on one scale."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from hefting.page.html import Markup, element
from hefting.scene import plus_minus


@dataclass(frozen=True)
class Row:
    """One interval. Numbers are in the unit of its scale."""

    name: str
    value: float | None
    """None where only the interval is known; not shown where open"""
    low: float
    """lower end, minus infinity where open; NaN where the method has no interval"""
    high: float
    truth: float | None = None
    matters: bool = True
    """whether the scale is made to hold it"""

    @property
    def is_open(self) -> bool:
        """Whether nothing is known of it."""
        return bool(np.isinf((self.low, self.high)).all())


def bars(rows: Sequence[Row], unit: str, *, from_zero: bool = False) -> Markup:
    """Rows of one unit as HTML: name, number, and the interval as a bar; below them the
    scale, which holds zero if `from_zero`."""
    rows = [replace(row, value=None) if row.is_open else row for row in rows]
    low, high = _scale(rows, from_zero=from_zero)
    cells: list[Markup] = []
    for row in rows:
        number = _number(row)
        shown = number if number == "open" else f"{number} {unit}"
        cells += _cells(row.name, shown, *_marks(row, low, high))
    marked = not all(row.is_open and row.truth is None for row in rows)
    labels = _labels(low, high, unit) if marked else ()
    scale = element("div", *labels, class_="scale")
    return element("div", *cells, scale, class_="bars")


def _cells(name: str, number: str, *drawn: Markup) -> list[Markup]:
    return [
        element("span", name),
        element("span", number, class_="value"),
        element("span", *drawn, class_="track"),
    ]


def _number(row: Row) -> str:
    """The value, and how far its interval reaches at the farther end; the middle of the
    interval where there is no value."""
    if row.value is None and np.isfinite((row.low, row.high)).all():
        middle, half = 0.5 * (row.low + row.high), 0.5 * (row.high - row.low)
        return plus_minus(middle, half)
    if row.value is None or not np.isfinite(row.value):
        return "open"
    if np.isnan(row.low):
        return plus_minus(row.value, None)
    return plus_minus(row.value, max(row.high - row.value, row.value - row.low))


def _scale(rows: Sequence[Row], *, from_zero: bool) -> tuple[float, float]:
    """Ends of the scale: all finite numbers of the rows that matter, and some room."""
    held = [0.0] if from_zero else []
    for row in rows:
        if row.matters:
            given = (row.value, row.low, row.high, row.truth)
            held += [v for v in given if v is not None and np.isfinite(v)]
    low, high = (min(held), max(held)) if held else (0.0, 1.0)
    room = 0.08 * (high - low) or max(abs(high), 1e-9)
    return (low - room if low < 0.0 or not from_zero else 0.0), high + room


def _marks(row: Row, low: float, high: float) -> Iterable[Markup]:
    """Interval, zero, truth and value of a row."""

    def at(value: float) -> float:
        return float(np.clip(100.0 * (value - low) / (high - low), 0.0, 100.0))

    if row.is_open:
        yield element("i", class_="open", title="open: not determined")
    elif not np.isnan(row.low):
        left, right = at(row.low), at(row.high)
        style = f"left:min({left:.3f}%,100% - 4px);width:{right - left:.3f}%"
        yield element("i", class_="range", style=style)
    if low < 0.0 < high:
        yield element("i", class_="zero", style=f"left:{at(0.0):.3f}%")
    if row.value is not None and np.isfinite(row.value) and low <= row.value <= high:
        yield element("i", class_="at", style=f"left:{at(row.value):.3f}%")
    if row.truth is not None:
        title = f"truth: {row.truth:.5g}"
        yield element(
            "i", class_="true", style=f"left:{at(row.truth):.3f}%", title=title
        )


def _labels(low: float, high: float, unit: str) -> list[Markup]:
    """The ends of the scale, and zero where it is well inside."""

    def text(value: float) -> str:
        return f"{value:.3g}".replace("-", "−")

    share = -low / (high - low)
    middle = []
    if 0.25 < share < 0.65:
        style = f"left:{100.0 * share:.3f}%;transform:translateX(-50%)"
        middle = [element("span", "0", style=style)]
    return [
        element("span", text(low), style="left:0"),
        *middle,
        element("span", f"{text(high)} {unit}", style="right:0"),
    ]


@dataclass(frozen=True)
class Count:
    """How much there is of one kind."""

    name: str
    value: float
    shown: str
    """The number with its unit"""
    colour: str = "x"
    """By its name in `hefting.page.figure`"""


def counts(rows: Sequence[Count]) -> Markup:
    """Rows as HTML: name, number and a bar, of the full width where it is all."""
    total = sum(row.value for row in rows) or 1.0
    cells: list[Markup] = []
    for row in rows:
        width = f"left:0;width:{100.0 * row.value / total:.3f}%"
        bar = element("i", style=f"{width};background:var(--{row.colour})")
        cells += _cells(row.name, row.shown, bar)
    return element("div", *cells, class_="bars")
