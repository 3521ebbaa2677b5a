"""Inspection: what a log holds, which conventions it seems to follow, and what can be found from it."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from hefting.calibration import TYPICAL_SIZE, WrenchSign, fit_freely, wrench_sign
from hefting.estimate import json_ready
from hefting.identifiability import Identifiability, identifiability
from hefting.motion import measure
from hefting.motion.measure import DESCRIPTIONS
from hefting.recording import Recording
from hefting.regressor import dynamism
from hefting.spatial import STANDARD_GRAVITY, Array


@dataclass(frozen=True, eq=False)
class Inspection:
    """Findings about a recording."""

    log: str
    duration: float
    """[s]; poses, when static"""
    static: bool
    streams: dict[str, tuple[int, float]]
    """samples and rate [Hz] of each stream"""
    motion: str
    """how velocities and accelerations are found"""
    linear_speed: tuple[float, float] | None
    """mean and largest [m/s], where the position is known"""
    angular_speed: tuple[float, float]
    """mean and largest [rad/s]"""
    dynamism: float
    """median (Nadeau et al. 2022, eq. 4)"""
    sign: WrenchSign
    quick_mass: float
    """mean |f| / |g| [kg], with no regard to bias and motion"""
    mass: float
    """least-squares mass [kg] beside a free bias, where that is determined"""
    bias: Array | None
    """(6,) as recorded [N, N m]; None where the motion cannot tell it from the object"""
    bias_t: Array | None
    """(6,) the bias over its standard deviation"""
    noise: tuple[float, float]
    """root-mean-square residual of force [N] and torque [N m]"""
    identifiability: Identifiability
    """what the motion can tell of an object of `TYPICAL_SIZE`, and why not the rest"""
    advice: tuple[str, ...]
    """what to do next, one sentence each"""
    warnings: tuple[str, ...]

    @property
    def undetermined(self) -> tuple[str, ...]:
        """Parameters the motion leaves open for an object of `TYPICAL_SIZE`."""
        return tuple(self.identifiability.open)

    def to_dict(self) -> dict[str, Any]:
        """JSON-ready values."""
        out = {name: getattr(self, name) for name in self.__dataclass_fields__ if name != "sign"}
        out["streams"] = {k: {"samples": n, "rate": rate} for k, (n, rate) in self.streams.items()}
        out["undetermined"] = self.undetermined
        out["identifiability"] = self.identifiability.to_dict()
        out["wrench"] = "on-object" if self.sign.on_object else "on-sensor"
        out["wrench_t"] = self.sign.t
        return json_ready(out)


def inspect(recording: Recording, gravity: ArrayLike = STANDARD_GRAVITY) -> Inspection:
    """Findings about `recording`, with `gravity` (3,) in world axes [m/s²]. Raises `InputError` as `measure` does."""
    measured = measure(recording, gravity)
    z, motion = measured.measurements, measured.motion
    sign = wrench_sign(z, True)
    fit = fit_freely(z, True)
    determined = not fit.mass_is_open
    if not determined:
        fit = fit_freely(z, False)
    found = identifiability(z, fit, TYPICAL_SIZE)
    mass = abs(float(fit.vector[0]))
    speed = np.linalg.norm(z.angular_velocity if motion is None else motion.angular_velocity, axis=1)
    linear = None
    if recording.has("linear_velocity"):
        linear = np.linalg.norm(recording["linear_velocity"].values, axis=1)
    elif motion is not None and motion.linear_velocity is not None:
        linear = np.linalg.norm(motion.linear_velocity, axis=1)
    return Inspection(
        log=recording.source,
        duration=recording.duration,
        static=recording.static,
        streams={name: (len(stream), recording.rates()[name]) for name, stream in recording.streams.items()},
        motion=DESCRIPTIONS[measured.source],
        linear_speed=None if linear is None else (float(linear.mean()), float(linear.max())),
        angular_speed=(float(speed.mean()), float(speed.max())),
        dynamism=float(np.median(dynamism(z))),
        sign=sign,
        quick_mass=float(np.linalg.norm(z.force, axis=1).mean() / np.linalg.norm(np.asarray(gravity, dtype=float))),
        mass=mass,
        bias=fit.bias,
        bias_t=None if fit.bias is None else fit.bias_t,
        noise=(fit.noise.force, fit.noise.torque),
        identifiability=found,
        advice=_advice(recording.source, sign, determined, found),
        warnings=(*recording.warnings, *measured.warnings),
    )


def _advice(source: str, sign: WrenchSign, determined: bool, found: Identifiability) -> tuple[str, ...]:
    advice = []
    if not determined:
        advice.append("record other orientations: a bias cannot be told from the object's weight in this one")
    if not sign.certain:
        advice.append("the wrench's sign is not certain: give --wrench on-object or on-sensor")
    advice.extend(found.summary)
    if any(name.startswith("J") for name in found.open):
        advice.append("give --shape: it says of the inertia what the motion does not")
    if not advice:
        advice.append(f"ready: hefting identify {source} --shape MESH")
    return tuple(advice)
