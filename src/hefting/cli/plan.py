"""hefting plan: find the motion to make next, for what is still unknown, within
limits."""

import argparse
from pathlib import Path
from typing import TYPE_CHECKING, Any

from hefting.cli import option_of, render
from hefting.cli.options import (
    GRAVITY,
    add_json,
    add_number,
    add_output,
    add_shape,
    add_verbose,
    check_output,
    read_estimate,
)
from hefting.cli.outputs import is_picture, no_output_format, print_object
from hefting.cli.progress import progress
from hefting.core.errors import InputError
from hefting.core.files import write_atomically
from hefting.core.messages import verdict_of
from hefting.core.quantity import numbers, quantities
from hefting.request.settings import accuracy_of, require_shape, shape_of

if TYPE_CHECKING:
    from hefting.core.measurements import Noise
    from hefting.planning import Plan

EXAMPLES = (
    "hefting plan --urdf ur5e.urdf --tip tool0 --output motion.csv",
    "hefting plan --urdf arm.urdf --tip flange --keep 'x<=0.6' --output plan.html",
    "hefting plan --urdf arm.urdf --tip flange --estimate now.json --quick",
)
PLAYER = ".html"
"""Suffix of a page that plays the motion."""
RATE = 100.0
"""[Hz] Default rate of the samples that will be recorded."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Arguments of ``hefting plan``."""
    from hefting.planning.files import FORMATS
    from hefting.plots.style import FORMATS as PICTURES

    parser.add_argument(
        "--urdf", metavar="FILE", required=True, help="the robot, with its limits"
    )
    parser.add_argument(
        "--tip", metavar="FRAME", required=True, help="link whose frame is the sensor's"
    )
    parser.add_argument(
        "--estimate",
        metavar="FILE",
        help="what is known so far, as hefting identify --output wrote it (JSON); "
        "- reads standard input; default nothing",
    )
    parser.add_argument(
        "--until",
        metavar="ACCURACY",
        help="what is to be reached, as in mass=1%%,com=2mm,inertia=20%%; default as "
        "much of everything as can be",
    )
    add_number(parser, "--duration", "S", "[s]; default 10", default=10.0)
    motions, pictures = ", ".join(FORMATS), ", ".join(PICTURES)
    what = f"the motion ({motions}), a picture ({pictures}), or a page that plays it"
    add_output(parser, f"{what} ({PLAYER})")
    add_json(parser)
    add_verbose(parser)
    add_shape(parser.add_argument_group("the object's shape"))
    _add_limits(parser.add_argument_group("limits"))
    _add_sensor(parser.add_argument_group("sensor"))
    search = parser.add_argument_group("search")
    search.add_argument(
        "--start",
        metavar="Q1,Q2...",
        help="joint positions to start from [rad]; default any",
    )
    search.add_argument(
        "--stop-and-go",
        action="store_true",
        help="poses with rests, for mass and COM alone",
    )
    search.add_argument(
        "--quick", action="store_true", help="search for some two seconds only"
    )
    search.add_argument(
        "--seed", type=int, metavar="N", default=0, help="same seed, same plan"
    )


def _add_limits(group: argparse._ActionsContainer) -> None:
    add_number(
        group,
        "--speed",
        "V",
        "of every corner of the object's box, and of the tip [m/s]; default 0.25",
        default=0.25,
    )
    group.add_argument(
        "--acceleration",
        metavar="A[,A...]",
        help="of all joints, or of each [rad/s²]; default 5, as URDFs have none",
    )
    group.add_argument(
        "--jerk", metavar="J[,J...]", help="the same [rad/s³]; default 100"
    )
    group.add_argument(
        "--keep",
        metavar="HALF-SPACE",
        action="append",
        default=[],
        help="where links and object stay, in the axes of the URDF's root, as in "
        "'z>=0.05', 'x<=0.6' or '0.7,0.7,0>=-0.3' (0.7 x + 0.7 y >= -0.3 m); repeatable",
    )
    group.add_argument(
        "--srdf", metavar="FILE", help="which links not to check against each other"
    )


