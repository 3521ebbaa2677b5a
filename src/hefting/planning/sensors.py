"""The sensors of a planned motion, wrench at the tip or torques of the joints, and the
accuracy to expect: that of the estimator on simulated recordings with random noise."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any, Self, TypeGuard

import numpy as np
from numpy.typing import ArrayLike

from hefting.core.errors import HeftingError, InputError
from hefting.core.estimate import Estimate
from hefting.core.gravity import ON_EARTH
from hefting.core.measurements import NOISE_LEVELS, MotionNoise, Noise
from hefting.core.messages import Message, note
from hefting.core.recording import Recording, Stream
from hefting.core.spatial import STANDARD_GRAVITY, Array, frozen, immutable
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
"""Errors of the accelerations from smoothed poses with 0.1 mm and 0.02° of noise at 100
Hz, as found on plans of 10 s for three arms."""
MOST_NOISE = 1e3
"""[N], [N m] Noise of an estimate's recording from which on it is ignored."""
POSE_NOISE = (1e-4, 3.5e-4)
"""Standard deviations along each axis of position [m] and orientation [rad] in the poses
of a cobot."""
GAIN = 0.0025
"""Standard deviation of the gain of a typical wrench sensor
(`hefting.core.sensor_accuracy.TYPICAL`), an error that recordings share."""
LARGEST_SHARE = 0.95
"""Largest share of an estimate's variance that is attributed to a shared error."""
FIRST_NOISE, LAST_NOISE = 0.1, 0.05
"""[N m] Default standard deviations of the noise of the first and the last joint; those
between are interpolated by their logarithm."""
NOISES = 3
"""Number of noise draws over which the final forecast is averaged: between single draws
an inertia's half-width varies by some 12 %."""
MOST_INSTANTS = 6
"""Largest number of instants of a forecast for joint torques: each takes some tenths of a
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
    """about noise that was not given"""
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
        """Sensor with the given noise, that of the estimate's recording, or a moderate
        one. `InputError` for noise that is not positive."""
        chain = Chain.of(robot, gravity)
        if noise is not None:
            if not (noise.force > 0.0 and noise.torque > 0.0):
                raise InputError("the noise of force and torque must be positive")
            return cls(robot, chain, noise, rate)
        levels = NOISE_LEVELS["moderate"]
        what = f"noise taken to be {levels.force:g} N and {levels.torque:g} N m"
        recorded = None if estimate is None else estimate.provenance.get("noise")
        if isinstance(recorded, dict):
            force, torque = (recorded.get(name) for name in ("force", "torque"))
            if _is_level(force) and _is_level(torque):
                levels = Noise(force, torque)
                what = f"noise as of the estimate: {force:.3g} N, {torque:.3g} N m"
        notes = (note("plan-noise-assumed", what, "noise"),)
        return cls(robot, chain, levels, rate, notes)

    @property
    def levels(self) -> dict[str, Any]:
        """Standard deviations of the noise [N], [N m]."""
        return {"force": self.noise.force, "torque": self.noise.torque}

    def information(self, vector: Array) -> Information:
        """Information by samples whose errors include those of the accelerations, for a
        body of parameters (10,)."""
        covariance = noise_covariance(self.noise, MOTION_NOISE, vector, self.rate)
        return Information.of(covariance, self.rate)

    def kept(self, held: Held) -> Array:
        """(10, 10) covariance of errors that no motion reduces: by the gain, now and when
        the tool was identified."""
        tool = GAIN * held.tool
        both = GAIN * held.body.vector + tool
        return np.outer(both, both) + np.outer(tool, tool)

    def forecast(
        self, trajectory: Trajectory, instants: int, held: Held, seed: int
    ) -> Forecast:
        """Forecast by `identify` with simulated recordings; the bias is estimated unless
        the estimate's recording had none or a known one."""
        recordings = [
            self._recording(trajectory, held, [seed, 20 + 2 * k]) for k in range(NOISES)
        ]
        shape = None if held.estimate is not None else held.shape
        gravity = self.chain.gravity
        if np.array_equal(gravity, STANDARD_GRAVITY):
            gravity = ON_EARTH
        earlier_bias = held.estimate and held.estimate.provenance.get("bias")
        bias = "auto" if earlier_bias in ("none", "given") else "estimate"

        def after(duration: float, before: Array | None) -> Array | None:
            drawn = NOISES if duration == trajectory.duration else 1
            each = [by_one(drawing, duration, before) for drawing in recordings[:drawn]]
            known = [C for C in each if C is not None]
            return np.mean(known, axis=0) if len(known) == drawn else before

        def by_one(
            recording: Recording, duration: float, before: Array | None
        ) -> Array | None:
            try:
                result = identify(
                    recording, shape, duration=duration, gravity=gravity, bias=bias
                )
            except HeftingError:
                return before
            C = result.estimate.covariance
            if held.estimate is None:
                return C
            if C is None or not np.isfinite(C).all():
                return before
            # the estimate includes gain errors of object with tool, and of the tool's
            # recording; the simulated recording has no tool
            body, tool = GAIN * held.body.vector, GAIN * held.tool
            earlier = _without(_without(held.information, body + tool), tool)
            new = _without(np.asarray(np.linalg.inv(C), float), body)
            return np.linalg.inv(earlier + new) + self.kept(held)

        return forecast_by(after, held, trajectory.duration, instants)

    def _recording(
        self, trajectory: Trajectory, held: Held, seed: Sequence[int]
    ) -> Recording:
        """A simulated recording of poses and wrench, with noise of a seed."""
        from scipy.spatial.transform import Rotation

        motion = trajectory.sampled(self.rate)
        states = motion.position, motion.velocity, motion.acceleration
        tip = self.chain.forward(*states).motion
        wrench = expected_wrench(features(tip), held.body.vector).T
        rng = np.random.default_rng(seed)
        position, orientation = self.robot.poses(motion.position)
        shift, turn, noise = rng.normal(size=(3, len(position), 6))
        levels = np.repeat((self.noise.force, self.noise.torque), 3)
        turned = Rotation.from_quat(orientation) * Rotation.from_rotvec(
            POSE_NOISE[1] * turn[:, :3]
        )
        streams = {
            "position": position + POSE_NOISE[0] * shift[:, :3],
            "orientation": turned.as_quat(),
            "wrench": wrench + levels * noise,
        }
        return Recording(
            {name: Stream(motion.time, own) for name, own in streams.items()},
            source="plan",
        )


