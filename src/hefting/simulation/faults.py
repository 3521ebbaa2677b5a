"""Faults of a log (noise, bias, drift, clock, spikes, losses, contacts, saturation,
sign), its rates, and the log that a robot would write of a wielding with them."""

from dataclasses import dataclass, fields
from typing import Literal

import numpy as np
from scipy.spatial.transform import Rotation

from hefting.core.errors import InputError
from hefting.core.measurements import NOISE_LEVELS
from hefting.core.recording import Recording, Stream
from hefting.core.spatial import STANDARD_GRAVITY, Array, Mask
from hefting.simulation.wield import POSE_NOISE, Wielding

Six = tuple[float, float, float, float, float, float]

ZERO: Six = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0)

FT300: Six = (0.1, 0.1, 0.1, 0.005, 0.005, 0.003)
"""Standard deviations of the noise of a Robotiq FT 300 [N (3), N m (3)]; the paper's
moderate level, except about z."""

WRENCH_NOISE: dict[str, Six] = {
    **{
        name: (n.force, n.force, n.force, n.torque, n.torque, n.torque)
        for name, n in NOISE_LEVELS.items()
    },
    "ft300": FT300,
}
"""Standard deviations of wrench noise by name [N (3), N m (3)]."""

SHARES = ("spikes", "dropped", "contacts", "pose_glitches", "pose_stalls")
"""Faults that are shares of time or samples."""


@dataclass(frozen=True)
class Faults:
    """Imperfections of sensor, clock and surroundings; by default those of a
    well-maintained cobot without wrench noise. Pairs are of position [m] and orientation
    [rad], or of force [N] and torque [N m], along each axis; levels of noise are standard
    deviations.

    Random faults have a generator each, so that adding one does not change the others.
    Raises `InputError` for values out of range.
    """

    wrench_noise: Six = ZERO
    """standard deviations [N (3), N m (3)]"""
    noise_correlation: float = 0.0
    """correlation of the wrench noise between samples (first-order autoregressive): 0 is
    white, near 1 slow"""
    pose_noise: tuple[float, float] = POSE_NOISE
    """standard deviations per axis of position [m] and orientation [rad]"""
    pose_glitches: float = 0.0
    """share of poses that are wrong"""
    pose_glitch_size: tuple[float, float] = (0.3, 1.0)
    """their standard deviation per axis of position [m] and orientation [rad]"""
    pose_glitch_duration: float = 0.0
    """duration of each [s]; a single pose by default"""
    pose_stalls: float = 0.0
    """share of the time in which the last pose is repeated, in three stalls"""
    pose_startup: float = 0.0
    """time at the start with the identity as pose [s]"""
    pose_shutdown: float = 0.0
    """the same at the end [s]"""
    joint_noise: float = 0.0
    """standard deviation of joint angles [rad]"""
    bias: Six = ZERO
    """of the measured wrench [N (3), N m (3)]"""
    drift: Six = ZERO
    """change of the bias from the start to the end of the motion [N (3), N m (3)]"""
    drift_kind: Literal["linear", "exponential"] = "linear"
    """exponential: with a time constant of a third of the motion"""
    wrench_delay: float = 0.0
    """delay of the wrench's stamps relative to those of the poses [s]"""
    spikes: float = 0.0
    """share of wrench samples that are wrong"""
    spike_size: tuple[float, float] = (20.0, 1.0)
    """their standard deviation per axis [N], [N m]"""
    dropped: float = 0.0
    """share of messages of every kind that are lost"""
    contacts: float = 0.0
    """share of the time in which the object touches something, in ten contacts"""
    contact_force: tuple[float, float] = (3.0, 8.0)
    """lowest and highest force of a contact [N]"""
    saturation: tuple[float, float] | None = None
    """largest measured force and torque per axis [N], [N m]"""
    on_sensor: bool = False
    """whether the wrench is exerted on the sensor, opposite to the project's sign"""
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
                what = f"{field.name} is {value}, not {max(default.size, 1)} finite number(s)"
                raise InputError(what, "Faults")
            signed = "bias" in field.name or field.name in ("drift", "wrench_delay")
            if not signed and (numbers < 0).any():
                what = f"{field.name} is {value}, which is negative"
                raise InputError(what, "Faults")
        if self.drift_kind not in ("linear", "exponential"):
            what = f"drift_kind is '{self.drift_kind}'"
            raise InputError(what, "Faults", "use linear or exponential")
        for name in ("noise_correlation", *SHARES):
            if not getattr(self, name) < 1.0:
                kind = "share" if name in SHARES else "number"
                what = f"{name} is {getattr(self, name)}"
                raise InputError(what, "Faults", f"give a {kind} from 0 to below 1")


