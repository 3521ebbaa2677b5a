"""What every report shares."""

import sys
from collections.abc import Iterable

from rich.console import Console, RenderableType
from rich.text import Text


def print_report(report: RenderableType) -> None:
    """Print on standard output, no wider than the terminal; 100 columns where there is none."""
    Console(highlight=False, width=None if sys.stdout.isatty() else 100).print(report)


def warning_lines(warnings: Iterable[str]) -> list[Text]:
    """One line each."""
    return [Text(f"warning: {line}", style="yellow") for line in warnings]
