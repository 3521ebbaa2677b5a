"""What will be measured along the motion: the wrench at the tip, or in
`hefting.planning.joint_torques` the torques of the joints."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Protocol, Self, TypeGuard

from hefting.core.errors import InputError
from hefting.core.estimate import Estimate
from hefting.core.measurements import NOISE_LEVELS, MotionNoise, Noise
from hefting.core.messages import Message, note
from hefting.core.spatial import Array
from hefting.planning.forecast import GAIN, Forecaster, WrenchForecaster
from hefting.planning.held import Held
from hefting.planning.information import Information, Tells, noise_covariance
from hefting.planning.kinematics import Chain
from hefting.robots.robot import Robot

MOTION_NOISE = MotionNoise(0.03, 0.085, 0.087)
"""Errors of the accelerations that smoothing the poses of a planned motion leaves, with
0.1 mm and 0.02° of noise at 100 Hz: as found on plans of 10 s for three arms, whose
bandwidth is some 36 rad/s. Those of slower motions are smaller."""
MOST_NOISE = 1e3
"""[N], [N m] Noise of an estimate's recording from which on it is not believed."""


class Sensor(Protocol):
    """What is measured, and how well."""

    @property
    def gain(self) -> float:
        """Standard deviation of its gain, an error that the mass keeps."""
        ...

    @property
    def notes(self) -> tuple[Message, ...]:
        """What was assumed of it."""
        ...

    @property
    def levels(self) -> Any:
        """Of its noise, JSON-ready."""
        ...

    def information(self, vector: Array) -> Tells:
        """What it tells of a body of about these parameters (10,)."""
        ...

    def forecaster(
        self, robot: Robot, chain: Chain, held: Held, seed: int
    ) -> Forecaster:
        """What tells how sure one will be by it."""
        ...


@dataclass(frozen=True, eq=False)
class WristSensor:
    """A force-torque sensor at the tip."""

    noise: Noise
    rate: float
    """of the samples [Hz]"""
    notes: tuple[Message, ...] = ()
    """where the noise was not given"""
    gain: float = GAIN
    """standard deviation"""

    @classmethod
    def of(cls, noise: Noise | None, estimate: Estimate | None, rate: float) -> Self:
        """With a noise that is given, that of the estimate's recording, or a moderate
        one. `InputError` for a noise that is not positive."""
        if noise is not None:
            if not (noise.force > 0.0 and noise.torque > 0.0):
                raise InputError("the noise of force and torque must be positive")
            return cls(noise, rate)
        found = None if estimate is None else estimate.provenance.get("noise")
        if isinstance(found, dict):
            force, torque = (found.get(name) for name in ("force", "torque"))
            if _is_level(force) and _is_level(torque):
                what = f"noise as of the estimate: {force:.3g} N, {torque:.3g} N m"
                told = note("plan-noise-assumed", what, "noise")
                return cls(Noise(force, torque), rate, (told,))
        levels = NOISE_LEVELS["moderate"]
        what = f"noise taken to be {levels.force:g} N and {levels.torque:g} N m"
        return cls(levels, rate, (note("plan-noise-assumed", what, "noise"),))

    @property
    def levels(self) -> dict[str, float]:
        """Standard deviations [N], [N m]."""
        return {"force": self.noise.force, "torque": self.noise.torque}

    def information(self, vector: Array) -> Information:
        """With the errors of the accelerations by a body of ten parameters."""
        covariance = noise_covariance(self.noise, MOTION_NOISE, vector, self.rate)
        return Information.of(covariance, self.rate)

    def forecaster(
        self, robot: Robot, chain: Chain, held: Held, seed: int
    ) -> WrenchForecaster:
        """By `hefting.identify`."""
        return WrenchForecaster(robot, chain, held, self.noise, self.rate, seed)


def _is_level(value: object) -> TypeGuard[float]:
    """Whether a value that was read from a file can be a standard deviation."""
    return isinstance(value, float | int) and 0.0 < value < MOST_NOISE
