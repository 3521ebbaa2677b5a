"""The wrench as a linear model of everything unknown, at a clock offset and a direction of gravity.

With x(t) the features of the motion, A(x) the full regressor of `hefting.regressor` and o the clock offset, a wrench
stamped t is

    y(t) = A(x(t - o)) phi + sum_j h_j(t) beta_j + noise,

phi and beta as recorded, so that a sensor that counts the other way has a negative mass. Around an offset and a
direction of gravity g the model is also linear in their changes:

    dy/do = -A(dx/dt) phi,      dy/dg along a tangent e = -A(e in sensor axes) phi.
"""

from dataclasses import dataclass, field

import numpy as np

from hefting.conditioning.drift import Hats
from hefting.conditioning.signals import Signal, Snapshot
from hefting.regressor import FULL_MAP
from hefting.spatial import Array, Mask

DIFFERENCE = 2e-3
"""s, step of the numerical derivative by time."""
OPEN = 1e-11
"""Eigenvalues of the scaled normal equations below this part of the largest count as undetermined."""


@dataclass(frozen=True, eq=False)
class Model:
    """Columns of the linear model at K samples for one offset and gravity."""

    time: Array
    """(K,) [s] of the wrench"""
    read_at: float
    """s, offset for which the motion was read"""
    snapshots: tuple[Snapshot, ...]
    """of the motion; where the offset is free also of the motion a little earlier and later"""
    span: Array
    """(K,) [s] between those"""
    offset: float
    gravity: Array
    features: Array
    """(K, 12) of the motion"""
    rate: Array | None
    """(K, 12) their change by time, where the offset is free"""
    tangents: tuple[Array, ...]
    """(K, 12) each: their change with gravity along a tangent, where its direction is free"""
    regressor: Array = field(init=False)
    """(K, 6, 10)"""

    def __post_init__(self):
        object.__setattr__(self, "regressor", (self.features @ FULL_MAP).reshape(-1, 6, 10))

    @property
    def snapshot(self) -> Snapshot:
        """The motion itself."""
        return self.snapshots[0]

    def columns(self, phi: Array) -> Array:
        """(K, 6, 10 + extra) all columns but the bias's, at parameters phi (10,)."""
        changes = [] if self.rate is None else [-self.rate]
        extra = [times(change, phi)[:, :, None] for change in (*changes, *self.tangents)]
        return np.concatenate((self.regressor, *extra), axis=2) if extra else self.regressor


def times(features: Array, phi: Array) -> Array:
    """Wrench (K, 6) of the full model for motion features (K, 12)."""
    return features @ (FULL_MAP.reshape(12, 6, 10) @ phi)


def tangents_of(gravity: Array) -> Array:
    """(2, 3): unit vectors at right angles to gravity (3,) and to each other."""
    axis = np.eye(3)[np.argmin(np.abs(gravity))]
    first = np.cross(gravity, axis)
    first = first / np.linalg.norm(first)
    return np.array((first, np.cross(gravity / np.linalg.norm(gravity), first)), dtype=float)


def features_at(snapshot: Snapshot, gravity: Array | None) -> Array:
    """Motion features (K, 12) of the regressor: with a - g, unless gravity is None (measured with a)."""
    x = snapshot.features
    if gravity is None:
        return x
    x = x.copy()
    x[:, :3] -= snapshot.world @ gravity
    return x


