"""hefting batch: identify the objects in many recordings, into one table."""

import argparse
import sys
from collections.abc import Callable, Generator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

from hefting.cli import render
from hefting.cli.identify import add_hyperparameters, add_reading
from hefting.cli.options import (
    add_json,
    add_log_options,
    add_mass,
    add_shape,
    add_shape_details,
    add_workers,
)
from hefting.cli.outputs import check_report, page_context, print_object
from hefting.core.errors import InputError
from hefting.core.files import write_atomically

if TYPE_CHECKING:
    from hefting.batches.batch import Progress

EXAMPLES = (
    "hefting batch manifest.csv --output results",
    "hefting batch monday/ --shape mug.stl --output results --report monday.html",
    "hefting batch 'day*/*.csv' --output results --resume",
    "hefting batch manifest.csv --group-by object --output objects",
    "hefting batch manifest.csv --output results --scheduler tcp://10.0.0.5:8786",
)
STATUS_NONE = 1
"""Exit status where no recording could be identified."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Arguments of ``hefting batch``."""
    from hefting.estimators import default_method

    parser.add_argument(
        "-o",
        "--output",
        metavar="FOLDER",
        required=True,
        help="folder for the table (Parquet), and for nothing else",
    )
    add_workers(parser)
    parser.add_argument(
        "--resume",
        action="store_true",
        help="continue in a folder with results: rows of the same recording, options and "
        "version are kept",
    )
    parser.add_argument(
        "--group-by",
        metavar="COLUMN",
        help="identify all recordings of an object together: the manifest's column "
        "that names it, or folder",
    )
    parser.add_argument(
        "--report",
        metavar="FILE.html",
        help="write one page: verdicts, residuals, failures, what is worth a look",
    )
    add_json(parser)
    given = parser.add_argument_group("of recordings whose row does not say otherwise")
    add_shape(given)
    given.add_argument("--tool", metavar="FILE", help="subtract this gripper (JSON)")
    given.add_argument(
        "--method", metavar="NAME", help=f"default {default_method(True)}"
    )
    given.add_argument(
        "--until",
        metavar="ACCURACY",
        help="use only as much of each as makes it this sure, as in mass=1%%,com=2mm; the "
        "table says whether it is (sufficient)",
    )
    add_mass(given)
    add_shape_details(given)
    parser.add_argument(
        "log",
        metavar="RECORDINGS",
        nargs="+",
        help="a manifest (.csv, .parquet, .toml), a folder, a 'pattern*', or logs",
    )
    add_reading(add_log_options(parser))
    add_hyperparameters(parser.add_argument_group("methods"))


def run(arguments: argparse.Namespace) -> int:
    """Run the batch and print its summary; returns the exit status."""
    from hefting.batches.batch import batch
    from hefting.cli.report.batch import batch_report
    from hefting.cli.report.estimate import print_lines

    a = arguments
    _check_report(a)
    try:
        with _bar(a.json) as bar:
            found = batch(
                a.log[0] if len(a.log) == 1 else a.log,
                a.output,
                jobs=a.jobs,
                scheduler=a.scheduler,
                resume=a.resume,
                group_by=a.group_by,
                progress=bar,
                **_given(a),
            )
    except KeyboardInterrupt:
        raise KeyboardInterrupt("stopped; the same with --resume goes on") from None
    summary = found.summary
    if a.report:
        from hefting.page.batch import batch_page

        write_atomically(a.report, batch_page(found, page_context()))
    if a.json:
        print_object(found)
    else:
        print_lines(batch_report(found, render, a.report))
    return STATUS_NONE if summary.failed == summary.total else 0


def _check_report(a: argparse.Namespace) -> None:
    """`InputError` for names of results or page that cannot be used."""
    check_report(a)
    if Path(a.output).suffix.lower() in {".csv", ".parquet"}:
        fix = "name a folder, in which the table is recordings.parquet"
        raise InputError("names a file", a.output, fix)
    if a.report and Path(a.output).resolve() in Path(a.report).resolve().parents:
        what = "is among the results, whose folder is for nothing else"
        raise InputError(what, a.report, "choose another folder")


@contextmanager
def _bar(quiet: bool) -> "Generator[Callable[[Progress], None], None, None]":
    """Shows recordings done, rate and time left on standard error if a terminal."""
    if quiet or sys.stderr is None or not sys.stderr.isatty():
        yield lambda progress: None
        return
    from rich.console import Console
    from rich.progress import (
        BarColumn,
        MofNCompleteColumn,
        TextColumn,
        TimeRemainingColumn,
    )
    from rich.progress import Progress as Display

    columns = (
        *(BarColumn(20), MofNCompleteColumn()),
        TextColumn("{task.fields[about]}"),
        TimeRemainingColumn(compact=True),
    )
    with Display(*columns, console=Console(stderr=True), transient=True) as display:
        bar = display.add_task("", total=None, about="")

        def show(progress: "Progress") -> None:
            speed = display.tasks[0].speed
            rate = "" if speed is None else f"{speed:.3g} a second, "
            display.update(
                bar,
                total=progress.total,
                completed=progress.done,
                about=f"{rate}{progress.failed:,} failed, left",
            )

        yield show


def _given(a: argparse.Namespace) -> dict[str, Any]:
    """The given options for all recordings, by name."""
    from hefting.request.request import DEFAULTS, option_kinds

    values = {name: getattr(a, name, None) for name in option_kinds()}
    return {
        name: value
        for name, value in values.items()
        if value is not None and value != DEFAULTS.get(name)
    }
