"""A serial arm: from the joints' motion to the exact motion of the sensor frame at its
end."""

from dataclasses import dataclass, fields
from pathlib import Path
from typing import Self

import numpy as np
from numpy.typing import ArrayLike

from hefting.core.errors import InputError
from hefting.core.spatial import Array, frozen, rotation_matrices, skew
from hefting.robots import Robot
from hefting.robots.robot import Screw

SLACK = 1e-6
"""Excess over a joint's limit that is rounding [rad] or [rad/s]."""


@dataclass(frozen=True, eq=False)
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
        for field in fields(self):
            object.__setattr__(self, field.name, frozen(getattr(self, field.name)))
        shape = self.position.shape
        if (
            self.time.shape != shape[:1]
            or len(shape) != 2
            or {self.velocity.shape, self.acceleration.shape} != {shape}
        ):
            raise InputError(
                "time (K,), position, velocity and acceleration (K, n) do not agree",
                where="JointMotion",
            )


@dataclass(frozen=True, eq=False)
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
        for field in fields(self):
            object.__setattr__(self, field.name, frozen(getattr(self, field.name)))

    @property
    def orientation(self) -> Array:
        """(K, 4) unit quaternions x, y, z, w, sensor in world."""
        from scipy.spatial.transform import Rotation

        return Rotation.from_matrix(self.rotation).as_quat()

    @property
    def mean_speeds(self) -> tuple[float, float]:
        """Means over the samples of the angular speed [rad/s] and of the sensor
        origin's speed [m/s]."""
        angular, linear = (
            np.linalg.norm(v, axis=1)
            for v in (self.angular_velocity, self.linear_velocity)
        )
        return float(angular.mean()), float(linear.mean())

    def linear_speed(self, point: ArrayLike = (0.0, 0.0, 0.0)) -> Array:
        """(K,) speed [m/s] of a point (3,) [m] fixed in the sensor frame."""
        offset = self.rotation @ np.asarray(point, dtype=float)
        return np.linalg.norm(
            self.linear_velocity + _cross(self.angular_velocity, offset), axis=1
        )


