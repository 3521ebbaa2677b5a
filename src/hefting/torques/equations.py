"""Equations of joint torques, one row per joint and sample, and their moments at each
time scale.

    tau_j - (arm's own torque, where it is known)
        = o_j + (c_j + l_j |tau_j|) s(dq_j) + v_j dq_j + a_j ddq_j
        + g_j tau_j + L (p_j + d_j s(dq_j) + e_j dq_j)
        + w_j' beta + y_j' phi

with the offset o_j, Coulomb friction c_j, the friction l_j per rigid-body torque tau_j,
viscous friction v_j, reflected inertia of the rotor a_j, error of the gain g_j, base
parameters of the arm beta and parameters of the payload phi. s is a smoothed sign. L is
1 in samples with the payload and 0 in those without, so p_j, d_j and e_j are the changes
of offset and frictions under load. All is averaged over 1 / `RATE`; friction by load and
error of the gain follow from these averages. A row is left out where friction follows
no law (`TorqueSamples.sliding`).
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from functools import cached_property
from itertools import pairwise
from typing import Self

import numpy as np

from hefting.core.spatial import Array, Indices, Mask, immutable
from hefting.core.torque_moments import PAYLOAD, TorqueMoments, merged
from hefting.torques.dynamics import JointDynamics
from hefting.torques.samples import TorqueSamples, averages

OWN = (
    "offset",
    "Coulomb friction",
    "viscous friction",
    "reflected inertia",
    "friction by load",
    "error of the gain",
    "change of the offset under load",
    "change of the Coulomb friction under load",
    "change of the viscous friction under load",
)
"""Nuisances: the unknowns of one joint each, in the order of their columns."""
COULOMB_FRICTION = OWN.index("Coulomb friction")
FRICTION_BY_LOAD = OWN.index("friction by load")
GAIN = OWN.index("error of the gain")
OFFSET_CHANGE = OWN.index("change of the offset under load")
CHANGES = slice(OFFSET_CHANGE, len(OWN))
SIGN_SPEED = 0.01
"""[rad/s] Scale v of the smoothed sign, tanh(dq / v)."""
RATE = 100.0
"""[Hz] Rate of the rows: the motion of held objects is below some 10 Hz."""
ROWS_TOGETHER = 4096
"""Number of samples whose columns are in memory at once."""


@immutable
class Load:
    """Approximate parameters of arm and payload, for the friction by load."""

    arm: Array
    """(10 n,) parameters of the links, as `JointDynamics.arm`"""
    payload: Array
    """(10,)"""

    @classmethod
    def published(cls, dynamics: JointDynamics) -> Self:
        """The URDF's arm, and no payload."""
        return cls(dynamics.arm, np.zeros(PAYLOAD))


@immutable
class Rows:
    """Equations of consecutive samples."""

    values: Array
    """(K, n, c) columns [own | arm | payload 10 | torque] [N m]"""
    time: Array
    """(K,) [s]"""
    used: Mask
    """(K, n) whether a row counts"""
    published: Array | None = None
    """(K, n) torques of the URDF's arm [N m], if its parameters are taken as known"""

    @classmethod
    def of(
        cls,
        dynamics: JointDynamics,
        samples: TorqueSamples,
        loaded: bool,
        arm_known: bool = False,
    ) -> Self:
        """Rows of a run with (`loaded`) or without the payload. The column of friction
        by load is zero until `under` fills it.

        With `arm_known` the arm has the URDF's parameters: its torques are subtracted,
        and there are no columns of the arm.
        """
        starts = samples.bins(RATE)
        parts = [
            [averages(x, own) for x in _columns(dynamics, part, loaded, arm_known)]
            for part, own in _parts(samples, starts)
        ]
        values, published = (np.concatenate(each) for each in zip(*parts, strict=True))
        mean = samples.averaged(starts)
        return cls(values, mean.time, mean.sliding, published if arm_known else None)

    def under(self, dynamics: JointDynamics, load: Load) -> Self:
        """The rows with the columns of friction by load, |tau_j| s(dq_j), and of the gain's
        error, tau_j, for `load`."""
        values = self.values.copy()
        rigid_torque = values[..., -PAYLOAD - 1 : -1] @ load.payload
        if self.published is None:
            arm = values[..., len(OWN) : -PAYLOAD - 1]
            rigid_torque += arm @ (dynamics.links @ load.arm)
            values[..., GAIN] = rigid_torque
        else:
            rigid_torque += self.published
        sign = values[..., COULOMB_FRICTION]
        values[..., FRICTION_BY_LOAD] = np.abs(rigid_torque) * sign
        return replace(self, values=values)


