"""Options that several commands share, and the log that the options describe."""

import argparse
import os
from collections.abc import Callable
from dataclasses import replace
from itertools import chain
from pathlib import Path
from typing import TYPE_CHECKING

from hefting.cli import option_of
from hefting.cli.standard_input import NAME, input_file
from hefting.core.errors import InputError
from hefting.core.files import check_replaceable

if TYPE_CHECKING:
    from hefting.core.estimate import Estimate
    from hefting.core.recording import Recording
    from hefting.core.spatial import Array
    from hefting.export.known import Fill
    from hefting.shapes import Shape

GRAVITY = "0,0,-9.80665"
"""`hefting.core.spatial.STANDARD_GRAVITY` as on the command line."""
POSE = (
    "x,y,z [m], or with qx,qy,qz,qw, or with turns (0,0,30mm,z:90), or a file with a "
    "4 x 4 matrix"
)
OUTPUTS = {"output", "report", "record", "save", "repair"}
"""Options that name files to write."""
ESTIMATE = "written by hefting identify --output; - reads standard input"


def add_number(
    parser: argparse._ActionsContainer,
    option: str,
    metavar: str,
    text: str,
    default: float | None = None,
) -> None:
    """Add an option that takes a number."""
    parser.add_argument(option, type=float, metavar=metavar, help=text, default=default)


def add_json(parser: argparse._ActionsContainer) -> None:
    """Option on JSON output."""
    parser.add_argument(
        "--json", action="store_true", help="print one JSON object and nothing else"
    )


def add_verbose(
    parser: argparse._ActionsContainer,
    what: str = "what was found, assumed and checked on the way",
) -> None:
    """Option on details."""
    parser.add_argument(
        "-v", "--verbose", action="store_true", help=f"also print {what}"
    )


class _WhenShown:
    """Text that is made when help is shown, as it needs imports."""

    def __init__(self, make: Callable[[], str]):
        self._make = make

    def __str__(self) -> str:
        return self._make()


def add_output(
    parser: argparse._ActionsContainer, what: str | Callable[[], str]
) -> None:
    """Option on files to write."""
    action = parser.add_argument(
        "-o", "--output", metavar="FILE", action="append", default=[]
    )
    # argparse formats help with the attributes of the action, from 3.14 on when it is
    # added, too
    vars(action)["what"] = what if isinstance(what, str) else _WhenShown(what)
    action.help = "write %(what)s; repeatable"


def add_workers(parser: argparse._ActionsContainer) -> None:
    """Options on local processes or a cluster."""
    parser.add_argument(
        "--jobs", type=int, metavar="N", help="local processes; default one a core"
    )
    parser.add_argument(
        "--scheduler", metavar="ADDRESS", help="a Dask scheduler to use instead"
    )


def add_export(parser: argparse._ActionsContainer) -> None:
    """Options on files for simulators and robots."""
    parser.add_argument(
        "--sensor-pose-in-flange",
        metavar="POSE",
        help=f"controllers want flange axes: {POSE}",
    )
    parser.add_argument(
        "--accept",
        action="store_true",
        help="write files for simulators and robots even where the verdict is not to "
        "use the estimate",
    )
    parser.add_argument(
        "--fill-inertia",
        metavar="shape|point",
        help="where the recording leaves the inertia open, write that of the shape "
        "with the mass evenly spread, or of a point: simulators need one",
    )


def add_object_frame(parser: argparse._ActionsContainer, verb: str) -> None:
    """The option for numbers in the object's frame."""
    parser.add_argument(
        "--object-frame",
        action="store_true",
        help=f"{verb} the frame of the shape's file, by its --object-pose",
    )


def fill_inertia_of(text: str | None, shape: "Shape | None") -> "Fill":
    """The argument of `export` for the text of ``--fill-inertia``; `InputError` for
    another word, and where the shape is not given."""
    if text == "shape":
        if shape is None:
            raise InputError("which shape?", "--fill-inertia shape", "give --shape")
        return shape
    if text not in (None, "point"):
        raise InputError(
            f"'{text}' is neither shape nor point", "--fill-inertia", "use one of them"
        )
    return text


def read_estimate(path: str) -> "Estimate":
    """The estimate in a JSON file, or in standard input for ``-``."""
    from hefting.core.estimate import Estimate

    with input_file(path) as file:
        return Estimate.load(file)


