"""Equations of joint torques: one row a joint and sample, in the unknowns that are
there; and their moments at each time scale.

    tau_j - (arm's own torque, where it is known)
        = o_j + (c_j + l_j |tau_j|) s(dq_j) + v_j dq_j + a_j ddq_j
        + L (p_j + d_j s(dq_j))
        + w_j' beta + y_j' phi

with the offset o_j, Coulomb friction c_j and its part l_j that grows with the rigid
bodies' torque, viscous friction v_j and the rotor's reflected inertia a_j. s is a
smoothed sign; L is 1 in samples with the payload and 0 in those without, so that p_j
and d_j are what has changed of offset and friction. The torque and every column pass
the same linear filter: the average over some milliseconds, of which the friction by load
is made, so that another load needs no sample again. Where a joint hardly moves
its friction has no law, so that its row is left out.
"""

from __future__ import annotations

from dataclasses import replace
from functools import cached_property
from typing import Self

import numpy as np

from hefting.core.errors import InputError
from hefting.core.immutable import immutable
from hefting.core.spatial import Array, Indices, Mask
from hefting.core.torque_moments import PAYLOAD, TorqueMoments, merged
from hefting.torques.dynamics import JointDynamics
from hefting.torques.samples import STICTION_SPEED, TorqueSamples, averages

OWN = (
    "offset",
    "Coulomb friction",
    "viscous friction",
    "reflected inertia",
    "friction by load",
    "change of the offset under load",
    "change of the Coulomb friction under load",
)
"""What each joint has of its own."""
COULOMB_FRICTION = OWN.index("Coulomb friction")
FRICTION_BY_LOAD = OWN.index("friction by load")
OFFSET_CHANGE = OWN.index("change of the offset under load")
FRICTION_CHANGE = OWN.index("change of the Coulomb friction under load")
SIGN_SPEED = 0.01
"""[rad/s] Speed over which the smoothed sign changes."""
RATE = 100.0
"""[Hz] of the rows: held objects move below some 10 Hz."""
ROWS_TOGETHER = 4096
"""Samples whose columns are in memory at once."""


@immutable
class Load:
    """Parameters that tell about how large the rigid bodies' torques are, by which
    friction grows."""

    arm: Array
    """(10 n,) of the links, as of `JointDynamics.arm`"""
    payload: Array
    """(10,)"""

    @classmethod
    def published(cls, dynamics: JointDynamics) -> Self:
        """The URDF's arm, and no payload."""
        return cls(dynamics.arm, np.zeros(PAYLOAD))


@immutable
class Rows:
    """Equations of a stretch of samples."""

    values: Array
    """(K, n, c) columns [own | arm | payload 10 | torque] [N m]"""
    time: Array
    """(K,) [s]"""
    used: Mask
    """(K, n) which of them count"""
    published: Array | None = None
    """(K, n) torques of the URDF's arm [N m], where that is taken for the arm"""

    @classmethod
    def of(
        cls,
        dynamics: JointDynamics,
        samples: TorqueSamples,
        loaded: bool,
        arm_known: bool = False,
    ) -> Self:
        """Of a run with (`loaded`) or without the payload; friction by load is zero, see
        `under`.

        With `arm_known` the URDF's inertias are taken for the arm's, and the columns of
        its parameters left out.
        """
        starts = samples.bins(RATE)
        parts = [
            _averages(dynamics, samples, part, loaded, arm_known)
            for part in _parts(starts, len(samples.time))
        ]
        values, published, time, speed = (
            np.concatenate(each) for each in zip(*parts, strict=True)
        )
        used = np.abs(speed) >= STICTION_SPEED
        return cls(values, time, used, published if arm_known else None)

    def under(self, dynamics: JointDynamics, load: Load) -> Self:
        """The same with friction by a `load`."""
        values = self.values.copy()
        rigid = values[..., -PAYLOAD - 1 : -1] @ load.payload
        if self.published is None:
            arm = values[..., len(OWN) : -PAYLOAD - 1]
            rigid += arm @ (dynamics.links @ load.arm)
        else:
            rigid += self.published
        sign = values[..., COULOMB_FRICTION]
        values[..., FRICTION_BY_LOAD] = np.abs(rigid) * sign
        return replace(self, values=values)


def columns(
    dynamics: JointDynamics, samples: TorqueSamples, loaded: bool, arm_known: bool
) -> tuple[Array, Array]:
    """(K, n, c) columns of every sample, unfiltered, without friction by load; and
    (K, n) torques of the URDF's arm."""
    dq, ddq = samples.velocity, samples.acceleration
    W = dynamics.regressor(samples.position, dq, ddq)
    arm = 0 if arm_known else len(dynamics.base)
    found = np.zeros((*dq.shape, len(OWN) + arm + PAYLOAD + 1))
    sign = np.tanh(dq / SIGN_SPEED)
    for i, values in enumerate((1.0, sign, dq, ddq)):
        found[..., i] = values
    if loaded:
        found[..., OFFSET_CHANGE], found[..., FRICTION_CHANGE] = 1.0, sign
        Y = W[..., -PAYLOAD:] @ dynamics.payload
        found[..., -PAYLOAD - 1 : -1] = Y
    found[..., -1] = samples.torque
    published = W @ dynamics.arm
    if arm_known:
        found[..., -1] -= published
    else:
        found[..., len(OWN) : len(OWN) + arm] = W[..., dynamics.base]
    return found, published


