"""What will be measured along the motion, the wrench at the tip or the torques of the
joints, and how sure one will be by it: what the estimator says of a recording as it is
expected, the noise drawn."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any, Self, TypeGuard

import numpy as np
from numpy.typing import ArrayLike

from hefting.core.errors import HeftingError, InputError
from hefting.core.estimate import Estimate
from hefting.core.gravity import ON_EARTH
from hefting.core.immutable import immutable
from hefting.core.measurements import NOISE_LEVELS, MotionNoise, Noise
from hefting.core.messages import Message, note
from hefting.core.recording import Recording, Stream
from hefting.core.spatial import STANDARD_GRAVITY, Array, frozen
from hefting.identification import identify
from hefting.identification.by_torques import ByTorques
from hefting.planning.held import Held
from hefting.planning.information import (
    Information,
    JointInformation,
    expected_wrench,
    features,
    noise_covariance,
)
from hefting.planning.kinematics import Chain, Trajectory
from hefting.planning.result import Forecast, forecast_by
from hefting.robots.robot import Robot
from hefting.torques.dynamics import JointDynamics
from hefting.torques.runs import LoadedRuns
from hefting.torques.samples import TorqueSamples

MOTION_NOISE = MotionNoise(0.03, 0.085, 0.087)
"""Errors of the accelerations that smoothing the poses of a planned motion leaves, with
0.1 mm and 0.02° of noise at 100 Hz: as found on plans of 10 s for three arms, whose
bandwidth is some 36 rad/s. Those of slower motions are smaller."""
MOST_NOISE = 1e3
"""[N], [N m] Noise of an estimate's recording from which on it is not believed."""
POSE_NOISE = (1e-4, 3.5e-4)
"""Standard deviations along each axis of position [m] and orientation [rad] of the poses
that a cobot reports."""
GAIN = 0.0025
"""Standard deviation of a wrench sensor's gain, of which nothing is said
(`hefting.core.sensor_accuracy.TYPICAL`): an error that two recordings share."""
LARGEST_SHARE = 0.95
"""Share of an estimate's variance that is taken to be the sensor's gain at most."""
FIRST_NOISE, LAST_NOISE = 0.1, 0.05
"""[N m] Standard deviations of the noise of the first and the last joint, where nothing
is said: those between lie between, by their logarithm."""
NOISES = 3
"""Draws of the noise that what is expected at the end is the mean of: by one alone an
inertia's half-width varies by some 12 %."""
MOST_INSTANTS = 6
"""At which is told how sure one is expected to be: each takes some tenths of a
second."""


@immutable
class WristSensor:
    """A force-torque sensor at the tip."""

    robot: Robot
    chain: Chain
    noise: Noise
    rate: float
    """of the samples [Hz]"""
    notes: tuple[Message, ...] = ()
    """where the noise was not given"""
    gain = GAIN

    @classmethod
    def of(
        cls,
        robot: Robot,
        gravity: Array,
        noise: Noise | None,
        estimate: Estimate | None,
        rate: float,
    ) -> Self:
        """With a noise that is given, that of the estimate's recording, or a moderate
        one. `InputError` for a noise that is not positive."""
        chain = Chain.of(robot, gravity)
        if noise is not None:
            if not (noise.force > 0.0 and noise.torque > 0.0):
                raise InputError("the noise of force and torque must be positive")
            return cls(robot, chain, noise, rate)
        levels = NOISE_LEVELS["moderate"]
        what = f"noise taken to be {levels.force:g} N and {levels.torque:g} N m"
        found = None if estimate is None else estimate.provenance.get("noise")
        if isinstance(found, dict):
            force, torque = (found.get(name) for name in ("force", "torque"))
            if _is_level(force) and _is_level(torque):
                levels = Noise(force, torque)
                what = f"noise as of the estimate: {force:.3g} N, {torque:.3g} N m"
        notes = (note("plan-noise-assumed", what, "noise"),)
        return cls(robot, chain, levels, rate, notes)

    @property
    def levels(self) -> dict[str, Any]:
        """Of the noise [N], [N m]."""
        return {"force": self.noise.force, "torque": self.noise.torque}

    def information(self, vector: Array) -> Information:
        """With the errors of the accelerations by a body of ten parameters."""
        covariance = noise_covariance(self.noise, MOTION_NOISE, vector, self.rate)
        return Information.of(covariance, self.rate)

    def kept(self, held: Held) -> Array:
        """(10, 10) covariance of errors that no motion lessens: of the gain, now and
        when the tool was identified."""
        tool = GAIN * held.tool
        both = GAIN * held.body.vector + tool
        return np.outer(both, both) + np.outer(tool, tool)

    def forecast(
        self, trajectory: Trajectory, instants: int, held: Held, seed: int
    ) -> Forecast:
        """By `identify`, of the wrench that is expected, in which a bias is found anew
        unless the estimate's recording had none or a known one."""
        recordings = [
            self._recording(trajectory, held, [seed, 20 + 2 * k]) for k in range(NOISES)
        ]
        shape = None if held.estimate is not None else held.shape
        gravity = self.chain.gravity
        if np.array_equal(gravity, STANDARD_GRAVITY):
            gravity = ON_EARTH
        found_before = held.estimate and held.estimate.provenance.get("bias")
        bias = "auto" if found_before in ("none", "given") else "estimate"

        def after(duration: float, before: Array | None) -> Array | None:
            drawn = NOISES if duration == trajectory.duration else 1
            known = [by_one(own, duration, before) for own in recordings[:drawn]]
            own = [C for C in known if C is not None]
            return np.mean(own, axis=0) if len(own) == drawn else before

        def by_one(
            recording: Recording, duration: float, before: Array | None
        ) -> Array | None:
            try:
                found = identify(
                    recording, shape, duration=duration, gravity=gravity, bias=bias
                )
            except HeftingError:
                return before
            C = found.estimate.covariance
            if held.estimate is None:
                return C
            if C is None or not np.isfinite(C).all():
                return before
            # the new recording is made without a tool; that of the tool erred, too
            own, tool = GAIN * held.body.vector, GAIN * held.tool
            both = _without(held.information, own + tool)
            both = _without(both, tool)
            both = both + _without(np.asarray(np.linalg.inv(C), float), own)
            return np.linalg.inv(both) + self.kept(held)

        return forecast_by(after, held, trajectory.duration, instants)

    def _recording(
        self, trajectory: Trajectory, held: Held, seed: Sequence[int]
    ) -> Recording:
        """What a robot's log is expected to hold."""
        from scipy.spatial.transform import Rotation

        motion = trajectory.sampled(self.rate)
        states = motion.position, motion.velocity, motion.acceleration
        tip = self.chain.forward(*states).motion
        wrench = expected_wrench(features(tip), held.body.vector).T
        rng = np.random.default_rng(seed)
        position, orientation = self.robot.poses(motion.position)
        off, turn, noise = rng.normal(size=(3, len(position), 6))
        levels = np.repeat((self.noise.force, self.noise.torque), 3)
        turned = Rotation.from_quat(orientation) * Rotation.from_rotvec(
            POSE_NOISE[1] * turn[:, :3]
        )
        streams = {
            "position": position + POSE_NOISE[0] * off[:, :3],
            "orientation": turned.as_quat(),
            "wrench": wrench + levels * noise,
        }
        return Recording(
            {name: Stream(motion.time, own) for name, own in streams.items()},
            source="plan",
        )