def _add_sensor(group: argparse._ActionsContainer) -> None:
    group.add_argument(
        "--sensor-noise",
        metavar="FORCE,TORQUE",
        help="of a sample, one standard deviation, as in 0.1N,5mNm; default that of "
        "the estimate's recording, else 0.1N,5mNm",
    )
    group.add_argument(
        "--noise-from", metavar="LOG", help="the same, from an earlier recording"
    )
    add_number(group, "--rate", "HZ", "of the samples; default 100")
    group.add_argument(
        "--sensor-range",
        metavar="FORCE,TORQUE",
        help="largest along each axis, as in 100N,5Nm; default any",
    )
    group.add_argument(
        "--torques",
        action="store_true",
        help="no wrench sensor: the joints' torques are measured; with --shape or --box",
    )
    group.add_argument(
        "--torque-noise",
        metavar="T[,T...]",
        help="of a sample of all joints, or of each, one standard deviation [N m]; "
        "default that of the estimate's recording, else from 0.1 at the base to 0.05",
    )
    group.add_argument(
        "--gravity",
        metavar="X,Y,Z",
        default=GRAVITY,
        help=f"in the axes of the URDF's root [m/s²]; default {GRAVITY}",
    )


def run(arguments: argparse.Namespace) -> int:
    """Plan, write the outputs, and print the expected accuracy; returns the exit status,
    3 for an estimate that is not to be used."""
    from hefting.cli.report import exit_status

    a = arguments
    require_shape(a)
    _check_outputs(a)
    _require_joints(a)
    with progress("planning", a.json):
        found = _plan(a)
        contents = [_content(found, path) for path in a.output]
    for path, content in zip(a.output, contents, strict=True):
        write_atomically(path, content)
    status = exit_status(verdict_of(found.warnings))
    if a.json:
        print_object(found)
        return status
    from hefting.cli.report.estimate import Line, print_lines
    from hefting.cli.report.plan import plan_report

    written = [Line(f"wrote {path}") for path in a.output]
    print_lines([*plan_report(found, a.verbose), *written], render)
    return status


def _check_outputs(a: argparse.Namespace) -> None:
    """`InputError` for an output that cannot or must not be written."""
    from hefting.planning.files import FORMATS
    from hefting.plots.style import FORMATS as PICTURES
    from hefting.plots.style import picture_suffix

    known = (*FORMATS, *PICTURES, PLAYER)
    for path in a.output:
        suffix = Path(path).suffix.lower()
        if suffix not in known:
            raise no_output_format(path, known)
        if is_picture(path):
            picture_suffix(path)
        check_output(path, a)


def _require_joints(a: argparse.Namespace) -> None:
    """`InputError` for a format that needs another number of joints than the plan's."""
    from hefting.planning.files import JOINTS, require_joints
    from hefting.robots import Robot

    if limited := JOINTS.keys() & {Path(path).suffix for path in a.output}:
        joints = len(Robot.from_urdf(a.urdf, a.tip).joints)
        for suffix in limited:
            require_joints(suffix, joints)


def _plan(a: argparse.Namespace) -> "Plan":
    from hefting.planning import plan

    torques = _torques_of(a)
    noise, rate = _noise_of(a)
    force = torque = None
    if a.sensor_range is not None:
        force, torque = _positive(a.sensor_range, "--sensor-range", "100N,5Nm")
    given: dict[str, Any] = {
        "estimate": None if a.estimate is None else read_estimate(a.estimate),
        "shape": shape_of(a),
        "until": None if a.until is None else accuracy_of(a.until),
        "duration": a.duration,
        "speed": a.speed,
        "start": None if a.start is None else numbers(a.start, None, "--start"),
        "noise": noise,
        "acceleration": _of_joints(a.acceleration, "--acceleration"),
        "jerk": _of_joints(a.jerk, "--jerk"),
        "force": force,
        "torque": torque,
        "keep": a.keep,
        "srdf": a.srdf,
        "gravity": numbers(a.gravity, 3, "--gravity"),
        "rate": rate,
        "torques": torques,
        "effort": "quick" if a.quick else "full",
        "stop_and_go": a.stop_and_go,
        "seed": a.seed,
    }
    return plan(a.urdf, a.tip, **given)


