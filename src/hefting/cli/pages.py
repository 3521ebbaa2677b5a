"""Reports: one page of a result, with plots, that needs no network."""

import argparse
import sys
from pathlib import Path
from typing import TYPE_CHECKING

from hefting.cli import render
from hefting.cli.options import check_output
from hefting.cli.parser import say
from hefting.core.errors import InputError
from hefting.core.shell import typed

if TYPE_CHECKING:
    from hefting.core.estimate import Estimate
    from hefting.core.inertia import InertialParameters
    from hefting.core.spatial import Array
    from hefting.identification.compare import Comparison
    from hefting.identification.identify import Identification
    from hefting.shapes import Shape

SUFFIX = ".html"


def add_report(parser: argparse._ActionsContainer) -> None:
    """Where the page goes."""
    parser.add_argument(
        "--report",
        metavar=f"FILE{SUFFIX}",
        help="write one page with everything to look at: numbers, wrench, object in 3D",
    )


def check_report(path: str | None, *inputs: str | None) -> None:
    """`InputError` for a page that cannot or must not be written,
    `MissingDependencyError` without what draws it."""
    if path is None:
        return
    if Path(path).suffix.lower() != SUFFIX:
        fix = f"choose a name that ends in {SUFFIX}"
        raise InputError("a report is an HTML page", path, fix)
    from hefting.page.html import require_plotly

    require_plotly()
    check_output(path, *inputs)


def identified(
    path: str | None,
    found: "Comparison | Identification",
    estimate: "Estimate",
    shape: "Shape | None",
    truth: "InertialParameters | None",
    flange: "Array | None",
) -> str | None:
    """The page of what was found by one method or by several, `estimate` being the one
    to trust; None where no page is wanted."""
    if path is None:
        return None
    from hefting.identification.compare import Comparison
    from hefting.page import Context, identification_page

    context = Context(shape, truth, flange, command_line(), render)
    if not isinstance(found, Comparison):
        return identification_page(estimate, found.ingested, found.estimator, context)
    best = found.recommended
    seen, estimator = found.seen[best], found.estimators[best]
    return identification_page(estimate, seen, estimator, context, found)


def command_line() -> str:
    """The command, as one would type it."""
    return typed(["hefting", *sys.argv[1:]])


def write_report(path: str | None, page: str | None) -> tuple[str, ...]:
    """Write the page, whole or not at all, if there is one; its path."""
    if path is None or page is None:
        return ()
    from hefting.core.files import write_atomically

    write_atomically(path, page)
    return (path,)


def open_page(address: str) -> None:
    """Open a page in a browser, and say so where there is none."""
    import webbrowser

    if not webbrowser.open(address):
        say("no browser could be opened: open the address in one")
