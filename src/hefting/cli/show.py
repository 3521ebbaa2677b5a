"""hefting show: draw a shape as it is posed on the sensor, to check the pose by eye."""

import argparse
from typing import TYPE_CHECKING

from hefting.cli import render
from hefting.cli.options import (
    add_gravity,
    add_recording,
    add_shape,
    add_tool,
    check_output,
    read_recording,
)
from hefting.cli.parser import WIDTH, wrapped, wrote
from hefting.cli.progress import progress
from hefting.core.errors import InputError, printable
from hefting.core.files import write_atomically
from hefting.request.settings import gravity_of, refuse_given, shape_of

if TYPE_CHECKING:
    from hefting.core.estimate import Estimate
    from hefting.core.spatial import Array
    from hefting.shapes import Shape

BY_LEAST_SQUARES = "log, by least squares"
"""Name of the estimate from a log that does not use the shape."""
DEFAULT = "hefting-show.png"
OF_SHAPES = (
    *("shape", "unit", "object_pose", "box", "hull", "points", "points_per_cm3"),
    *("estimate", "output", "run"),
)
"""Arguments of the command that need no log."""
EXAMPLES = (
    "hefting show --shape drill.stl --unit mm --object-pose 0,0,0.05",
    "hefting show --shape drill.stl log.csv",
)


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Arguments of ``hefting show``."""
    from hefting.plots.style import FORMATS

    shape = parser.add_argument_group("the object's shape")
    add_shape(shape)
    log = add_recording(
        parser,
        what="draw gravity, and the COM by least squares, of this recording as well",
        count="?",
    )
    add_gravity(log)
    add_tool(log)
    results = parser.add_argument_group("results")
    results.add_argument(
        "--estimate",
        metavar="FILE",
        help="draw the COM of this estimate as well (JSON)",
    )
    results.add_argument(
        "-o",
        "--output",
        metavar="FILE",
        default=DEFAULT,
        help=f"the picture ({', '.join(FORMATS)}); default {DEFAULT}",
    )


def run(arguments: argparse.Namespace) -> None:
    """Write the picture, and print where the shape is."""
    from hefting.core.estimate import Estimate
    from hefting.plots import picture_of, picture_suffix, plot_shape
    from hefting.scene import place_of

    a = arguments
    suffix = picture_suffix(a.output)
    check_output(a.output, a)
    if not a.log:
        of_logs = (name for name in vars(a) if name not in OF_SHAPES)
        refuse_given(a, of_logs, "there is no log", "give LOG, or leave it out")
    with progress("drawing"):
        shape = shape_of(a)
        if shape is None:
            raise InputError(
                "no shape to show", "--shape", "give --shape FILE or --box"
            )
        found = {"estimate": Estimate.load(a.estimate)} if a.estimate else {}
        gravity = None
        if a.log:
            tool = a.tool or _tool_beside(found.get("estimate"))
            beside = ", less the tool" if tool else ""
            found[BY_LEAST_SQUARES + beside], gravity = _of_log(a, tool)
        picture = picture_of(plot_shape(shape, found, gravity), suffix)
    write_atomically(a.output, picture)
    for line in (*place_of(shape), *_depths(shape, found)):
        print(wrapped(printable(line), WIDTH))
    for line in shape.warnings:
        print(wrapped(f"warning: {render(line)}", WIDTH))
    wrote(a.output)


def _tool_beside(estimate: "Estimate | None") -> "Estimate | None":
    """The tool that was subtracted for an estimate."""
    from hefting.core.estimate import Estimate
    from hefting.core.estimate_json import subtracted_tool
    from hefting.core.inertia import InertialParameters

    vector = subtracted_tool(estimate.provenance if estimate else {})
    return vector if vector is None else Estimate("", InertialParameters(vector), 0)


def _of_log(a: argparse.Namespace, tool: "Estimate | None") -> "tuple[Estimate, Array]":
    """The least-squares estimate, and gravity (K, 3) in sensor axes [m/s²]."""
    from hefting.identification import identify

    found = identify(read_recording(a), method="OLS", gravity=gravity_of(a), tool=tool)
    return found.estimate, found.ingested.measurements.gravity


def _depths(shape: "Shape", found: "dict[str, Estimate]") -> list[str]:
    """A line for each estimate with the depth of its COM in the shape's convex hull."""
    from hefting.scene import com_reach, depth_of, headline_of

    lines = []
    for name, estimate in found.items():
        depth = depth_of(shape, estimate.parameters.center_of_mass)
        half = com_reach(estimate)
        side = "inside" if depth >= 0.0 else "outside"
        where = f"{1e3 * abs(depth):.1f} mm {side} the convex hull"
        if depth < 0.0 and (half is None or -depth > half.max()):
            where += ": are pose and unit right?"
        lines.append(f"{name}: {headline_of(estimate).numbers[1]}; {where}")
    return lines
