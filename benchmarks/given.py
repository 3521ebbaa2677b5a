"""What a user gives: a correct recording, and what a mistake turns it into."""

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from benchmarks.bodies import Body, random_body
from hefting.core.inertia import InertialParameters
from hefting.core.measurements import Measurements
from hefting.core.recording import Recording, Stream
from hefting.core.regressor import predict_wrench
from hefting.core.spatial import STANDARD_GRAVITY, Array
from hefting.shapes import Shape
from hefting.simulation import UR5, random_smooth, sinusoids, stop_and_go
from hefting.simulation.faults import WRENCH_NOISE, Faults, Rates, record
from hefting.simulation.wield import wield_analytically

RATE = 100.0


DURATION = 10.0


BIAS = np.array((2.0, 2.0, 2.0, 0.1, 0.1, 0.1))
"""Typical bias of the sensor [N, N m]."""


KINDS = ("homogeneous", "hollow", "materials", "hammer", "insert")


@dataclass(frozen=True, eq=False)
class Given:
    """What a user gives to `hefting.identify`, and the truth."""

    recording: Recording
    shape: Shape
    truth: InertialParameters
    others: tuple[InertialParameters, ...] = ()
    """bodies that are held at another time"""
    options: dict[str, Any] = field(default_factory=dict)
    """arguments of `hefting.identify` besides"""
    body: Body | None = None
    exact: Measurements | None = None
    """exact motion, from which the wrench of any other body follows"""

    def wrench_of(self, body: Array) -> Array:
        """(K, 6) exact wrench of the ten parameters of a body on the same motion."""
        assert self.exact is not None
        return predict_wrench(self.exact, body)

    def wrench(self, change: Callable[[Array, Array], Array]) -> "Given":
        """With the wrench changed, as a function of time (K,) and wrench (K, 6)."""
        return self.stream("wrench", change)

    def stream(self, name: str, change: Callable[[Array, Array], Array]) -> "Given":
        """With one stream's values changed."""
        stream = self.recording[name]
        changed = Stream(
            stream.time, change(np.array(stream.time), np.array(stream.values))
        )
        streams = {**self.recording.streams, name: changed}
        return replace(self, recording=replace(self.recording, streams=streams))

    def clock(self, change: Callable[[Array], Array], *names: str) -> "Given":
        """With the times of some streams changed."""
        streams = dict(self.recording.streams)
        for name in names:
            streams[name] = Stream(change(streams[name].time), streams[name].values)
        return replace(self, recording=replace(self.recording, streams=streams))


def correct(seed: int, imu: bool = False, noise: str = "moderate") -> Given:
    """A recording without any mistake: a random body of 0.2 to 2.5 kg, ten seconds of
    one of three kinds of motion."""
    rng = np.random.default_rng([15, seed])
    body = random_body(KINDS[seed % len(KINDS)], 90_000 + seed)
    mass = float(np.exp(rng.uniform(np.log(0.2), np.log(2.5))))
    thing = InertialParameters(body.parameters.vector * mass / body.parameters.mass)
    speed = float(rng.uniform(0.7, 2.0))
    joints = (
        sinusoids(DURATION, RATE, speed),
        random_smooth(DURATION, RATE, speed, seed),
        stop_and_go(DURATION, RATE, seed=seed),
    )[seed % 3]
    wielding = wield_analytically(UR5, joints, thing, STANDARD_GRAVITY)
    wrong = Faults(
        wrench_noise=WRENCH_NOISE[noise],
        bias=tuple(BIAS * rng.uniform(-1.0, 1.0, 6)),  # type: ignore[arg-type]
    )
    rates = Rates(imu=RATE if imu else 0.0)
    recording = record(wielding, wrong, rates, seed)
    return Given(recording, body.shape, thing, body=body, exact=wielding.measurements)


Change = Callable[[Given, np.random.Generator], Given]


@dataclass(frozen=True)
class Mistake:
    """One mistake in one strength."""

    name: str
    strength: str
    make: Change
    codes: frozenset[str]
    """codes of messages that name it rightly; empty where no data can tell it"""
    needs_shape: bool = False
    """whether it is a mistake about the shape, so that there is none without one"""
    imu: bool = False


def orientation(given: Given) -> Rotation:
    return Rotation.from_quat(np.array(given.recording["orientation"].values))


def gravity_of(given: Given) -> Array:
    """(K, 3) gravity in sensor axes at the wrench's samples, on the same clock."""
    R = orientation(given)
    return R.inv().apply(np.array(STANDARD_GRAVITY))
