"""Printing of reports, and the parts that they share."""

from collections.abc import Callable, Iterable

from rich.box import SIMPLE_HEAD
from rich.console import Console, Group
from rich.measure import Measurement
from rich.table import Table
from rich.text import Text

from hefting.cli.parser import output_width, wrapped
from hefting.cli.report import verdict_lines
from hefting.core.errors import printable
from hefting.core.messages import Verdict

WIDEST = 1000
"""More columns than any table needs."""


def print_report(report: Group, render: Callable[[str], str] = str) -> None:
    """Print on standard output, no wider than the terminal, or than `WIDTH` columns.

    `render` replaces the library's names of arguments by the reader's. A table that is
    too wide has less space between its columns.
    """
    width = output_width()
    for line in report.renderables:
        if isinstance(line, Text):
            line.plain = wrapped(printable(render(line.plain)), width)
    console = Console(highlight=False, width=width)
    for line in report.renderables:
        if (
            isinstance(line, Table)
            and not line.show_lines  # tables of prose are wrapped
            and _width_of(line, console) > width
        ):
            line.padding = 0
    console.print(report)


def bare_table() -> Table:
    """A table without columns."""
    return Table(box=SIMPLE_HEAD, pad_edge=False, padding=(0, 1, 0, 0))


def plain_table(first: str, *others: str) -> Table:
    """A table without rows; named columns, except the first, are right-aligned."""
    table = bare_table()
    table.add_column(first, no_wrap=True)
    for name in others:
        table.add_column(name, justify="right" if name else "left", overflow="fold")
    return table


def _width_of(table: Table, console: Console) -> int:
    """Width of a table without a limit [columns]."""
    wide = console.options.update_width(WIDEST)
    return Measurement.get(console, wide, table).maximum


def doubt_lines(verdict: Verdict, warnings: Iterable[str]) -> list[Text]:
    """The verdict and its reasons, then the warnings that are none of them."""
    style = "bold" if verdict.level == "good" else "yellow"
    lines = [Text(line, style=style) for line in verdict_lines(verdict)]
    return lines + warning_lines(verdict.others(warnings))


def warning_lines(warnings: Iterable[str]) -> list[Text]:
    """One line each."""
    return [Text(f"warning: {line}", style="yellow") for line in warnings]
