"""Gauss-Newton over parameters, bias, clock offset and gravity's direction: robust, or plain on chosen samples."""

from dataclasses import dataclass, replace
from typing import Self

import numpy as np

from hefting.conditioning.drift import Hats
from hefting.conditioning.signals import Signal, Snapshot
from hefting.conditioning.system import Model, Solved, model_at, solve, tangents_of
from hefting.spatial import Array, Mask, skew, vector_to_tensor

FREEDOM = 3.0
"""Degrees of freedom of the Student distribution of a sample's residual."""
LARGEST_STEP = 0.02
"""s, of the offset in one step."""
FARTHEST = 0.1
"""s, from where a fit begins to where it may end"""
COARSE, FINE = 2e-3, 1e-5
"""s: as far a model serves by its rate, on the way and at the end"""
CLOSE = 1e-3
"""A change of the prediction by this part of the noise is none."""
TINY = 1e-9
"""Of the wrench: residuals are not trusted to be smaller."""


@dataclass(frozen=True, eq=False)
class Problem:
    """Wrench samples, the motion, and what is free."""

    signal: Signal
    time: Array
    """(K,) [s]"""
    wrench: Array
    """(K, 6) as recorded"""
    free_offset: bool
    free_gravity: bool
    knots: tuple[int, ...]
    """numbers of knots the bias may have"""
    stride: int = 1
    """of the samples among the recording's"""

    def model(self, offset: float, gravity: Array, known: Model | None, within: float) -> Model:
        """The model at an offset and gravity, from a known one if its offset is `within` so many seconds."""
        return model_at(self.signal, self.time, gravity, offset, self.free_offset, self.free_gravity, known, within)

    @property
    def floor(self) -> Array:
        """(2,) smallest scale of force and torque residuals."""
        size = np.sqrt(np.mean(self.wrench.reshape(-1, 2, 3) ** 2, axis=(0, 2)))
        return TINY * np.maximum(size, 1e-3 * max(float(size.max()), 1e-3))

    def every(self, most: int) -> Self:
        """At most so many samples, evenly chosen."""
        step = -(-len(self.time) // most)
        if step == 1:
            return self
        return replace(self, time=self.time[::step], wrench=self.wrench[::step], stride=self.stride * step)


@dataclass(frozen=True, eq=False)
class Fit:
    """A solution, and what it leaves."""

    phi: Array
    """(10,) as recorded: of negative mass where the sensor counts the other way"""
    hats: Hats
    bias: Array
    """(n, 6) at the knots"""
    scale: Array
    """(2,) of force and torque residuals: root mean square, or the Student distribution's"""
    weights: Array
    """(K,) in the sums: by the motion's errors, zero where left out or not known"""
    spread: Array
    """(K,) how much larger than usual a sample's residual may be, for the motion's errors"""
    residual: Array
    """(K, 6)"""
    columns: Array
    """(K, 6, 10 + extra)"""
    solved: Solved
    model: Model

    @property
    def offset(self) -> float:
        """[s]"""
        return self.model.offset

    @property
    def gravity(self) -> Array:
        """(3,) in world axes [m/s²]"""
        return self.model.gravity

    @property
    def known(self) -> Mask:
        """(K,) samples at which the motion is known"""
        return self.model.snapshot.known

    @property
    def bias_now(self) -> Array:
        """(K, 6) at the samples."""
        return self.hats.combine(self.bias)


@dataclass(frozen=True, eq=False)
class Start:
    """Where to begin."""

    phi: Array
    offset: float
    gravity: Array
    scale: Array
    knots: Array
    """(n,) [s] of the bias"""
    bias: Array
    """(n, 6) there"""
    model: Model | None = None
    """of the same samples at or near the same offset, to save work"""

    def bias_at(self, time: Array) -> Array:
        """(K, 6) at times (K,)."""
        return np.column_stack([np.interp(time, self.knots, column) for column in self.bias.T])


def begin(fit: Fit) -> Start:
    """From where another fit ended."""
    return Start(fit.phi, fit.offset, fit.gravity, fit.scale, fit.hats.knots, fit.bias, fit.model)


def gauss_newton(
    problem: Problem, start: Start, knots: int, kept: Mask | None = None, steps: int = 12, hold: bool = False
) -> Fit:
    """The fit with so many bias knots: Student-weighted over all samples, or plain over those `kept` (K,).

    With `hold` the offset stays, though it counts as unknown in the normal equations.
    """
    wrench, free = problem.wrench, problem.free_offset
    hats = Hats.over(problem.time, knots)
    phi, offset, gravity, scale, bias = start.phi, start.offset, start.gravity, start.scale, start.bias_at(problem.time)
    bounds = offset - FARTHEST, offset + FARTHEST
    model = problem.model(offset, gravity, start.model, COARSE)
    for step in range(steps):
        residual = wrench - model.regressor @ phi - bias
        weights, scale, _ = _weights(problem, model, phi, residual, kept, scale)
        columns = model.columns(phi)
        if hold and free:
            columns = np.delete(columns, 10, axis=2)
        solved = solve(columns, wrench, weights, np.repeat(scale, 3), hats)
        effect = float(np.sqrt(np.mean((model.regressor @ (solved.solution[:10] - phi)) ** 2)))
        phi, bias = solved.solution[:10], hats.combine(solved.bias)
        moved = 0.0
        if free and not hold:
            moved = float(np.clip(solved.solution[10], -LARGEST_STEP, LARGEST_STEP))
            moved = float(np.clip(offset + moved, *bounds)) - offset
            offset += moved
        if model.tangents:
            turned = gravity + np.clip(solved.solution[-2:], -3.0, 3.0) @ tangents_of(gravity)
            gravity = turned * (np.linalg.norm(gravity) / np.linalg.norm(turned))
        done = step and abs(moved) < 1e-6 and effect < (CLOSE if kept is None else 0.1 * CLOSE) * float(scale.max())
        model = problem.model(offset, gravity, model, FINE if done or step == steps - 1 else COARSE)
        if done:
            break
    residual = wrench - model.regressor @ phi - bias
    weights, scale, spread = _weights(problem, model, phi, residual, kept, scale)
    columns = model.columns(phi)
    solved_all = solve(columns, wrench, weights, np.repeat(scale, 3), hats)
    return Fit(phi, hats, solved.bias, scale, weights, spread, residual, columns, solved_all, model)


def _weights(
    problem: Problem, model: Model, phi: Array, residual: Array, kept: Mask | None, scale: Array
) -> tuple[Array, Array, Array]:
    """Weights (K,), the scales (2,) that go with the residuals, and how these may vary by the motion's errors (K,)."""
    known = model.snapshot.known
    trust, spread = motion_weights(phi, model.snapshot, problem.signal.bandwidth, problem.time, scale)
    used = known if kept is None else known & kept
    weights = np.where(used, trust, 0.0)
    square = np.sum(residual.reshape(-1, 2, 3) ** 2, axis=2)
    if kept is not None:
        scale = np.sqrt(weights @ square / max(3.0 * weights.sum(), 1e-300))
        return weights, np.maximum(scale, problem.floor), spread
    student = weights
    for _ in range(2):
        u = weights * (square @ scale**-2.0)
        student = weights * ((FREEDOM + 6.0) / (FREEDOM + u))
        scale = np.maximum(np.sqrt(student @ square / (3.0 * max(int(used.sum()), 1))), problem.floor)
    return student, scale, spread


def motion_weights(phi: Array, seen: Snapshot, bandwidth: float, time: Array, scale: Array) -> tuple[Array, Array]:
    """Weights (K,) by the spread of the motion's errors, as `hefting.motion.sample_weights`, one on average.

    And by what factor (K,) those make a single residual larger than usual.
    """
    if not np.isfinite(bandwidth) or len(time) < 2 or not seen.known.any():
        return np.ones(len(time)), np.ones(len(time))
    lever, inertia = skew(phi[1:4]), vector_to_tensor(phi[4:])
    force, torque = scale
    excess = (np.sum((lever / force) ** 2) + np.sum((inertia / torque) ** 2)) * seen.angular_std**2
    if seen.linear_std is not None:
        excess = excess + (3.0 * (phi[0] / force) ** 2 + np.sum((lever / torque) ** 2)) * seen.linear_std**2
    per_error = max(1.0 / (float(np.median(np.diff(time))) * bandwidth), 1.0)
    weights = 1.0 / (1.0 + per_error * excess / 6.0)
    variance = 1.0 + excess / 6.0
    return weights / weights[seen.known].mean(), np.sqrt(variance / np.median(variance[seen.known]))
