"""hefting inspect: say what a log holds, its conventions, and what can be found from
it."""

import argparse

from hefting.cli import render
from hefting.cli.options import (
    add_gravity,
    add_json,
    add_recording,
    add_verbose,
    gravity_of,
    read_recording,
)
from hefting.cli.progress import progress

EXAMPLES = (
    "hefting inspect log.csv",
    "hefting inspect log.csv --map map.toml --verbose",
    "hefting inspect held.mcap --wrench-topic /ft_sensor/wrench",
    "hefting inspect log.parquet --json",
)


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Arguments of ``hefting inspect``."""
    add_gravity(add_recording(parser))
    add_json(parser)
    add_verbose(parser)


def run(arguments: argparse.Namespace) -> None:
    """Print the findings."""
    from hefting.inspection import inspect

    with progress("inspecting", arguments.json):
        found = inspect(read_recording(arguments), gravity_of(arguments))
    if arguments.json:
        import json

        print(render(json.dumps(found.to_dict())))
        return
    from hefting.cli.report.inspection import inspection_report
    from hefting.cli.report.printing import print_report

    print_report(inspection_report(found, arguments.verbose), render)
