"""The optimisation problem: objective and limits as functions of the control points,
with gradients."""

from __future__ import annotations

from functools import cached_property
from typing import Self

import numpy as np
from scipy.interpolate import BSpline

from hefting.core.accuracy import Accuracy
from hefting.core.inertia import InertialParameters, com_jacobian
from hefting.core.spatial import Array, frozen, immutable
from hefting.planning.information import (
    Information,
    JointInformation,
    feature_gradient,
    features,
)
from hefting.planning.kinematics import (
    AT_REST,
    DEGREE,
    Chain,
    Passed,
    TipGradient,
    TipMotion,
    Trajectory,
    knots_of,
)
from hefting.planning.limits import CLEARANCE, CLEARANCE_SCALE, Constraints, JointStates
from hefting.planning.space import Space

NORM_QUANTILE = 1.75
"""95 % quantile of the length of a normal vector over the root of its mean square: 1.96
for one uncertain axis, 1.61 for three alike."""
SHARPNESS = 12.0
"""Exponent of the power mean that approximates the largest share."""
DOUBLE = np.array((1.0, 2.0, 2.0, 1.0, 2.0, 1.0)) ** 0.5
"""Weights of a tensor's entries in its Frobenius norm."""


@immutable
class Objective:
    """Uncertainty after the motion: the largest ratio of deviation to tolerance, or the
    volume of the parameters' ellipsoid."""

    rows: tuple[Array, ...]
    """(k, 10) of each quantity: its deviation over its tolerance, by the parameters"""
    floors: Array
    """squares of each quantity that no motion reduces"""
    volume: bool
    """whether the volume is the objective"""

    @classmethod
    def of(
        cls, body: InertialParameters, asked: Accuracy | None, gain: float = 0.0
    ) -> Self:
        """Objective for a body of about these parameters; `gain` is the standard
        deviation of the sensor's gain, an error of the mass that no motion reduces."""
        rows, floors = [], []
        for name, own in quantities(body).items():
            limit = getattr(asked, name) if asked else None
            if limit is not None and np.isfinite(limit):
                factor = 1.96 if name == "mass" else NORM_QUANTILE
                rows.append(frozen(factor / limit * own))
                floors.append((factor * gain / limit) ** 2 if name == "mass" else 0.0)
        return cls(tuple(rows), frozen(floors), not rows)

    def value(self, information: Array) -> tuple[float, Array]:
        """Log of the uncertainty, and its derivative by the information (10, 10)."""
        scale = 1.0 / np.sqrt(information.diagonal())
        L = np.linalg.cholesky(scale[:, None] * information * scale)
        half = np.linalg.solve(L, np.diag(scale))
        C = half.T @ half
        if self.volume:
            log = np.log(L.diagonal()).sum() - np.log(scale).sum()
            return -float(log) / 10.0, -C / 20.0
        images = [rows @ C for rows in self.rows]
        squares = np.array(
            [np.sum(i * rows) for i, rows in zip(images, self.rows, strict=True)]
        )
        squares = squares + self.floors
        powers = (squares / squares.max()) ** (0.5 * SHARPNESS)
        shares = powers / powers.sum()
        value = 0.5 * np.log(squares.max()) + np.log(powers.sum()) / SHARPNESS
        slope = sum(
            -0.5 * s / q * (i.T @ i)
            for s, q, i in zip(shares, squares, images, strict=True)
        )
        return float(value), np.asarray(slope)


def quantities(body: InertialParameters) -> dict[str, Array]:
    """Derivatives by the parameters of the relative mass (1, 10), the COM (3, 10) [m] and
    the inertia about the COM over its norm (6, 10)."""
    J = com_jacobian(body)
    size = float(np.linalg.norm(body.inertia_at_com)) or 1e-12
    return {
        "mass": J[:1] / body.mass,
        "center_of_mass": J[1:4],
        "inertia": DOUBLE[:, None] * J[4:] / size,
    }


NEAR = 0.03
"""[m] Clearances below this are linearised; others do not become small in one round."""
STEP = 1e-4
"""[rad] Step of the finite differences."""


@immutable
class Cuts:
    """Clearances of solids and walls at K instants, linear in the joint positions."""

    position: Array
    """(K, n) about which they are linear [rad]"""
    clearance: Array
    """(K,) [m]"""
    slope: Array
    """(K, n) [m/rad]; zero for clearances from `NEAR` on"""

    @classmethod
    def of(cls, space: Space, position: Array) -> Self:
        """Clearances about joint positions (K, n)."""
        clearance = space.clearance(position)
        slope = np.zeros_like(position)
        near = np.flatnonzero(clearance < NEAR)
        if len(near):
            n = position.shape[1]
            moved = (position[near, None] + STEP * np.eye(n)).reshape(-1, n)
            own = space.clearance(moved).reshape(len(near), n)
            slope[near] = (own - clearance[near, None]) / STEP
        return cls(position, clearance, slope)

    def at(self, position: Array) -> Array:
        """(K,) clearances at joint positions (K, n)."""
        return self.clearance + ((position - self.position) * self.slope).sum(axis=1)


GRID = 30.0
"""[Hz] Rate of the optimisation's grid: ten times that of the motion."""
FINEST_PIECE = 0.3
"""[s] Least duration of a polynomial piece: motion up to some 1.5 Hz, which cobots
follow."""
MOST_PIECES = 100
"""Largest number of polynomial pieces: more would take too long, so longer motions are
slower."""


