"""Samples of joint torques with the joints' motion, from a recording."""

from __future__ import annotations

import hashlib
from dataclasses import fields
from typing import Self

import numpy as np

from hefting.core.errors import InputError
from hefting.core.immutable import immutable
from hefting.core.messages import Message, warning
from hefting.core.recording import Recording
from hefting.core.spatial import Array, Indices, median
from hefting.motion.curve import Curve
from hefting.robots.joint_log import named_columns
from hefting.torques.dynamics import JointDynamics

FEWEST = 20
"""Samples of a run that a motion is found from."""


@immutable
class TorqueSamples:
    """Motion and torques of n joints at K instants."""

    time: Array
    """(K,) [s], increasing"""
    position: Array
    """(K, n) [rad] or [m]"""
    velocity: Array
    """(K, n) [rad/s] or [m/s]"""
    acceleration: Array
    """(K, n) [rad/s²] or [m/s²]"""
    torque: Array
    """(K, n) [N m] or [N], exerted by the motors on the links"""

    @classmethod
    def smoothed(
        cls, joint_time: Array, position: Array, time: Array, torque: Array
    ) -> Self:
        """From joint positions (L, n) at `joint_time` (L,) and torques (K, n) at `time`
        (K,) [s]: each joint's motion is a spline through its positions.

        Torques outside the positions' time, or in gaps, are left out. Raises
        `InputError` for fewer than `FEWEST` samples.
        """
        for kind, many in (("positions", len(joint_time)), ("torques", len(time))):
            if many < FEWEST:
                what = f"{many} samples of joint {kind} are too few"
                raise InputError(what, fix=f"record at least {FEWEST}, moving")
        motion = np.empty((3, *torque.shape))
        for j in range(position.shape[1]):
            own = position[:, j : j + 1]
            if not np.ptp(own):
                motion[:, :, j] = np.array((own[0, 0], 0.0, 0.0))[:, None]
                motion[:, (time < joint_time[0]) | (time > joint_time[-1]), j] = np.nan
                continue
            curve = Curve.fit(joint_time, own, f"position of joint {j + 1}")
            for k, values in enumerate(curve.evaluate(time, spread=False)[:3]):
                motion[k, :, j] = values[:, 0]
        kept = np.isfinite(motion).all(axis=(0, 2))
        if kept.sum() < FEWEST:
            raise InputError(
                "hardly any torque was measured while the joints' positions were"
            )
        position, velocity, acceleration = motion[:, kept]
        return cls(time[kept], position, velocity, acceleration, torque[kept])

    def __getitem__(self, part: slice) -> TorqueSamples:
        return TorqueSamples(*(getattr(self, own.name)[part] for own in fields(self)))

    def delayed(self, by: float) -> TorqueSamples:
        """With torques that came `by` seconds after the motion that they belong to."""
        time = self.time - by
        kept = (time >= self.time[0]) & (time <= self.time[-1])
        position, velocity, acceleration = (
            np.column_stack([np.interp(time[kept], self.time, own) for own in each.T])
            for each in (self.position, self.velocity, self.acceleration)
        )
        own = self.time[kept], position, velocity, acceleration, self.torque[kept]
        return TorqueSamples(*own)

    @property
    def digest(self) -> str:
        """Tells one run from another, whatever the motion."""
        return hashlib.sha256(self.torque.tobytes()).hexdigest()[:16]

    @property
    def interval(self) -> float:
        """[s] Median from sample to sample."""
        return median(np.diff(self.time))

    def bins(self, rate: float) -> Indices:
        """Index of the first sample of each 1 / `rate` seconds that has any; each
        sample's own, where they come no faster."""
        if self.interval * rate > 0.7:
            return np.arange(len(self.time))
        number = np.floor((self.time - self.time[0]) * rate + 1e-6)
        return np.flatnonzero(np.diff(number, prepend=-1.0))


UR_JOINT = "shoulder_pan_joint"
"""Name of a joint by which a Universal Robots driver is known, whose efforts are
currents unless it was told otherwise."""
LEAST_TURN = 0.02
"""[rad] A joint that turns less does not move."""


def samples_of(
    recording: Recording, dynamics: JointDynamics, gains: Array | None = None
) -> TorqueSamples:
    """Motion and torques of the joints of `dynamics`.

    `gains` [N m/A], (n,) or one number for all, say that the recorded values are the
    motors' currents. Raises `InputError` where positions or torques are not there, are
    of other joints, or currents have no gains.
    """
    if not recording.has("joint_positions"):
        raise InputError(
            "has no joint positions", recording.source, "record q1..qn, or JointState"
        )
    stream = _torques(recording, gains)
    names = named_columns(recording, dynamics.robot)
    columns = [names[name] for name in dynamics.names]
    q = recording["joint_positions"]
    torque = recording[stream].values[:, columns]
    if gains is not None:
        torque = torque * _checked(gains, len(columns), recording.source)
    turns = [s.column for s in dynamics.robot.screws if not s.slides]
    position = q.values[:, columns]
    # angles may be given within half a turn
    position[:, turns] = np.unwrap(position[:, turns], axis=0)
    time = recording[stream].time
    return TorqueSamples.smoothed(q.time, position, time, torque)


def still_joints(
    samples: TorqueSamples, dynamics: JointDynamics, source: str
) -> tuple[Message, ...]:
    """A warning about joints that never move, if any."""
    turned = np.ptp(samples.position, axis=0)
    names = [n for n, by in zip(dynamics.names, turned, strict=True) if by < LEAST_TURN]
    if not names:
        return ()
    what = (
        f"{source}: {', '.join(names)} never moves, so that its torque, with a friction "
        "that is not known, tells nothing"
    )
    return (warning("joint-still", what),)


def _torques(recording: Recording, gains: Array | None) -> str:
    source = recording.source
    if recording.has("joint_torques"):
        if UR_JOINT in recording.joint_names and gains is None:
            raise InputError(
                "efforts of a UR driver are currents unless use_currents_as_efforts is "
                "false, and then without the gravity of the configured payload",
                source,
                "give `torque_gains` [N m/A], or 1 where they are torques and no "
                "payload is configured",
            )
        return "joint_torques"
    if recording.has("joint_currents"):
        if gains is None:
            raise InputError(
                "the motors' currents are in amperes",
                source,
                "give `torque_gains`, one for each joint [N m/A]",
            )
        return "joint_currents"
    raise InputError(
        "there are no joint torques",
        source,
        "record them in columns tau1..taun, as effort of JointState or as "
        "actual_current, or name their columns in a column map (`column_map`)",
    )


def _checked(gains: Array, joints: int, source: str) -> Array:
    values = np.atleast_1d(np.asarray(gains, dtype=float))
    if values.shape not in ((1,), (joints,)) or not np.isfinite(values).all():
        what = f"{len(values)} gains for {joints} joints"
        raise InputError(what, source, "give one for each")
    if not values.all():
        raise InputError("a gain is zero", source, "give N m/A of each joint")
    return values
