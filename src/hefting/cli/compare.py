"""hefting compare: check whether estimates can be of the same object, by their intervals."""

import argparse

from hefting.cli import render
from hefting.cli.options import add_json, read_estimate
from hefting.cli.outputs import print_object
from hefting.core.errors import InputError

EXAMPLES = ("hefting compare monday.json tuesday.json", "hefting compare *.json --json")


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Arguments of ``hefting compare``."""
    parser.add_argument(
        "estimates",
        metavar="ESTIMATE.json",
        nargs="+",
        help="two or more, as hefting identify --output wrote them; of the same object "
        "in the same grasp, in the same sensor frame",
    )
    add_json(parser)


def run(arguments: argparse.Namespace) -> int:
    """Compare, and print the table; returns the exit status, 3 where they contradict
    one another."""
    from hefting.cli.report import STATUS_DO_NOT_USE
    from hefting.identification.agreement import Agreement

    paths: list[str] = arguments.estimates
    if len(paths) < 2:
        raise InputError(
            "nothing to compare it with", paths[0], "give another estimate"
        )
    for i, path in enumerate(paths):
        if path in paths[:i]:
            raise InputError("is given twice", path, "give two different estimates")
    agreement = Agreement.of({path: read_estimate(path) for path in paths})
    if arguments.json:
        print_object(agreement)
    else:
        from hefting.cli.report.estimate import print_lines
        from hefting.cli.report.methods import agreement_report

        print_lines(agreement_report(agreement), render)
    return 0 if agreement.agree else STATUS_DO_NOT_USE