@immutable
class Basis:
    """Splines at rest at both ends, on a grid of K instants: q = start + values[0] @ x,
    and its derivatives values[k] @ x."""

    knots: Array
    values: Array
    """(4, K, P) of position, speed, acceleration and jerk"""

    @classmethod
    def of(cls, duration: float, pieces: int, rate: float) -> Self:
        """Basis of a number of polynomial pieces over `duration` [s], at `rate` [Hz]."""
        knots = knots_of(duration, pieces)
        count = len(knots) - DEGREE - 1
        splines = BSpline(knots, np.eye(count), DEGREE)
        time = np.linspace(0.0, duration, max(round(duration * rate), 2) + 1)
        values = []
        for order in range(4):
            each = (splines.derivative(order) if order else splines)(time)
            free = each[:, AT_REST : count - AT_REST + 1].copy()
            free[:, -1] = each[:, count - AT_REST :].sum(axis=1)
            values.append(free)
        return cls(knots, np.array(values))

    @property
    def free(self) -> int:
        """P, number of free control points"""
        return self.values.shape[2]

    def trajectory(self, start: Array, x: Array) -> Trajectory:
        """Trajectory of free control points (P, n), relative to the start (n,)."""
        n = len(start)
        last = np.repeat(x[-1:], AT_REST - 1, axis=0)
        return Trajectory(
            self.knots, start + np.vstack((np.zeros((AT_REST, n)), x, last))
        )

    def states(self, start: Array, x: Array) -> JointStates:
        """Joint motion on the grid."""
        q, v, a, j = self.values @ x
        return JointStates(start + q, v, a, j)


def pieces_of(duration: float) -> int:
    """Number of polynomial pieces of a motion of `duration` [s]."""
    return int(np.clip(np.floor(duration / FINEST_PIECE), 4, MOST_PIECES))


@immutable
class Problem:
    """The motion from `start` within limits that leaves the least uncertainty."""

    chain: Chain
    basis: Basis
    start: Array
    """(n,) [rad]"""
    known: Array
    """(10, 10) information before the motion"""
    information: Information | JointInformation
    objective: Objective
    constraints: Constraints
    cuts: Cuts | None = None
    """clearances, linear about the motion of the last round"""

    @property
    def duration(self) -> float:
        """[s]"""
        return float(self.basis.knots[-1])

    @cached_property
    def size(self) -> tuple[int, int]:
        """Numbers (P, n) of free control points and joints."""
        return self.basis.free, len(self.start)

    def look(self, x: Array) -> Look:
        """The motion of free control points (P, n), evaluated on the grid."""
        states = self.basis.states(self.start, x)
        passed = self.chain.forward(*states[:3])
        each = features(passed.motion)
        gained = self.information.gained(passed, each, self.duration)
        return Look(self, states, passed, each, self.known + gained)


@immutable
class Look:
    """A motion on the grid, and the information after it."""

    problem: Problem
    states: JointStates
    passed: Passed
    features: Array
    """(12, K)"""
    after: Array
    """(10, 10) information after the motion"""

    @property
    def tip(self) -> TipMotion:
        """Motion of the sensor frame."""
        return self.passed.motion

    def excesses(self) -> dict[str, Array]:
        """Share of each limit that is used, less one; positive where it is broken."""
        limits = self.problem.constraints
        shares = limits.joint_shares(self.states)
        excesses = {}
        for name, share in zip(JointStates._fields, shares, strict=True):
            excesses[f"{name}+"], excesses[f"{name}-"] = share - 1.0, -share - 1.0
        corners = limits.corner_shares(limits.corner_velocities(self.tip))
        excesses["corner"] = corners - 1.0
        if limits.has_wrench_range:
            share = limits.wrench_shares(self.features)
            excesses["wrench+"], excesses["wrench-"] = share - 1.0, -share - 1.0
        if len(limits.normals):
            excesses["clearance"] = -limits.clearances(self.tip) / CLEARANCE_SCALE
        if self.problem.cuts is not None:
            clear = self.problem.cuts.at(self.states.position)
            excesses["contact"] = (CLEARANCE - clear) / CLEARANCE_SCALE
        return excesses

    def gradient(self, by_after: Array, by: dict[str, Array]) -> Array:
        """Derivatives (P, n) of a function by the control points, from those `by_after`
        the information (10, 10) and `by` the excesses."""
        problem, limits, tip = self.problem, self.problem.constraints, self.tip
        slopes = problem.information.back(
            self.passed, self.features, problem.duration, by_after
        )
        by_features = slopes.features
        if "wrench+" in by:
            unit = limits.wrench_shares(np.eye(12))
            by_features = by_features + unit.T @ (by["wrench+"] - by["wrench-"])
        acceleration, turning, spin = feature_gradient(tip, by_features)
        velocities = limits.corner_velocities(tip)
        speeds = np.sqrt((velocities**2).sum(axis=1))
        weight = by["corner"] / (np.maximum(speeds, 1e-9) * limits.limits.corner_speed)
        linear, angular = limits.corner_slopes(weight[:, None] * velocities)
        force = torque = np.zeros_like(linear)
        if "clearance" in by:
            by_clearance = -by["clearance"] / CLEARANCE_SCALE
            force, torque = limits.clearance_slopes(tip, by_clearance)
        tips = TipGradient(spin + angular, linear, turning, acceleration, force, torque)
        by_states = [*self.passed.back(tips), np.zeros_like(self.states.jerk)]
        by_states[0] = by_states[0] + slopes.position
        by_states[1] = by_states[1] + slopes.velocity
        if problem.cuts is not None:
            push = by["contact"][:, None] / CLEARANCE_SCALE
            by_states[0] = by_states[0] - push * problem.cuts.slope
        for i, (name, (_, half)) in enumerate(
            zip(JointStates._fields, limits.joint_scales, strict=True)
        ):
            by_states[i] = by_states[i] + (by[f"{name}+"] - by[f"{name}-"]) / half
        values = problem.basis.values
        return np.asarray(
            sum(B.T @ by_one for B, by_one in zip(values, by_states, strict=True))
        )
