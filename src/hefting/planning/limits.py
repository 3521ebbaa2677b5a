"""Limits of a planned motion, and the shares of them that it uses."""

from collections.abc import Sequence
from dataclasses import fields
from pathlib import Path
from typing import NamedTuple, Self

import numpy as np
from numpy.typing import ArrayLike

from hefting.core.errors import InputError
from hefting.core.spatial import SPEED_LIMIT, Array, cross, freeze, frozen, immutable
from hefting.planning.information import expected_wrench
from hefting.planning.kinematics import TipMotion
from hefting.planning.space import HalfSpace
from hefting.robots.robot import Robot, resolved
from hefting.robots.urdf import Tree, read_urdf

ACCELERATION = 5.0
"""[rad/s²] Default limit of a joint, which no URDF gives. Cobots reach twice as much at
their slowest joints."""
JERK = 100.0
"""[rad/s³] Default limit of a joint: full acceleration within a twentieth of a second."""
NUMBERS = ("corner_speed", "force", "torque")
"""Limits that are not for each joint."""


@immutable
class Limits:
    """Hard limits of a motion of n joints; `InputError` for values that are no limits."""

    position: Array
    """(n, 2) lowest and highest position of each joint [rad]; infinite of a continuous
    joint"""
    speed: Array
    """(n,) [rad/s]"""
    acceleration: Array
    """(n,) [rad/s²]"""
    jerk: Array
    """(n,) [rad/s³]"""
    corner_speed: float = SPEED_LIMIT
    """of every corner of the object's box and of the sensor frame's origin [m/s]"""
    force: float | None = None
    """largest force [N] that the sensor shows, along each axis; None: no limit"""
    torque: float | None = None
    """the same of the torque [N m]"""

    def __post_init__(self):
        freeze(self, "position", "speed", "acceleration", "jerk")
        n = len(self.position)
        if self.position.shape != (n, 2) or np.isnan(self.position).any():
            raise InputError("position is not a low and a high end (n, 2)", "Limits")
        if (self.position[:, 0] >= self.position[:, 1]).any():
            what = "a joint's lowest position is not below its highest"
            raise InputError(what, "Limits")
        for field in fields(self)[1:]:
            value = getattr(self, field.name)
            shape = () if field.name in NUMBERS else (n,)
            if value is None and field.default is None:
                continue
            own = np.asarray(value, dtype=float)
            if own.shape != shape or not (own > 0.0).all():
                of = f", or {n} of them, one for each joint" if shape else ""
                what = f"is not a positive number{of}"
                raise InputError(what, f"`{field.name}`")

    @classmethod
    def from_urdf(
        cls,
        path: str | Path,
        robot: Robot,
        acceleration: ArrayLike | None = None,
        jerk: ArrayLike | None = None,
        corner_speed: float = SPEED_LIMIT,
        force: float | None = None,
        torque: float | None = None,
    ) -> Self:
        """Limits with positions and speeds of a URDF's `<limit>` elements, for the joints
        of `robot` and the joints that mimic them.

        Parameters
        ----------
        path : the URDF that `robot` was made from.
        acceleration, jerk : of all joints, or (n,) of each [rad/s²], [rad/s³]; by
            default `ACCELERATION` and `JERK`.
        corner_speed, force, torque : as in `Limits`.

        Raises `InputError` for a joint without limits, for a prismatic joint, and if the
        limits of a joint and of one that mimics it exclude each other.
        """
        tree = read_urdf(path)
        for joint in tree.chain(robot.sensor_frame):
            if joint.kind == "prismatic":
                what = "it slides, and plans are of joints that turn"
                fix = "make it fixed, where it will stand, in a copy of the URDF"
                raise InputError(what, f"{path}, joint '{joint.name}'", fix)
        positions, speeds = [], []
        for name in robot.joints:
            joint, where = tree.joints[name], f"{path}, joint '{name}'"
            if joint.kind == "revolute" and joint.limits is None:
                fix = (
                    'give <limit lower="..." upper="..." velocity="..."/> [rad, rad/s], '
                    "or make it fixed where it stands"
                )
                raise InputError("it has no lower and upper limit", where, fix)
            if joint.speed is None:
                fix = 'give <limit velocity="..."/> [rad/s]'
                raise InputError("it has no limit of its speed", where, fix)
            positions.append(joint.limits or (-np.inf, np.inf))
            speeds.append(joint.speed)
        n = len(positions)
        if not n:
            raise InputError(f"no joint moves '{robot.sensor_frame}'", path)
        _keep_mimics(tree, robot, positions, speeds)
        return cls(
            np.array(positions),
            np.array(speeds),
            _of_each(ACCELERATION if acceleration is None else acceleration, n),
            _of_each(JERK if jerk is None else jerk, n),
            corner_speed,
            force,
            torque,
        )


