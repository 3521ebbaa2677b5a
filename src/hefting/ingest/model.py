"""Model: the wrench as a function of parameters, bias, clock offset and gravity's
direction.

With x(t) the features of the motion, A(x) the full regressor of
`hefting.core.regressor` and o the clock offset, a wrench with time stamp t is

    y(t) = A(x(t - o)) phi + sum_j h_j(t) beta_j + noise.

phi and beta have the sign of the recorded wrench, so the mass is negative for a sensor
of the other sign convention. About an offset and a direction of gravity g the model is
linear in their changes, too:

    dy/do = -A(dx/dt) phi,      dy/dg along a tangent e = -A(e in sensor axes) phi.

Each column of the design matrix is linear in the known row of a sample, z = [x, dx/dt,
tangents, y]. The normal equations of any phi therefore follow from the one matrix Z'WZ;
they are solved with undetermined directions left out.
"""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from hefting.core.lapack import lapack
from hefting.core.regressor import FULL_MAP
from hefting.core.spatial import Array, Mask, cross, immutable
from hefting.ingest.blocks import Blocks
from hefting.ingest.drift import HatFunctions
from hefting.ingest.path import WORLD_AXES_COLUMNS, Path, Reading

LARGEST_TAYLOR_STEP = {True: (8e-3, 2e-3), False: (2e-3, 1e-5)}
"""[s] Time over which the motion is extrapolated by its second-order Taylor series:
(during the iteration, at its end).

Key True: a smooth motion. The third-order remainder for a signal of f Hz over t is (2
pi f t)³ / 6, at 2 Hz 2e-4 and 3e-6. Key False: a motion that contains the vibrations a
sensor measured.
"""
RESIDUAL_SCALE_FLOOR = 1e-9
"""Smallest residual scale, as a share of the wrench's root mean square."""
FEATURES = 12
"""Number of features of the motion: a - g, alpha and vech(w w')."""
REGRESSOR_BY_FEATURE = FULL_MAP.reshape(FEATURES, 6, 10)
"""(12, 6, 10) regressor per unit of motion feature: see `hefting.core.regressor`."""


@dataclass(frozen=True)
class Layout:
    """Position of each unknown in the normal equations."""

    offset: int | None
    """of the clock offset; None where it is not free"""
    tilt: slice | None
    """(2,) of gravity's change along its two tangents; None where it is not free"""
    core: int
    """number of these and the ten parameters, which come first; the bias follows"""

    @classmethod
    def of(cls, *, free_offset: bool, free_gravity: bool) -> "Layout":
        """Layout for the unknowns that are free."""
        offset = 10 if free_offset else None
        next_index = 11 if free_offset else 10
        if not free_gravity:
            return cls(offset, None, next_index)
        return cls(offset, slice(next_index, next_index + 2), next_index + 2)


@immutable
class Problem:
    """Wrench samples, the motion, and the free unknowns."""

    path: Path
    blocks: Blocks
    free_offset: bool
    """whether the clock offset is unknown"""
    free_gravity: bool
    """whether gravity's direction is unknown"""
    knots: tuple[int, ...]
    """numbers of knots the bias may have, in increasing order"""

    @property
    def time(self) -> Array:
        """(B,) [s]"""
        return self.blocks.time

    @property
    def wrench(self) -> Array:
        """(B, 6) as recorded [N, N m]"""
        return self.blocks.wrench

    @cached_property
    def floor(self) -> Array:
        """(2,) smallest scale of force [N] and torque [N m] residuals."""
        size = np.sqrt(np.mean(self.wrench.reshape(-1, 2, 3) ** 2, axis=(0, 2)))
        return RESIDUAL_SCALE_FLOOR * np.maximum(
            size, 1e-3 * max(float(size.max()), 1e-3)
        )

    def every(self, most: int) -> "Problem":
        """The problem with at most `most` of its blocks, evenly chosen."""
        chosen = self.blocks.every(most)
        return self if chosen is self.blocks else replace(self, blocks=chosen)


