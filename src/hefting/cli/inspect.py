"""hefting inspect: say what a log holds, its conventions, and what can be found from it."""

import argparse

from hefting.cli.options import add_json, add_log, numbers, progress


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Arguments of ``hefting inspect``."""
    add_log(parser)
    add_json(parser)


def run(arguments: argparse.Namespace) -> None:
    """Print the findings."""
    from hefting.inspection import inspect
    from hefting.logs import read_log

    with progress("reading ..."):
        found = inspect(read_log(arguments.log), numbers(arguments.gravity, 3, "--gravity"))
    if arguments.json:
        import json

        print(json.dumps(found.to_dict()))
        return
    from hefting.report import inspection_report, print_report

    print_report(inspection_report(found))
