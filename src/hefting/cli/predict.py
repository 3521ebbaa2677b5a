"""hefting predict: predict the wrench that an identified object needs along a motion, and
its uncertainty."""

import argparse
from pathlib import Path

from hefting.cli import render
from hefting.cli.options import (
    ESTIMATE,
    GRAVITY,
    add_motion,
    add_output,
    add_part,
    add_place,
    add_recording,
    add_sensor_accuracy,
    add_tool,
    check_output,
    read_estimate,
    read_recording,
)
from hefting.cli.outputs import (
    add_report,
    check_report,
    no_output_format,
    page_context,
    print_object,
    write_report,
)
from hefting.cli.parser import wrote
from hefting.cli.progress import progress
from hefting.core.errors import InputError
from hefting.core.files import write_atomically
from hefting.request.settings import gravity_of, sensor_accuracy_of

EXAMPLES = (
    "hefting predict mug.json log.csv",
    "hefting predict mug.json plan.csv --output wrench.csv --output wrench.svg",
    "hefting predict mug.json held.mcap --start 5 --duration 10 --json",
)


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Arguments of ``hefting predict``."""
    from hefting.plots.style import FORMATS

    parser.add_argument("estimate", metavar="ESTIMATE.json", help=ESTIMATE)
    log = add_recording(
        parser, "TRAJECTORY", "planned or recorded motion, with or without a wrench"
    )
    log.add_argument(
        "--gravity", metavar="X,Y,Z", help=f"in world axes [m/s²]; default {GRAVITY}"
    )
    add_place(log)
    add_tool(log, "the sensor bears this gripper as well")
    add_sensor_accuracy(log)
    add_motion(log)
    add_part(log)
    add_output(
        parser, f"the wrench and its band (.csv), or a picture ({', '.join(FORMATS)})"
    )
    add_report(parser)


def run(arguments: argparse.Namespace) -> int:
    """Predict, write outputs, and print peaks and extremes; returns the exit status."""
    from hefting.cli.report import exit_status
    from hefting.plots.style import FORMATS
    from hefting.prediction import predict

    a, formats = arguments, (".csv", *FORMATS)
    for path in a.output:
        if Path(path).suffix.lower() not in formats:
            raise no_output_format(path, formats)
        check_output(path, a)
    check_report(a)
    if a.gravity == "estimate":
        raise InputError(
            "the motion does not determine gravity", "--gravity", "give X,Y,Z"
        )
    gravity = gravity_of(a)
    estimate = read_estimate(a.estimate)
    with progress("predicting", a.json):
        recording = read_recording(a, wrench_needed=False)
        found = predict(
            estimate,
            recording,
            gravity=gravity,
            tool=a.tool,
            motion=a.motion,
            start=a.start,
            duration=a.duration,
            sensor_accuracy=sensor_accuracy_of(a),
        )
        contents = [_content(found, Path(path).suffix.lower()) for path in a.output]
        page = None
        if a.report is not None:
            from hefting.page import prediction_page

            page = prediction_page(found, estimate, page_context())
    for path, content in zip(a.output, contents, strict=True):
        write_atomically(path, content)
    pages = write_report(a.report, page)
    if a.json:
        print_object(found)
        return exit_status(found.verdict)
    from hefting.cli.report.prediction import prediction_report
    from hefting.cli.report.printing import print_report

    print_report(prediction_report(found, a.verbose), render)
    for path in (*a.output, *pages):
        wrote(path)
    return exit_status(found.verdict)


def _content(found, suffix: str) -> bytes:
    if suffix == ".csv":
        return found.csv()
    from hefting.plots import picture_of, plot_prediction

    return picture_of(plot_prediction(found, render), suffix)
