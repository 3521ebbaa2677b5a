"""Limits that a planned motion keeps, and how far it is from them, as shares."""

from collections.abc import Sequence
from dataclasses import fields
from pathlib import Path
from typing import NamedTuple, Self

import numpy as np
from numpy.typing import ArrayLike

from hefting.core.errors import InputError
from hefting.core.immutable import immutable
from hefting.core.spatial import SPEED_LIMIT, Array, cross, freeze, frozen
from hefting.planning.information import expected_wrench
from hefting.planning.kinematics import TipMotion
from hefting.planning.space import HalfSpace
from hefting.robots.robot import Robot, resolved
from hefting.robots.urdf import Tree, read_urdf

ACCELERATION = 5.0
"""[rad/s²] of a joint, where nothing is said: no URDF has it. Cobots reach twice as
much at their slowest joints."""
JERK = 100.0
"""[rad/s³] of a joint, where nothing is said: a twentieth of a second to full
acceleration."""
NUMBERS = ("corner_speed", "force", "torque")


@immutable
class Limits:
    """Hard limits of a motion of n joints. `InputError` for values that are none."""

    position: Array
    """(n, 2) lowest and highest position of each joint [rad]; infinite of a joint that
    turns without end"""
    speed: Array
    """(n,) [rad/s]"""
    acceleration: Array
    """(n,) [rad/s²]"""
    jerk: Array
    """(n,) [rad/s³]"""
    corner_speed: float = SPEED_LIMIT
    """of every corner of the object's box and of the origin of the sensor frame
    [m/s]"""
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
        """Positions and speeds of a URDF's `<limit>` elements, for the joints of
        `robot`, which keep those of the joints that mimic them as well.

        Parameters
        ----------
        path : the URDF that `robot` was made from.
        acceleration, jerk : of all joints, or (n,) of each [rad/s²], [rad/s³]; by
            default `ACCELERATION` and `JERK`, as no URDF has them.
        corner_speed, force, torque : as in `Limits`.

        Raises `InputError` for a joint without limits, naming it, for a joint that
        slides, and for limits of a joint and one that mimics it that exclude each other.
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
                    'give <limit lower="..." upper="..." velocity="..."/> [rad, rad/s]'
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
    """Narrow the limits of the robot's joints to what those that mimic them keep."""
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
"""[m] from walls, and of the links and the object from each other: what a corner moves
at 0.25 m/s in a fiftieth of a second."""
CLEARANCE_SCALE = 0.1
"""[m] into a wall that counts as much as going a whole limit beyond it."""


class JointStates(NamedTuple):
    """Joint motion on a grid; each (K, n)."""

    position: Array
    speed: Array
    acceleration: Array
    jerk: Array


@immutable
class Constraints:
    """Limits as numbers that are at most zero where they are kept: a share of the limit
    less one."""

    limits: Limits
    corners: Array
    """(c, 3) [m] in the sensor frame"""
    body: Array
    """(10,) parameters of the body whose wrench is expected"""
    normals: Array
    """(p, 3) of half-spaces, in root axes"""
    offsets: Array
    """(p,) [m] with the margin"""

    @classmethod
    def of(
        cls,
        limits: Limits,
        corners: Array,
        body: Array,
        half_spaces: Sequence[HalfSpace] = (),
    ) -> Self:
        """With the half-spaces that the corners keep to."""
        normals = np.array([each.normal for each in half_spaces]).reshape(-1, 3)
        offsets = CLEARANCE + np.array([each.offset for each in half_spaces])
        return cls(
            limits, frozen(corners), frozen(body), frozen(normals), frozen(offsets)
        )

    @property
    def joint_scales(self) -> tuple[tuple[Array, Array], ...]:
        """Middle and half-width of what each of position, speed, acceleration and jerk
        may be, (n,) each; infinite where nothing binds."""
        own = self.limits
        bounded = np.isfinite(own.position).all(axis=1)
        low, high = np.where(bounded, own.position.T, 0.0)
        middle = (low + high) / 2.0
        half = np.where(bounded, (high - low) / 2.0, np.inf)
        zero = np.zeros(len(half))
        others = ((zero, each) for each in (own.speed, own.acceleration, own.jerk))
        return (middle, half), *others

    @property
    def _ways(self) -> Array:
        """(3, c, 1) [m] to the corners"""
        return self.corners.T[:, :, None]

    def joint_shares(self, states: JointStates) -> list[Array]:
        """Signed shares (K, n) of the limits of each of position, speed, acceleration
        and jerk."""
        pairs = zip(states, self.joint_scales, strict=True)
        return [(x - middle) / half for x, (middle, half) in pairs]

    def corner_velocities(self, tip: TipMotion) -> Array:
        """(c, 3, K) in sensor axes [m/s]"""
        turning = cross(tip.angular_velocity[:, None], self._ways)
        return tip.velocity + turning.swapaxes(0, 1)

    def corner_slopes(self, by: Array) -> tuple[Array, Array]:
        """Derivatives (3, K) by velocity and angular velocity of what has those `by`
        (c, 3, K) by the velocities of the corners."""
        return by.sum(axis=0), cross(self._ways, by.swapaxes(0, 1)).sum(axis=1)

    def corner_shares(self, velocities: Array) -> Array:
        """(c, K) speeds of the corners over the limit."""
        return np.sqrt((velocities**2).sum(axis=1)) / self.limits.corner_speed

    def wrench_shares(self, x: Array) -> Array:
        """(6, K) signed shares of the sensor's range that the body is expected to use,
        for features (12, K)."""
        return expected_wrench(x, self.body) / self.wrench_range[:, None]

    @property
    def wrench_range(self) -> Array:
        """(6,) infinite where there is none"""
        own = self.limits
        return np.repeat([own.force or np.inf, own.torque or np.inf], 3)

    @property
    def has_wrench_range(self) -> bool:
        """Whether the sensor has a range."""
        return bool(np.isfinite(self.wrench_range).any())

    def clearances(self, tip: TipMotion) -> Array:
        """(p, c, K) [m] of the corners from the half-spaces, beyond the margin."""
        normals = np.einsum("pj,jik->pik", self.normals, tip.rotation)
        along = np.einsum("pik,ci->pck", normals, self.corners)
        return (
            along + (self.normals @ tip.position)[:, None] - self.offsets[:, None, None]
        )

    def clearance_slopes(self, tip: TipMotion, by: Array) -> tuple[Array, Array]:
        """Derivatives (3, K) by shifts and turns of the tip of what has those `by` (p,
        c, K) by the clearances."""
        normals = np.einsum("pj,jik->pik", self.normals, tip.rotation)
        push = np.einsum("pck,pik->cik", by, normals)
        return self.corner_slopes(push)
