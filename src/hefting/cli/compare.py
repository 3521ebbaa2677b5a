"""hefting compare: check whether estimates can be of the same object, by their intervals."""

import argparse

from hefting.cli import render
from hefting.cli.options import add_json, add_object_frame, read_estimate
from hefting.cli.outputs import print_object
from hefting.core.errors import InputError

EXAMPLES = (
    "hefting compare monday.json tuesday.json",
    "hefting compare *.json --json",
    "hefting compare grasp1.json grasp2.json --object-frame --pose-std 1mm,1deg",
)


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Arguments of ``hefting compare``."""
    parser.add_argument(
        "estimates",
        metavar="ESTIMATE.json",
        nargs="+",
        help="two or more, as hefting identify --output wrote them; of the same object "
        "in the same grasp, in the same sensor frame, or with --object-frame in any",
    )
    add_object_frame(parser, "compare several grasps in")
    parser.add_argument(
        "--pose-std",
        metavar="LENGTH,ANGLE",
        help="how well each --object-pose is known; default exactly",
    )
    add_json(parser)


def run(arguments: argparse.Namespace) -> int:
    """Compare, and print the table; returns the exit status, 3 where they contradict
    one another."""
    from hefting.cli.report import STATUS_DO_NOT_USE
    from hefting.identification.agreement import Agreement
    from hefting.request.settings import in_object_frame

    paths: list[str] = arguments.estimates
    if len(paths) < 2:
        raise InputError(
            "nothing to compare it with", paths[0], "give another estimate"
        )
    for i, path in enumerate(paths):
        if path in paths[:i]:
            raise InputError("is given twice", path, "give two different estimates")
    estimates = {path: read_estimate(path) for path in paths}
    if arguments.object_frame:
        for path, estimate in estimates.items():
            estimates[path] = in_object_frame(estimate, None, arguments.pose_std)
    elif arguments.pose_std:
        raise InputError("is for --object-frame", "--pose-std", "give that as well")
    agreement = Agreement.of(estimates)
    if arguments.json:
        print_object(agreement)
    else:
        from hefting.cli.report.estimate import print_lines
        from hefting.cli.report.methods import agreement_report

        print_lines(agreement_report(agreement), render)
    return 0 if agreement.agree else STATUS_DO_NOT_USE
