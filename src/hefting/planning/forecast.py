"""How sure one will be: what the estimator says of the recording that a motion is
expected to give."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from hefting.core.accuracy import Accuracy
from hefting.core.errors import HeftingError
from hefting.core.estimate import NORMAL_95, com_jacobian
from hefting.core.gravity import ON_EARTH
from hefting.core.inertia import InertialParameters
from hefting.core.measurements import Noise
from hefting.core.recording import Recording, Stream
from hefting.core.spatial import STANDARD_GRAVITY, Array, frozen, vector_to_tensor
from hefting.estimators import Bayes
from hefting.identification import identify
from hefting.planning.held import Held
from hefting.planning.information import expected_wrench, features
from hefting.planning.kinematics import Chain
from hefting.planning.result import Forecast
from hefting.planning.trajectory import Trajectory
from hefting.robots.robot import Robot

INSTANTS = {"full": 10, "next": 6, "quick": 2}
"""At which is told how sure one is expected to be, besides before the motion."""
SHORTEST = 1.0
"""[s] of a recording from which something is expected."""
POSE_NOISE = (1e-4, 3.5e-4)
"""Standard deviations along each axis of position [m] and orientation [rad] of the poses
that a cobot reports."""
GAIN = 0.0025
"""Standard deviation of a sensor's gain, of which nothing is said
(`hefting.core.sensor_accuracy.TYPICAL`): an error that two recordings share."""
LARGEST_SHARE = 0.95
"""Share of an estimate's variance that is taken to be the sensor's gain at most."""
DRAWS = 1000
"""Draws from a covariance for an accuracy."""
LEVEL = 0.95


class Forecaster(Protocol):
    """Tells how sure one will be."""

    def forecast(self, trajectory: Trajectory, instants: int) -> Forecast:
        """Before the motion, and at so many instants of it."""
        ...


def forecast_by(
    after: Callable[[float, Array | None], Array | None],
    held: Held,
    duration: float,
    instants: int,
) -> Forecast:
    """Before a motion of `duration` [s], and at so many instants of it.

    `after` gives the covariance (10, 10) after so long a part of the motion [s], from
    that before it; None stands for next to nothing.
    """
    times = np.linspace(min(SHORTEST, 0.5 * duration), duration, instants)
    if instants <= 2:
        times = times[-1:]
    before = _before(held)
    known = [before, *(after(t, before) for t in times)]
    accuracies = [_accuracy(C, held.body) for C in known]
    widths = [NORMAL_95 * _deviations(C, held.body) for C in known]
    return Forecast(
        frozen([0.0, *times]),
        frozen([own[0] for own in widths]),
        frozen([own[1:4] for own in widths]),
        frozen([vector_to_tensor(own[4:]) for own in widths]),
        tuple(accuracies),
    )


@dataclass(frozen=True, eq=False)
class WrenchForecaster:
    """By `identify`, of the wrench that is expected."""

    robot: Robot
    chain: Chain
    held: Held
    noise: Noise
    rate: float
    """of wrench and poses [Hz]"""
    seed: int

    def forecast(self, trajectory: Trajectory, instants: int) -> Forecast:
        """Before the motion, and at so many instants of it."""
        recording = self.recording(trajectory)

        def after(duration: float, before: Array | None) -> Array | None:
            return self._after(recording, duration, before)

        return forecast_by(after, self.held, trajectory.duration, instants)

    def recording(self, trajectory: Trajectory) -> Recording:
        """What a robot's log is expected to hold, with seeded noise."""
        from scipy.spatial.transform import Rotation

        motion = trajectory.sampled(self.rate)
        tip = self.chain.forward(
            motion.position, motion.velocity, motion.acceleration
        ).motion
        wrench = expected_wrench(features(tip), self.held.body.vector).T
        rng = np.random.default_rng([self.seed, 20])
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

    def _after(
        self, recording: Recording, duration: float, before: Array | None
    ) -> Array | None:
        """(10, 10) covariance after so long a part of the motion [s]; what is known
        now where that part tells nothing."""
        shape = None if self.held.estimate is not None else self.held.shape
        standard = np.array_equal(self.chain.gravity, STANDARD_GRAVITY)
        gravity = ON_EARTH if standard else self.chain.gravity
        try:
            found = identify(recording, shape, duration=duration, gravity=gravity)
        except HeftingError:
            return before
        C = found.estimate.covariance
        if self.held.estimate is None or C is None or not np.isfinite(C).all():
            return C if self.held.estimate is None else before
        shared = GAIN * self.held.body.vector
        both = _without(self.held.information, shared)
        both = both + _without(np.asarray(np.linalg.inv(C), float), shared)
        return np.linalg.inv(both) + np.outer(shared, shared)


def _before(held: Held) -> Array | None:
    """(10, 10) covariance of what is known now; None where next to nothing is."""
    if held.estimate is not None:
        return np.asarray(held.estimate.covariance)
    if held.shape is None:
        return None
    return Bayes(held.shape).prior_covariance(held.body.mass)


def _without(information: Array, shared: Array) -> Array:
    """Information (10, 10) without an error `shared` (10,) of unit variance, as far as
    its covariance has it: (C - s s')^-1 by Sherman and Morrison."""
    seen = information @ shared
    share = float(shared @ seen)
    part = min(1.0, LARGEST_SHARE / max(share, 1e-300))
    return information + part / (1.0 - part * share) * np.outer(seen, seen)


def _deviations(C: Array | None, body: InertialParameters) -> Array:
    """(10,) standard deviations of mass, COM and inertia about it; infinite where
    nothing is known."""
    if C is None:
        return np.full(10, np.inf)
    finite = np.where(np.isfinite(C), C, 0.0)
    J = com_jacobian(body)
    variances = np.einsum("ip,pq,iq->i", J, finite, J)
    open_ones = (J**2) @ np.where(np.isfinite(C.diagonal()), 0.0, 1.0) > 0.0
    return np.where(open_ones, np.inf, np.sqrt(np.maximum(variances, 0.0)))


def _accuracy(C: Array | None, body: InertialParameters) -> Accuracy:
    """What errors do not exceed with probability `LEVEL`."""
    if C is None or not np.isfinite(C).all():
        return Accuracy(np.inf, np.inf, np.inf)
    values, vectors = np.linalg.eigh(C)
    half = vectors * np.sqrt(np.maximum(values, 0.0))
    normal = np.random.default_rng(0).standard_normal((DRAWS, 10))
    return Accuracy.of_draws(body.vector + normal @ half.T, body, LEVEL)