@immutable
class Model:
    """Model of each block, linearised about an offset and a direction of gravity."""

    reading: Reading
    offset: float
    """[s]"""
    gravity: Array
    """(3,) in world axes [m/s²]"""
    features: Array
    """(B, 12) of the motion"""
    known: Array
    """(B, z) rows in which the columns are linear: features, their rates if the offset
    is free, the two tangents of gravity in sensor axes if its direction is free, and
    the wrench"""
    layout: Layout

    @classmethod
    def at(
        cls,
        problem: Problem,
        offset: float,
        gravity: Array,
        reading: Reading | None = None,
        *,
        final: bool = True,
    ) -> "Model":
        """The model about a clock offset and a direction of gravity.

        Parameters
        ----------
        problem : samples and motion.
        offset : by which the wrench is late [s].
        gravity : (3,) in world axes [m/s²].
        reading : motion at nearby times; it is extrapolated where that is accurate
            enough, to save time.
        final : whether the accuracy is that of a final solution or of an iteration.
        """
        wanted = problem.time - offset if problem.path.moves else problem.time
        reading = _read_motion(problem, wanted, reading, final=final)
        inside = np.clip(wanted, problem.path.first, problem.path.last)
        values, rates = _extrapolate(reading, inside, problem.blocks.variance)
        modelled_gravity = np.zeros(3) if problem.path.gravity_measured else gravity
        features = features_of(values, modelled_gravity)
        known = [features]
        if problem.free_offset:
            known.append(features_of(rates, modelled_gravity))
        if problem.free_gravity:
            known.append(_tangents_in_sensor_axes(values, gravity))
        known.append(problem.wrench)
        layout = Layout.of(
            free_offset=problem.free_offset, free_gravity=problem.free_gravity
        )
        return cls(reading, offset, gravity, features, np.hstack(known), layout)

    @cached_property
    def with_fixed_offset(self) -> "Model":
        """The same model without the offset, which must be among its unknowns."""
        layout = Layout.of(free_offset=False, free_gravity=self.layout.tilt is not None)
        return replace(
            self,
            known=np.delete(self.known, np.s_[FEATURES : 2 * FEATURES], axis=1),
            layout=layout,
        )

    def maps(self, phi: Array) -> Array:
        """(z, 6, core) columns of parameters, offset and tilt per unit of `known`, at
        parameters phi (10,)."""
        wrench_by_feature = REGRESSOR_BY_FEATURE @ phi
        maps = np.zeros((self.known.shape[1], 6, self.layout.core))
        maps[:FEATURES, :, :10] = REGRESSOR_BY_FEATURE
        row = FEATURES
        if self.layout.offset is not None:
            maps[row : row + FEATURES, :, self.layout.offset] = -wrench_by_feature
            row += FEATURES
        if self.layout.tilt is not None:
            for i in range(2):
                tangent = slice(row + 3 * i, row + 3 * i + 3)
                maps[tangent, :, self.layout.tilt.start + i] = wrench_by_feature[:3]
        return maps

    def columns(self, phi: Array) -> Array:
        """(B, 6, core) columns of the design matrix for parameters, offset and tilt, at
        parameters phi (10,)."""
        maps = self.maps(phi)
        return (self.known @ maps.reshape(len(maps), -1)).reshape(-1, 6, maps.shape[2])

    def predict(self, phi: Array) -> Array:
        """(B, 6) wrench of parameters phi (10,), without bias."""
        return self.features @ (REGRESSOR_BY_FEATURE @ phi)

    def predict_rate(self, phi: Array) -> Array:
        """(B, 6) derivative of `predict` with respect to time, per second; the offset must
        be among the unknowns."""
        return self.known[:, FEATURES : 2 * FEATURES] @ (REGRESSOR_BY_FEATURE @ phi)


def _read_motion(
    problem: Problem, wanted: Array, reading: Reading | None, *, final: bool
) -> Reading:
    """The motion at or near the `wanted` times (B,): the given `reading` if it is near
    enough, else a new one. Its mask `known` is that of the wanted times."""
    path = problem.path
    inside = np.clip(wanted, path.first, path.last)
    largest_step = LARGEST_TAYLOR_STEP[path.smooth][final]
    reusable = (
        reading is not None
        and len(reading.time) == len(wanted)
        and not np.abs(inside - reading.time).max() > largest_step
    )
    if reading is None or not reusable:
        reading = path.at(
            wanted, rates=problem.free_offset or bool(problem.blocks.variance.any())
        )
    return replace(reading, known=~reading.in_gap & (inside == wanted))


def _extrapolate(reading: Reading, time: Array, variance: Array) -> tuple[Array, Array]:
    """Values and rates (B, 21) at times (B,) near those of a reading, by its
    second-order Taylor series, averaged over samples whose times have the `variance`
    (B,) [s²]."""
    step = (time - reading.time)[:, None]
    half_square = 0.5 * (step * step + variance[:, None])
    values = reading.value + step * reading.rate + half_square * reading.curvature
    return values, reading.rate + step * reading.curvature


def features_of(rows: Array, gravity: Array) -> Array:
    """(B, 12) features of readings (B, 21): a - g, alpha, vech(w w'). `gravity` is zero
    if a - g was measured."""
    maps = np.eye(rows.shape[1], FEATURES)  # the motion's columns come first
    for axis in range(3):
        maps[WORLD_AXES_COLUMNS][3 * axis : 3 * axis + 3, axis] = -gravity
    return rows @ maps


def _tangents_in_sensor_axes(rows: Array, gravity: Array) -> Array:
    """(B, 6) negative tangents of gravity in sensor axes, one after the other, from
    readings (B, 21)."""
    into_sensor = rows[:, WORLD_AXES_COLUMNS].reshape(-1, 3, 3)
    tangents = -(into_sensor @ tangents_of(gravity).T)
    return np.swapaxes(tangents, 1, 2).reshape(-1, 6)


def tangents_of(gravity: Array) -> Array:
    """(2, 3) unit vectors perpendicular to gravity (3,) and to each other."""
    axis = np.eye(3)[np.argmin(np.abs(gravity))]
    first = cross(gravity, axis)
    first = first / np.linalg.norm(first)
    return np.array((first, cross(gravity / np.linalg.norm(gravity), first)))


