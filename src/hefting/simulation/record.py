"""What a robot's log would hold of a wielding, with everything that is wrong with
sensors."""

import numpy as np
from scipy.spatial.transform import Rotation

from hefting.core.recording import Recording, Stream
from hefting.core.spatial import Array, Mask
from hefting.simulation.faults import Faults, Rates
from hefting.simulation.physics import Wielding

STALLS = 3
"""Number of stalls in a recording that has any."""


def with_pose_faults(
    time: Array,
    position: Array,
    orientation: Array,
    faults: Faults,
    rng: np.random.Generator,
) -> tuple[Array, Array]:
    """Positions (K, 3) [m] and quaternions (K, 4) at times (K,) [s] with the faults of
    their stream, the same for the same generator."""
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
    """Masks (K,) of the glitches, each of at least one sample."""
    if not faults.pose_glitches or len(since) < 2:
        return []
    samples = max(round(faults.pose_glitch_duration * (len(since) - 1) / since[-1]), 1)
    begins = np.flatnonzero(rng.random(len(since)) < faults.pose_glitches / samples)
    rows = np.arange(len(since))
    return [(rows >= begin) & (rows < begin + samples) for begin in begins]


RAMP = 0.05
"""[s] that a contact takes to come and to go, where it lasts that long."""

BOUTS = 10
"""Contacts in a recording that has any."""

LEVER = 0.10
"""m: contacts are within so much of the centre of mass along each axis."""


def record(
    wielding: Wielding,
    faults: Faults = Faults(),  # noqa: B008 (immutable)
    rates: Rates = Rates(),  # noqa: B008 (immutable)
    seed: int = 0,
) -> Recording:
    """The log of a wielding, the same for the same `seed`.

    The wrench is, in this order: exact, less what contacts exert on the object; turned
    to the sensor's sign; with bias, drift, noise and spikes; saturated; thinned by
    losses; stamped late. Streams are ``wrench``, ``position`` and ``orientation``, and,
    at rates that are not 0, ``joint_positions``, ``gyroscope`` and ``accelerometer``
    (of an IMU at the sensor's origin). Raises `InputError` for rates that do not divide
    that of the motion.
    """
    time = wielding.motion.time
    own = (len(time) - 1) / (time[-1] - time[0]) if len(time) > 1 else 1.0
    # one generator for each purpose: what one fault draws does not change the others
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
        mask[0] = True  # a log starts somewhere
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
    """(K, 6) what the sensor shows at each instant."""
    from scipy.signal import lfilter

    shown = (exact - push) * (-1.0 if faults.on_sensor else 1.0)
    passed = (time - time[0]) / max(time[-1] - time[0], 1e-12)
    if faults.drift_kind == "exponential":
        passed = np.expm1(-3.0 * passed) / np.expm1(-3.0)
    shown = shown + faults.bias + passed[:, None] * np.asarray(faults.drift)
    a = faults.noise_correlation
    white = draws["noise"].normal(size=shown.shape)
    if a:
        start = white[:1] * a  # as if it had always run
        white = np.asarray(
            lfilter([np.sqrt(1.0 - a * a)], [1.0, -a], white, axis=0, zi=start)[0]
        )
    shown = shown + np.asarray(faults.wrench_noise) * white
    wrong = draws["spikes"].random(len(shown)) < faults.spikes
    jumps = np.repeat(faults.spike_size, 3) * draws["spikes"].normal(size=shown.shape)
    shown = shown + wrong[:, None] * jumps
    if faults.saturation is not None:
        most = np.repeat(faults.saturation, 3)
        shown = np.clip(shown, -most, most)
    return shown


def _push(wielding: Wielding, faults: Faults, rng: np.random.Generator) -> Array:
    """(K, 6) force [N] and torque [N m] that contacts exert on the object, in sensor
    axes about the sensor origin."""
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