def add_recording(
    parser: argparse.ArgumentParser,
    metavar: str = "LOG",
    what: str = "recording",
    count: str | None = None,
) -> "argparse._ArgumentGroup":
    """Add the log, and options of its format; returns the group of these, for more.
    `count` is the number of logs as for `argparse`, by default one."""
    from hefting.logs.registry import formats, join_words

    known = join_words([name for each in formats() for name in each.help_names], "or")
    parser.add_argument(
        "log",
        metavar=metavar,
        nargs=count,
        help=f"{what}: {known}; - reads standard input; see --map, --urdf",
    )
    group = add_log_options(parser)
    group.add_argument(
        "--poses",
        metavar="FILE",
        help="poses or joint angles from another table, where the log has only the "
        "wrench; on the same clock",
    )
    return group


def add_log_options(parser: argparse.ArgumentParser) -> "argparse._ArgumentGroup":
    """Add options of log formats; returns their group, for more."""
    from hefting.logs.registry import all_options, join_words, table_formats

    tables = join_words([each.name for each in table_formats()], "or")
    group = parser.add_argument_group("reading the log")
    group.add_argument(
        "--map",
        metavar="FILE",
        help=f"TOML file that says which columns of a {tables} hold what",
    )
    group.add_argument(
        "--urdf",
        metavar="FILE",
        help="poses from joint angles, by this robot; with --sensor-frame",
    )
    group.add_argument(
        "--sensor-pose-in-log",
        metavar="POSE",
        help=f"the sensor in the frame whose pose is logged, where that is another: {POSE}",
    )
    group.add_argument(
        "--sensor-turned",
        metavar="AXIS:DEG",
        help="the same for a sensor that is only turned, as in z:45",
    )
    bags = parser.add_argument_group("streams of a ROS bag")
    for name, (metavar, text) in all_options().items():
        of = bags if text.startswith("of a bag: ") else group
        text = text.removeprefix("of a bag: ")
        of.add_argument(option_of(name), metavar=metavar, help=text)
    return group


def add_part(parser: argparse._ActionsContainer, do: str = "use") -> None:
    """Options on the part of a recording."""
    add_number(parser, "--start", "S", "leave out what is before [s]", default=0.0)
    add_number(parser, "--duration", "S", f"{do} this much [s]")


def add_wrench(parser: argparse._ActionsContainer, biases: str) -> None:
    """Options on the sign convention of the wrench, and on its bias."""
    parser.add_argument(
        "--wrench",
        metavar="auto|on-object|on-sensor",
        default="auto",
        help="the body that the wrench acts on; default auto",
    )
    parser.add_argument(
        "--bias",
        metavar="BIAS",
        default="auto",
        help=f"of the wrench: {biases}; default auto",
    )


def add_motion(parser: argparse._ActionsContainer) -> None:
    """Option on the source of velocities and accelerations."""
    parser.add_argument(
        "--motion",
        metavar="SOURCE",
        default="auto",
        help="velocities and accelerations: columns of the log, or from its poses by "
        "smooth or filter; default auto",
    )


def add_gravity(parser: argparse._ActionsContainer) -> None:
    """Options on gravity."""
    parser.add_argument(
        "--gravity",
        metavar="X,Y,Z|estimate",
        help=f"in world axes [m/s²], or find its direction; default {GRAVITY}, "
        "its size ± 0.013",
    )
    add_place(parser)


def add_place(parser: argparse._ActionsContainer) -> None:
    """Options on the place on the Earth, for the size of gravity."""
    add_number(
        parser, "--latitude", "DEG", "local gravity, straight down, north positive"
    )
    add_number(parser, "--altitude", "M", "with --latitude; default about sea level")


def add_sensor_accuracy(parser: argparse._ActionsContainer) -> None:
    """Option on the accuracy of the sensor."""
    parser.add_argument(
        "--sensor-accuracy",
        metavar="ACCURACY",
        help="how far the force-torque sensor may be off, of the load and as an "
        "offset, as in '0.5%% 0.3N 0.01Nm', or its name; default 0.5%%",
    )


def add_tool(
    parser: argparse._ActionsContainer, what: str = "subtract this gripper"
) -> None:
    """Option on a tool that the sensor holds besides the object."""
    parser.add_argument(
        "--tool",
        metavar="FILE",
        help=f"{what}, as hefting calibrate measured it (JSON)",
    )