def _content(found: "Plan", path: str) -> str | bytes:
    from hefting.planning.files import content_of

    suffix = Path(path).suffix.lower()
    if is_picture(path):
        from hefting.plots import picture_of, plot_plan

        return picture_of(plot_plan(found, render), suffix)
    if suffix == PLAYER:
        from hefting.viewer.player import plan_player

        return plan_player(found)
    return content_of(found, path)


def _noise_of(a: Any) -> "tuple[Noise | None, float]":
    """Noise of a sample, as given or from a recording (None without either), and the
    rate of the samples [Hz]."""
    from hefting.core.measurements import Noise

    noise, rate = None, RATE
    if a.sensor_noise is not None:
        noise = Noise(*_positive(a.sensor_noise, "--sensor-noise", "0.1N,5mNm"))
    if a.noise_from is not None:
        if noise is not None:
            what = "is given beside --noise-from"
            raise InputError(what, "--sensor-noise", "leave one of them out")
        noise, rate = _noise_of_recording(a)
    return noise, rate if a.rate is None else a.rate


def _positive(text: str, option: str, example: str) -> tuple[float, ...]:
    """Positive force [N] and torque [N m]."""
    values = quantities(text, ("force", "torque"), option, example)
    if not min(values) > 0.0:
        raise InputError(f"'{text}' is not positive", option, f"as in {example}")
    return values


def _torques_of(a: Any) -> bool | float | list[float]:
    """Whether joint torques are measured, and their noise [N m] where it was given.
    Raises `InputError` without a shape, and for options of a wrench sensor."""
    if not a.torques:
        if a.torque_noise is not None:
            what = "is for joint torques"
            raise InputError(what, "--torque-noise", "give --torques as well")
        return False
    for name in ("sensor_noise", "noise_from", "sensor_range"):
        if getattr(a, name) is not None:
            what = "is of a wrench sensor, not for --torques"
            raise InputError(what, option_of(name), "leave it out")
    if a.shape is None and a.box is None:
        what = "joint torques hardly determine an inertia without a shape"
        raise InputError(what, "--torques", "give --shape FILE or --box")
    noise = _of_joints(a.torque_noise, "--torque-noise")
    return True if noise is None else noise


def _of_joints(text: str | None, option: str) -> float | list[float] | None:
    """One number for all joints, or comma-separated numbers for each; None for None."""
    if text is None:
        return None
    values = numbers(text, None, option)
    return values[0] if len(values) == 1 else values


def _noise_of_recording(a: Any) -> "tuple[Noise, float]":
    """Noise and rate [Hz] of a recording of the same sensor; the noise is that of
    uncorrelated samples with as much information."""
    from hefting.core.measurements import Noise
    from hefting.ingest.ingest import ingest
    from hefting.logs import read_log
    from hefting.robots import Robot, with_poses

    recording = read_log(a.noise_from)
    if not recording.has("orientation"):
        recording = with_poses(recording, Robot.from_urdf(a.urdf, a.tip))
    if recording.static:
        what = "static poses do not show how fast the sensor is"
        raise InputError(what, a.noise_from, "give --sensor-noise and --rate")
    found = ingest(recording)
    correlation = max(found.fit.autocorrelation, 1.0) ** 0.5
    time = recording["wrench"].time
    rate = (len(time) - 1) / float(time[-1] - time[0])
    noise = found.noise
    return Noise(correlation * noise.force, correlation * noise.torque), rate
