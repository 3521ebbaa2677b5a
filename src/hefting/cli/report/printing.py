"""What every report shares."""

import sys
from collections.abc import Callable, Iterable

from rich.console import Console, Group
from rich.text import Text

from hefting.cli.parser import WIDTH
from hefting.cli.report.verdict import verdict_lines
from hefting.core.verdict import Verdict


def print_report(report: Group, render: Callable[[str], str] = str) -> None:
    """Print on standard output, no wider than the terminal; `WIDTH` columns where there
    is none.

    `render` turns the library's way of naming its arguments into the reader's.
    """
    for line in report.renderables:
        if isinstance(line, Text):
            line.plain = render(line.plain)
    Console(highlight=False, width=None if sys.stdout.isatty() else WIDTH).print(report)


def verdict_texts(verdict: Verdict) -> list[Text]:
    """The verdict and its reasons."""
    style = "bold" if verdict.level == "good" else "yellow"
    return [Text(line, style=style) for line in verdict_lines(verdict)]


def warning_lines(warnings: Iterable[str]) -> list[Text]:
    """One line each."""
    return [Text(f"warning: {line}", style="yellow") for line in warnings]
