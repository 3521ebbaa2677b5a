"""Options of `hefting plan` on the sensor, as values of the library."""

from typing import TYPE_CHECKING, Any

from hefting.core.errors import InputError
from hefting.core.quantity import numbers, quantities

if TYPE_CHECKING:
    from hefting.core.measurements import Noise

RATE = 100.0
"""[Hz] Default rate of the samples that will be recorded."""


def noise_of(a: Any) -> "tuple[Noise | None, float]":
    """Noise of a sample, as given or from a recording (None without either), and the
    rate of the samples [Hz]."""
    from hefting.core.measurements import Noise

    rate = RATE if a.rate is None else a.rate
    if a.sensor_noise is None:
        if a.noise_from is None:
            return None, rate
        noise, own = _noise_of_recording(a)
        return noise, own if a.rate is None else rate
    if a.noise_from is not None:
        what = "is given beside --noise-from"
        raise InputError(what, "--sensor-noise", "leave one of them out")
    kinds = "force", "torque"
    force, torque = quantities(a.sensor_noise, kinds, "--sensor-noise", "0.1N,5mNm")
    if not min(force, torque) > 0.0:
        what = f"'{a.sensor_noise}' has no noise, and every sensor has some"
        raise InputError(what, "--sensor-noise", "as in 0.1N,5mNm")
    return Noise(force, torque), rate


def sensor_range_of(text: str | None) -> tuple[float | None, float | None]:
    """Largest force [N] and torque [N m] along each axis; None, None without limits."""
    if text is None:
        return None, None
    kinds = "force", "torque"
    force, torque = quantities(text, kinds, "--sensor-range", "100N,5Nm")
    if not min(force, torque) > 0.0:
        what = f"'{text}' is no range"
        raise InputError(what, "--sensor-range", "as in 100N,5Nm")
    return force, torque


def torques_of(a: Any) -> bool | float | list[float]:
    """Whether joint torques are measured, and their noise [N m] where it was given.

    Raises `InputError` without a shape, and for options of a wrench sensor.
    """
    if not a.torques:
        if a.torque_noise is not None:
            what = "is for joint torques"
            raise InputError(what, "--torque-noise", "give --torques as well")
        return False
    for name in ("sensor_noise", "noise_from", "sensor_range"):
        if getattr(a, name) is not None:
            option = f"--{name.replace('_', '-')}"
            what = "is of a wrench sensor, not for --torques"
            raise InputError(what, option, "leave it out")
    if a.shape is None and a.box is None:
        what = "joint torques hardly determine an inertia without a shape"
        raise InputError(what, "--torques", "give --shape FILE or --box")
    noise = of_joints(a.torque_noise, "--torque-noise")
    return True if noise is None else noise


def of_joints(text: str | None, option: str) -> float | list[float] | None:
    """One number for all joints, or comma-separated numbers for each; None for None."""
    if text is None:
        return None
    values = numbers(text, text.count(",") + 1, option)
    return values[0] if len(values) == 1 else values


def _noise_of_recording(a: Any) -> "tuple[Noise, float]":
    """Noise and rate [Hz] of a recording of the same sensor; the noise is that of
    uncorrelated samples with as much information."""
    from hefting.core.measurements import Noise
    from hefting.ingest.ingest import ingest
    from hefting.logs import read_log
    from hefting.robots import Robot, with_poses

    recording = read_log(a.noise_from)
    if not recording.has("orientation"):
        recording = with_poses(recording, Robot.from_urdf(a.urdf, a.tip))
    if recording.static:
        what = "static poses do not show how fast the sensor is"
        raise InputError(what, a.noise_from, "give --sensor-noise and --rate")
    found = ingest(recording)
    correlation = max(found.fit.autocorrelation, 1.0) ** 0.5
    time = recording["wrench"].time
    rate = (len(time) - 1) / float(time[-1] - time[0])
    noise = found.noise
    return Noise(correlation * noise.force, correlation * noise.torque), rate
