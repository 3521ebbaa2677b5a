"""Forward kinematics of a robot: joint positions to poses of the sensor frame, for all
samples at once."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Self

import numpy as np
from numpy.typing import ArrayLike

from hefting.core.errors import InputError, nearest
from hefting.core.spatial import Array, cross, frozen, immutable, rotation_matrices
from hefting.robots.urdf import SCALAR, Joint, Tree, listed, read_urdf

CHUNK = 8_192
"""Number of samples at a time, so that the arrays of a joint fit into the cache."""


@immutable
class Screw:
    """A movable joint between root and sensor frame, in root axes at zero screws."""

    slides: bool
    """whether it is prismatic"""
    axis: Array
    """(3,) unit vector"""
    point: Array
    """(3,) on the axis [m]"""
    column: int
    """index of the joint in the robot's `joints` that moves it"""
    multiplier: float
    offset: float
    """of its position, multiplier * q[column] + offset [rad] or [m]"""


@dataclass(frozen=True, eq=False)
class Robot:
    """The joints of a robot that move its sensor frame.

    The pose of the sensor frame in the root frame is a product of exponentials (Lynch
    and Park, *Modern Robotics*, sec. 4.1.2), exp([S_1] q_1) ... exp([S_n] q_n) M; fixed
    joints are in the screws S_i and in M. The root frame, of the URDF's root link, is
    the world frame of these poses and of gravity.

    Examples
    --------
    >>> robot = hefting.Robot.from_urdf("arm.urdf", sensor_frame="tool")
    >>> robot.joints
    ('turn',)
    """

    source: str
    """Path of the URDF, for messages."""
    root: str
    """Root link."""
    sensor_frame: str
    """Link whose frame is the sensor's."""
    joints: tuple[str, ...]
    """n joints that move the frame, from root to sensor; for a mimic joint the one that
    it mimics."""
    all_joints: tuple[str, ...]
    """All movable joints of the robot that mimic no other, in the file's order."""
    limits: tuple[tuple[float, float] | None, ...]
    """Lowest and highest angle of each of `joints` [rad], infinite without limits in the
    URDF; None for a prismatic joint."""
    screws: tuple[Screw, ...]
    """From root to sensor frame."""
    home_position: Array
    """(3,) of the sensor frame in the root frame when all screws are at zero [m]"""
    home_orientation: Array
    """(4,) unit quaternion x, y, z, w"""

    @classmethod
    def from_urdf(cls, path: str | Path, sensor_frame: str) -> Self:
        """The robot of a URDF file; `sensor_frame` is the name of one of its links.

        Raises `InputError` as `hefting.robots.urdf.read_urdf`, for an unknown link, and
        for a joint between root and link that is floating or planar, or mimics one that
        is missing, floating, planar or itself.
        """
        return cls.from_tree(read_urdf(path), sensor_frame)

    @classmethod
    def from_tree(cls, tree: Tree, sensor_frame: str) -> Self:
        """As `from_urdf`, by a kinematic tree that was read."""
        path = tree.source
        if sensor_frame not in tree.links:
            joint = tree.joints.get(sensor_frame)
            hint = (
                f" (a joint is; its link is '{joint.child}')"
                if joint
                else nearest(sensor_frame, tree.links)
            )
            what = f"no frame is named '{sensor_frame}'{hint}"
            raise InputError(
                what, where=path, fix=f"choose one of: {listed(tree.links)}"
            )
        columns: dict[str, int] = {}
        screws: list[Screw] = []
        position, orientation = np.zeros(3), np.array((0.0, 0.0, 0.0, 1.0))
        for joint in tree.chain(sensor_frame):
            rotation = rotation_matrices(orientation)
            with np.errstate(over="ignore", invalid="ignore"):
                position = position + rotation @ joint.position
            orientation = _product(orientation, joint.orientation)
            orientation = orientation / np.linalg.norm(orientation)
            if joint.kind == "fixed":
                continue
            if joint.kind not in SCALAR:
                what = f"it is {joint.kind}, and lies between '{tree.root}' and '{sensor_frame}'"
                fix = f"joints there can be {', '.join(SCALAR)} or fixed"
                raise InputError(what, where=f"{path}, joint '{joint.name}'", fix=fix)
            moving, multiplier, offset = resolved(joint, tree)
            axis = frozen(rotation_matrices(orientation) @ joint.axis)
            column = columns.setdefault(moving, len(columns))
            screws.append(
                Screw(
                    joint.kind == "prismatic",
                    axis,
                    frozen(position),
                    column,
                    multiplier,
                    offset,
                )
            )
        if not np.isfinite(position).all():
            what = f"'{sensor_frame}' is infinitely far away"
            raise InputError(what, where=path, fix="give lengths in metres")
        every = (
            joint
            for joint in tree.joints.values()
            if joint.kind in SCALAR and joint.mimic is None
        )
        return cls(
            source=path,
            root=tree.root,
            sensor_frame=sensor_frame,
            joints=tuple(columns),
            all_joints=tuple(joint.name for joint in every),
            limits=tuple(_limits(tree.joints[name]) for name in columns),
            screws=tuple(screws),
            home_position=frozen(position),
            home_orientation=frozen(orientation),
        )

    def poses(self, q: ArrayLike) -> tuple[Array, Array]:
        """Position (K, 3) [m] and orientation (K, 4) of the sensor frame in the root
        frame.

        `q` (K, n) are positions of `joints` [rad] or [m]. Orientations are unit
        quaternions x, y, z, w, continuous in q: their sign does not jump. Raises
        `InputError` for another shape, and if a pose is not finite.
        """
        values = np.asarray(q, dtype=float)
        if values.ndim != 2 or values.shape[1] != len(self.joints):
            what = f"joint positions have shape {values.shape}, not (K, {len(self.joints)})"
            raise InputError(
                what, where=self.source, fix=f"give the joints {listed(self.joints)}"
            )
        position, orientation = np.empty((len(values), 3)), np.empty((len(values), 4))
        for first in range(0, len(values), CHUNK):
            chunk = slice(first, first + CHUNK)
            self._move(values[chunk].T, position[chunk].T, orientation[chunk].T)
        bad = ~(
            np.isfinite(position).all(axis=1) & np.isfinite(orientation).all(axis=1)
        )
        if bad.any():
            k = int(np.argmax(bad))
            what = f"joint positions of sample {k + 1} give no finite pose"
            raise InputError(what, where=self.source)
        return position, orientation

    @np.errstate(over="ignore", invalid="ignore")
    def _move(self, q: Array, position: Array, orientation: Array) -> None:
        """Fill `position` (3, K) and `orientation` (4, K) from `q` (n, K), from the last
        screw to the first."""
        p = np.repeat(self.home_position[:, None], q.shape[1], axis=1)
        quaternion = np.repeat(self.home_orientation[:, None], q.shape[1], axis=1)
        for screw in reversed(self.screws):
            amount = screw.multiplier * q[screw.column] + screw.offset
            axis, point = screw.axis[:, None], screw.point[:, None]
            if screw.slides:
                p += axis * amount
                continue
            sin, cos = np.sin(0.5 * amount), np.cos(0.5 * amount)
            p -= point
            # p + cos twist + sin axis x twist: Rodrigues' formula by half angles
            twist = cross(axis, p) * (2.0 * sin)
            p += point
            p += cos * twist
            twist *= sin
            p += cross(axis, twist)
            quaternion = _product(np.vstack((axis * sin, cos)), quaternion)
        position[:] = p
        orientation[:] = quaternion / np.sqrt(
            np.einsum("ik,ik->k", quaternion, quaternion)
        )


