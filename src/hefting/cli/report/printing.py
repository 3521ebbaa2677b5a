"""What every report shares: how it is printed, and its numbers as people read them: as
many digits as their interval is worth, points under each other, ``open`` where neither
the recording nor a shape determines them."""

import sys
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from shutil import get_terminal_size
from typing import Self

import numpy as np
from numpy.typing import ArrayLike
from rich.box import SIMPLE_HEAD
from rich.console import Console, Group
from rich.measure import Measurement
from rich.table import Table
from rich.text import Text

from hefting.cli.parser import WIDTH, wrapped
from hefting.cli.report import other_warnings, verdict_lines
from hefting.core.errors import printable
from hefting.core.estimate import Estimate
from hefting.core.messages import Verdict
from hefting.core.quantity import decimals
from hefting.core.spatial import tensor_to_vector

WIDEST = 1000
"""Columns that no table needs."""


def print_report(report: Group, render: Callable[[str], str] = str) -> None:
    """Print on standard output, no wider than the terminal; `WIDTH` columns where there
    is none.

    `render` turns the library's way of naming its arguments into the reader's. A table
    that is too wide has less space between its columns.
    """
    width = get_terminal_size().columns if sys.stdout.isatty() else WIDTH
    for line in report.renderables:
        if isinstance(line, Text):
            line.plain = wrapped(printable(render(line.plain)), width)
    console = Console(highlight=False, width=width)
    for line in report.renderables:
        if (
            isinstance(line, Table)
            and not line.show_lines  # of prose, which is wrapped anyway
            and _width_of(line, console) > width
        ):
            line.padding = 0
    console.print(report)


def plain_table(first: str, *others: str) -> Table:
    """A table with these columns and no rows yet: the first to the left, the others to
    the right but for those without a name."""
    table = Table(box=SIMPLE_HEAD, pad_edge=False, padding=(0, 1, 0, 0))
    table.add_column(first, no_wrap=True)
    for name in others:
        table.add_column(name, justify="right" if name else "left", overflow="fold")
    return table


def _width_of(table: Table, console: Console) -> int:
    """Columns that a table takes where it has them."""
    wide = console.options.update_width(WIDEST)
    return Measurement.get(console, wide, table).maximum


def doubt_lines(verdict: Verdict, warnings: Iterable[str]) -> list[Text]:
    """The verdict and its reasons, then the warnings that are none of them."""
    style = "bold" if verdict.level == "good" else "yellow"
    told = [Text(line, style=style) for line in verdict_lines(verdict)]
    return told + warning_lines(other_warnings(warnings, verdict))


def warning_lines(warnings: Iterable[str]) -> list[Text]:
    """One line each."""
    return [Text(f"warning: {line}", style="yellow") for line in warnings]


FEWEST, MOST = 0, 9
"""Decimals that are printed."""
SIGNIFICANT = 4
"""Digits of a number of which nobody says how sure it is."""

MILLIMETRE = 3
"""Decimal places by which millimetres differ from metres."""
LEAST_DIGITS = 2
"""Significant digits of the mass, and of the largest moment, that are shown however
wide their intervals are."""
NOTHING = 0.01
"""Share of the widest interval of the inertia below which moments count as none."""


def decimals_of(value: float, reach: float | None, digits: int = 2) -> int:
    """Decimals that show so many `digits` of how far a value may be off, its `reach`;
    where that is not known, `SIGNIFICANT` digits of the value."""
    known = reach is not None and np.isfinite(reach) and reach > 0.0
    size, digits = (reach, digits) if known else (abs(value), SIGNIFICANT)
    if not size or not np.isfinite(size):
        return FEWEST
    # 9.96 has as many digits before the point as 10 once it is rounded
    order = int(np.floor(np.log10(size) + 1e-3))
    return int(np.clip(digits - 1 - order, FEWEST, MOST))


def fixed(value: float, decimals: int) -> str:
    """A number with so many decimals, without a minus before a zero; ``open`` where it
    is not finite."""
    if not np.isfinite(value):
        return "open"
    return f"{round(float(value), decimals) + 0.0:.{decimals}f}"


def with_reach(values: ArrayLike, reach: float | None) -> str:
    """``"1.4, 172.2, 60.0 ± 0.8"``, with one digit of how far each may be off at most;
    the values alone where nobody says."""
    numbers = np.asarray(values, dtype=float)
    if not np.isfinite(numbers).all() or (reach is not None and not np.isfinite(reach)):
        return "open"
    decimals = decimals_of(float(np.abs(numbers).max()), reach, 1)
    text = ", ".join(fixed(value, decimals) for value in numbers)
    return text if reach is None else f"{text} ± {fixed(reach, decimals)}"


def aligned(rows: Sequence[Sequence[str]]) -> list[list[str]]:
    """Rows of numbers, filled up so that in each column points stand under each other
    where the column is set to the right."""
    places = [max(map(_places, column)) for column in zip(*rows, strict=True)]
    return [
        [text + " " * (n - _places(text)) for text, n in zip(row, places, strict=True)]
        for row in rows
    ]


def _places(text: str) -> int:
    """Characters from the point on."""
    _, point, part = text.partition(".")
    return len(point) + len(part)


@dataclass(frozen=True, eq=False)
class Worth:
    """Decimal places of mass [kg], COM [mm] and inertia at the COM [kg m²], and which of
    the ten are open."""

    places: np.ndarray
    open: np.ndarray

    @classmethod
    def of(cls, estimate: Estimate) -> Self:
        """From the intervals of an estimate."""
        p, half = estimate.parameters, estimate.half_widths
        com, moments = p.center_of_mass, p.inertia_at_com.diagonal()
        wide = half["inertia_at_com"]
        widest = float(np.max(wide, where=np.isfinite(wide), initial=0.0))
        size = max(float(np.abs(moments).max()), NOTHING * widest)
        inertia = decimals(wide, size, LEAST_DIGITS)
        places = (
            decimals(half["mass"], abs(p.mass), LEAST_DIGITS),
            *decimals(half["center_of_mass"], float(np.abs(com).max())) - MILLIMETRE,
            *tensor_to_vector(inertia).astype(int),
        )
        return cls(np.array(places, dtype=int), estimate.undetermined.ten)

    def text(self, value: float, row: int, is_estimate: bool) -> str:
        """A number of one row; an end of an interval may be open by itself."""
        if not np.isfinite(value) or (is_estimate and self.open[row]):
            return "open"
        return fixed(value, max(int(self.places[row]), 0))