def add_mass(parser: argparse._ActionsContainer) -> None:
    """Option on a scale's reading."""
    parser.add_argument(
        "--mass",
        metavar="0.512kg±1g",
        help="what a scale shows of the object, without the --tool; ± (or +-) is one "
        "standard deviation, or the scale's stated accuracy; default its last digit",
    )


def part_of(a: argparse.Namespace, recording: "Recording") -> "Recording":
    """The part of a recording by the options of `add_part`."""
    if not a.start and a.duration is None:
        return recording
    return recording.slice(a.start, a.duration)


def read_recording(
    arguments: argparse.Namespace, wrench_needed: bool = True
) -> "Recording":
    """The recording that the arguments describe; ``-`` is standard input."""
    from hefting.request.settings import recording_of

    with input_file(arguments.log) as path:
        recording = recording_of(arguments, path, wrench_needed)
    return replace(recording, source=NAME) if arguments.log == "-" else recording


def check_output(path: str, a: argparse.Namespace) -> None:
    """`InputError` as of `check_place`, for an existing output that is no regular file,
    and for a file that any other option names."""
    check_place(path)
    given = (value for name, value in vars(a).items() if name not in OUTPUTS)
    words = chain.from_iterable(v if isinstance(v, list) else [v] for v in given)
    check_replaceable(path, *(word for word in words if isinstance(word, str)))


def flange_of(a: argparse.Namespace) -> "Array | None":
    """The given pose (4, 4) of the sensor in the flange, or None; `InputError` where
    nothing is written."""
    from hefting.request.settings import pose_of

    flange = pose_of(a.sensor_pose_in_flange)
    written = a.output, getattr(a, "report", None), getattr(a, "export_to", None)
    if flange is not None and not any(written):
        what = "is for files to write"
        raise InputError(what, "--sensor-pose-in-flange", "give --output FILE")
    return flange


def check_place(path: str) -> None:
    """`InputError` for standard output, and an output in a folder that is absent or
    cannot be written."""
    if path == "-":
        raise InputError("is no name of a file", path, "choose another name")
    folder = Path(path).absolute().parent
    if not folder.is_dir():
        raise InputError("the folder does not exist", where=path)
    if not os.access(folder, os.W_OK):
        raise InputError("the folder cannot be written", where=path)


def add_shape(parser: argparse._ActionsContainer) -> None:
    """Options on the shape and its pose; for others see `add_shape_details`."""
    parser.set_defaults(points=None, points_per_cm3=None)
    parser.add_argument(
        "--shape",
        metavar="FILE",
        help="mesh, point cloud or labelled parts; or box:X0,X1,Y0,Y1,Z0,Z1 in the "
        "sensor frame [m]",
    )
    parser.add_argument(
        "--unit", metavar="m|cm|mm|in", help="length unit of its file; default m"
    )
    parser.add_argument(
        "--object-pose",
        metavar="POSE",
        help=f"the file's frame in the sensor frame: {POSE}",
    )
    parser.add_argument(
        "--box",
        metavar="X,Y,Z",
        help="instead of a file: the sides [m] of a box that holds the object, its "
        "centre at --object-pose, else at the sensor; --box 10cm,20cm,5cm works too",
    )
    parser.add_argument(
        "--hull",
        action="store_true",
        help="take the convex hull of the shape's file, for example if its mesh has holes",
    )


def add_shape_details(group: argparse._ActionsContainer) -> None:
    """Options on the accuracy of the shape, and on its number of points."""
    from hefting.estimators import methods_with

    pose, shape = (", ".join(methods_with(name)) for name in ("pose_std", "shape_std"))
    group.add_argument(
        "--pose-std",
        metavar="LENGTH,ANGLE",
        help=f"{pose}: how well --object-pose is known, as in 5mm,5deg; 0mm,0deg: "
        "exactly; default perhaps exactly, perhaps some 5 mm and 5° off",
    )
    group.add_argument(
        "--shape-std",
        metavar="SHARE",
        help=f"{shape}: how well the shape is known, as in 20%%; default exactly, "
        "20%% for a hull, less for a mesh with holes; a box need only hold the object",
    )
    group.add_argument(
        "--points",
        type=int,
        metavar="N",
        help="about how many point masses; default 56",
    )
    add_number(group, "--points-per-cm3", "D", "points per cm³ instead")