def model_at(
    signal: Signal,
    time: Array,
    gravity: Array,
    offset: float,
    free_offset: bool,
    free_gravity: bool,
    known: Model | None = None,
    within: float = 0.0,
) -> Model:
    """The model for wrench samples stamped `time` (K,), with gravity (3,) in world axes, `offset` [s] late.

    A model already `known` of the same samples saves reading the motion, if its offset is `within` so many seconds.
    """
    if (
        known is not None
        and known.time is time
        and len(known.snapshots) == (3 if free_offset else 1)
        and abs(offset - known.read_at) <= (within if free_offset else 0.0)
    ):
        read_at, snapshots, span = known.read_at, known.snapshots, known.span
    else:
        read_at, (snapshots, span) = offset, _read(signal, time - offset, free_offset)
    g = None if signal.gravity_measured else gravity
    seen = snapshots[0]
    x, rate, tangents = features_at(seen, g), None, ()
    if free_offset:
        earlier, later = snapshots[1:]
        inside = (earlier.known & later.known & seen.known)[:, None]
        rate = np.where(inside, (features_at(later, g) - features_at(earlier, g)) / span[:, None], 0.0)
        if offset != read_at:
            x = x - (offset - read_at) * rate
    if free_gravity and g is not None:
        along = -(seen.world @ tangents_of(gravity).T)
        tangents = tuple(np.hstack((along[:, :, i], np.zeros((len(time), 9)))) for i in range(2))
    return Model(time, read_at, snapshots, span, offset, gravity, x, rate, tangents)


def _read(signal: Signal, time: Array, change: bool) -> tuple[tuple[Snapshot, ...], Array]:
    """The motion at times (K,), and, if its `change` is wanted, a little earlier and later, with the time between."""
    if not change:
        return (signal.at(time),), np.ones(len(time))
    earlier, later = (np.clip(time + side * DIFFERENCE, signal.first, signal.last) for side in (-1.0, 1.0))
    return (signal.at(time), signal.at(earlier), signal.at(later)), np.maximum(later - earlier, 1e-12)


@dataclass(frozen=True, eq=False)
class Solved:
    """Solution of weighted normal equations."""

    solution: Array
    """(p,) of the model's columns"""
    bias: Array
    """(n, 6)"""
    inverse: Array
    """(p + 6 n, p + 6 n) of the normal matrix; zero where undetermined"""
    open: Mask
    """(p + 6 n,) what the data leave undetermined"""


def solve(columns: Array, wrench: Array, weights: Array, scale: Array, hats: Hats) -> Solved:
    """Weighted least squares: columns (K, 6, p), wrench (K, 6), weights (K,), scale (6,) of the noise."""
    K, _, p = columns.shape
    n = hats.n
    rows = columns * (1.0 / scale)[:, None]
    target = wrench / scale
    weighted = rows * weights[:, None, None]
    N = np.zeros((p + 6 * n, p + 6 * n))
    b = np.empty(p + 6 * n)
    flat = weighted.reshape(6 * K, p)
    N[:p, :p] = flat.T @ rows.reshape(6 * K, p)
    b[:p] = flat.T @ target.ravel()
    cross = hats.project(weighted.reshape(K, 6 * p)).reshape(n, 6, p) / scale[:, None]
    N[p:, :p] = cross.reshape(6 * n, p)
    N[:p, p:] = N[p:, :p].T
    b[p:] = (hats.project(target * weights[:, None]) / scale).ravel()
    N[p:, p:] = np.einsum("ij,cd->icjd", hats.gram(weights), np.diag(scale**-2.0)).reshape(6 * n, 6 * n)
    inverse, open_ = invert(N)
    solution = inverse @ b
    return Solved(solution[:p], solution[p:].reshape(n, 6), inverse, open_)


def invert(N: Array) -> tuple[Array, Mask]:
    """Inverse of a positive semidefinite matrix in its determined directions, and which unknowns are not.

    Columns are scaled to one length first; an unknown with part in a direction left out is undetermined.
    """
    length = np.sqrt(np.maximum(N.diagonal(), 0.0))
    usable = length > 1e-150
    length = np.where(usable, length, 1.0)
    scaled = N / length / length[:, None]
    values, vectors = np.linalg.eigh(scaled)
    good = values > OPEN * values[-1] if values[-1] > 0.0 else np.zeros(len(values), dtype=bool)
    kept = vectors[:, good] / np.sqrt(values[good])
    inverse = (kept @ kept.T) / length / length[:, None]
    open_ = np.asarray((vectors[:, ~good] ** 2).sum(axis=1) > 1e-4) | ~usable
    inverse[~usable] = 0.0
    inverse[:, ~usable] = 0.0
    return inverse, open_
