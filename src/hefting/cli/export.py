"""hefting export: write an estimate for a simulator or a robot controller."""

import argparse

from hefting.cli import render
from hefting.cli.options import (
    ESTIMATE,
    add_accept,
    add_sensor_pose,
    check_output,
    either,
    read_estimate,
)
from hefting.cli.parser import say

EXAMPLES = (
    "hefting export mug.json --to urdf --output mug.urdf",
    "hefting export mug.json --to urdf --into robot.urdf --link tool0",
    "hefting export mug.json --to ur --sensor-pose-in-flange 0,0,0.03,0,0,0,1",
    "hefting identify log.csv --json | hefting export - --to mjcf",
)


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Arguments of ``hefting export``."""
    from hefting.export import INSERTABLE, TARGETS

    parser.add_argument("estimate", metavar="ESTIMATE.json", help=ESTIMATE)
    parser.add_argument(
        "--to",
        metavar="TARGET",
        required=True,
        help=either(list(TARGETS)),
    )
    formats = either(list(INSERTABLE.values()))
    parser.add_argument(
        "--into", metavar="FILE", help=f"put it into a link of this {formats} file"
    )
    parser.add_argument("--link", metavar="NAME", help="that link, or body")
    add_sensor_pose(parser)
    add_accept(parser)
    parser.add_argument(
        "--output", metavar="FILE", help="write there instead of printing"
    )


def run(arguments: argparse.Namespace) -> None:
    """Print or write the estimate in the target's form."""
    from hefting.core.files import write_atomically
    from hefting.export import export
    from hefting.shapes import parse_pose

    a = arguments
    if a.output:
        check_output(a.output, a.estimate, a.into, a.sensor_pose_in_flange)
    flange = parse_pose(a.sensor_pose_in_flange) if a.sensor_pose_in_flange else None
    exported = export(
        read_estimate(a.estimate), a.to, flange, a.into, a.link, accept=a.accept
    )
    for line in exported.warnings:
        say(f"warning: {render(line)}")
    if a.output:
        write_atomically(a.output, exported.text)
        print(f"wrote {a.output} ({exported.frame} axes)")
    else:
        print(exported.text, end="" if exported.text.endswith("\n") else "\n")