def _without(information: Array, shared: Array) -> Array:
    """Information (10, 10) with a `shared` error s (10,) of unit variance removed from
    the covariance C, (C - p s s')^-1 by Sherman and Morrison, where p <= 1 is such that
    at most `LARGEST_SHARE` of a variance is removed."""
    image = information @ shared
    share = float(shared @ image)
    part = min(1.0, LARGEST_SHARE / max(share, 1e-300))
    return information + part / (1.0 - part * share) * np.outer(image, image)


def _is_level(value: object) -> TypeGuard[float]:
    """Whether a value from a file can be a standard deviation."""
    return isinstance(value, float | int) and 0.0 < value < MOST_NOISE


def refuse_of_torques(
    shape: object, noise: object, force: object, torque: object, stop_and_go: bool
) -> None:
    """`InputError` for arguments that joint torques do not allow."""
    given = {"noise": noise, "force": force, "torque": torque}
    for name, value in given.items():
        if value is not None:
            what = "it is of a wrench sensor, and `torques` are of the joints"
            raise InputError(what, f"`{name}`", "leave it out")
    if stop_and_go:
        what = "torques of joints at rest are of no use: their friction follows no law there"
        raise InputError(what, "`stop_and_go`", "plan a motion")
    if shape is None:
        what = "joint torques hardly determine an inertia without a shape"
        raise InputError(what, fix="give `shape`")


@immutable
class JointTorques:
    """Measured torques of n joints, of an arm without a wrench sensor."""

    dynamics: JointDynamics
    noise: Array
    """(n,) standard deviations [N m]"""
    rate: float
    """of the samples [Hz]"""
    notes: tuple[Message, ...] = ()
    """assumptions"""
    gain = 0.0
    """no common one: the forecast includes gains of the joints"""

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
        """Torques with the given noise, that of the estimate's recording, or a default
        one. Raises `InputError` for noise that is not positive or of n joints, and as
        `JointDynamics.from_urdf`."""
        dynamics = JointDynamics.from_urdf(urdf, tip, gravity)
        noise, assumed = _noise(given, estimate, dynamics.joints)
        what = (
            "expected with an empty run of the same motion, which shows arm and "
            "friction: play it without the object as well"
        )
        notes = (*assumed, note("plan-empty-run-assumed", what, "torques"))
        return cls(dynamics, frozen(noise), rate, notes)

    @property
    def levels(self) -> dict[str, Any]:
        """Standard deviations [N m]."""
        return {"joint_torques": self.noise.tolist()}

    def information(self, vector: Array) -> JointInformation:
        """Information by the difference of a loaded and an empty run, with twice the
        variance of the noise."""
        return JointInformation(2.0**0.5 * self.noise, self.rate)

    def kept(self, held: Held) -> Array:
        """(10, 10) zero: the forecast includes the gains of the joints."""
        return np.zeros((10, 10))

    def forecast(
        self, trajectory: Trajectory, instants: int, held: Held, seed: int
    ) -> Forecast:
        """Forecast by `hefting.identification.by_torques` with a simulated run without
        the object and one with it, by the arm's published inertias."""
        empty, loaded = self._runs(trajectory, held, seed)

        def after(duration: float, before: Array | None) -> Array | None:
            part = slice(int(np.searchsorted(empty.time, duration + 1e-9)))
            try:
                runs = (loaded[part],), (empty[part],)
                fitted = LoadedRuns(self.dynamics, *runs).fit()
                if held.estimate is None:
                    state = fitted.state
                    result = ByTorques(
                        self.dynamics, fitted, (), False, state.samples, state.duration
                    )
                    return result.estimate(held.shape).covariance
            except (HeftingError, np.linalg.LinAlgError):
                return before
            A = fitted.state.factor[:, :10]
            C = np.linalg.inv(held.information + A.T @ A)
            return np.asarray(C, dtype=float)

        number = min(instants, MOST_INSTANTS)
        return forecast_by(after, held, trajectory.duration, number)

    def _runs(
        self, trajectory: Trajectory, held: Held, seed: int
    ) -> tuple[TorqueSamples, TorqueSamples]:
        """Simulated runs without and with the object."""
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
"""A sensor and its noise. `gain` is the standard deviation of its gain, an error of the
mass that no motion reduces."""


def _noise(
    given: bool | ArrayLike, estimate: Estimate | None, joints: int
) -> tuple[Array, tuple[Message, ...]]:
    """Standard deviations (n,) [N m], and a note if they were not given."""
    if given is not True:
        return _given(given, joints), ()
    recorded = None if estimate is None else estimate.provenance.get("torque_noise")
    if isinstance(recorded, (list, tuple)) and len(recorded) == joints:
        noise, of = _given(recorded, joints), "as of the estimate:"
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
