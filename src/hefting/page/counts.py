"""Counts: how many there are of each kind, as bars on one scale."""

from collections.abc import Sequence
from dataclasses import dataclass

from hefting.page.html import Markup, element


@dataclass(frozen=True)
class Count:
    """How much there is of one kind."""

    name: str
    value: float
    shown: str
    """The number with its unit"""
    colour: str = "x"
    """By its name in `hefting.page.palette`"""


def counts(rows: Sequence[Count]) -> Markup:
    """Rows as HTML: name, number and a bar, of the full width where it is all."""
    total = sum(row.value for row in rows) or 1.0
    cells: list[Markup] = []
    for row in rows:
        width = f"left:0;width:{100.0 * row.value / total:.3f}%"
        bar = element("i", style=f"{width};background:var(--{row.colour})")
        cells += [
            element("span", row.name),
            element("span", row.shown, class_="value"),
            element("span", bar, class_="track"),
        ]
    return element("div", *cells, class_="bars")
