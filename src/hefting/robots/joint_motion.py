"""Motion of a robot's joints, and the exact motion of its sensor frame by it."""

from dataclasses import fields

import numpy as np
from numpy.typing import ArrayLike

from hefting.core.errors import InputError
from hefting.core.immutable import immutable
from hefting.core.spatial import Array, freeze, rotation_matrices, skew
from hefting.robots.robot import Robot


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