def _parts(starts: Indices, samples: int) -> list[Indices]:
    """Edges of whole bins, of at most `ROWS_TOGETHER` samples where bins are
    shorter."""
    edges = np.append(starts, samples)
    parts: list[Indices] = []
    first = 0
    while first < len(starts):
        last = int(np.searchsorted(edges, edges[first] + ROWS_TOGETHER, "right")) - 1
        last = max(last, first + 1)
        parts.append(edges[first : last + 1])
        first = last
    return parts


def _averages(
    dynamics: JointDynamics,
    samples: TorqueSamples,
    edges: Indices,
    loaded: bool,
    arm_known: bool,
) -> tuple[Array, Array, Array, Array]:
    """Columns, torques of the URDF's arm, time and velocity, averaged between
    `edges`."""
    chosen = samples[int(edges[0]) : int(edges[-1])]
    values, published = columns(dynamics, chosen, loaded, arm_known)
    found = values, published, chosen.time, chosen.velocity
    if (np.diff(edges) == 1).all():
        return found
    starts = edges[:-1] - edges[0]
    values, published, time, velocity = (averages(each, starts) for each in found)
    return values, published, time, velocity


LEVELS = 7
"""Scales whose differences are kept apart; the last is of 2^6 and 2^6 rows, 0.64 s and
0.64 s at 100 Hz."""
HALF = 0.5**0.5


@immutable
class TorqueScales:
    """Moments at each time scale, from which the noise and its colour are found after
    the samples are gone.

    Rows that follow one another are turned into their Haar coefficients: differences of
    neighbours, then of averages of two, of four ..., and what is left in the end. The
    transform is orthonormal, so that the factors of all scales together are those of
    the rows; and where the noise is coloured, its coefficients at different scales are
    nearly independent, each scale with a variance of its own (Wornell 1993). So weights
    by scale are generalised least squares, and intervals allow for the colour.
    """

    levels: tuple[TorqueMoments, ...]

    @classmethod
    def empty(cls, joints: int, own: int, arm: int = 0) -> Self:
        """No samples yet; for the arguments see `TorqueMoments.empty`."""
        none = TorqueMoments.empty(joints, own, arm)
        return cls((none,) * (LEVELS + 1))

    def fold(self, rows: Rows) -> Self:
        """Moments with rows that follow one another in time, none before or after
        them."""
        values = rows.values * rows.used[:, :, None]
        left, share = _padded(values), _padded(rows.used.astype(float))
        levels = list(self.levels)
        for level in range(LEVELS):
            pairs = left.reshape(-1, 2, *left.shape[1:])
            each = share.reshape(-1, 2, share.shape[1])
            difference = HALF * (pairs[:, 0] - pairs[:, 1])
            left, share = HALF * (pairs[:, 0] + pairs[:, 1]), 0.5 * each.sum(axis=1)
            # white noise has the variance `share` in each coefficient
            levels[level] = _added(levels[level], difference, share)
        levels[-1] = _added(levels[-1], left, share)
        levels[-1] = replace(
            levels[-1],
            samples=levels[-1].samples + len(rows.time),
            start=min(levels[-1].start, float(rows.time.min(initial=np.inf))),
            end=max(levels[-1].end, float(rows.time.max(initial=-np.inf))),
        )
        return type(self)(tuple(levels))

    def merge(self, other: TorqueScales) -> Self:
        """Of the samples of both, see `TorqueMoments.merge`."""
        if len(self.levels) != len(other.levels):
            raise InputError("moments of different time scales do not merge")
        pairs = zip(self.levels, other.levels, strict=True)
        return type(self)(tuple(a.merge(b) for a, b in pairs))

    @cached_property
    def whole(self) -> TorqueMoments:
        """Of all rows, as of white noise."""
        return merged(self.levels)

    @cached_property
    def factors(self) -> Array:
        """(LEVELS + 1, n, c, c) those of all scales."""
        return np.array([each.factors for each in self.levels])

    @property
    def counts(self) -> Array:
        """(LEVELS + 1, n) coefficients that count."""
        return np.array([each.counts for each in self.levels])

    @property
    def samples(self) -> int:
        """Rows folded in."""
        return self.levels[-1].samples


def _added(moments: TorqueMoments, rows: Array, share: Array) -> TorqueMoments:
    return replace(moments.fold_rows(rows), counts=moments.counts + share.sum(axis=0))


def _padded(values: Array) -> Array:
    """With zeros at the end, to a whole number of the longest blocks."""
    more = -len(values) % 2**LEVELS
    return np.concatenate((values, np.zeros((more, *values.shape[1:]))))
