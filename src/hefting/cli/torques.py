"""Options and steps of commands that take joint torques in place of a wrench."""

import argparse
import shlex
from typing import TYPE_CHECKING

from hefting.cli import option_of
from hefting.cli.options import part_of
from hefting.cli.standard_input import input_file
from hefting.core.errors import InputError
from hefting.core.quantity import numbers

if TYPE_CHECKING:
    from hefting.core.estimate import Estimate
    from hefting.core.recording import Recording
    from hefting.shapes import Shape

METHODS = "Bayes, GEO, LMI, OLS, PMD"
"""Methods that need only the equations of the parameters."""
WRENCH_ONLY = {
    "tool": None,
    "bias": "auto",
    "wrench": "auto",
    "motion": "auto",
    "until": None,
    "sensor_accuracy": None,
    "report": None,
    "sensor_pose_in_log": None,
    "sensor_turned": None,
}
"""Options that are not for joint torques, and their defaults."""


def add_torques(group: argparse._ActionsContainer) -> None:
    """Options on the use of joint torques, and on their unit."""
    group.add_argument(
        "--torques",
        action="store_true",
        help="identify from joint torques; with --urdf and --sensor-frame",
    )
    group.add_argument(
        "--torque-gains",
        metavar="K[,K...]",
        help="torque of each joint per motor current [N m/A], if currents were "
        "recorded",
    )


def add_empty(group: argparse._ActionsContainer) -> None:
    """Options on the empty arm."""
    group.add_argument(
        "--empty",
        metavar="FILE",
        action="append",
        default=[],
        help="recording of the same arm without the object, of any motion; repeatable",
    )
    group.add_argument(
        "--arm",
        metavar="FILE.json",
        help="the same, as hefting calibrate --torques kept it",
    )


def require_torques(a: argparse.Namespace) -> None:
    """`InputError` for options of torques without ``--torques``."""
    for name in ("empty", "arm", "torque_gains"):
        if not a.torques and getattr(a, name, None):
            fix = "give --torques as well"
            raise InputError("is for joint torques", option_of(name), fix)


def identified(a: argparse.Namespace, shape: "Shape | None") -> "Estimate":
    """The estimate from joint torques."""
    from hefting.identification.by_torques import ByTorques
    from hefting.request.settings import hyperparameters_of

    _refuse_wrench_options(a)
    if a.method and (a.method.lower() == "all" or "," in a.method):
        raise InputError(
            "methods are compared by the wrench", "--method", f"choose one of {METHODS}"
        )
    recordings = [part_of(a, _read(a, log, a.poses)) for log in a.log]
    found = ByTorques.of(
        recordings,
        a.urdf,
        a.sensor_frame,
        empty=[_read(a, log) for log in a.empty],
        arm=a.arm,
        torque_gains=a.torque_gains and numbers(a.torque_gains, None, "--torque-gains"),
        gravity=_gravity(a),
    )
    return found.estimate(shape, a.method, **hyperparameters_of(a))


def calibrate(a: argparse.Namespace) -> list[str]:
    """Write the arm's calibration; returns lines to print."""
    from hefting.identification.by_torques import calibrate_arm
    from hefting.torques.runs import save_arm

    _refuse_wrench_options(a)
    dynamics, runs, messages = calibrate_arm(
        [part_of(a, _read(a, a.log, a.poses))],
        a.urdf,
        a.sensor_frame,
        torque_gains=a.torque_gains and numbers(a.torque_gains, None, "--torque-gains"),
        gravity=_gravity(a),
    )
    save_arm(a.output, dynamics, runs)
    noise = ", ".join(f"{value:.3g}" for value in runs.fit.std)
    words = ["hefting", "identify", "LOG", "--torques", "--urdf", a.urdf]
    words += ["--sensor-frame", a.sensor_frame, "--arm", a.output]
    return [
        *(f"{each.severity}: {each}" for each in messages),
        f"arm of {dynamics.joints} joints, {len(dynamics.base)} base parameters, "
        f"{runs.scales.samples} samples",
        f"what its torques leave unexplained: {noise} N m",
        f"wrote {a.output}: {shlex.join(words)}",
    ]


def _refuse_wrench_options(a: argparse.Namespace) -> None:
    if not a.urdf or not a.sensor_frame:
        raise InputError(
            "joint torques need the robot and the link that holds the object",
            "--torques",
            "give --urdf FILE and --sensor-frame NAME",
        )
    for name, default in WRENCH_ONLY.items():
        if getattr(a, name, default) != default:
            what = "is for a wrench, not for --torques"
            raise InputError(what, option_of(name), "leave it out")


def _read(a: argparse.Namespace, log: str, poses: str | None = None) -> "Recording":
    """A log, with the joint positions in the file `poses`, if any."""
    from hefting.request.settings import logged

    with input_file(log) as path:
        own = argparse.Namespace(**(vars(a) | {"poses": poses}))
        return logged(own, path, wrench_needed=False)


def _gravity(a: argparse.Namespace) -> tuple[float, ...]:
    from hefting.request.settings import gravity_of

    if a.gravity == "estimate":
        raise InputError(
            "is not found from joint torques",
            "--gravity estimate",
            "give X,Y,Z in the axes of the robot's base",
        )
    return gravity_of(a).vector
