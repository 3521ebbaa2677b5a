"""hefting demo: simulate a robot arm wielding a hammer, identify it, write pictures."""

import argparse
from importlib.util import find_spec

from hefting.cli import render
from hefting.cli.options import add_verbose
from hefting.cli.parser import wrote
from hefting.cli.progress import progress

EXAMPLES = ("hefting demo", "hefting demo --output /tmp/hammer")


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Arguments of ``hefting demo``."""
    parser.add_argument(
        "-o",
        "--output",
        metavar="FOLDER",
        default="demo",
        help="where log, mesh, estimate and pictures go; default %(default)s",
    )
    add_verbose(parser)


def run(arguments: argparse.Namespace) -> None:
    """Run the demo and print truth beside estimate."""
    from hefting.cli.report.estimate import estimate_report, print_lines
    from hefting.simulation.demo import run

    can_draw = find_spec("matplotlib") is not None
    with progress("simulating a robot arm that wields a hammer"):
        shown = run(arguments.output, can_draw)
    report = estimate_report(
        shown.estimate, shown.truth, shown.errors, arguments.verbose
    )
    print_lines(report, render)
    wrote(*shown.files)
    if not can_draw:
        print("without pictures: pip install 'hefting[plot]'")
