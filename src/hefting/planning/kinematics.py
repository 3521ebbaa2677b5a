"""Joint trajectories, B-splines of degree five at rest at both ends; the motion of the
sensor frame in its own axes, for all samples at once; and the gradient of a function of
that motion by the joints' motion.

With links i = 1..n, screw axes s_i (unit vectors, in axes of link i), the twist
V = (w, v) and its derivative A = (w', a) of a frame fixed to link i at a point of axis
i are (Featherstone, *Rigid Body Dynamics Algorithms*, sec. 5.3)

    V_i = X_i V_{i-1} + S_i q_i',
    A_i = X_i A_{i-1} + S_i q_i'' + V_i x S_i q_i',       A_0 = (0, -gravity)

where X_i moves to the point and turns by -q_i about the axis. So a is the spatial
acceleration less gravity; the classical acceleration of the point less gravity is a + w
x v. As dX_i/dq_i = -(S_i x) X_i, the derivatives of a function by V, A and the pose of
the last frame transform as wrenches, back through the same links.

Arrays have the samples last: (3, K) are vectors of K samples.
"""

from __future__ import annotations

from functools import cached_property
from typing import NamedTuple, Self

import numpy as np
from numpy.typing import ArrayLike
from scipy.interpolate import BSpline

from hefting.core.spatial import (
    Array,
    cross,
    freeze,
    frozen,
    immutable,
    rotation_matrices,
    skew,
)
from hefting.robots.joint_motion import JointMotion
from hefting.robots.robot import Robot

DEGREE = 5
AT_REST = 3
"""Number of equal control points at each end, for zero velocity and acceleration."""


def knots_of(duration: float, pieces: int) -> Array:
    """Knots of equal polynomial pieces over `duration` [s], clamped at both ends."""
    inner = np.linspace(0.0, duration, pieces + 1)
    return np.concatenate((np.zeros(DEGREE), inner, np.full(DEGREE, duration)))


@immutable
class Trajectory:
    """q(t) = sum_i B_i(t) c_i, at rest at both ends, with continuous jerk between."""

    knots: Array
    """(m + 6,) [s]"""
    points: Array
    """(m, n) control points [rad]; the first three are equal, and the last three"""

    def __post_init__(self):
        freeze(self, "knots", "points")

    @property
    def duration(self) -> float:
        """[s]"""
        return float(self.knots[-1])

    @cached_property
    def _derivatives(self) -> tuple[BSpline, ...]:
        own = BSpline(self.knots, self.points, DEGREE)
        return tuple(own.derivative(k) if k else own for k in range(4))

    def at(self, time: ArrayLike) -> JointMotion:
        """Position, velocity and acceleration at instants (K,) [s]; at rest before the
        start and after the end."""
        t = np.asarray(time, dtype=float)
        inside = np.clip(t, 0.0, self.duration)
        q, v, a = (each(inside) for each in self._derivatives[:3])
        return JointMotion(t, q, v, a)

    def jerk(self, time: ArrayLike) -> Array:
        """(K, n) [rad/s³] at instants (K,) [s]"""
        return self._derivatives[3](np.asarray(time, dtype=float))

    def repeated(self, copies: int) -> Trajectory:
        """The motion forwards and backwards in turn, `copies` in all, at rest between.
        Backwards it uses the same shares of limits and gives the same information."""
        inner, T = self.knots[DEGREE + 1 : -DEGREE - 1], self.duration
        both = (inner, self.points), (T - inner[::-1], self.points[::-1])
        knots, points = [self.knots[: DEGREE + 1]], [self.points[:AT_REST]]
        for k in range(copies):
            inner, path = both[k % 2]
            knots += [k * T + inner, np.full(AT_REST, (k + 1) * T)]
            points.append(path[AT_REST:])
        knots.append(np.full(DEGREE + 1 - AT_REST, copies * T))
        return Trajectory(np.concatenate(knots), np.concatenate(points))

    def sampled(self, rate: float) -> JointMotion:
        """The motion sampled at about `rate` [Hz], including start and end."""
        count = max(round(self.duration * rate), 1)
        return self.at(np.linspace(0.0, self.duration, count + 1))


W, V, DW, A, P = range(5)
"""Indices of the vectors of a frame: angular and linear velocity, their derivatives, and
the position from the root's origin."""
VECTORS = 5


