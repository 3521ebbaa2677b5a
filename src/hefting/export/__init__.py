"""Export: an estimate as text for a simulator, a robot controller, or a table.

    exported = export(estimate, "urdf")
    exported = export(estimate, "ur", sensor_pose_in_flange=pose)
    exported = export(estimate, "urdf", into="robot.urdf", link="tool0")

Each file of this package holds a `Target`, or those of one make; this one lists and uses
them.
"""

from collections.abc import Callable
from dataclasses import dataclass
from importlib import import_module
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike

from hefting.core.errors import InputError, nearest
from hefting.core.estimate import Answered, Estimate, estimate_of
from hefting.core.messages import Message, warning
from hefting.export.body import THINNEST, Body
from hefting.export.known import Fill, inertia_messages, known_body, with_comment
from hefting.export.target import Target, put_inertial

__all__ = ["INSERTABLE", "SUFFIXES", "TARGETS", "Exported", "Target", "export"]

FILES = (
    "urdf",
    "mjcf",
    "sdf",
    "usd",
    "ur",
    "xarm",
    "franka",
    "kuka",
    "abb",
    "fanuc",
    "kinova",
    "doosan",
    "ros2_control",
    "estimate_files",
)
"""The files of the targets, in the order of lists of targets."""


FARTHEST_COM = 3.0
"""[m] Distance of the COM from the flange above which a warning is given, as the pose is
then probably not in metres."""

REGISTRY: dict[str, Target] = {
    target.name: target
    for file in FILES
    for target in vars(import_module(f"{__name__}.{file}")).values()
    if isinstance(target, Target)
}
"""All targets by name."""

TARGETS: dict[str, str] = {
    name: target.description for name, target in REGISTRY.items()
}
"""Descriptions of all targets by name."""

SUFFIXES: dict[str, str] = {
    suffix: target.name
    for target in sorted(REGISTRY.values(), key=lambda target: not target.is_read_back)
    for suffix in target.suffixes
}
"""Target of each file suffix, in order those that Hefting reads back first."""

INSERTABLE: dict[str, str] = {
    name: target.place.format for name, target in REGISTRY.items() if target.place
}
"""Format of the existing files that a target can be put into, by target."""


@dataclass(frozen=True)
class Exported:
    """Text for a target, and warnings about its use."""

    text: str
    """Content of the file, or the lines to paste."""
    frame: str
    """Frame of its numbers: that of the estimate, or ``flange``."""
    warnings: tuple[str, ...] = ()
    """One sentence each."""


def export(
    estimate: Estimate | Answered,
    target: str,
    sensor_pose_in_flange: ArrayLike | None = None,
    into: str | Path | None = None,
    link: str | None = None,
    name: str = "object",
    *,
    accept: bool = False,
    fill_inertia: Fill = None,
    say: Callable[[str], str] = str,
) -> Exported:
    """Text of an estimate for a target; nothing is written.

    Numbers have as many digits as their intervals are worth (`hefting.core.quantity`);
    comments repeat the verdict and the warnings. An inertia that neither the recording
    nor a shape determines is left out where a controller takes mass and COM alone.

    Parameters
    ----------
    estimate : in sensor axes about the sensor origin, or the result of
        `hefting.identify`; for simulators, JSON and CSV in any frame, such as the
        object's (`hefting.in_frame`).
    target : a name in `TARGETS`.
    sensor_pose_in_flange : pose of the sensor in the flange frame, as for `identify`;
        with it the text is in flange axes about the flange origin, without it in sensor
        axes, which controllers do not expect: a warning says so. JSON and CSV are
        always in sensor axes.
    into : existing URDF, MJCF or SDF file: the text is that file with the body's
        inertial put into a link, replacing an existing one, and every other byte
        unchanged.
    link : name of the link (of the body, in MJCF) in that file.
    name : name of the body in a file of its own; one printable line.
    accept : whether to write an estimate with the verdict "do not use". JSON holds the
        verdict, and is written anyway.
    fill_inertia : replacement of an open inertia for simulators, which need one:
        ``"point"``, the smallest that they accept, or a shape in the estimate's frame with
        uniform density. JSON and CSV are never filled in.
    say : turns names of arguments in backquotes, in comments, into the reader's.

    Raises `InputError` for a value without an estimate, an unknown target, arguments, a
    file or a link that do not fit it, and, except for JSON and CSV, parameters that no
    body can have, an open mass or COM, and an open inertia where one is needed.
    """
    estimate, target = estimate_of(estimate), target.lower()
    if target not in REGISTRY:
        of = [name for name, about in TARGETS.items() if target in about.lower()]
        guess = f" (did you mean {' or '.join(of)}?)" if of and target else ""
        what = f"unknown target '{target}'{guess or nearest(target, REGISTRY)}"
        raise InputError(what, fix=f"choose from: {', '.join(REGISTRY)}")
    chosen = REGISTRY[target]
    _check_arguments(chosen, into, link, name)
    if not (estimate.verdict.usable or chosen.is_read_back or accept):
        what = f"the estimate is not to be used: {estimate.verdict.reasons[0]}"
        fix = "identify it again, or give `accept` to write it as it is"
        raise InputError(what, fix=fix)
    if estimate.frame != "sensor" and (
        chosen.wants_flange
        or chosen.in_sensor_axes
        or sensor_pose_in_flange is not None
    ):
        what = (
            f"the estimate is in {estimate.frame} axes, which controllers do not take"
        )
        raise InputError(what, fix="give it in sensor axes")
    if chosen.write_estimate is not None:
        text = chosen.write_estimate(estimate, name)
        unused = () if sensor_pose_in_flange is None else (_pose_unused(chosen),)
        return Exported(text, estimate.frame, unused)

    body = known_body(estimate, name, fill_inertia, accept, say)
    warnings = inertia_messages(estimate, chosen, body, fill_inertia)
    if sensor_pose_in_flange is not None:
        if chosen.in_sensor_axes:
            warnings.append(_pose_unused(chosen))
        else:
            body = body.moved(sensor_pose_in_flange, "flange")
    body = body.rounded()
    warnings += _body_warnings(chosen, body)
    if into is None:
        assert chosen.write is not None  # a target without `write_estimate` has it
        return Exported(chosen.write(body), body.frame, tuple(warnings))
    text, more = _put_into(chosen, body, into, link)
    return Exported(text, body.frame, (*warnings, *more))


