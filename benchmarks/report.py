"""The report: sections of rows, as a table for reading and as JSON for comparing."""

import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from rich.console import Console
from rich.table import Table

from benchmarks.timing import Timing


@dataclass(frozen=True)
class Row:
    """One line of the report."""

    what: str
    timing: Timing | None = None
    """Its times, if it is a piece of work."""
    figure: float | None = None
    """What was found, apart from the times."""
    unit: str = ""
    """Of the figure; ``x``: how many times faster than the party it is compared with,
    by the medians; ``of ...``: what share of that party's time, or memory, it takes."""
    at_least: float | None = None
    """Target of the figure, from below."""
    at_most: float | None = None
    """Target of the figure, from above."""
    name: str = ""
    """Under which a share is kept, see `benchmarks.ratios`."""

    @property
    def met(self) -> bool | None:
        """Whether the target is met; None without one."""
        if self.figure is None or (self.at_least is None and self.at_most is None):
            return None
        return (self.at_least is None or self.figure >= self.at_least) and (
            self.at_most is None or self.figure <= self.at_most
        )

    def to_dict(self) -> dict[str, Any]:
        """The row as JSON-ready values, times in seconds."""
        times = None
        if self.timing is not None:
            t = self.timing
            times = {
                "median": t.median,
                "best": t.best,
                "median_cpu": t.median_cpu,
                "repetitions": len(t.wall),
            }
        return {
            "what": self.what,
            "seconds": times,
            "figure": self.figure,
            "unit": self.unit,
            "at_least": self.at_least,
            "at_most": self.at_most,
            "met": self.met,
        }


@dataclass(frozen=True)
class Section:
    """Rows that belong together."""

    title: str
    rows: tuple[Row, ...]


def faster(
    what: str, ours: Timing, theirs: Timing, at_least: float | None = None
) -> Row:
    """Row of `ours`, with how many times faster than `theirs` it is: the ratio of the
    medians."""
    return Row(what, ours, theirs.median / ours.median, "x", at_least=at_least)


def saved(sections: list[Section], quick: bool, path: Path) -> None:
    """Write the figures as JSON."""
    report = {
        "quick": quick,
        "sections": [
            {"title": s.title, "rows": [r.to_dict() for r in s.rows]} for s in sections
        ],
    }
    path.write_text(json.dumps(report, indent=1) + "\n")


def show(sections: list[Section]) -> None:
    """Print one table."""
    table = Table(show_edge=False, pad_edge=False)
    table.add_column("", overflow="fold")
    for name in ("median", "best", "median CPU", "figure", "target"):
        table.add_column(name, justify="right", no_wrap=True)
    for section in sections:
        table.add_section()
        table.add_row(f"[bold]{section.title}[/bold]")
        for row in section.rows:
            times = ("", "", "")
            if row.timing is not None:
                t = row.timing
                times = (seconds(t.median), seconds(t.best), seconds(t.median_cpu))
            table.add_row(
                f"  {row.what}", *times, number(row.figure, row.unit), target(row)
            )
    Console(width=118).print(table)


def seconds(value: float) -> str:
    """A time for reading."""
    for size, unit in ((1.0, "s"), (1e-3, "ms")):
        if value >= size:
            return f"{value / size:.3g} {unit}"
    return f"{value * 1e6:.3g} µs"


def number(value: float | None, unit: str) -> str:
    """A figure for reading; objectives [N] with the digits in which they could
    differ."""
    if value is None:
        return ""
    if unit == "s":
        return seconds(value)
    digits = (
        f"{value:,.0f}"
        if abs(value) >= 1000.0
        else f"{value:.{8 if unit == 'N' else 3}g}"
    )
    return f"{digits} {unit}".rstrip()


def target(row: Row) -> str:
    """The target for reading, marked when it is missed."""
    bounds = [("≥", row.at_least), ("≤", row.at_most)]
    text = " ".join(
        f"{sign} {number(value, row.unit)}"
        for sign, value in bounds
        if value is not None
    )
    return f"{text} {'✓' if row.met else '[bold]missed[/bold]'}" if text else ""