def _keep_mimics(
    tree: Tree, robot: Robot, positions: list[tuple[float, float]], speeds: list[float]
) -> None:
    """Narrow the limits of the robot's joints, in place, to those of their mimics."""
    for joint in tree.joints.values():
        if joint.mimic is None:
            continue
        name, factor, offset = resolved(joint, tree)
        if name not in robot.joints or factor == 0.0:
            continue
        i = robot.joints.index(name)
        if joint.limits is not None:
            low, high = sorted((end - offset) / factor for end in joint.limits)
            positions[i] = max(low, positions[i][0]), min(high, positions[i][1])
            if positions[i][0] >= positions[i][1]:
                what = f"its limits leave no room to '{name}', which it mimics"
                raise InputError(what, f"{tree.source}, joint '{joint.name}'")
        if joint.speed is not None:
            speeds[i] = min(speeds[i], joint.speed / abs(factor))


def _of_each(values: ArrayLike, n: int) -> Array:
    array = np.asarray(values, dtype=float)
    return np.full(n, float(array)) if array.ndim == 0 else array


CLEARANCE = 0.005
"""[m] Least distance from walls, and between links and object: a corner at 0.25 m/s moves
so far in a fiftieth of a second."""
CLEARANCE_SCALE = 0.1
"""[m] Penetration that counts as much as exceeding a limit by its own size."""


class JointStates(NamedTuple):
    """Joint motion on a grid; each (K, n)."""

    position: Array
    speed: Array
    acceleration: Array
    jerk: Array


@immutable
class Constraints:
    """Shares of limits that a motion uses, and their derivatives."""

    limits: Limits
    corners: Array
    """(c, 3) [m] in the sensor frame"""
    body: Array
    """(10,) parameters of the body that causes the expected wrench"""
    normals: Array
    """(p, 3) of half-spaces, in root axes"""
    offsets: Array
    """(p,) [m] of half-spaces, with `CLEARANCE` added"""

    @classmethod
    def of(
        cls,
        limits: Limits,
        corners: Array,
        body: Array,
        half_spaces: Sequence[HalfSpace] = (),
    ) -> Self:
        """Constraints with half-spaces that the corners must stay in."""
        normals = np.array([each.normal for each in half_spaces]).reshape(-1, 3)
        offsets = CLEARANCE + np.array([each.offset for each in half_spaces])
        return cls(
            limits, frozen(corners), frozen(body), frozen(normals), frozen(offsets)
        )

    @property
    def joint_scales(self) -> tuple[tuple[Array, Array], ...]:
        """Middles and half-widths (n,) of the ranges of position, speed, acceleration and
        jerk; infinite without limits."""
        limits = self.limits
        bounded = np.isfinite(limits.position).all(axis=1)
        low, high = np.where(bounded, limits.position.T, 0.0)
        middle = (low + high) / 2.0
        half = np.where(bounded, (high - low) / 2.0, np.inf)
        zero = np.zeros(len(half))
        rates = limits.speed, limits.acceleration, limits.jerk
        return (middle, half), *((zero, rate) for rate in rates)

    @property
    def _corner_columns(self) -> Array:
        """(3, c, 1) corners [m]"""
        return self.corners.T[:, :, None]

    def joint_shares(self, states: JointStates) -> list[Array]:
        """Signed shares (K, n) of limits of position, speed, acceleration and jerk."""
        pairs = zip(states, self.joint_scales, strict=True)
        return [(x - middle) / half for x, (middle, half) in pairs]

    def corner_velocities(self, tip: TipMotion) -> Array:
        """(c, 3, K) velocities of the corners in sensor axes [m/s]."""
        turning = cross(tip.angular_velocity[:, None], self._corner_columns)
        return tip.velocity + turning.swapaxes(0, 1)

    def corner_slopes(self, by: Array) -> tuple[Array, Array]:
        """Derivatives (3, K) of a function by velocity and angular velocity of the tip,
        from those `by` the velocities of the corners (c, 3, K)."""
        moments = cross(self._corner_columns, by.swapaxes(0, 1))
        return by.sum(axis=0), moments.sum(axis=1)

    def corner_shares(self, velocities: Array) -> Array:
        """(c, K) speeds of the corners over the limit."""
        return np.sqrt((velocities**2).sum(axis=1)) / self.limits.corner_speed

    def wrench_shares(self, x: Array) -> Array:
        """(6, K) expected wrench over the sensor's range, for features (12, K)."""
        return expected_wrench(x, self.body) / self.wrench_range[:, None]

    @property
    def wrench_range(self) -> Array:
        """(6,) range of the sensor [N, N m], infinite without limits."""
        limits = self.limits
        return np.repeat([limits.force or np.inf, limits.torque or np.inf], 3)

    @property
    def has_wrench_range(self) -> bool:
        """Whether the sensor has a range."""
        return bool(np.isfinite(self.wrench_range).any())

    def clearances(self, tip: TipMotion) -> Array:
        """(p, c, K) distances [m] of corners into half-spaces, less `CLEARANCE`."""
        normals = np.einsum("pj,jik->pik", self.normals, tip.rotation)
        along = np.einsum("pik,ci->pck", normals, self.corners)
        return (
            along + (self.normals @ tip.position)[:, None] - self.offsets[:, None, None]
        )

    def clearance_slopes(self, tip: TipMotion, by: Array) -> tuple[Array, Array]:
        """Derivatives (3, K) of a function by translation and rotation of the tip, from
        those `by` the clearances (p, c, K)."""
        normals = np.einsum("pj,jik->pik", self.normals, tip.rotation)
        push = np.einsum("pck,pik->cik", by, normals)
        return self.corner_slopes(push)
