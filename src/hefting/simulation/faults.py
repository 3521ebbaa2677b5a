"""What is wrong with a log (noise, bias, drift, clock, spikes, losses, contacts,
saturation, sign), and its rates."""

from dataclasses import dataclass, fields
from typing import Literal

import numpy as np

from hefting.core.errors import InputError
from hefting.core.measurements import NOISE_LEVELS
from hefting.core.spatial import STANDARD_GRAVITY, Array
from hefting.simulation.wield import POSE_NOISE

Six = tuple[float, float, float, float, float, float]

ZERO: Six = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0)

FT300: Six = (0.1, 0.1, 0.1, 0.005, 0.005, 0.003)
"""Standard deviations of the signal of a Robotiq FT 300 [N (3), N m (3)]; the paper's
moderate level, but about z."""

WRENCH_NOISE: dict[str, Six] = {
    **{
        name: (n.force, n.force, n.force, n.torque, n.torque, n.torque)
        for name, n in NOISE_LEVELS.items()
    },
    "ft300": FT300,
}
"""Standard deviations of wrench noise by name [N (3), N m (3)]: the paper's levels, and
a sensor's."""

SHARES = ("spikes", "dropped", "contacts", "pose_glitches", "pose_stalls")


@dataclass(frozen=True)
class Faults:
    """Imperfections of sensor, clock and surroundings; by default those of a well-kept
    cobot, and no wrench noise. Pairs are of position [m] and orientation [rad], or of
    force [N] and torque [N m], along each axis; levels of noise are standard
    deviations.

    All but the sign, bias and drift are random, each from a generator of its own: to
    add one leaves the others as they were. Raises `InputError` for values out of range.
    """

    wrench_noise: Six = ZERO
    """standard deviations [N (3), N m (3)]"""
    noise_correlation: float = 0.0
    """of the wrench noise from sample to sample: 0 white, near 1 slow (first-order
    autoregressive)"""
    pose_noise: tuple[float, float] = POSE_NOISE
    """standard deviations per axis of position [m] and orientation [rad]"""
    pose_glitches: float = 0.0
    """share of poses that are wrong"""
    pose_glitch_size: tuple[float, float] = (0.3, 1.0)
    """their standard deviation per axis of position [m] and orientation [rad]"""
    pose_glitch_duration: float = 0.0
    """how long each of them lasts [s]; a single pose by default"""
    pose_stalls: float = 0.0
    """share of the time that the last pose is repeated, in three stalls"""
    pose_startup: float = 0.0
    """time at the start during which the pose is the identity [s]"""
    pose_shutdown: float = 0.0
    """the same at the end [s]"""
    joint_noise: float = 0.0
    """standard deviation of joint angles [rad]"""
    bias: Six = ZERO
    """of the wrench, as the sensor shows it [N (3), N m (3)]"""
    drift: Six = ZERO
    """of the bias, from the start to the end of the motion [N (3), N m (3)]"""
    drift_kind: Literal["linear", "exponential"] = "linear"
    """exponential: it settles, with a time constant of a third of the motion"""
    wrench_delay: float = 0.0
    """the wrench is stamped so much later than the poses [s]"""
    spikes: float = 0.0
    """share of wrench samples that are wrong"""
    spike_size: tuple[float, float] = (20.0, 1.0)
    """their standard deviation per axis [N], [N m]"""
    dropped: float = 0.0
    """share of messages of every kind that are lost"""
    contacts: float = 0.0
    """share of the time that the object touches something, in ten bouts"""
    contact_force: tuple[float, float] = (3.0, 8.0)
    """lowest and highest force of a contact [N]"""
    saturation: tuple[float, float] | None = None
    """largest force and torque the sensor shows, per axis [N], [N m]"""
    on_sensor: bool = False
    """the sensor shows the wrench exerted on itself, the opposite of the project's
    sign"""
    gyroscope_noise: float = 0.005
    """standard deviation per axis [rad/s]"""
    gyroscope_bias: tuple[float, float, float] = (0.0, 0.0, 0.0)
    """[rad/s]"""
    accelerometer_noise: float = 0.05
    """standard deviation per axis [m/s²]"""
    accelerometer_bias: tuple[float, float, float] = (0.0, 0.0, 0.0)
    """[m/s²]"""

    def __post_init__(self):
        for field in fields(self):
            value = getattr(self, field.name)
            if isinstance(value, str | bool) or value is None:
                continue
            numbers = np.asarray(value, dtype=float)
            default = np.asarray((0.0, 0.0) if field.default is None else field.default)
            if numbers.shape != default.shape or not np.isfinite(numbers).all():
                raise InputError(
                    f"{field.name} is {value}, not {max(default.size, 1)} finite number(s)",
                    "Faults",
                )
            signed = "bias" in field.name or field.name in ("drift", "wrench_delay")
            if not signed and (numbers < 0).any():
                what = f"{field.name} is {value}, which is negative"
                raise InputError(what, "Faults")
        if self.drift_kind not in ("linear", "exponential"):
            raise InputError(
                f"drift_kind is '{self.drift_kind}'",
                "Faults",
                "use linear or exponential",
            )
        for name in ("noise_correlation", *SHARES):
            if not getattr(self, name) < 1.0:
                kind = "share" if name in SHARES else "number"
                what = f"{name} is {getattr(self, name)}"
                raise InputError(what, "Faults", f"give a {kind} from 0 to below 1")


@dataclass(frozen=True)
class Rates:
    """How often each sensor is read [Hz]: None as often as the motion was computed, 0
    never.

    Each must divide the rate of the motion: nothing is interpolated.
    """

    wrench: float | None = None
    pose: float | None = None
    joints: float | None = 0.0
    imu: float | None = 0.0

    def stride(self, name: str, own: float) -> int:
        """Every how manieth sample of a motion of rate `own` [Hz] is read; 0 for
        none."""
        rate = getattr(self, name)
        if rate is None:
            return 1
        if rate == 0.0:
            return 0
        steps = own / rate if rate > 0.0 else 0.0
        if not (
            np.isfinite(steps)
            and round(steps) >= 1
            and abs(steps - round(steps)) < 1e-6 * steps
        ):
            fix = "compute the motion at a multiple of it"
            raise InputError(
                f"a {name} rate of {rate:g} Hz does not divide the motion's {own:g} Hz",
                fix=fix,
            )
        return round(steps)


def tilted_gravity(
    angle: float, heading: float = 0.0, gravity: tuple[float, ...] = STANDARD_GRAVITY
) -> Array:
    """Gravity (3,) [m/s²] in the axes of a base tilted by `angle` [rad] about its axis
    at `heading` [rad] from x."""
    from scipy.spatial.transform import Rotation

    turn = angle * np.array((np.cos(heading), np.sin(heading), 0.0))
    return Rotation.from_rotvec(turn).inv().apply(np.asarray(gravity, dtype=float))
