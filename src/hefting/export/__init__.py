"""Export: an estimate as text for a simulator, a robot controller, or a table.

    exported = export(estimate, "urdf")
    exported = export(estimate, "ur", sensor_pose_in_flange=pose)
    exported = export(estimate, "urdf", into="robot.urdf", link="tool0")

Each target is a function from `Body` to text; this file knows only that.
"""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from numpy.typing import ArrayLike

from hefting.core.errors import InputError, nearest
from hefting.core.estimate import Estimate
from hefting.core.messages import Message, warning
from hefting.export import controllers, mjcf, records, sdf, urdf, usd
from hefting.export.body import THINNEST, Body
from hefting.export.splice import Place, put_inertial

__all__ = ["SUFFIXES", "TARGETS", "Exported", "export"]


@dataclass(frozen=True)
class Exported:
    """Text for a target, and what the user should know before using it."""

    text: str
    """Content of the file, or the lines to paste."""
    frame: str
    """Frame of its numbers: ``sensor`` or ``flange``."""
    warnings: tuple[str, ...] = ()
    """One sentence each."""


@dataclass(frozen=True)
class _Simulator:
    """A file format for simulators; `place` and `inertial` where one can be put into an existing file."""

    write: Callable[[Body], str]
    place: Place | None = None
    inertial: Callable[[Body], str] | None = None


SIMULATORS = {
    "urdf": _Simulator(urdf.write, urdf.PLACE, urdf.inertial),
    "mjcf": _Simulator(mjcf.write, mjcf.PLACE, mjcf.inertial),
    "sdf": _Simulator(sdf.write, sdf.PLACE, sdf.inertial),
    "usd": _Simulator(usd.write),
}
CONTROLLERS: dict[str, Callable[[Body], str]] = {
    "ur": controllers.write_ur,
    "xarm": controllers.write_xarm,
    "franka": controllers.write_franka,
    "kuka": controllers.write_kuka,
    "abb": controllers.write_abb,
    "fanuc": controllers.write_fanuc,
}

TARGETS = {
    "urdf": "link of a URDF robot (ROS, Pinocchio, MuJoCo)",
    "mjcf": "body of a MuJoCo model",
    "sdf": "link of an SDFormat model (Gazebo)",
    "usd": "rigid body of a USD stage, usda text (Isaac Sim)",
    "ur": "Universal Robots: URScript set_target_payload",
    "xarm": "UFACTORY xArm: Python set_tcp_load (mass and COM only)",
    "franka": "Franka: libfranka setLoad, ROS 2 SetLoad",
    "kuka": "KUKA: KRL load data",
    "abb": "ABB: RAPID loaddata",
    "fanuc": "Fanuc: payload schedule",
    "json": "the estimate itself, which Hefting reads back",
    "csv": "the estimate as one row of a table",
}
"""Every target and what it is."""

SUFFIXES = {".json": "json", ".urdf": "urdf", ".xml": "mjcf", ".sdf": "sdf", ".usda": "usd", ".csv": "csv"}
"""Target of each file suffix."""


