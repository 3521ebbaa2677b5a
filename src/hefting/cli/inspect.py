"""hefting inspect: say what a log holds, its conventions, and what can be found from
it."""

import argparse

from hefting.cli import render
from hefting.cli.options import (
    add_gravity,
    add_part,
    add_recording,
    add_tool,
    read_recording,
)
from hefting.cli.outputs import (
    add_report,
    check_report,
    page_context,
    print_object,
    write_report,
)
from hefting.cli.parser import wrote
from hefting.cli.progress import progress
from hefting.request.settings import gravity_of

EXAMPLES = (
    "hefting inspect log.csv",
    "hefting inspect log.csv --map map.toml --verbose",
    "hefting inspect held.mcap --wrench-topic /ft_sensor/wrench",
    "hefting inspect log.parquet --json",
)


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Arguments of ``hefting inspect``."""
    group = add_recording(parser)
    add_gravity(group)
    add_tool(group)
    add_part(group, do="inspect")
    add_report(parser)


def run(arguments: argparse.Namespace) -> None:
    """Print the findings."""
    from hefting.inspection import inspect

    a = arguments
    check_report(a)
    with progress("inspecting", a.json):
        found = inspect(
            read_recording(a), gravity_of(a), a.tool, start=a.start, duration=a.duration
        )
        page = None
        if a.report is not None:
            from hefting.page import inspection_page

            page = inspection_page(found, page_context())
    pages = write_report(a.report, page)
    if a.json:
        print_object(found)
        return
    from hefting.cli.report.inspection import inspection_report
    from hefting.cli.report.printing import print_report

    print_report(inspection_report(found, arguments.verbose), render)
    for path in pages:
        wrote(path)
