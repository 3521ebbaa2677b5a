"""Serial arms: exact motion of the sensor frame at the end from that of the joints."""

from pathlib import Path
from typing import Self

import numpy as np
from numpy.typing import ArrayLike

from hefting.core.errors import InputError
from hefting.core.spatial import Array, freeze, frozen, immutable
from hefting.robots import Robot
from hefting.robots.joint_motion import (
    JointMotion,
    SensorMotion,
    angular_velocity,
    sensor_motion,
)
from hefting.robots.robot import Screw

SLACK = 1e-6
"""Excess over a joint's limit that is ignored as rounding [rad] or [rad/s]."""


@immutable
class Arm:
    """A robot with a force-torque sensor at its end: a chain of revolute and prismatic
    joints. The base is the world frame."""

    robot: Robot
    """kinematics and limits"""
    start: Array
    """(n,) joint positions that motions start from [rad] or [m]"""
    joint_speeds: Array | None = None
    """(n,) highest joint speeds [rad/s], if known"""

    def __post_init__(self):
        freeze(self, "start", "joint_speeds")
        if self.start.shape != (self.n,):
            what = (
                f"{len(self.start)} joint positions to start from, but {self.n} joints"
            )
            raise InputError(what, self.robot.source)

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
        """Arm of revolute joints in standard Denavit-Hartenberg form: link i is Rz(q_i)
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
        home = frozen(position), frozen(Rotation.from_matrix(rotation).as_quat())
        frames = name, "base", "flange"
        robot = Robot(*frames, joints, joints, pairs, tuple(screws), *home)
        speeds = None if joint_speeds is None else frozen(joint_speeds)
        return cls(robot, frozen(start), speeds)

    @classmethod
    def from_urdf(
        cls, path: str | Path, sensor_frame: str, start: ArrayLike | None = None
    ) -> Self:
        """The arm of a URDF whose link `sensor_frame` carries the sensor; see
        `Robot.from_urdf` for errors.

        `start` (n,) is by default the middle of each joint's range, or zero without
        limits.
        """
        robot = Robot.from_urdf(path, sensor_frame)
        if not robot.joints:
            raise InputError(
                f"no joint moves '{sensor_frame}'", path, "choose a link further out"
            )
        middle = [_middle(pair) for pair in robot.limits]
        return cls(robot, frozen(middle if start is None else start))

    @property
    def n(self) -> int:
        """Number of joints."""
        return len(self.robot.joints)

    @property
    def room(self) -> Array:
        """(n,) angle from `start` to the nearest limit of each joint [rad]; zero for
        prismatic joints."""
        return np.array(
            [
                0.0 if pair is None else max(min(at - pair[0], pair[1] - at), 0.0)
                for at, pair in zip(self.start, self.robot.limits, strict=True)
            ]
        )

    def exceeded(self, joints: JointMotion) -> tuple[str, ...]:
        """A line for each limit of the real arm that a motion exceeds."""
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
        """Exact motion of the sensor frame; see `sensor_motion`."""
        return sensor_motion(self.robot, joints)

    def angular_velocity(self, joints: JointMotion) -> Array:
        """(K, 3) angular velocity of the sensor frame [rad/s]."""
        return angular_velocity(self.robot, joints)


def _middle(pair: tuple[float, float] | None) -> float:
    ends = (0.0, 0.0) if pair is None else pair
    return 0.5 * sum(ends) if np.isfinite(ends).all() else 0.0


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
limits from the user manual); start as in the paper's simulations."""

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

UR5E = Arm.from_dh(
    "UR5e",
    a=(0.0, -0.425, -0.3922, 0.0, 0.0, 0.0),
    alpha=(np.pi / 2, 0.0, 0.0, np.pi / 2, -np.pi / 2, 0.0),
    d=(0.1625, 0.0, 0.0, 0.1333, 0.0997, 0.0996),
    start=UR5.start,
    limits=[(-2.0 * np.pi, 2.0 * np.pi)] * 6,
    joint_speeds=[np.pi] * 6,
)
"""Universal Robots UR5e; the maker's nominal values ("DH parameters for calculations of
kinematics and dynamics", Universal Robots support)."""

PANDA = Arm.from_dh(
    "Panda",
    a=(0.0, 0.0, 0.0825, -0.0825, 0.0, 0.088, 0.0),
    alpha=np.radians((-90.0, 90.0, 90.0, -90.0, 90.0, 90.0, 0.0)),
    d=(0.333, 0.0, 0.316, 0.0, 0.384, 0.0, 0.107),
    start=np.radians((0.0, -30.0, 0.0, -120.0, 0.0, 110.0, 45.0)),
    limits=(
        (-2.8973, 2.8973),
        (-1.7628, 1.7628),
        (-2.8973, 2.8973),
        (-3.0718, -0.0698),
        (-2.8973, 2.8973),
        (-0.0175, 3.7525),
        (-2.8973, 2.8973),
    ),
    joint_speeds=(2.175, 2.175, 2.175, 2.175, 2.61, 2.61, 2.61),
)
"""Franka Emika Panda; Denavit-Hartenberg parameters and limits as in the maker's
control interface documentation, in standard form."""