class TipMotion(NamedTuple):
    """Motion of the sensor frame at K instants, in sensor axes unless stated."""

    angular_velocity: Array
    """(3, K) [rad/s]"""
    velocity: Array
    """(3, K) of the origin [m/s]"""
    angular_acceleration: Array
    """(3, K) [rad/s²]"""
    acceleration: Array
    """(3, K) of the origin, classical, less gravity [m/s²]"""
    position: Array
    """(3, K) of the origin, in root axes [m]"""
    rotation: Array
    """(3, 3, K) rotations, sensor axes to root axes: rows are the root's axes"""


@immutable
class Chain:
    """The joints that move the sensor frame of a robot without prismatic joints."""

    axes: Array
    """(s, 3) in root axes at zero joint positions, from root to sensor frame"""
    steps: Array
    """(s + 1, 3) [m] from the root's origin, by a point on each axis, to the sensor's"""
    columns: tuple[int, ...]
    multipliers: Array
    offsets: Array
    """angle of each axis: multiplier * q[column] + offset"""
    home: Array
    """(3, 3) sensor axes in root axes at zero joint positions"""
    gravity: Array
    """(3,) in root axes [m/s²]"""
    joints: int
    """number n of joints that are not mimics"""

    @classmethod
    def of(cls, robot: Robot, gravity: Array) -> Self:
        """Chain of a robot; `gravity` (3,) is in root axes [m/s²]."""
        points = [np.zeros(3), *(s.point for s in robot.screws), robot.home_position]
        return cls(
            frozen([screw.axis for screw in robot.screws]),
            frozen(np.diff(points, axis=0)),
            tuple(screw.column for screw in robot.screws),
            frozen([screw.multiplier for screw in robot.screws]),
            frozen([screw.offset for screw in robot.screws]),
            frozen(rotation_matrices(robot.home_orientation)),
            frozen(gravity),
            len(robot.joints),
        )

    @cached_property
    def turns(self) -> list[tuple[Array, Array]]:
        """K = [axis]x and K K of each axis, for Rodrigues' formula."""
        return [(skew(axis), skew(axis) @ skew(axis)) for axis in self.axes]

    def forward(self, q: Array, dq: Array, ddq: Array) -> Passed:
        """Motion of the tip for positions, velocities and accelerations (K, n) of the
        joints, with the intermediate values that `Passed.back` needs."""
        K = len(q)
        x = np.zeros((3, VECTORS, K))
        x[:, A] = -self.gravity[:, None]
        turned = np.ascontiguousarray(np.repeat(np.eye(3)[:, :, None], K, axis=2))
        links = []
        for i, column in enumerate(self.columns):
            m = self.multipliers[i]
            _step(x, self.steps[i])
            angle = m * q[:, column] + self.offsets[i]
            sin, cos = np.sin(angle), np.cos(angle)
            both = np.concatenate((x, turned), axis=1)
            both = _turned(both, self.turns[i], -sin, cos)
            x, turned = both[:, :VECTORS], both[:, VECTORS:]
            axis = self.axes[i][:, None]
            rate = m * dq[:, column]
            carried = x.copy()
            x[:, W] += axis * rate
            x[:, DW] += axis * (m * ddq[:, column]) + cross(x[:, W], axis) * rate
            x[:, A] += cross(x[:, V], axis) * rate
            links.append((sin, cos, rate, carried))
        _step(x, self.steps[-1])
        x = np.einsum("ji,jck->ick", self.home, x)
        turned = np.einsum("ji,jck->ick", self.home, turned)
        w, v = x[:, W], x[:, V]
        motion = TipMotion(
            w,
            v,
            x[:, DW],
            x[:, A] + cross(w, v),
            np.einsum("icK,iK->cK", turned, x[:, P]),
            np.moveaxis(turned, 0, 1),
        )
        return Passed(self, motion, links)


class TipGradient(NamedTuple):
    """Derivatives (3, K) of a function by a `TipMotion`, where those by the pose are by
    translation (force) and rotation (torque) along and about the sensor's axes."""

    angular_velocity: Array
    velocity: Array
    angular_acceleration: Array
    acceleration: Array
    force: Array
    torque: Array


