"""What an experiment is: independent jobs, the function that does one, and the report
made of all results."""

import csv
import io
import json
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from matplotlib.figure import Figure

Job = dict[str, Any]
"""Parameters of one job, JSON-ready, its seed among them: the result depends on nothing
else."""
Result = dict[str, Any]
"""Numbers a job found, JSON-ready."""
Cell = str | float | int | None
PLAIN = 1e6
"""Numbers below it are shown without an exponent."""


@dataclass(frozen=True)
class Table:
    """Rows under named columns; units are in the names."""

    name: str
    """Of its files."""
    title: str
    columns: tuple[str, ...]
    rows: tuple[tuple[Cell, ...], ...]

    def csv(self) -> str:
        """Comma-separated values with one header row."""
        text = io.StringIO()
        csv.writer(text, lineterminator="\n").writerows((self.columns, *self.rows))
        return text.getvalue()

    def json(self) -> str:
        """A list of objects, one a row."""
        rows = [dict(zip(self.columns, row, strict=True)) for row in self.rows]
        return json.dumps(rows, indent=1) + "\n"

    def markdown(self) -> str:
        """A Markdown table, numbers with three digits."""
        lines = [
            " | ".join(map(str, self.columns)),
            " | ".join("---" for _ in self.columns),
        ]
        lines += [" | ".join(map(shown, row)) for row in self.rows]
        return "".join(f"| {line} |\n" for line in lines)


def shown(cell: Cell) -> str:
    """A cell as a person reads it: three significant digits, nothing for what is not
    known."""
    if cell is None:
        return ""
    if not isinstance(cell, float):
        return str(cell)
    text = f"{cell:.3g}"
    return f"{float(text):.0f}" if "e+" in text and abs(cell) < PLAIN else text


@dataclass(frozen=True)
class Report:
    """What an experiment shows."""

    tables: tuple[Table, ...]
    figures: dict[str, "Figure"] = field(default_factory=dict)
    """By the name of its files."""
    notes: tuple[str, ...] = ()
    """What to know when reading them: where a figure differs from the published one,
    and why; one sentence each."""


@dataclass(frozen=True)
class Experiment:
    """One table or figure of the paper."""

    name: str
    """As on the command line."""
    title: str
    source: str
    """Table, figure or section of Nadeau et al. 2022."""
    jobs: Callable[[bool], list[Job]]
    """All jobs, or few of them for a quick run."""
    run: Callable[[Job], Result]
    report: Callable[[list[tuple[Job, Result]]], Report]
    """Of jobs and their results, in the order of `jobs`."""
