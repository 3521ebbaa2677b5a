"""hefting calibrate: measure an empty gripper, its bias and noise, for --tool and
--bias."""

import argparse
import shlex
from pathlib import Path

from hefting.cli import render
from hefting.cli.options import (
    add_gravity,
    add_part,
    add_recording,
    add_sensor_accuracy,
    check_output,
    part_of,
    read_recording,
)
from hefting.cli.outputs import (
    add_report,
    check_report,
    page_context,
    print_object,
    write_report,
)
from hefting.cli.progress import progress
from hefting.cli.torques import add_torques, calibrate, require_torques
from hefting.core.errors import InputError
from hefting.request.settings import gravity_of, sensor_accuracy_of

EXAMPLES = (
    "hefting calibrate empty.csv --output gripper.json",
    "hefting identify full.csv --tool gripper.json",
    "hefting identify full.csv --tool gripper.json --bias gripper.json",
)


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Arguments of ``hefting calibrate``."""
    parser.add_argument(
        "-o",
        "--output",
        metavar="FILE.json",
        required=True,
        help="where the tool's estimate goes",
    )
    add_report(parser)
    log = add_recording(parser)
    add_torques(parser.add_argument_group("the arm's own torques"))
    add_gravity(log)
    add_sensor_accuracy(log)
    add_part(log)


def run(arguments: argparse.Namespace) -> int:
    """Identify the gripper, save it, print how to use it; returns the exit status."""
    from hefting.cli.report import exit_status
    from hefting.cli.report.estimate import Line, estimate_report, print_lines
    from hefting.identification.identify import calibration

    a = arguments
    if Path(a.output).suffix.lower() != ".json":
        raise InputError(
            "the tool's estimate is a JSON file",
            a.output,
            "choose a name that ends in .json",
        )
    check_output(a.output, a)
    check_report(a)
    require_torques(a)
    if a.torques and a.json:
        what = "is for a wrench, not for --torques"
        raise InputError(what, "--json", "leave it out")
    if a.torques:
        with progress("calibrating"):
            lines = calibrate(a)
        print_lines(list(map(Line, lines)), render)
        return 0
    with progress("calibrating", a.json):
        found = calibration(
            part_of(a, read_recording(a)),
            gravity=gravity_of(a),
            sensor_accuracy=sensor_accuracy_of(a),
        )
        tool, page = found.estimate, None
        if a.report is not None:
            from hefting.page import identification_page

            page = identification_page(
                tool,
                found.ingested,
                found.estimator,
                page_context(),
                title="The tool that the sensor holds",
            )
    tool.save(a.output)
    pages = write_report(a.report, page)
    if a.json:
        print_object(tool)
        return exit_status(tool.verdict)
    subtract = shlex.join(["hefting", "identify", "LOG", "--tool", a.output])
    next_steps = (
        f"wrote {a.output}: to subtract it, {subtract}",
        "to use its wrench bias as well, where the sensor was not zeroed since: "
        f"{shlex.join(['--bias', a.output])}",
    )
    report = estimate_report(tool, verbose=a.verbose)
    written = [f"wrote {path}" for path in pages]
    print_lines([*report, *map(Line, (*next_steps, *written))], render)
    return exit_status(tool.verdict)
