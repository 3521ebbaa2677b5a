"""Gauss-Newton over parameters, bias, clock offset and gravity's direction: robust, or plain on chosen samples.

With x(t) the features of the motion, A(x) the full regressor of `hefting.core.regressor` and o the clock offset, a
wrench stamped t is

    y(t) = A(x(t - o)) phi + sum_j h_j(t) beta_j + noise,

phi and beta as recorded, so that a sensor that counts the other way has a negative mass. Around an offset and a
direction of gravity g the model is also linear in their changes:

    dy/do = -A(dx/dt) phi,      dy/dg along a tangent e = -A(e in sensor axes) phi.

Each column is linear in what is known of a sample, z = [x, dx/dt, tangents, y], so the normal equations of any
phi follow from the one matrix Z'WZ.
"""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from hefting.core.lapack import lapack
from hefting.core.regressor import FULL_MAP
from hefting.core.spatial import Array, Mask
from hefting.ingest.blocks import Blocks
from hefting.ingest.drift import HatFunctions
from hefting.ingest.path import MOTION_COLUMNS, WORLD_AXES_COLUMNS, Path, Reading
from hefting.motion.weighting import effect_of_acceleration_errors, samples_per_error

STUDENT_DEGREES_OF_FREEDOM = 3.0
"""Degrees of freedom of the Student t distribution assumed for a sample's residual in a robust fit."""
LARGEST_OFFSET_STEP = 0.02
"""[s] Largest change of the clock offset in one Gauss-Newton step."""
LARGEST_OFFSET_CHANGE = 0.1
"""[s] Largest change of the clock offset between the start and the end of one fit."""
LARGEST_TAYLOR_STEP = {True: (8e-3, 2e-3), False: (2e-3, 1e-5)}
"""[s] Time over which the motion is extrapolated by its second-order Taylor series: (during the iteration, at its end).

Key True: a smooth motion. The third-order remainder for a signal of f Hz over t is (2 pi f t)³ / 6, at 2 Hz 2e-4 and
3e-6. Key False: a motion that contains the vibrations a sensor measured.
"""
NEGLIGIBLE_PREDICTION_CHANGE = 1e-3
"""Change of the predicted wrench, as a share of the residual scale, at which a robust fit counts as converged."""
RESIDUAL_SCALE_FLOOR = 1e-9
"""Smallest residual scale, as a share of the wrench's root mean square."""
UNDETERMINED_EIGENVALUE = 1e-11
"""Eigenvalues of the scaled normal matrix below this share of the largest one count as zero."""
SAFE_PIVOT_RATIO = 1e-6
"""Squared ratio of the smallest to the largest Cholesky pivot above which the normal matrix is inverted directly.

Above it no eigenvalue comes near `UNDETERMINED_EIGENVALUE`, unless many of some hundred unknowns lose rank together.
"""
REGRESSOR_BY_FEATURE = FULL_MAP.reshape(12, 6, 10)
"""(12, 6, 10) full regressor per unit of each motion feature: see `hefting.core.regressor`."""


@dataclass(frozen=True)
class Layout:
    """Where each unknown stands in the normal equations."""

    offset: int | None
    """of the clock; None where it is not free"""
    tilt: slice | None
    """(2,) of gravity along its tangents; None where it is not free"""
    core: int
    """number of these and of the ten parameters, which come first; the bias follows"""

    @classmethod
    def of(cls, free_offset: bool, free_gravity: bool) -> "Layout":
        """With what is free."""
        offset = 10 if free_offset else None
        at = 11 if free_offset else 10
        return cls(offset, slice(at, at + 2) if free_gravity else None, at + 2 * free_gravity)


@dataclass(frozen=True, eq=False)
class Problem:
    """Wrench samples, the motion, and what is free."""

    path: Path
    blocks: Blocks
    free_offset: bool
    free_gravity: bool
    knots: tuple[int, ...]
    """numbers of knots the bias may have"""

    @property
    def time(self) -> Array:
        """(B,) [s]"""
        return self.blocks.time

    @property
    def wrench(self) -> Array:
        """(B, 6) as recorded"""
        return self.blocks.wrench

    @cached_property
    def floor(self) -> Array:
        """(2,) smallest scale of force and torque residuals."""
        size = np.sqrt(np.mean(self.wrench.reshape(-1, 2, 3) ** 2, axis=(0, 2)))
        return RESIDUAL_SCALE_FLOOR * np.maximum(size, 1e-3 * max(float(size.max()), 1e-3))

    def every(self, most: int) -> "Problem":
        """At most so many blocks, evenly chosen."""
        chosen = self.blocks.every(most)
        return self if chosen is self.blocks else replace(self, blocks=chosen)


