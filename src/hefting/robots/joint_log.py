"""Poses of the sensor from the joint positions of a recording."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from hefting.core.errors import InputError, nearest
from hefting.core.messages import Message, note, warning
from hefting.core.recording import Recording, Stream
from hefting.core.spatial import Array
from hefting.robots.robot import Robot
from hefting.robots.urdf import listed

REPLACED = (
    "position",
    "orientation",
    "linear_velocity",
    "angular_velocity",
    "linear_acceleration",
    "angular_acceleration",
)
"""Streams in the recording's world axes, which need not be those of the robot's root."""

TURNS = 4 * 2 * np.pi
"""Range assumed for a joint without limits, to each side [rad]."""


def with_poses(
    recording: Recording, robot: Robot, joint_names: Sequence[str] = ()
) -> Recording:
    """The recording with position and orientation of the sensor computed from its joint
    positions.

    The poses have the times and rows of the joint positions; their world is the robot's
    root frame. Recorded poses, velocities and accelerations in world axes are dropped, as
    they may be of another frame or world. A note about this is added, and a warning about
    doubtful angles.

    Parameters
    ----------
    joint_names : names of the columns q1..qn, by default those of the recording. With
        names, other joints than the robot's are ignored. Without names, q1..qn are the
        robot's `joints` or `all_joints`, whichever has their number.

    Raises `InputError` if the recording has no joint positions, if names and columns
    differ in number, a name is repeated, a joint is missing, the number of unnamed
    columns fits neither, or no joint moves the sensor frame.

    Examples
    --------
    >>> robot = hefting.Robot.from_urdf("arm.urdf", sensor_frame="tool")
    >>> joints = {"time": [0.0, 0.1], "q1": [0.0, 0.5]}
    >>> recording = hefting.as_recording(joints, wrench_needed=False)
    >>> sorted(hefting.with_poses(recording, robot).streams)
    ['joint_positions', 'orientation', 'position']
    """
    if not robot.screws:
        what = f"no joint moves the frame '{robot.sensor_frame}': it is fixed to the root '{robot.root}'"
        raise InputError(
            what, where=robot.source, fix="choose the frame of the force-torque sensor"
        )
    names = tuple(joint_names) or recording.joint_names
    columns = _joints_of_columns(names, recording, robot)
    stream = recording["joint_positions"]
    q = stream.values[:, [columns.index(name) for name in robot.joints]]
    position, orientation = robot.poses(q)
    poses = {
        "position": Stream(stream.time, position, stream.rows),
        "orientation": Stream(stream.time, orientation, stream.rows),
    }
    dropped = [name for name in REPLACED if name in recording.streams]
    done = f"poses of '{robot.sensor_frame}' in '{robot.root}' from {listed(robot.joints)} by {robot.source}"
    if dropped:
        done += f", in place of the recorded {', '.join(dropped)}"
    kept = {
        name: stream
        for name, stream in recording.streams.items()
        if name not in REPLACED
    }
    warnings = (*recording.warnings, *angle_doubts(q, robot))
    notes = (*recording.notes, note("poses-from-joints", done))
    return replace(
        recording, streams=kept | poses, warnings=warnings, notes=notes, angles=None
    )


def named_columns(recording: Recording, robot: Robot) -> dict[str, int]:
    """The column of each joint in the recording's joint positions, by name; columns and
    errors as in `with_poses`."""
    names = _joints_of_columns(recording.joint_names, recording, robot)
    return {name: column for column, name in enumerate(names)}


def _joints_of_columns(
    names: tuple[str, ...], recording: Recording, robot: Robot
) -> tuple[str, ...]:
    """The joint of each column, as in `with_poses`; `InputError` unless each of the
    robot's joints has one column."""
    source = recording.source
    if not recording.has("joint_positions"):
        fix = "record columns q1..qn, or JointState"
        raise InputError("has no joint positions", source, fix)
    count = recording["joint_positions"].values.shape[1]
    if not names:
        return _joints_by_number(count, robot, source)
    if len(names) != count:
        what = f"{len(names)} joint names for {count} columns of joint positions"
        raise InputError(what, where=source)
    missing = [name for name in robot.joints if name not in names]
    if missing:
        what = f"lacks joint {listed(missing, 10)} of {robot.source}{nearest(missing[0], names)}"
        raise InputError(what, where=source, fix=f"it has {listed(names)}")
    repeated = [name for name in robot.joints if names.count(name) > 1]
    if repeated:
        raise InputError(
            f"two columns of joint positions are named '{repeated[0]}'", where=source
        )
    return names


def _joints_by_number(count: int, robot: Robot, source: str) -> tuple[str, ...]:
    for joints in (robot.joints, robot.all_joints):
        if len(joints) == count:
            return joints
    needed = f"'{robot.sensor_frame}' is moved by {len(robot.joints)} ({listed(robot.joints)})"
    every = f", the whole robot by {len(robot.all_joints)} ({listed(robot.all_joints)})"
    what = f"has {count} unnamed joints, but in {robot.source} {needed}{every}"
    raise InputError(what, where=source, fix="name the joints, or record those")


def angle_doubts(q: Array, robot: Robot) -> tuple[Message, ...]:
    """A warning if angles `q` (K, n) [rad] are so large that they may be degrees."""
    for angles, limits, name in zip(q.T, robot.limits, robot.joints, strict=True):
        if limits is None:
            continue
        low, high = (
            limit if np.isfinite(limit) else sign * TURNS
            for limit, sign in zip(limits, (-1, 1), strict=True)
        )
        peak = angles[np.argmax(np.abs(angles))]
        if peak < low - 2 * np.pi or peak > high + 2 * np.pi:
            what = f"joint {name} reaches {peak:.4g} rad, far beyond its limits: are the joint angles in degrees?"
            return (warning("joint-angles-degrees", what),)
    return ()