def tilt_gravity(gravity: Array, change: Array) -> Array:
    """Gravity (3,) moved by `change` (2,) [m/s²] along its tangents, length kept."""
    moved = gravity + change @ tangents_of(gravity)
    return moved * (np.linalg.norm(gravity) / np.linalg.norm(moved))


UNDETERMINED_EIGENVALUE = 1e-11
"""Share of the largest eigenvalue of the scaled normal matrix below which eigenvalues
count as zero."""
SAFE_PIVOT_RATIO = 1e-6
"""Squared ratio of the smallest to the largest Cholesky pivot above which the normal
matrix is inverted directly: no eigenvalue then comes near `UNDETERMINED_EIGENVALUE`,
unless many of some hundred unknowns lose rank together."""


@immutable
class Solution:
    """Solution of weighted normal equations."""

    core: Array
    """(core,) parameters, changes of offset and tilt: `hefting.ingest.model.Layout`"""
    bias: Array
    """(n, 6) at the knots [N, N m]"""
    inverse: Array
    """(core + 6 n, core + 6 n) of the normal matrix; zero where undetermined"""
    undetermined: Mask
    """(core + 6 n,) unknowns that the data leave undetermined"""


def solve(
    model: Model, phi: Array, weights: Array, scale: Array, hats: HatFunctions
) -> Solution:
    """Weighted least squares of the model that is linear about parameters phi.

    Parameters
    ----------
    model : with the known rows of B blocks.
    phi : (10,) parameters about which the columns of offset and tilt are evaluated.
    weights : (B,) of the blocks' squared residuals.
    scale : (2,) standard deviations of force [N] and torque [N m] residuals.
    hats : the functions of time of which the bias is composed.
    """
    maps, known = model.maps(phi), model.known
    inverse_variance = np.repeat(scale, 3) ** -2.0
    weighted = known * weights[:, None]
    gram = weighted.T @ known
    p, n = maps.shape[2], hats.n
    N, b = np.empty((p + 6 * n, p + 6 * n)), np.empty(p + 6 * n)

    by_channel = maps.transpose(1, 0, 2)  # (6, z, p)
    gram_columns = gram @ by_channel
    blocks = by_channel.transpose(0, 2, 1) @ gram_columns
    N[:p, :p] = (blocks * inverse_variance[:, None, None]).sum(axis=0)
    wrench = np.arange(len(gram) - 6, len(gram))
    b[:p] = (gram_columns[np.arange(6), wrench] * inverse_variance[:, None]).sum(axis=0)

    projected = hats.project(weighted)  # (n, z)
    cross = projected @ by_channel * inverse_variance[:, None, None]
    N[p:, :p] = cross.transpose(1, 0, 2).reshape(6 * n, p)
    N[:p, p:] = N[p:, :p].T
    b[p:] = (projected[:, -6:] * inverse_variance).ravel()

    bias_gram = np.einsum("ij,cd->icjd", hats.gram(weights), np.diag(inverse_variance))
    N[p:, p:] = bias_gram.reshape(6 * n, 6 * n)
    inverse, undetermined = invert(N)
    solution = inverse @ b
    return Solution(solution[:p], solution[p:].reshape(n, 6), inverse, undetermined)


def invert(N: Array) -> tuple[Array, Mask]:
    """Inverse of a positive semidefinite matrix (q, q) in its determined directions,
    and a mask (q,) of the others.

    The unknowns are scaled to a unit diagonal first. An unknown with a component in a
    direction that is left out counts as undetermined.
    """
    length = np.sqrt(np.maximum(N.diagonal(), 0.0))
    usable = length > 1e-150
    length = np.where(usable, length, 1.0)
    scaled = N / length / length[:, None]
    factor, failed = lapack.dpotrf(scaled, lower=1)
    pivots = factor.diagonal()
    if (
        not failed
        and usable.all()
        and (pivots.min() / pivots.max()) ** 2 > SAFE_PIVOT_RATIO
    ):
        lower = lapack.dpotri(factor, lower=1)[0]  # zero above the diagonal
        inverse = lower + lower.T
        np.fill_diagonal(inverse, lower.diagonal())
        return inverse / length / length[:, None], np.zeros(len(N), dtype=bool)
    return _invert_semidefinite(scaled, length, usable)


def _invert_semidefinite(
    scaled: Array, length: Array, usable: Mask
) -> tuple[Array, Mask]:
    """As `invert`, by eigenvalues of the scaled matrix (q, q)."""
    values, vectors = np.linalg.eigh(scaled)
    determined = np.zeros(len(values), dtype=bool)
    if values[-1] > 0.0:
        determined = values > UNDETERMINED_EIGENVALUE * values[-1]
    kept = vectors[:, determined] / np.sqrt(values[determined])
    inverse = (kept @ kept.T) / length / length[:, None]
    undetermined = (
        np.asarray((vectors[:, ~determined] ** 2).sum(axis=1) > 1e-4) | ~usable
    )
    inverse[~usable] = 0.0
    inverse[:, ~usable] = 0.0
    return inverse, undetermined