def _without(information: Array, shared: Array) -> Array:
    """Information (10, 10) without an error `shared` (10,) of unit variance, as far as
    its covariance has it: (C - s s')^-1 by Sherman and Morrison."""
    seen = information @ shared
    share = float(shared @ seen)
    part = min(1.0, LARGEST_SHARE / max(share, 1e-300))
    return information + part / (1.0 - part * share) * np.outer(seen, seen)


def _is_level(value: object) -> TypeGuard[float]:
    """Whether a value that was read from a file can be a standard deviation."""
    return isinstance(value, float | int) and 0.0 < value < MOST_NOISE


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


@immutable
class JointTorques:
    """The torques of n joints, of an arm without a wrench sensor."""

    dynamics: JointDynamics
    noise: Array
    """(n,) standard deviations [N m]"""
    rate: float
    """of the samples [Hz]"""
    notes: tuple[Message, ...] = ()
    """what was assumed"""
    gain = 0.0
    """each joint has one of its own, which the forecast counts"""

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
        `JointDynamics.from_urdf`."""
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

    def kept(self, held: Held) -> Array:
        """(10, 10) None is known: the forecast counts the gains of the joints."""
        return np.zeros((10, 10))

    def forecast(
        self, trajectory: Trajectory, instants: int, held: Held, seed: int
    ) -> Forecast:
        """By `hefting.identification.by_torques`, of a run without the object and one
        with it, by the arm's published inertias."""
        empty, loaded = self._runs(trajectory, held, seed)

        def after(duration: float, before: Array | None) -> Array | None:
            part = slice(int(np.searchsorted(empty.time, duration + 1e-9)))
            try:
                runs = (loaded[part],), (empty[part],)
                found = LoadedRuns(self.dynamics, *runs).fit()
                if held.estimate is None:
                    state = found.state
                    own = ByTorques(
                        self.dynamics, found, (), False, state.samples, state.duration
                    )
                    return own.estimate(held.shape).covariance
            except (HeftingError, np.linalg.LinAlgError):
                return before
            A = found.state.factor[:, :10]
            C = np.linalg.inv(held.information + A.T @ A)
            return np.asarray(C, dtype=float)

        number = min(instants, MOST_INSTANTS)
        return forecast_by(after, held, trajectory.duration, number)

    def _runs(
        self, trajectory: Trajectory, held: Held, seed: int
    ) -> tuple[TorqueSamples, TorqueSamples]:
        """What is expected to be recorded, without the object and with it."""
        motion = trajectory.sampled(self.rate)
        states = motion.position, motion.velocity, motion.acceleration
        W = self.dynamics.regressor(*states)
        arm = W @ self.dynamics.arm
        object_ = W[..., -10:] @ (self.dynamics.payload @ held.body.vector)
        rng = np.random.default_rng([seed, 21])
        noise = self.noise * rng.normal(size=(2, *arm.shape))
        return (
            TorqueSamples(motion.time, *states, arm + noise[0]),
            TorqueSamples(motion.time, *states, arm + object_ + noise[1]),
        )


Sensor = WristSensor | JointTorques
"""What is measured, and how well. `gain` is the standard deviation of its gain, an error
that the mass keeps."""


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
