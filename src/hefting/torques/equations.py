"""Equations of joint torques: one row a joint and sample, in the unknowns that are
there.

    tau_j - (arm's own torque, where it is known)
        = o_j + (c_j + l_j |tau_j|) s(dq_j) + v_j dq_j + a_j ddq_j
        + L (p_j + d_j s(dq_j))
        + w_j' beta + y_j' phi

with the offset o_j, Coulomb friction c_j and its part l_j that grows with the rigid
bodies' torque, viscous friction v_j and the rotor's reflected inertia a_j. s is a
smoothed sign; L is 1 in samples with the payload and 0 in those without, so that p_j
and d_j are what has changed of offset and friction. The torque and every column pass
the same linear filter: the average over some milliseconds. Where a joint hardly moves
its friction has no law, so that its row is left out.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Self

import numpy as np

from hefting.core.spatial import Array, Indices, Mask
from hefting.core.torque_moments import PAYLOAD
from hefting.torques.dynamics import JointDynamics
from hefting.torques.samples import TorqueSamples

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
FRICTION_BY_LOAD = OWN.index("friction by load")
OFFSET_CHANGE = OWN.index("change of the offset under load")
FRICTION_CHANGE = OWN.index("change of the Coulomb friction under load")
SIGN_SPEED = 0.01
"""[rad/s] over which the smoothed sign changes."""
STICTION_SPEED = 0.05
"""[rad/s] below which a joint's friction has no law."""
RATE = 100.0
"""[Hz] of the rows: held objects move below some 10 Hz."""
ROWS_TOGETHER = 4096
"""Samples whose columns are in memory at once."""


@dataclass(frozen=True, eq=False)
class Load:
    """About how large the rigid bodies' torques are, by which friction grows."""

    arm: Array
    """(10 n,) of the links, as of `JointDynamics.arm`"""
    payload: Array
    """(10,)"""

    @classmethod
    def published(cls, dynamics: JointDynamics) -> Self:
        """The URDF's arm, and no payload."""
        return cls(dynamics.arm, np.zeros(PAYLOAD))


@dataclass(frozen=True, eq=False)
class Rows:
    """Equations of a stretch of samples."""

    values: Array
    """(K, n, c) columns [own | arm | payload 10 | torque] [N m]"""
    time: Array
    """(K,) [s]"""
    used: Mask
    """(K, n) which of them count"""

    @classmethod
    def of(
        cls,
        dynamics: JointDynamics,
        samples: TorqueSamples,
        loaded: bool,
        arm_known: bool = False,
        load: Load | None = None,
    ) -> Self:
        """Of a run with (`loaded`) or without the payload. With `arm_known` the URDF's
        inertias are the arm's, and its columns left out. `load` is by default the
        published one."""
        load = Load.published(dynamics) if load is None else load
        starts = samples.bins(RATE)
        parts = [
            _averages(dynamics, samples, part, loaded, arm_known, load)
            for part in _parts(starts, len(samples.time))
        ]
        values, time, speed = (
            np.concatenate(each) for each in zip(*parts, strict=True)
        )
        return cls(values, time, np.abs(speed) >= STICTION_SPEED)


def columns(
    dynamics: JointDynamics,
    samples: TorqueSamples,
    loaded: bool,
    arm_known: bool,
    load: Load,
) -> Array:
    """(K, n, c) of every sample, unfiltered."""
    dq, ddq = samples.velocity, samples.acceleration
    W = dynamics.regressor(samples.position, dq, ddq)
    arm = 0 if arm_known else len(dynamics.base)
    found = np.zeros((*dq.shape, len(OWN) + arm + PAYLOAD + 1))
    sign = np.tanh(dq / SIGN_SPEED)
    Y = W[..., -PAYLOAD:] @ dynamics.payload
    rigid = W @ load.arm
    if loaded:
        rigid += Y @ load.payload
    friction = np.abs(rigid) * sign
    for i, values in enumerate((1.0, sign, dq, ddq, friction)):
        found[..., i] = values
    if loaded:
        found[..., OFFSET_CHANGE], found[..., FRICTION_CHANGE] = 1.0, sign
        found[..., -PAYLOAD - 1 : -1] = Y
    found[..., -1] = samples.torque
    if arm_known:
        found[..., -1] -= W @ dynamics.arm
    else:
        found[..., len(OWN) : len(OWN) + arm] = W[..., dynamics.base]
    return found


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
    load: Load,
) -> tuple[Array, Array, Array]:
    """Columns, time and velocity between `edges`."""
    chosen = samples[int(edges[0]) : int(edges[-1])]
    starts = edges[:-1] - edges[0]
    counts = np.diff(edges)
    values = columns(dynamics, chosen, loaded, arm_known, load)
    values, time, velocity = (
        np.add.reduceat(each, starts, axis=0)
        for each in (values, chosen.time, chosen.velocity)
    )
    return values / counts[:, None, None], time / counts, velocity / counts[:, None]