@immutable
class Passed:
    """Motion of the tip, with intermediate values of `Chain.forward`."""

    chain: Chain
    motion: TipMotion
    links: list[tuple[Array, Array, Array, Array]]
    """of each axis: sine, cosine and rate (K,), and the vectors (3, 5, K) before its own
    motion is added"""

    @cached_property
    def rates(self) -> Array:
        """(n, K) speeds [rad/s] about the axes of `screws`; without mimic joints"""
        return np.array([rate for _, _, rate, _ in self.links])

    @cached_property
    def screws(self) -> Array:
        """(3, 2, n, K) screw axis of each joint, linear and angular: the twist of the
        sensor frame, in its axes, by a unit speed of that joint."""
        chain, K = self.chain, self.motion.velocity.shape[1]
        screws = np.zeros((3, 2, len(chain.columns), K))
        for i, (sin, cos, _, _) in enumerate(self.links):
            across, square = chain.turns[i]
            before = screws[:, :, :i]
            before[:, 0] += cross(before[:, 1], chain.steps[i][:, None, None])
            flat = before.reshape(3, -1)
            before += (
                (1.0 - cos) * (square @ flat).reshape(before.shape)
                - sin * (across @ flat).reshape(before.shape)
            )  # fmt: skip
            screws[:, 1, i] = chain.multipliers[i] * chain.axes[i][:, None]
        screws[:, 0] += cross(screws[:, 1], chain.steps[-1][:, None, None])
        return np.einsum("ji,jcnk->icnk", chain.home, screws)

    def screws_back(self, by: Array) -> Array:
        """Derivatives (K, n) of a function by joint positions, from those `by` the screws
        (3, 2, n, K): dS_j/dq_i = S_j x S_i, the Lie bracket, for i > j, else zero."""
        v, w = self.screws[:, 0], self.screws[:, 1]
        turn = cross(w, by[:, 1]) + cross(v, by[:, 0])
        shift = cross(w, by[:, 0])
        turn, shift = (own.cumsum(axis=1) - own for own in (turn, shift))
        return -(w * turn + v * shift).sum(axis=0).T

    def back(self, gradient: TipGradient) -> tuple[Array, Array, Array]:
        """Derivatives (K, n) of a function by joint positions, velocities and
        accelerations, from its `gradient` by the tip's motion."""
        chain, K = self.chain, self.motion.velocity.shape[1]
        w, v = self.motion.angular_velocity, self.motion.velocity
        g = gradient
        # derivatives as moment and force, by velocity, acceleration and pose in turn
        y = np.stack(
            (
                g.angular_velocity + cross(v, g.acceleration),
                g.velocity + cross(g.acceleration, w),
                g.angular_acceleration,
                g.acceleration,
                g.torque,
                g.force,
            ),
            axis=1,
        )
        y = np.einsum("ij,jck->ick", chain.home, y)
        by_joints = np.zeros((3, chain.joints, K))
        for i in reversed(range(len(chain.columns))):
            _step_back(y, chain.steps[i + 1])
            sin, cos, rate, x = self.links[i]
            column, m, axis = chain.columns[i], chain.multipliers[i], chain.axes[i]
            across, _ = chain.turns[i]
            side = axis[:, None]
            # V_i x S without the part of V_i by this joint, which is along S
            by_joints[1, column] += m * (
                axis @ (y[:, 0])
                + ((across.T @ x[:, W]) * y[:, 2]).sum(axis=0)
                + ((across.T @ x[:, V]) * y[:, 3]).sum(axis=0)
            )
            by_joints[2, column] += m * (axis @ y[:, 2])
            y[:, 0] += rate * cross(side, y[:, 2])
            y[:, 1] += rate * cross(side, y[:, 3])
            turn = axis @ y[:, 4]
            for pair, vector in ((0, W), (1, V), (2, DW), (3, A)):
                turn -= ((across @ x[:, vector]) * y[:, pair]).sum(axis=0)
            by_joints[0, column] += m * turn
            y = _turned(y, chain.turns[i], sin, cos)
        position, velocity, acceleration = (each.T for each in by_joints)
        return position, velocity, acceleration


def _turned(x: Array, turn: tuple[Array, Array], sin: Array, cos: Array) -> Array:
    """Vectors (3, c, K) turned about an axis, of which `turn` is as in `Chain.turns`, by
    angles of sine and cosine (K,)."""
    flat, (across, square) = x.reshape(3, -1), turn
    first, second = (each @ flat for each in (across, square))
    return x + sin * first.reshape(x.shape) + (1.0 - cos) * second.reshape(x.shape)


def _step(x: Array, step: Array) -> None:
    """Vectors (3, 5, K) of a frame, moved by a step (3,) [m] in place."""
    x[:, V] += cross(x[:, W], step[:, None])
    x[:, A] += cross(x[:, DW], step[:, None])
    x[:, P] += step[:, None]


def _step_back(y: Array, step: Array) -> None:
    """Derivatives (3, 6, K) by a frame, moved back by a step (3,) [m] in place."""
    for pair in (0, 2, 4):
        y[:, pair] += cross(step[:, None], y[:, pair + 1])