@dataclass(frozen=True)
class Rates:
    """Rates of the sensors [Hz]: None is that of the motion, 0 is not recorded. Each must
    divide the rate of the motion, as samples are not interpolated."""

    wrench: float | None = None
    pose: float | None = None
    joints: float | None = 0.0
    imu: float | None = 0.0

    def stride(self, name: str, own: float) -> int:
        """Number of samples of a motion at `own` [Hz] per sample of a sensor; 0 if it is
        not recorded."""
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
            what = (
                f"a {name} rate of {rate:g} Hz does not divide the motion's {own:g} Hz"
            )
            raise InputError(what, fix=fix)
        return round(steps)


def tilted_gravity(angle: float, heading: float) -> Array:
    """Gravity (3,) [m/s²] in the axes of a base tilted by `angle` [rad] about its axis
    at `heading` [rad] from x."""
    turn = angle * np.array((np.cos(heading), np.sin(heading), 0.0))
    return Rotation.from_rotvec(turn).inv().apply(STANDARD_GRAVITY)


STALLS = 3
"""Number of stalls in a recording that has any."""


def with_pose_faults(
    time: Array,
    position: Array,
    orientation: Array,
    faults: Faults,
    rng: np.random.Generator,
) -> tuple[Array, Array]:
    """Positions (K, 3) [m] and quaternions (K, 4) at times (K,) [s] with glitches, stalls
    and identity poses."""
    since = time - time[0]
    position, orientation = position.copy(), orientation.copy()
    for mask in _bouts(since, faults, rng):
        place, turn = rng.normal(size=(2, 3))
        position[mask] += faults.pose_glitch_size[0] * place
        turned = Rotation.from_quat(orientation[mask]) * Rotation.from_rotvec(
            faults.pose_glitch_size[1] * turn
        )
        orientation[mask] = turned.as_quat()
    slot = since[-1] / STALLS
    for stall in range(STALLS if faults.pose_stalls else 0):
        lasts = faults.pose_stalls * slot
        begin = stall * slot + rng.uniform(0.1 * (slot - lasts), slot - lasts)
        held = np.flatnonzero((since >= begin) & (since < begin + lasts))
        if len(held):
            position[held], orientation[held] = position[held[0]], orientation[held[0]]
    silent = (since < faults.pose_startup) | (since > since[-1] - faults.pose_shutdown)
    position[silent], orientation[silent] = 0.0, (0.0, 0.0, 0.0, 1.0)
    return position, orientation


def _bouts(since: Array, faults: Faults, rng: np.random.Generator) -> list[Mask]:
    """Masks (K,) of the glitches, of at least one sample each."""
    if not faults.pose_glitches or len(since) < 2:
        return []
    samples = max(round(faults.pose_glitch_duration * (len(since) - 1) / since[-1]), 1)
    begins = np.flatnonzero(rng.random(len(since)) < faults.pose_glitches / samples)
    rows = np.arange(len(since))
    return [(rows >= begin) & (rows < begin + samples) for begin in begins]


RAMP = 0.05
"""[s] Rise and fall time of a contact, at most half its duration."""

BOUTS = 10
"""Number of contacts in a recording that has any."""

LEVER = 0.10
"""[m] Largest distance of a contact from the centre of mass along each axis."""


def record(
    wielding: Wielding, faults: Faults = Faults(), rates: Rates = Rates(), seed: int = 0
) -> Recording:
    """The log of a wielding, the same for the same `seed`.

    The wrench is, in this order: exact, less the wrench of contacts on the object; of the
    sensor's sign; with bias, drift, noise and spikes; saturated; without lost messages;
    delayed. Streams are ``wrench``, ``position`` and ``orientation``, and,
    at rates that are not 0, ``joint_positions``, ``gyroscope`` and ``accelerometer``
    (of an IMU at the sensor's origin). Raises `InputError` for rates that do not divide
    that of the motion.
    """
    time = wielding.motion.time
    own = (len(time) - 1) / (time[-1] - time[0]) if len(time) > 1 else 1.0
    # one generator for each purpose, so that a fault does not change the others
    draws = {name: np.random.default_rng([seed, i]) for i, name in enumerate(PURPOSES)}
    streams: dict[str, Stream] = {}

    def add(name: str, values: Array, kind: str, delay: float = 0.0) -> None:
        stride = rates.stride(kind, own)
        if stride:
            mask = kept[kind][::stride]
            streams[name] = Stream(time[::stride][mask] + delay, values[::stride][mask])

    kept = {
        kind: draws[f"lost {kind}"].random(len(time)) >= faults.dropped
        for kind in KINDS
    }
    for mask in kept.values():
        mask[0] = True  # a log has a first message
    z = wielding.measurements
    stride = rates.stride("wrench", own)
    if stride:
        index = slice(None, None, stride)
        wrench = np.zeros((len(time), 6))
        wrench[index] = _wrench(
            z.wrench[index],
            _push(wielding, faults, draws["contacts"])[index],
            time[index],
            faults,
            draws,
        )
        add("wrench", wrench, "wrench", faults.wrench_delay)
    position, orientation = with_pose_faults(
        time, *_pose(wielding, faults, draws["pose"]), faults, draws["pose faults"]
    )
    add("position", position, "pose")
    add("orientation", orientation, "pose")
    angles = wielding.joints.position
    add(
        "joint_positions",
        angles + faults.joint_noise * draws["joints"].normal(size=angles.shape),
        "joints",
    )
    gyroscope = z.angular_velocity + faults.gyroscope_noise * draws["gyroscope"].normal(
        size=(len(time), 3)
    )
    add("gyroscope", gyroscope + faults.gyroscope_bias, "imu")
    force = (
        z.linear_acceleration
        - z.gravity
        + faults.accelerometer_noise
        * draws["accelerometer"].normal(size=(len(time), 3))
    )
    add("accelerometer", force + faults.accelerometer_bias, "imu")
    names = wielding.arm.robot.joints if "joint_positions" in streams else ()
    return Recording(streams, source="simulation", joint_names=names)


