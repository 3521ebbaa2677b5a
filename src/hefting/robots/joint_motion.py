"""Motion of a robot's joints, as planned or in a log, and that of its sensor frame by
it."""

from collections.abc import Sequence
from dataclasses import fields, replace

import numpy as np
from numpy.typing import ArrayLike

from hefting.core.errors import InputError, nearest
from hefting.core.messages import Message, note, warning
from hefting.core.recording import Recording, Stream
from hefting.core.spatial import Array, freeze, immutable, rotation_matrices, skew
from hefting.robots.robot import Robot
from hefting.robots.urdf import listed


@immutable
class JointMotion:
    """Motion of n joints at K instants. `InputError` unless the shapes agree."""

    time: Array
    """(K,) [s]"""
    position: Array
    """(K, n) [rad]"""
    velocity: Array
    """(K, n) [rad/s]"""
    acceleration: Array
    """(K, n) [rad/s²]"""

    def __post_init__(self):
        freeze(self, *(field.name for field in fields(self)))
        shape = self.position.shape
        if (
            self.time.shape != shape[:1]
            or len(shape) != 2
            or {self.velocity.shape, self.acceleration.shape} != {shape}
        ):
            what = "time (K,), position, velocity and acceleration (K, n) do not agree"
            raise InputError(what, where="JointMotion")


@immutable
class SensorMotion:
    """Exact motion of the sensor frame at K instants, in world axes."""

    time: Array
    """(K,) [s]"""
    position: Array
    """(K, 3) sensor origin [m]"""
    rotation: Array
    """(K, 3, 3) sensor axes to world axes"""
    linear_velocity: Array
    """(K, 3) of the sensor origin [m/s]"""
    angular_velocity: Array
    """(K, 3) [rad/s]"""
    linear_acceleration: Array
    """(K, 3) classical, of the sensor origin [m/s²]"""
    angular_acceleration: Array
    """(K, 3) [rad/s²]"""

    def __post_init__(self):
        freeze(self, *(field.name for field in fields(self)))

    @property
    def orientation(self) -> Array:
        """(K, 4) unit quaternions x, y, z, w, sensor in world."""
        from scipy.spatial.transform import Rotation

        return Rotation.from_matrix(self.rotation).as_quat()

    @property
    def mean_speeds(self) -> tuple[float, float]:
        """Mean angular speed [rad/s], and mean speed of the sensor's origin [m/s]."""
        angular, linear = (
            np.linalg.norm(v, axis=1)
            for v in (self.angular_velocity, self.linear_velocity)
        )
        return float(angular.mean()), float(linear.mean())

    def linear_speed(self, point: ArrayLike = (0.0, 0.0, 0.0)) -> Array:
        """(K,) speed [m/s] of a point (3,) [m] fixed in the sensor frame."""
        offset = self.rotation @ np.asarray(point, dtype=float)
        return np.linalg.norm(
            self.linear_velocity + np.cross(self.angular_velocity, offset), axis=1
        )


def sensor_motion(robot: Robot, joints: JointMotion) -> SensorMotion:
    """Exact motion of the sensor frame, by forward recursion (Siciliano et al.,
    *Robotics*, sec. 7.5.2).

    `InputError` if the number of joints differs from the robot's.
    """
    require_its_joints(robot, joints)
    K = len(joints.time)
    rotation = np.broadcast_to(np.eye(3), (K, 3, 3))
    position, velocity, acceleration, w, dw = (np.zeros((K, 3)) for _ in range(5))
    at_rest = np.zeros(3)

    def carry(offset: Array) -> None:
        nonlocal position, velocity, acceleration
        position = position + offset
        velocity = velocity + np.cross(w, offset)
        acceleration = (
            acceleration + np.cross(dw, offset) + np.cross(w, np.cross(w, offset))
        )

    for screw in robot.screws:
        carry(rotation @ (screw.point - at_rest))
        at_rest = screw.point
        amount, rate, change = (
            screw.multiplier * values[:, screw.column, None]
            for values in (joints.position, joints.velocity, joints.acceleration)
        )
        amount = amount + screw.offset
        axis = rotation @ screw.axis
        if screw.slides:
            carry(axis * amount)
            velocity = velocity + axis * rate
            acceleration = acceleration + axis * change + 2.0 * np.cross(w, axis * rate)
        else:
            dw = dw + axis * change + np.cross(w, axis * rate)
            w = w + axis * rate
            rotation = rotation @ _turned(screw.axis, amount[:, 0])
    carry(rotation @ (robot.home_position - at_rest))
    rotation = rotation @ rotation_matrices(robot.home_orientation)
    return SensorMotion(joints.time, position, rotation, velocity, w, acceleration, dw)


def angular_velocity(robot: Robot, joints: JointMotion) -> Array:
    """(K, 3) angular velocity [rad/s] of `sensor_motion`, bit by bit, in a third of the
    time. `InputError` if the number of joints differs from the robot's.
    """
    require_its_joints(robot, joints)
    K = len(joints.time)
    rotation, w = np.broadcast_to(np.eye(3), (K, 3, 3)), np.zeros((K, 3))
    for screw in robot.screws:
        if screw.slides:
            continue
        amount, rate = (
            screw.multiplier * values[:, screw.column]
            for values in (joints.position, joints.velocity)
        )
        w = w + (rotation @ screw.axis) * rate[:, None]
        rotation = rotation @ _turned(screw.axis, amount + screw.offset)
    return w


def require_its_joints(robot: Robot, joints: JointMotion) -> None:
    """`InputError` if a motion has another number of joints than the robot."""
    count, needed = joints.position.shape[1], len(robot.joints)
    if count != needed:
        what = f"there are {count} joints, but the arm has {needed}"
        raise InputError(what, where="JointMotion")


def _turned(axis: Array, angle: Array) -> Array:
    """Rotations (K, 3, 3) about a unit vector (3,) by angles (K,) [rad]."""
    K = skew(axis)
    sin, cos = np.sin(angle)[:, None, None], np.cos(angle)[:, None, None]
    return np.eye(3) + sin * K + (1.0 - cos) * (K @ K)


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