@dataclass(frozen=True, eq=False)
class Model:
    """What is known of each block at one offset and direction of gravity."""

    reading: Reading
    offset: float
    gravity: Array
    features: Array
    """(B, 12) of the motion"""
    known: Array
    """(B, z) all that the columns are made of: features, their rates if the offset is free, the two tangents of
    gravity in sensor axes if it is free, and the wrench"""
    layout: Layout

    @classmethod
    def at(
        cls, problem: Problem, offset: float, gravity: Array, reading: Reading | None = None, final: bool = True
    ) -> "Model":
        """At an offset and gravity; from a `reading` of the motion if that is near enough for a `final` one or not."""
        path, blocks, free_offset = problem.path, problem.blocks, problem.free_offset
        wanted = blocks.time - offset if path.moves else blocks.time
        reach = LARGEST_TAYLOR_STEP[path.smooth][final]
        inside = np.clip(wanted, path.first, path.last)
        if reading is None or len(reading.time) != len(wanted) or np.abs(inside - reading.time).max() > reach:
            reading = path.at(wanted, rates=free_offset or bool(blocks.variance.any()))
        reading = replace(reading, known=~reading.in_gap & (inside == wanted))
        apart = (inside - reading.time)[:, None]
        second = 0.5 * (apart * apart + blocks.variance[:, None])
        rows = reading.value + apart * reading.rate + second * reading.curvature
        rates = reading.rate + apart * reading.curvature
        g = np.zeros(3) if path.gravity_measured else gravity
        features = _features(rows, g)
        parts = [features]
        if free_offset:
            parts.append(_features(rates, g))
        if problem.free_gravity:
            along = -(rows[:, WORLD_AXES_COLUMNS].reshape(-1, 3, 3) @ tangents_of(gravity).T)
            parts.append(np.swapaxes(along, 1, 2).reshape(-1, 6))
        parts.append(blocks.wrench)
        layout = Layout.of(free_offset, problem.free_gravity)
        return cls(reading, offset, gravity, features, np.hstack(parts), layout)

    @property
    def held(self) -> "Model":
        """The same with the offset known."""
        layout = Layout.of(False, self.layout.tilt is not None)
        return replace(self, known=np.delete(self.known, np.s_[12:24], axis=1), layout=layout)

    def maps(self, phi: Array) -> Array:
        """(z, 6, core): the columns of parameters, offset and tilt, linear in `known`, at parameters phi (10,)."""
        effect = REGRESSOR_BY_FEATURE @ phi
        maps = np.zeros((self.known.shape[1], 6, self.layout.core))
        maps[MOTION_COLUMNS, :, :10] = REGRESSOR_BY_FEATURE
        at = 12
        if self.layout.offset is not None:
            maps[at : at + 12, :, self.layout.offset] = -effect
            at += 12
        if self.layout.tilt is not None:
            for i in range(2):
                maps[at + 3 * i : at + 3 * i + 3, :, self.layout.tilt.start + i] = effect[:3]
        return maps

    def columns(self, phi: Array) -> Array:
        """(B, 6, core) of parameters, offset and tilt."""
        maps = self.maps(phi)
        return (self.known @ maps.reshape(len(maps), -1)).reshape(-1, 6, maps.shape[2])

    def predict(self, phi: Array) -> Array:
        """(B, 6) wrench of parameters phi (10,), without bias."""
        return self.features @ (REGRESSOR_BY_FEATURE @ phi)


def _features(rows: Array, gravity: Array) -> Array:
    """(B, 12) with a - g in the place of a; `gravity` zero where it is part of what was measured."""
    features = rows[:, MOTION_COLUMNS].copy()
    if gravity.any():
        features[:, :3] -= rows[:, WORLD_AXES_COLUMNS].reshape(-1, 3, 3) @ gravity
    return features


def tangents_of(gravity: Array) -> Array:
    """(2, 3): unit vectors at right angles to gravity (3,) and to each other."""
    axis = np.eye(3)[np.argmin(np.abs(gravity))]
    first = np.cross(gravity, axis)
    first = first / np.linalg.norm(first)
    return np.array((first, np.cross(gravity / np.linalg.norm(gravity), first)), dtype=float)


@dataclass(frozen=True, eq=False)
class Solution:
    """Of weighted normal equations."""

    core: Array
    """(core,): parameters, then changes of offset and tilt; see `Layout`"""
    bias: Array
    """(n, 6) at the knots"""
    inverse: Array
    """(core + 6 n, core + 6 n) of the normal matrix; zero where undetermined"""
    undetermined: Mask
    """(core + 6 n,) what the data leave open"""