KINDS = ("wrench", "pose", "joints", "imu")
PURPOSES = (
    "noise", "spikes", "contacts", "pose", "joints", "gyroscope", "accelerometer", *(f"lost {kind}" for kind in KINDS),
    "pose faults",
)  # fmt: skip


def _wrench(
    exact: Array,
    push: Array,
    time: Array,
    faults: Faults,
    draws: dict[str, np.random.Generator],
) -> Array:
    """(K, 6) measured wrench [N, N m]."""
    wrench = (exact - push) * (-1.0 if faults.on_sensor else 1.0)
    passed = (time - time[0]) / max(time[-1] - time[0], 1e-12)
    if faults.drift_kind == "exponential":
        passed = np.expm1(-3.0 * passed) / np.expm1(-3.0)
    wrench = wrench + faults.bias + passed[:, None] * np.asarray(faults.drift)
    white = draws["noise"].normal(size=wrench.shape)
    noise = correlated(white, faults.noise_correlation)
    wrench = wrench + np.asarray(faults.wrench_noise) * noise
    wrong = draws["spikes"].random(len(wrench)) < faults.spikes
    jumps = np.repeat(faults.spike_size, 3) * draws["spikes"].normal(size=wrench.shape)
    wrench = wrench + wrong[:, None] * jumps
    if faults.saturation is not None:
        most = np.repeat(faults.saturation, 3)
        wrench = np.clip(wrench, -most, most)
    return wrench


def correlated(white: Array, a: float) -> Array:
    """Noise (K, n) with correlation `a` between samples, from white noise of the same
    standard deviation."""
    from scipy.signal import lfilter

    start = white[:1] * a  # stationary from the start
    shaped = lfilter([np.sqrt(1.0 - a * a)], [1.0, -a], white, axis=0, zi=start)
    return np.asarray(shaped[0]) if a else white


def _push(wielding: Wielding, faults: Faults, rng: np.random.Generator) -> Array:
    """(K, 6) force [N] and torque [N m] of contacts on the object, in sensor axes about
    the sensor's origin."""
    time = wielding.motion.time - wielding.motion.time[0]
    push = np.zeros((len(time), 6))
    if not faults.contacts:
        return push
    slot = (time[-1] + (time[1] - time[0] if len(time) > 1 else 1.0)) / BOUTS
    lasts = faults.contacts * slot
    for bout in range(BOUTS):
        begin = bout * slot + rng.uniform(0.0, slot - lasts)
        since = time - begin
        inside = (since > 0.0) & (since < lasts)
        ramp = min(RAMP, 0.5 * lasts)
        share = np.clip(np.minimum(since, lasts - since) / ramp, 0.0, 1.0)
        envelope = np.where(inside, 0.5 - 0.5 * np.cos(np.pi * share), 0.0)[:, None]
        force = rng.normal(size=3)
        force *= rng.uniform(*faults.contact_force) / np.linalg.norm(force)
        where = wielding.body.center_of_mass + rng.uniform(-LEVER, LEVER, 3)
        push += envelope * np.concatenate((force, np.cross(where, force)))
    return push


def _pose(
    wielding: Wielding, faults: Faults, rng: np.random.Generator
) -> tuple[Array, Array]:
    """Position (K, 3) and orientation (K, 4) with noise."""
    motion = wielding.motion
    place, turn = rng.normal(size=(2, len(motion.time), 3))
    turned = Rotation.from_matrix(motion.rotation) * Rotation.from_rotvec(
        faults.pose_noise[1] * turn
    )
    return motion.position + faults.pose_noise[0] * place, turned.as_quat()