def _product(first: Array, second: Array) -> Array:
    """Product (4, ...) of quaternions x, y, z, w: the rotation `second`, then `first`,
    in fixed axes."""
    u, v, a, b = first[:3], second[:3], first[3], second[3]
    return np.concatenate(
        (a * v + b * u + cross(u, v), (a * b - (u * v).sum(axis=0))[None])
    )


def resolved(joint: Joint, tree: Tree) -> tuple[str, float, float]:
    """The joint that `joint` finally mimics, or itself, with multiplier and offset."""
    multiplier, offset, passed = 1.0, 0.0, {joint.name}
    where = f"{tree.source}, joint '{joint.name}'"
    while joint.mimic is not None:
        name, factor, shift = joint.mimic
        multiplier, offset = multiplier * factor, multiplier * shift + offset
        if name not in tree.joints:
            what = f"it mimics '{name}', which is not there{nearest(name, tree.joints)}"
            raise InputError(what, where=where)
        if name in passed:
            raise InputError(
                f"it mimics itself (by way of {listed(sorted(passed), 5)})", where=where
            )
        passed.add(name)
        joint = tree.joints[name]
        if joint.kind not in SCALAR:
            raise InputError(f"it mimics '{name}', which is {joint.kind}", where=where)
    return joint.name, multiplier, offset


def _limits(joint: Joint) -> tuple[float, float] | None:
    return None if joint.kind == "prismatic" else joint.limits or (-np.inf, np.inf)
