"""Limits that a planned motion keeps at every instant."""

from dataclasses import dataclass, fields
from pathlib import Path
from typing import Self

import numpy as np
from numpy.typing import ArrayLike

from hefting.core.errors import InputError
from hefting.core.spatial import SPEED_LIMIT, Array, frozen
from hefting.robots.robot import Robot
from hefting.robots.urdf import read_urdf

ACCELERATION = 5.0
"""[rad/s²] of a joint, where nothing is said: no URDF has it. Cobots reach twice as
much at their slowest joints."""
JERK = 100.0
"""[rad/s³] of a joint, where nothing is said: a twentieth of a second to full
acceleration."""
NUMBERS = ("corner_speed", "force", "torque")


@dataclass(frozen=True, eq=False)
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
        for name in ("position", "speed", "acceleration", "jerk"):
            object.__setattr__(self, name, frozen(getattr(self, name)))
        n = len(self.position)
        if self.position.shape != (n, 2) or np.isnan(self.position).any():
            raise InputError("position is not a low and a high end (n, 2)", "Limits")
        if (self.position[:, 0] >= self.position[:, 1]).any():
            raise InputError(
                "a joint's lowest position is not below its highest", "Limits"
            )
        for field in fields(self)[1:]:
            value = getattr(self, field.name)
            shape = () if field.name in NUMBERS else (n,)
            if value is None and field.default is None:
                continue
            own = np.asarray(value, dtype=float)
            if own.shape != shape or not (own > 0.0).all():
                what = "a positive number" + (
                    f" of each of {n} joints" if shape else ""
                )
                raise InputError(f"{field.name} is not {what}", "Limits")

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
        `robot`.

        Parameters
        ----------
        path : the URDF that `robot` was made from.
        acceleration, jerk : of all joints, or (n,) of each [rad/s²], [rad/s³]; by
            default `ACCELERATION` and `JERK`, as no URDF has them.
        corner_speed, force, torque : as in `Limits`.

        Raises `InputError` for a joint without limits, naming it, for a joint that
        slides, and for one that others mimic.
        """
        tree = read_urdf(path)
        positions, speeds = [], []
        for name in robot.joints:
            joint, where = tree.joints[name], f"{path}, joint '{name}'"
            if joint.kind == "prismatic":
                fix = "choose a tip that only turning joints move"
                raise InputError(
                    "it slides, and plans are of joints that turn", where, fix
                )
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
        return cls(
            np.array(positions),
            np.array(speeds),
            _of_each(ACCELERATION if acceleration is None else acceleration, n),
            _of_each(JERK if jerk is None else jerk, n),
            corner_speed,
            force,
            torque,
        )


def _of_each(values: ArrayLike, n: int) -> Array:
    array = np.asarray(values, dtype=float)
    return np.full(n, float(array)) if array.ndim == 0 else array
