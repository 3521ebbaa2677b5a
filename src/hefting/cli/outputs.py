"""Outputs of commands: files by their suffixes, and a page that needs no network."""

import argparse
import json
import shlex
import sys
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

from hefting.cli import render
from hefting.cli.options import add_json, add_verbose, check_output
from hefting.cli.parser import say
from hefting.cli.progress import progress
from hefting.core.errors import InputError
from hefting.core.files import write_atomically

if TYPE_CHECKING:
    from collections.abc import Iterable

    from hefting.core.estimate import Estimate
    from hefting.core.inertia import InertialParameters
    from hefting.core.spatial import Array
    from hefting.export import Exported, Target
    from hefting.export.known import Fill
    from hefting.identification.compare import Comparison
    from hefting.identification.identify import Identification
    from hefting.ingest.ingested import Ingested
    from hefting.page import Context
    from hefting.shapes import Shape

SUFFIX = ".html"
STATUS_NOT_WRITTEN = 2
"""Exit status where an output was left out, without a worse status."""


def wanted(a: argparse.Namespace, estimate: "Estimate") -> list[str]:
    """The outputs to write; those that must not be are named on standard error."""
    if not a.output:
        return []
    from hefting.export import REGISTRY, SUFFIXES

    kept: list[str] = []
    for path in a.output:
        if is_picture(path):  # a picture shows the verdict and what is open
            kept.append(path)
            continue
        why = _why_not(a, estimate, REGISTRY[SUFFIXES[Path(path).suffix]])
        if why is None:
            kept.append(path)
        else:
            say(f"{path} was not written: {why}")
    return kept


def _why_not(
    a: argparse.Namespace, estimate: "Estimate", target: "Target"
) -> str | None:
    """The reason why an estimate is not written for a target, and the option that writes
    it; else None."""
    if not (estimate.verdict.usable or a.accept or target.is_read_back):
        return "the estimate is not to be used; --accept writes it"
    if target.write_estimate is not None:
        return None
    open_ = estimate.undetermined
    if open_.position and not a.accept:
        return f"the recording leaves {open_.position} open; --accept writes it"
    if open_.inertia and target.needs_inertia and a.fill_inertia is None:
        return (
            "the recording leaves the inertia open; --fill-inertia point, or shape, "
            "writes one that is not measured"
        )
    return None


def write(
    paths: list[str],
    estimate: "Estimate",
    flange: "Array | None",
    accept: bool,
    fill: "Fill",
) -> "list[tuple[str, Exported]]":
    """Write the estimate to each path, in the form of its suffix; nothing is written
    unless all can be made."""
    if not paths:
        return []
    from hefting.export import SUFFIXES, export

    made = partial(export, estimate, accept=accept, fill_inertia=fill, say=render)
    texts = [(path, made(SUFFIXES[Path(path).suffix], flange)) for path in paths]
    for path, exported in texts:
        write_atomically(path, exported.text)
    return texts


def is_picture(path: str) -> bool:
    """Whether a file of this name is a picture."""
    from hefting.plots.style import FORMATS

    return Path(path).suffix.lower() in FORMATS


def draw_pictures(
    paths: "Iterable[str]",
    found: "Ingested",
    estimate: "Estimate",
    shape: "Shape | None",
    truth: "InertialParameters | None",
) -> dict[str, bytes]:
    """The contents of the pictures in `paths`; nothing is written."""
    wanted = [path for path in paths if is_picture(path)]
    if not wanted:
        return {}
    from hefting.plots import picture_of, plot_identification

    with progress("drawing"):
        figure = plot_identification(
            found.measurements, estimate, shape, truth, render, found.log_start
        )
        return {path: picture_of(figure, Path(path).suffix.lower()) for path in wanted}


def print_object(found: Any) -> None:
    """Print what was found as one JSON object."""
    print(render(json.dumps(found.to_dict())))


def add_report(parser: argparse._ActionsContainer) -> None:
    """Options on printed text, and on the page."""
    parser.add_argument(
        "--report",
        metavar=f"FILE{SUFFIX}",
        help="write one page with everything to look at: numbers, wrench, object in 3D",
    )
    add_json(parser)
    add_verbose(parser)


def check_report(a: argparse.Namespace) -> None:
    """`InputError` for a page that cannot or must not be written,
    `MissingDependencyError` without what draws it."""
    path = a.report
    if path is None:
        return
    if Path(path).suffix.lower() != SUFFIX:
        fix = f"choose a name that ends in {SUFFIX}"
        raise InputError("a report is an HTML page", path, fix)
    from hefting.page.html import require_plotly

    require_plotly()
    check_output(path, a)


def identified(
    path: str | None,
    found: "Comparison | Identification",
    estimate: "Estimate",
    shape: "Shape | None",
    truth: "InertialParameters | None",
    flange: "Array | None",
) -> str | None:
    """The page of the result of one method or several, `estimate` being the recommended
    one; None where no page is wanted."""
    if path is None:
        return None
    from hefting.identification.compare import Comparison
    from hefting.page import identification_page

    context = page_context(shape=shape, truth=truth, flange=flange)
    if not isinstance(found, Comparison):
        return identification_page(estimate, found.ingested, found.estimator, context)
    best = found.recommended
    seen, estimator = found.seen[best], found.estimators[best]
    return identification_page(estimate, seen, estimator, context, found)


def page_context(**known: Any) -> "Context":
    """Further content of a page: the command as typed, and what is `known` of the
    object."""
    from hefting.page import Context

    return Context(command=shlex.join(["hefting", *sys.argv[1:]]), say=render, **known)


def no_output_format(path: str, known: "Iterable[str]") -> InputError:
    """The error for a file to write with none of the `known` endings; for a page it names
    ``--report``."""
    suffix = Path(path).suffix
    fix = f"use {', '.join(known)}"
    if not suffix:
        return InputError("has no ending, which tells what to write", path, fix)
    if suffix.lower() == SUFFIX:
        fix = f"--report {path} writes a page"
    return InputError(f"'{suffix}' is not an output format", path, fix)


def write_report(path: str | None, page: str | None) -> tuple[str, ...]:
    """Write the page, whole or not at all, if there is one; its path."""
    if path is None or page is None:
        return ()
    write_atomically(path, page)
    return (path,)


def open_page(address: str) -> None:
    """Open a page in a browser, and say so where there is none."""
    import webbrowser

    if not webbrowser.open(address):
        say("no browser could be opened: open the address in one")
