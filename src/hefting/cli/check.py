"""hefting check: find links of a URDF with inertials that no body can have, and repair
them."""

import argparse
import re

from hefting.cli.options import add_json, check_output
from hefting.core.errors import printable
from hefting.core.files import write_atomically

EXAMPLES = (
    "hefting check robot.urdf",
    "hefting check robot.urdf --repair repaired.urdf --diff",
)


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Arguments of ``hefting check``."""
    parser.add_argument("urdf", metavar="ROBOT.urdf", help="a robot; xacro expanded")
    parser.add_argument(
        "--repair",
        metavar="FILE",
        help="write the robot with the nearest possible tensors, all else unchanged",
    )
    parser.add_argument(
        "--diff", action="store_true", help="show what --repair changes, for patch"
    )
    add_json(parser)


def run(arguments: argparse.Namespace) -> int:
    """Check, repair with ``--repair``, and print; returns the exit status, 3 where links
    remain that no body can have."""
    from hefting.cli.report import STATUS_DO_NOT_USE
    from hefting.cli.report.inertias import inertias_report
    from hefting.cli.report.printing import print_report
    from hefting.robots import repair_inertias

    a = arguments
    if a.repair:
        check_output(a.repair, a)
    repaired = repair_inertias(a.urdf)
    if a.repair:
        write_atomically(a.repair, repaired.after)
    left = repaired.remaining if a.repair else repaired.failing
    status = STATUS_DO_NOT_USE if left else 0
    if a.json:
        import json

        print(json.dumps(repaired.to_dict() | {"repaired": a.repair}))
        return status
    print_report(inertias_report(repaired, a.repair))
    if a.diff:
        print(_shown(repaired.diff(a.repair)), end="")
    return status


def _shown(diff: str) -> str:
    """The diff without signs that control a terminal, but for tabs and line ends."""
    return re.sub(r"(?:[^\n\t\r]|\r(?!\n))+", lambda text: printable(text[0]), diff)