def _check_arguments(
    target: Target, into: str | Path | None, link: str | None, name: object
) -> None:
    if into is not None and target.place is None:
        what = f"{target.name} cannot be put into an existing file"
        raise InputError(what, fix=f"only {', '.join(INSERTABLE)} can")
    if link is not None and into is None:
        raise InputError(f"link '{link}' of which file?", fix="give `into`=FILE")
    line = name if isinstance(name, str) and name.isprintable() else ""
    if not line.strip() or len(line) > 200 or line == "world":
        what = f"{repr(name)[:200]} cannot name a body"
        raise InputError(what, fix="give one printable line, and not 'world'")


def _pose_unused(target: Target) -> Message:
    what = f"{target.name} holds the estimate in sensor axes: the sensor's pose in the flange was not used"
    return warning("sensor-pose-unused", what, "sensor_pose_in_flange")


def _body_warnings(target: Target, body: Body) -> list[Message]:
    warnings = []
    if body.thickened:
        what = (
            "the body is flat or rod-like: it was given a thickness of a thousandth of its size, which keeps "
            f"simulators from refusing it and changes its inertia by about {THINNEST:g} of the largest moment"
        )
        warnings.append(warning("body-thickened", what))
    distance = float(np.linalg.norm(body.center_of_mass))
    if body.frame == "flange" and distance > FARTHEST_COM:
        what = f"the centre of mass is {distance:.3g} m from the flange: is the sensor's pose in metres, or as in 40mm?"
        warnings.append(warning("com-far", what, "sensor_pose_in_flange"))
    if target.wants_flange and body.without:
        what = f"{body.without} is not in it: a controller that does not know it takes both together"
        warnings.append(warning("tool-left-out", what, "tool"))
    if target.wants_flange and body.frame != "flange":
        what = (
            "written in sensor axes, but the controller takes flange axes: "
            "give the sensor's pose in the flange, 0,0,0 where they are the same "
            "(`sensor_pose_in_flange`=x,y,z,qx,qy,qz,qw, or as in 0,0,40mm,z:45)"
        )
        warnings.append(warning("sensor-axes", what, "sensor_pose_in_flange"))
    return [*warnings, *target.warnings(body)]


def _put_into(
    target: Target, body: Body, into: str | Path, link: str | None
) -> tuple[str, list[Message]]:
    assert target.place is not None  # ensured by _check_arguments
    assert target.inertial is not None
    element = with_comment(target.inertial(body), body.notes)
    text, before = put_inertial(into, link, element, target.place)
    what = f"the frame of '{link}' is taken to be the {body.frame} frame"
    warnings = [warning("link-frame-assumed", what)]
    warnings += target.file_warnings(text, str(link))
    if before:
        what = f"'{link}' had {before}: it was replaced, not added to"
        warnings.append(warning("inertial-replaced", what))
    return text, warnings
