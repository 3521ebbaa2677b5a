"""The torques of the joints, of an arm without a wrench sensor: what is refused, what is
assumed, and how sure one will be by them.

The forecast is the estimator's own (`hefting.torques`): of torques as they are expected
from the arm's published inertias along the plan, once without the object and once with
it, the noise drawn, arm and friction found from both.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any, Self

import numpy as np
from numpy.typing import ArrayLike

from hefting.core.errors import HeftingError, InputError
from hefting.core.estimate import Estimate
from hefting.core.messages import Message, note
from hefting.core.spatial import Array, frozen
from hefting.identification.by_torques import ByTorques
from hefting.planning.forecast import forecast_by
from hefting.planning.held import Held
from hefting.planning.joint_information import JointInformation
from hefting.planning.kinematics import Chain
from hefting.planning.result import Forecast
from hefting.planning.trajectory import Trajectory
from hefting.robots.robot import Robot
from hefting.torques.dynamics import JointDynamics
from hefting.torques.runs import LoadedRuns
from hefting.torques.samples import TorqueSamples

FIRST_NOISE, LAST_NOISE = 0.1, 0.05
"""[N m] Standard deviations of the noise of the first and the last joint, where nothing
is said: those between lie between, by their logarithm."""
MOST_INSTANTS = 6
"""At which is told how sure one is expected to be: each takes some tenths of a
second."""


def refuse_of_torques(
    shape: object, noise: object, force: object, torque: object, stop_and_go: bool
) -> None:
    """`InputError` for what cannot be planned for joint torques."""
    given = {"noise": noise, "force": force, "torque": torque}
    for name, value in given.items():
        if value is not None:
            what = "it is of a wrench sensor, and `torques` are of the joints"
            raise InputError(what, f"`{name}`", "leave it out")
    if stop_and_go:
        what = "joints at rest tell nothing by torques: their friction has no law there"
        raise InputError(what, "`stop_and_go`", "plan a motion")
    if shape is None:
        what = "joint torques hardly tell an inertia without a shape"
        raise InputError(what, fix="give `shape`")


@dataclass(frozen=True, eq=False)
class JointTorques:
    """The torques of n joints."""

    dynamics: JointDynamics
    noise: Array
    """(n,) standard deviations [N m]"""
    rate: float
    """of the samples [Hz]"""
    notes: tuple[Message, ...] = ()
    """what was assumed"""
    gain: float = 0.0
    """each joint has one of its own, which is not modelled"""

    @classmethod
    def of(
        cls,
        given: bool | ArrayLike,
        estimate: Estimate | None,
        rate: float,
        urdf: str | Path,
        tip: str,
        gravity: Array,
    ) -> Self:
        """With a noise that is given, that of the estimate's recording, or a usual one.

        Raises `InputError` for a noise that is none of n joints, and as
        `JointDynamics.from_urdf`.
        """
        dynamics = JointDynamics.from_urdf(urdf, tip, gravity)
        noise, told = _noise(given, estimate, dynamics.joints)
        what = (
            "expected with an empty run of the same motion, which tells arm and "
            "friction: play it without the object as well"
        )
        notes = (*told, note("plan-empty-run-assumed", what, "torques"))
        return cls(dynamics, frozen(noise), rate, notes)

    @property
    def levels(self) -> dict[str, Any]:
        """Standard deviations [N m]."""
        return {"joint_torques": self.noise.tolist()}

    def information(self, vector: Array) -> JointInformation:
        """Of the loaded run less the empty one, as if all samples counted twice the
        variance."""
        return JointInformation(2.0**0.5 * self.noise, self.rate)

    def forecaster(
        self, robot: Robot, chain: Chain, held: Held, seed: int
    ) -> TorqueForecaster:
        """By `hefting.identification.by_torques`."""
        return TorqueForecaster(self.dynamics, held, self.noise, self.rate, seed)


@dataclass(frozen=True, eq=False)
class TorqueForecaster:
    """By the estimator, of an empty and a loaded run of the motion."""

    dynamics: JointDynamics
    held: Held
    noise: Array
    rate: float
    seed: int

    def forecast(self, trajectory: Trajectory, instants: int) -> Forecast:
        """Before the motion, and at so many instants of it."""
        empty, loaded = self.runs(trajectory)

        def after(duration: float, before: Array | None) -> Array | None:
            many = int(np.searchsorted(empty.time, duration + 1e-9))
            return self._after(empty[:many], loaded[:many], before)

        number = min(instants, MOST_INSTANTS)
        return forecast_by(after, self.held, trajectory.duration, number)

    def runs(self, trajectory: Trajectory) -> tuple[TorqueSamples, TorqueSamples]:
        """What is expected to be recorded, without the object and with it."""
        motion = trajectory.sampled(self.rate)
        states = motion.position, motion.velocity, motion.acceleration
        W = self.dynamics.regressor(*states)
        arm = W @ self.dynamics.arm
        object_ = W[..., -10:] @ (self.dynamics.payload @ self.held.body.vector)
        rng = np.random.default_rng([self.seed, 21])
        noise = self.noise * rng.normal(size=(2, *arm.shape))
        return (
            TorqueSamples(motion.time, *states, arm + noise[0]),
            TorqueSamples(motion.time, *states, arm + object_ + noise[1]),
        )

    def _after(
        self, empty: TorqueSamples, loaded: TorqueSamples, before: Array | None
    ) -> Array | None:
        """(10, 10) covariance after both runs; that before where they tell nothing."""
        try:
            found = LoadedRuns(self.dynamics, (loaded,), (empty,)).fit()
            if self.held.estimate is None:
                own = ByTorques(self.dynamics, found, (), arm_known=False)
                return own.estimate(self.held.shape).covariance
        except (HeftingError, np.linalg.LinAlgError):
            return before
        A = found.state.factor[:, :10]
        C = np.linalg.inv(self.held.information + A.T @ A)
        return np.asarray(C, dtype=float)


def _noise(
    given: bool | ArrayLike, estimate: Estimate | None, joints: int
) -> tuple[Array, tuple[Message, ...]]:
    """(n,) [N m], and a note where it was not given."""
    if given is not True:
        return _given(given, joints), ()
    found = None if estimate is None else estimate.provenance.get("torque_noise")
    if isinstance(found, (list, tuple)) and len(found) == joints:
        noise, of = _given(found, joints), "as of the estimate:"
    else:
        noise, of = np.geomspace(FIRST_NOISE, LAST_NOISE, joints), "taken to be"
    each = ", ".join(f"{value:.2g}" for value in noise)
    what = f"noise of the joint torques {of} {each} N m"
    return noise, (note("plan-torque-noise-assumed", what, "torques"),)


def _given(values: object, joints: int) -> Array:
    try:
        own = np.asarray(values, dtype=float)
    except (TypeError, ValueError):
        raise InputError("the noise of the torques is not made of numbers") from None
    if own.shape not in ((), (joints,)) or not (np.isfinite(own) & (own > 0.0)).all():
        what = f"the noise of the torques is not positive, of all or of {joints} joints"
        raise InputError(what, "`torques`", "as in 0.1 [N m]")
    return np.broadcast_to(own, (joints,))