def solve(model: Model, phi: Array, weights: Array, scale: Array, hats: HatFunctions) -> Solution:
    """Weighted least squares about the parameters phi (10,): weights (B,), scale (2,) of force and torque."""
    maps, z = model.maps(phi), model.known
    inverse_variance = np.repeat(scale, 3) ** -2.0
    weighted = z * weights[:, None]
    gram = weighted.T @ z
    p, n = maps.shape[2], hats.n
    by_channel = maps.transpose(1, 0, 2)  # (6, z, p)
    seen = gram @ by_channel
    N, b = np.empty((p + 6 * n, p + 6 * n)), np.empty(p + 6 * n)
    N[:p, :p] = (by_channel.transpose(0, 2, 1) @ seen * inverse_variance[:, None, None]).sum(axis=0)
    wrench = np.arange(len(gram) - 6, len(gram))
    b[:p] = (seen[np.arange(6), wrench] * inverse_variance[:, None]).sum(axis=0)
    crossing = hats.project(weighted)  # (n, z)
    cross = (crossing @ by_channel * inverse_variance[:, None, None]).transpose(1, 0, 2).reshape(6 * n, p)
    N[p:, :p], N[:p, p:] = cross, cross.T
    b[p:] = (crossing[:, -6:] * inverse_variance).ravel()
    N[p:, p:] = np.einsum("ij,cd->icjd", hats.gram(weights), np.diag(inverse_variance)).reshape(6 * n, 6 * n)
    inverse, undetermined = invert(N)
    solution = inverse @ b
    return Solution(solution[:p], solution[p:].reshape(n, 6), inverse, undetermined)


def invert(N: Array) -> tuple[Array, Mask]:
    """Inverse of a positive semidefinite matrix in its determined directions, and which unknowns are not.

    Columns are scaled to one length first; an unknown with part in a direction left out is undetermined.
    """
    length = np.sqrt(np.maximum(N.diagonal(), 0.0))
    usable = length > 1e-150
    length = np.where(usable, length, 1.0)
    scaled = N / length / length[:, None]
    factor, failed = lapack.dpotrf(scaled, lower=1)
    pivots = factor.diagonal()
    if not failed and usable.all() and (pivots.min() / pivots.max()) ** 2 > SAFE_PIVOT_RATIO:
        inverse = np.tril(lapack.dpotri(factor, lower=1)[0])
        inverse += np.tril(inverse, -1).T
        return inverse / length / length[:, None], np.zeros(len(N), dtype=bool)
    values, vectors = np.linalg.eigh(scaled)
    good = values > UNDETERMINED_EIGENVALUE * values[-1] if values[-1] > 0.0 else np.zeros(len(values), dtype=bool)
    kept = vectors[:, good] / np.sqrt(values[good])
    inverse = (kept @ kept.T) / length / length[:, None]
    undetermined = np.asarray((vectors[:, ~good] ** 2).sum(axis=1) > 1e-4) | ~usable
    inverse[~usable] = 0.0
    inverse[:, ~usable] = 0.0
    return inverse, undetermined


@dataclass(frozen=True, eq=False)
class Fit:
    """A solution, and what it leaves."""

    phi: Array
    """(10,) as recorded: of negative mass where the sensor counts the other way"""
    hats: HatFunctions
    bias: Array
    """(n, 6) at the knots"""
    scale: Array
    """(2,) of force and torque residuals: root mean square, or the Student distribution's"""
    weights: Array
    """(B,) in the sums: by the number of samples and the motion's errors, zero where left out or not known"""
    spread: Array
    """(B,) how much larger than usual a block's residual may be, for the motion's errors"""
    residual: Array
    """(B, 6)"""
    solution: Solution
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
        """(B,) blocks at which the motion is known"""
        return self.model.reading.known

    @cached_property
    def bias_now(self) -> Array:
        """(B, 6) at the blocks."""
        return self.hats.combine(self.bias)

    @cached_property
    def columns(self) -> Array:
        """(B, 6, core) of the model."""
        return self.model.columns(self.phi)

    @property
    def start(self) -> "Start":
        """To go on from here."""
        hats = self.hats
        return Start(self.phi, self.offset, self.gravity, self.scale, hats.knots, self.bias, self.model.reading)


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
    reading: Reading | None = None
    """of the motion at or near the same times, to save work"""

    def bias_at(self, time: Array) -> Array:
        """(B, 6) at times (B,)."""
        return np.column_stack([np.interp(time, self.knots, column) for column in self.bias.T])