def export(
    estimate: Estimate,
    target: str,
    sensor_pose_in_flange: ArrayLike | None = None,
    into: str | Path | None = None,
    link: str | None = None,
    name: str = "object",
) -> Exported:
    """Text of an estimate for a target; nothing is written.

    Parameters
    ----------
    estimate : in sensor axes about the sensor origin.
    target : a name in `TARGETS`.
    sensor_pose_in_flange : (4, 4) pose of the sensor frame in the flange frame [m]; with it the text is in
        flange axes about the flange origin, without it in sensor axes, which controllers do not expect: a
        warning says so. JSON and CSV are always in sensor axes.
    into : existing URDF, MJCF or SDF file: the text is that file with the body's inertial put into a link,
        in place of one that is there, and every other byte unchanged.
    link : name of the link (of the body, in MJCF) in that file.
    name : name of the body in a file of its own; one printable line.

    Raises `InputError` for an unknown target, arguments that do not fit it, a file or link that does not,
    and, for everything but JSON and CSV, parameters no body can have.
    """
    if target not in TARGETS:
        raise InputError(
            f"unknown target '{target}'{nearest(target, TARGETS)}", fix=f"choose from: {', '.join(TARGETS)}"
        )
    _check_arguments(target, into, link, name)
    if target in ("json", "csv"):
        text = records.write_json(estimate) if target == "json" else records.write_csv(estimate, name)
        what = f"{target} holds the estimate in sensor axes: the sensor's pose in the flange was not used"
        unused = warning("sensor-pose-unused", what, "sensor_pose_in_flange")
        return Exported(text, "sensor", (unused,) if sensor_pose_in_flange is not None else ())

    body = Body.from_parameters(estimate.parameters, name, "sensor")
    if sensor_pose_in_flange is not None:
        body = body.moved(sensor_pose_in_flange, "flange")
    warnings = []
    if body.thickened:
        what = (
            "the body is flat or rod-like: it was given a thickness of a thousandth of its size, which keeps "
            f"simulators from refusing it and changes its inertia by about {THINNEST:g} of the largest moment"
        )
        warnings.append(warning("body-thickened", what))
    if target in CONTROLLERS:
        return Exported(CONTROLLERS[target](body), body.frame, (*warnings, *_controller_warnings(target, body)))

    simulator = SIMULATORS[target]
    if body.is_point:
        raise InputError(
            "the estimate is a point mass, and a simulator needs an inertia",
            fix="identify it from a motion that rotates, or with a shape",
        )
    if into is None:
        return Exported(simulator.write(body), body.frame, tuple(warnings))
    assert simulator.place is not None  # as _check_arguments saw
    assert simulator.inertial is not None
    text, replaced = put_inertial(into, link, simulator.inertial(body), simulator.place)
    warnings.append(warning("link-frame-assumed", f"the frame of '{link}' is taken to be the {body.frame} frame"))
    if target == "mjcf" and mjcf.ignores_inertial(text):
        what = "the model says inertiafromgeom=true, which makes MuJoCo ignore every inertial"
        warnings.append(warning("inertials-ignored", what))
    if replaced:
        warnings.append(warning("inertial-replaced", f"'{link}' had an inertial: it was replaced, not added to"))
    return Exported(text, body.frame, tuple(warnings))


def _check_arguments(target: str, into: str | Path | None, link: str | None, name: str) -> None:
    if into is not None and (target not in SIMULATORS or SIMULATORS[target].place is None):
        able = ", ".join(key for key, simulator in SIMULATORS.items() if simulator.place)
        raise InputError(f"{target} cannot be put into an existing file", fix=f"only {able} can")
    if link is not None and into is None:
        raise InputError(f"link '{link}' of which file?", fix="name the file with (`into`=FILE)")
    if not name.strip() or not name.isprintable() or len(name) > 200 or name == "world":
        raise InputError(f"{name[:200]!r} cannot name a body", fix="give one printable line, and not 'world'")


def _controller_warnings(target: str, body: Body) -> list[Message]:
    warnings = []
    if body.frame != "flange":
        what = (
            "written in sensor axes, but the controller takes flange axes: "
            "give the sensor's pose in the flange (`sensor_pose_in_flange`=x,y,z,qx,qy,qz,qw)"
        )
        warnings.append(warning("sensor-axes", what, "sensor_pose_in_flange"))
    if target == "fanuc" and (share := controllers.dropped_products(body)) > 0.01:
        what = f"Fanuc takes no products of inertia: up to {share:.0%} of the largest moment is left out"
        warnings.append(warning("products-left-out", what))
    if target == "abb" and body.is_point:
        warnings.append(warning("point-mass", "the estimate is a point mass: the three moments are zero"))
    return warnings