@dataclass(frozen=True, eq=False)
class Arm:
    """A robot with a force-torque sensor at its end: any chain of joints that turn or
    slide.

    The base is the world frame. Joint i turns (or slides) about its screw axis at rest,
    moved by those before it.
    """

    robot: Robot
    """Joints, their screws at rest, their limits, and the pose of the sensor frame."""
    start: Array
    """(n,) joint positions that motions start from [rad] or [m]"""
    joint_speeds: Array | None = None
    """(n,) highest joint speeds [rad/s]; None where not known"""

    def __post_init__(self):
        object.__setattr__(self, "start", frozen(self.start))
        if self.joint_speeds is not None:
            object.__setattr__(self, "joint_speeds", frozen(self.joint_speeds))
        if self.start.shape != (self.n,):
            raise InputError(
                f"{len(self.start)} joint positions to start from, but {self.n} joints",
                self.robot.source,
            )

    @classmethod
    def from_dh(
        cls,
        name: str,
        a: ArrayLike,
        alpha: ArrayLike,
        d: ArrayLike,
        start: ArrayLike,
        limits: ArrayLike,
        joint_speeds: ArrayLike | None = None,
    ) -> Self:
        """Revolute joints in standard Denavit-Hartenberg form: link i is Rz(q_i)
        Tz(d_i) Tx(a_i) Rx(alpha_i).

        `a`, `d` [m], `alpha` [rad] and `start` [rad] are (n,), `limits` [rad] (n, 2);
        the sensor frame is the last link's.
        """
        from scipy.spatial.transform import Rotation

        position, rotation, screws = np.zeros(3), np.eye(3), []
        for i, (length, twist, offset) in enumerate(
            zip(*map(np.asarray, (a, alpha, d)), strict=True)
        ):
            screws.append(
                Screw(False, frozen(rotation[:, 2]), frozen(position), i, 1.0, 0.0)
            )
            position = position + rotation @ (length, 0.0, offset)
            rotation = rotation @ Rotation.from_rotvec((twist, 0.0, 0.0)).as_matrix()
        joints = tuple(f"joint{i + 1}" for i in range(len(screws)))
        pairs = tuple((float(low), float(high)) for low, high in np.asarray(limits))
        home = frozen(Rotation.from_matrix(rotation).as_quat())
        robot = Robot(
            name,
            "base",
            "flange",
            joints,
            joints,
            pairs,
            tuple(screws),
            frozen(position),
            home,
        )
        return cls(
            robot, frozen(start), None if joint_speeds is None else frozen(joint_speeds)
        )

    @classmethod
    def from_urdf(
        cls, path: str | Path, sensor_frame: str, start: ArrayLike | None = None
    ) -> Self:
        """The arm of a URDF whose link `sensor_frame` carries the sensor; see
        `Robot.from_urdf` for errors.

        It starts from `start` (n,), by default from the middle of each joint's range,
        from zero where there is none.
        """
        robot = Robot.from_urdf(path, sensor_frame)
        if not robot.joints:
            raise InputError(
                f"no joint moves '{sensor_frame}'", path, "choose a link further out"
            )
        return cls(
            robot,
            frozen(
                [_middle(pair) for pair in robot.limits] if start is None else start
            ),
        )

    @property
    def n(self) -> int:
        """Number of joints."""
        return len(self.robot.joints)

    @property
    def room(self) -> Array:
        """(n,) angle each joint can turn from `start` before a limit [rad]; zero for
        joints that slide."""
        return np.array(
            [
                0.0 if pair is None else max(min(at - pair[0], pair[1] - at), 0.0)
                for at, pair in zip(self.start, self.robot.limits, strict=True)
            ]
        )

    def exceeded(self, joints: JointMotion) -> tuple[str, ...]:
        """What the joints of the real arm could not do, one line each."""
        lines = []
        for i, (name, pair) in enumerate(
            zip(self.robot.joints, self.robot.limits, strict=True)
        ):
            low, high = joints.position[:, i].min(), joints.position[:, i].max()
            fastest = np.abs(joints.velocity[:, i]).max()
            if pair is not None and (low < pair[0] - SLACK or high > pair[1] + SLACK):
                reach = f"{low:.2f} to {high:.2f} rad, outside its {pair[0]:.2f} to {pair[1]:.2f} rad"
                lines.append(f"{name} turns from {reach}")
            if self.joint_speeds is not None and fastest > self.joint_speeds[i] + SLACK:
                lines.append(
                    f"{name} turns at up to {fastest:.2f} rad/s, above its {self.joint_speeds[i]:.2f} rad/s"
                )
        return tuple(lines)

    def motion(self, joints: JointMotion) -> SensorMotion:
        """Exact motion of the sensor frame, by forward recursion (Siciliano et al.,
        *Robotics*, sec. 7.5.2).

        `InputError` when the number of joints differs from the arm's.
        """
        self._require_its_joints(joints)
        K = len(joints.time)
        rotation = np.broadcast_to(np.eye(3), (K, 3, 3))
        position, velocity, acceleration, w, dw = (np.zeros((K, 3)) for _ in range(5))
        at_rest = np.zeros(3)

        def carry(offset: Array) -> None:
            nonlocal position, velocity, acceleration
            position = position + offset
            velocity = velocity + _cross(w, offset)
            acceleration = (
                acceleration + _cross(dw, offset) + _cross(w, _cross(w, offset))
            )

        for screw in self.robot.screws:
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
                acceleration = (
                    acceleration + axis * change + 2.0 * _cross(w, axis * rate)
                )
            else:
                dw = dw + axis * change + _cross(w, axis * rate)
                w = w + axis * rate
                rotation = rotation @ _turned(screw.axis, amount[:, 0])
        carry(rotation @ (self.robot.home_position - at_rest))
        rotation = rotation @ rotation_matrices(self.robot.home_orientation)
        return SensorMotion(
            joints.time, position, rotation, velocity, w, acceleration, dw
        )

    def angular_velocity(self, joints: JointMotion) -> Array:
        """(K, 3) that of `motion` alone [rad/s], to the last bit, in a third of the
        time.

        `InputError` when the number of joints differs from the arm's.
        """
        self._require_its_joints(joints)
        K = len(joints.time)
        rotation, w = np.broadcast_to(np.eye(3), (K, 3, 3)), np.zeros((K, 3))
        for screw in self.robot.screws:
            if screw.slides:
                continue
            amount, rate = (
                screw.multiplier * values[:, screw.column]
                for values in (joints.position, joints.velocity)
            )
            w = w + (rotation @ screw.axis) * rate[:, None]
            rotation = rotation @ _turned(screw.axis, amount + screw.offset)
        return w

    def _require_its_joints(self, joints: JointMotion) -> None:
        if joints.position.shape[1] != self.n:
            what = (
                f"there are {joints.position.shape[1]} joints, but the arm has {self.n}"
            )
            raise InputError(what, where="JointMotion")