def _columns(
    dynamics: JointDynamics, samples: TorqueSamples, loaded: bool, arm_known: bool
) -> tuple[Array, Array]:
    """Columns (K, n, c) of every sample, as `Rows.values` but not averaged and with zero
    for the friction by load; and torques (K, n) of the URDF's arm [N m]."""
    dq, ddq = samples.velocity, samples.acceleration
    W = dynamics.regressor(samples.position, dq, ddq)
    arm = 0 if arm_known else len(dynamics.base)
    values = np.zeros((*dq.shape, len(OWN) + arm + PAYLOAD + 1))
    sign = np.tanh(dq / SIGN_SPEED)
    for i, column in enumerate((1.0, sign, dq, ddq)):
        values[..., i] = column
    if loaded:
        values[..., CHANGES] = values[..., :3]
        Y = W[..., -PAYLOAD:] @ dynamics.payload
        values[..., -PAYLOAD - 1 : -1] = Y
    values[..., -1] = samples.torque
    published = W @ dynamics.arm
    if arm_known:
        values[..., -1] -= published
    else:
        values[..., len(OWN) : len(OWN) + arm] = W[..., dynamics.base]
    return values, published


def _parts(
    samples: TorqueSamples, starts: Indices
) -> Iterator[tuple[TorqueSamples, Indices]]:
    """Consecutive samples, about `ROWS_TOGETHER`, and the starts of averages in them."""
    count, many = len(samples.time), len(starts)
    parts = min(count // ROWS_TOGETHER + 1, many)
    edges = np.append(starts, count)
    for first, last in pairwise(np.linspace(0, many, parts + 1).astype(int)):
        begin, end = edges[first], edges[last]
        yield samples[begin:end], starts[first:last] - begin


LEVELS = 7
"""Number of time scales: at scale l, averages over 2^l rows are compared with the next
ones; at the last these are 0.64 s long at 100 Hz."""
HALF = 0.5**0.5


@immutable
class TorqueScales:
    """Moments at each time scale, from which the noise and its colour are found when the
    samples are no longer kept.

    Consecutive rows are transformed to their Haar coefficients, orthonormally: all scales
    together are the rows. Coefficients of coloured noise are nearly independent,
    with one variance per scale (Wornell 1993).
    """

    levels: tuple[TorqueMoments, ...]
    """`LEVELS` scales of differences or fewer, and the averages that remain"""

    @classmethod
    def empty(cls, joints: int, own: int, arm: int = 0) -> Self:
        """Moments of no samples; arguments as of `TorqueMoments.empty`."""
        none = TorqueMoments.empty(joints, own, arm)
        return cls((none,) * (LEVELS + 1))

    def fold(self, rows: Rows) -> Self:
        """Moments with consecutive rows added, as a run of their own."""
        values = rows.values * rows.used[:, :, None]
        sums, share = _padded(values), _padded(rows.used.astype(float))
        levels = list(self.levels)
        for level in range(len(levels) - 1):
            pairs = sums.reshape(-1, 2, *sums.shape[1:])
            each = share.reshape(-1, 2, share.shape[1])
            difference = HALF * (pairs[:, 0] - pairs[:, 1])
            sums, share = HALF * (pairs[:, 0] + pairs[:, 1]), 0.5 * each.sum(axis=1)
            # white noise has the variance `share` in each coefficient
            levels[level] = _added(levels[level], difference, share)
        levels[-1] = _added(levels[-1], sums, share)
        levels[-1] = replace(
            levels[-1],
            samples=levels[-1].samples + len(rows.time),
            start=min(levels[-1].start, float(rows.time.min(initial=np.inf))),
            end=max(levels[-1].end, float(rows.time.max(initial=-np.inf))),
        )
        return type(self)(tuple(levels))

    def merge(self, other: TorqueScales) -> Self:
        """Moments of the samples of both, see `TorqueMoments.merge`."""
        pairs = zip(self.levels, other.levels, strict=True)
        return type(self)(tuple(a.merge(b) for a, b in pairs))

    @cached_property
    def whole(self) -> TorqueMoments:
        """Moments of all rows, with all scales weighted alike."""
        return merged(self.levels)

    @cached_property
    def factors(self) -> Array:
        """(LEVELS + 1, n, c, c) factors of each scale and joint."""
        return np.array([each.factors for each in self.levels])

    @property
    def counts(self) -> Array:
        """(LEVELS + 1, n) numbers of coefficients that count."""
        return np.array([each.counts for each in self.levels])

    @property
    def samples(self) -> int:
        """Number of rows."""
        return self.levels[-1].samples


def _added(moments: TorqueMoments, rows: Array, share: Array) -> TorqueMoments:
    """Moments with rows (K, n, c) of which each counts by its `share` (K, n)."""
    return replace(moments.fold_rows(rows), counts=moments.counts + share.sum(axis=0))


def _padded(values: Array) -> Array:
    """Values with zeros appended to a multiple of 2^`LEVELS` rows."""
    more = -len(values) % 2**LEVELS
    return np.concatenate((values, np.zeros((more, *values.shape[1:]))))
