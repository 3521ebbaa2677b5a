"""The shares of its limits that a motion uses, on a fine grid."""

from typing import Self

import numpy as np

from hefting.core.messages import Message, note
from hefting.core.spatial import SPEED_LIMIT, Array, immutable
from hefting.planning.information import features
from hefting.planning.kinematics import Chain, Trajectory
from hefting.planning.limits import CLEARANCE, CLEARANCE_SCALE, Constraints, JointStates
from hefting.planning.space import Space

FINE = 1000.0
"""[Hz] Rate of the grid on which limits are kept."""
CLEARANCE_RATE = 100.0
"""[Hz] Rate of the grid of clearances at `SPEED_LIMIT`, and in proportion above it: in half
an interval no corner moves farther than a quarter of `CLEARANCE`."""
BINDING = 0.97
"""Share of a limit above which it binds."""
NAMES = {
    **{name: f"the {name} of {{}}" for name in JointStates._fields},
    "position": "the range of {}",
    "corner_speed": "the speed of {}",
    "force": "the sensor's range of force",
    "torque": "the sensor's range of torque",
}
"""Name of each limit in messages."""
EXCESSES = {
    **{name: (f"{name}+", f"{name}-") for name in JointStates._fields},
    "corner_speed": ("corner",),
    "force": ("wrench+", "wrench-"),
    "torque": ("wrench+", "wrench-"),
}
"""Names of each limit in `Look.excesses`."""


@immutable
class Usage:
    """Use that a motion makes of its limits."""

    shares: dict[str, float]
    """largest share of each limit"""
    places: dict[str, tuple[str, float]]
    """joint or corner of that share, and its time [s]"""
    clearance: float | None
    """[m] least; None if nothing is checked"""
    nearest: str
    """the two things between which it is"""

    @classmethod
    def of(
        cls,
        trajectory: Trajectory,
        chain: Chain,
        constraints: Constraints,
        joints: tuple[str, ...],
        space: Space | None,
    ) -> Self:
        """Usage by a motion of named joints."""
        count = max(round(trajectory.duration * FINE), 1)
        time = np.linspace(0.0, trajectory.duration, count + 1)
        motion = trajectory.at(time)
        states = JointStates(
            motion.position, motion.velocity, motion.acceleration, trajectory.jerk(time)
        )
        tip = chain.forward(*states[:3]).motion
        shares: dict[str, float] = {}
        places: dict[str, tuple[str, float]] = {}

        def add(name: str, signed: Array, columns: tuple[str, ...]) -> None:
            k, i = np.unravel_index(int(np.abs(signed).argmax()), signed.shape)
            shares[name] = float(np.abs(signed[k, i]))
            places[name] = columns[i], float(time[k])

        joint_names = tuple(f"joint '{name}'" for name in joints)
        for name, signed in zip(
            JointStates._fields, constraints.joint_shares(states), strict=True
        ):
            add(name, signed, joint_names)
        corners = constraints.corner_shares(constraints.corner_velocities(tip))
        points = ("the tip", *("a corner of the object",) * (len(corners) - 1))
        add("corner_speed", corners.T, points)
        if constraints.has_wrench_range:
            wrench = constraints.wrench_shares(features(tip)).T
            for name, part in (("force", slice(0, 3)), ("torque", slice(3, 6))):
                if np.isfinite(constraints.wrench_range[part]).all():
                    add(name, wrench[:, part], ("x", "y", "z"))
        clearance, nearest = None, ""
        if space is not None:
            fastest = shares["corner_speed"] * constraints.limits.corner_speed
            rate = CLEARANCE_RATE * max(1.0, fastest / SPEED_LIMIT)
            q = trajectory.sampled(rate).position
            clearance, nearest = space.nearest(q)
        return cls(shares, places, clearance, nearest)

    @property
    def largest(self) -> float:
        """Largest share of any limit; above one if a limit is broken."""
        clearance = 1.0 + self._shortfall / CLEARANCE
        return max(*self.shares.values(), clearance)

    @property
    def _shortfall(self) -> float:
        """[m] by which the clearance is below half of `CLEARANCE`; negative if above."""
        clearance = np.inf if self.clearance is None else self.clearance
        return 0.5 * CLEARANCE - clearance

    @property
    def beyond(self) -> dict[str, float]:
        """Excess of each broken limit, by its names in `Look.excesses`."""
        excesses = {
            name: share - 1.0
            for kind, share in self.shares.items()
            if share > 1.0
            for name in EXCESSES[kind]
        }
        if self._shortfall > 0.0:
            share = self._shortfall / CLEARANCE_SCALE
            excesses |= dict.fromkeys(("contact", "clearance"), share)
        return excesses

    @property
    def worst(self) -> str:
        """Name of the limit with the largest share."""
        if self._shortfall > 0.0:
            return f"the clearance between {self.nearest}"
        return self._named(max(self.shares, key=lambda name: self.shares[name]))

    @property
    def binding(self) -> tuple[Message, ...]:
        """A message for each limit that binds."""
        messages = [
            note(
                "plan-limit-binds",
                f"{self._named(name)}, {100.0 * share:.1f} % at "
                f"{self.places[name][1]:.2f} s",
            )
            for name, share in self.shares.items()
            if share > BINDING
        ]
        if self.clearance is not None and self.clearance < 2.0 * CLEARANCE:
            what = f"{1e3 * self.clearance:.0f} mm are left between {self.nearest}"
            messages.append(note("plan-limit-binds", what))
        return tuple(messages)

    def _named(self, name: str) -> str:
        return NAMES[name].format(self.places[name][0])