def gauss_newton(
    problem: Problem, start: Start, knots: int, robust: bool = False, steps: int = 12, hold: bool = False
) -> Fit:
    """The fit with so many bias knots: plain, by the blocks' counts, or Student-weighted if `robust`.

    With `hold` the offset stays, though it counts as unknown in the normal equations at the end.
    """
    wrench, free = problem.wrench, problem.free_offset
    hats = HatFunctions.over(problem.time, knots)
    phi, offset, gravity, scale, bias = start.phi, start.offset, start.gravity, start.scale, start.bias_at(problem.time)
    bounds = offset - LARGEST_OFFSET_CHANGE, offset + LARGEST_OFFSET_CHANGE
    model = Model.at(problem, offset, gravity, start.reading, final=False)
    for step in range(steps):
        residual = wrench - model.predict(phi) - bias
        weights, scale, _ = block_weights(problem, model.reading, phi, residual, robust, scale)
        inner = model.held if hold and free else model
        found = solve(inner, phi, weights, scale, hats)
        layout = inner.layout
        change = model.predict(found.core[:10] - phi)
        effect = float(np.sqrt(np.mean(change**2)))
        phi, bias = found.core[:10], hats.combine(found.bias)
        moved = 0.0
        if free and layout.offset is not None:
            moved = float(np.clip(found.core[layout.offset], -LARGEST_OFFSET_STEP, LARGEST_OFFSET_STEP))
            moved = float(np.clip(offset + moved, *bounds)) - offset
            offset += moved
        if layout.tilt is not None:
            turned = gravity + np.clip(found.core[layout.tilt], -3.0, 3.0) @ tangents_of(gravity)
            gravity = turned * (np.linalg.norm(gravity) / np.linalg.norm(turned))
        small = (NEGLIGIBLE_PREDICTION_CHANGE if robust else 0.1 * NEGLIGIBLE_PREDICTION_CHANGE) * float(scale.max())
        done = (step > 0 or not robust) and abs(moved) < 1e-6 and effect < small
        last = done or step == steps - 1
        if moved or layout.tilt is not None or last:
            model = Model.at(problem, offset, gravity, model.reading, final=last)
        if done:
            break
    residual = wrench - model.predict(phi) - bias
    weights, scale, spread = block_weights(problem, model.reading, phi, residual, robust, scale)
    final = solve(model, phi, weights, scale, hats)
    return Fit(phi, hats, found.bias, scale, weights, spread, residual, final, model)


def block_weights(
    problem: Problem, reading: Reading, phi: Array, residual: Array, robust: bool, scale: Array
) -> tuple[Array, Array, Array]:
    """Weights (B,), the scales (2,) that go with the residuals, and how these may vary by the motion's errors (B,)."""
    blocks, known = problem.blocks, reading.known
    trust, spread = motion_weights(phi, reading, problem.path.bandwidth, blocks.time, scale)
    weights = np.where(known, trust * blocks.count / blocks.mean_count, 0.0)
    square = np.sum(residual.reshape(-1, 2, 3) ** 2, axis=2)
    if not robust:
        scale = np.sqrt(weights @ square / max(3.0 * weights.sum(), 1e-300))
        return weights, np.maximum(scale, problem.floor), spread
    student = weights
    for _ in range(2):
        u = weights * (square @ scale**-2.0)
        student = weights * ((STUDENT_DEGREES_OF_FREEDOM + 6.0) / (STUDENT_DEGREES_OF_FREEDOM + u))
        scale = np.sqrt(student @ square / (3.0 * max(int((weights > 0.0).sum()), 1)))
        scale = np.maximum(scale, problem.floor)
    return student, scale, spread


def motion_weights(phi: Array, reading: Reading, bandwidth: float, time: Array, scale: Array) -> tuple[Array, Array]:
    """Weights (B,) by the spread of the motion's errors, as `hefting.motion.sample_weights`, one on average.

    And by what factor (B,) those make a single residual larger than usual.
    """
    known = reading.known
    if not np.isfinite(bandwidth) or len(time) < 2 or not known.any():
        return np.ones(len(time)), np.ones(len(time))
    share = scale**-2.0 @ effect_of_acceleration_errors(phi) / 6.0
    excess = share @ reading.variances
    weights = 1.0 / (1.0 + samples_per_error(time, bandwidth) * excess)
    variance = 1.0 + excess
    return weights / weights[known].mean(), np.sqrt(variance / np.median(variance[known]))
