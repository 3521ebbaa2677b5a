"""Which share of its limits a motion uses, on a grid fine enough to trust."""

from typing import Self

import numpy as np

from hefting.core.immutable import immutable
from hefting.core.messages import Message, note
from hefting.core.spatial import Array
from hefting.planning.information import features
from hefting.planning.kinematics import Chain, Trajectory
from hefting.planning.limits import CLEARANCE, CLEARANCE_SCALE, Constraints, JointStates
from hefting.planning.space import Space

FINE = 1000.0
"""[Hz] of the grid on which limits are kept."""
CLEARANCE_RATE = 100.0
"""[Hz] of the grid on which clearances are looked at: in half of its interval nothing
moves farther than a quarter of the clearance that is kept."""
BINDING = 0.97
"""Share of a limit from which on it is said to bind."""
NAMES = {
    **{name: f"the {name} of {{}}" for name in JointStates._fields},
    "position": "the range of {}",
    "corner_speed": "the speed of {}",
    "force": "the sensor's range of force",
    "torque": "the sensor's range of torque",
}

EXCESSES = {
    **{name: (f"{name}+", f"{name}-") for name in JointStates._fields},
    "corner_speed": ("corner",),
    "force": ("wrench+", "wrench-"),
    "torque": ("wrench+", "wrench-"),
}
"""How each limit is called on the optimisation's grid."""


@immutable
class Usage:
    """What a motion uses of its limits."""

    shares: dict[str, float]
    """largest share of each limit"""
    places: dict[str, tuple[str, float]]
    """joint or corner at which that is, and when [s]"""
    clearance: float | None
    """[m] least; None where nothing is around"""
    nearest: str
    """what it is between"""

    @classmethod
    def of(
        cls,
        trajectory: Trajectory,
        chain: Chain,
        constraints: Constraints,
        joints: tuple[str, ...],
        space: Space | None,
    ) -> Self:
        """Of a motion of named joints."""
        count = max(round(trajectory.duration * FINE), 1)
        time = np.linspace(0.0, trajectory.duration, count + 1)
        motion = trajectory.at(time)
        states = JointStates(
            motion.position, motion.velocity, motion.acceleration, trajectory.jerk(time)
        )
        tip = chain.forward(*states[:3]).motion
        shares: dict[str, float] = {}
        places: dict[str, tuple[str, float]] = {}

        def add(name: str, own: Array, who: tuple[str, ...]) -> None:
            k, i = np.unravel_index(int(np.abs(own).argmax()), own.shape)
            shares[name] = float(np.abs(own[k, i]))
            places[name] = who[i], float(time[k])

        own_joints = tuple(f"joint '{name}'" for name in joints)
        for name, own in zip(
            JointStates._fields, constraints.joint_shares(states), strict=True
        ):
            add(name, own, own_joints)
        corners = constraints.corner_shares(constraints.corner_velocities(tip))
        who = ("the tip", *("a corner of the object",) * (len(corners) - 1))
        add("corner_speed", corners.T, who)
        if constraints.has_wrench_range:
            wrench = constraints.wrench_shares(features(tip)).T
            for name, part in (("force", slice(0, 3)), ("torque", slice(3, 6))):
                if np.isfinite(constraints.wrench_range[part]).all():
                    add(name, wrench[:, part], ("x", "y", "z"))
        clearance, nearest = None, ""
        if space is not None:
            q = trajectory.sampled(CLEARANCE_RATE).position
            clearance, nearest = space.nearest(q)
        return cls(shares, places, clearance, nearest)

    @property
    def largest(self) -> float:
        """Share of the limit that is used most; above one where a limit is broken."""
        clear = 1.0 + self._lacking / CLEARANCE
        return max(*self.shares.values(), clear)

    @property
    def _lacking(self) -> float:
        """Of half the clearance that is kept [m]."""
        clear = np.inf if self.clearance is None else self.clearance
        return 0.5 * CLEARANCE - clear

    @property
    def beyond(self) -> dict[str, float]:
        """How far each limit is broken that is, by its names in `Look.excesses`."""
        found = {
            name: share - 1.0
            for kind, share in self.shares.items()
            if share > 1.0
            for name in EXCESSES[kind]
        }
        if self._lacking > 0.0:
            share = self._lacking / CLEARANCE_SCALE
            found |= dict.fromkeys(("contact", "clearance"), share)
        return found

    @property
    def worst(self) -> str:
        """The limit that is used most, in words."""
        if self._lacking > 0.0:
            return f"the clearance between {self.nearest}"
        return self._named(max(self.shares, key=lambda name: self.shares[name]))

    @property
    def binding(self) -> tuple[Message, ...]:
        """A message for each limit that binds."""
        found = [
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
            found.append(note("plan-limit-binds", what))
        return tuple(found)

    def _named(self, name: str) -> str:
        return NAMES[name].format(self.places[name][0])