def _cross(u: Array, v: Array) -> Array:
    return np.einsum("kij,kj->ki", skew(u), v)


def _turned(axis: Array, angle: Array) -> Array:
    """Rotations (K, 3, 3) about a unit vector (3,) by angles (K,) [rad]."""
    K = skew(axis)
    sin, cos = np.sin(angle)[:, None, None], np.cos(angle)[:, None, None]
    return np.eye(3) + sin * K + (1.0 - cos) * (K @ K)


def _middle(pair: tuple[float, float] | None) -> float:
    return (
        0.5 * (pair[0] + pair[1])
        if pair is not None and np.isfinite(pair).all()
        else 0.0
    )


UR5 = Arm.from_dh(
    "UR5",
    a=(0.0, -0.425, -0.39225, 0.0, 0.0, 0.0),
    alpha=(np.pi / 2, 0.0, 0.0, np.pi / 2, -np.pi / 2, 0.0),
    d=(0.089159, 0.0, 0.0, 0.10915, 0.09465, 0.0823),
    start=np.radians((0.0, -90.0, 60.0, -90.0, -90.0, 0.0)),
    limits=[(-2.0 * np.pi, 2.0 * np.pi)] * 6,
    joint_speeds=[np.pi] * 6,
)
"""Universal Robots UR5 with the sensor frame at its flange; the maker's nominal values
("DH parameters for calculations of kinematics and dynamics", Universal Robots support;
limits from the user manual). It starts as in the paper's simulations."""

XARM7 = Arm.from_dh(
    "xArm 7",
    a=(0.0, 0.0, 0.0525, 0.0775, 0.0, 0.076, 0.0),
    alpha=(-np.pi / 2, np.pi / 2, np.pi / 2, np.pi / 2, np.pi / 2, -np.pi / 2, 0.0),
    d=(0.267, 0.0, 0.293, 0.0, 0.3425, 0.0, 0.097),
    start=np.radians((0.0, -15.0, 0.0, 60.0, 0.0, 105.0, 0.0)),
    limits=(
        (-2.0 * np.pi, 2.0 * np.pi),
        (-2.059, 2.0944),
        (-2.0 * np.pi, 2.0 * np.pi),
        (-0.19198, 3.927),
        (-2.0 * np.pi, 2.0 * np.pi),
        (-1.69297, np.pi),
        (-2.0 * np.pi, 2.0 * np.pi),
    ),
    joint_speeds=[np.pi] * 7,
)
"""uFactory xArm 7 with the sensor frame at its flange; offsets, limits and speeds as in
the maker's URDF (xArm-Developer/xarm_ros, xarm_description)."""
