"""Simulated recordings in which the object changes, and clean ones.

A UR5 holds a box, along smooth random motion, trapezoid moves, stop-and-go motion or at
rest. In a recording with an event the body changes once, or something touches it for a
while; in the others sensor and clock have faults, or none.
"""

from dataclasses import dataclass, replace

import numpy as np
from scipy.signal import butter, lfilter
from scipy.spatial.transform import Rotation

from hefting.core.inertia import InertialParameters
from hefting.core.recording import Recording
from hefting.core.spatial import Array, skew
from hefting.simulation import (
    UR5,
    WRENCH_NOISE,
    Faults,
    JointMotion,
    Wielding,
    random_smooth,
    record,
    stop_and_go,
    trapezoids,
    wield_analytically,
)

EVENTS = ("picked-up", "put-down", "swapped", "slipped", "touched")
"""What happens once in a recording."""
CLEAN = ("clean", "drift", "settling", "offset", "spikes", "coloured")
"""Recordings without an event: perfect ones, and those with faults that ingest puts
right."""
MISFITS = ("turned", "flipped", "units", "tilted", "filtered", "late")
"""Recordings without an event that no single body explains, as something else is
wrong."""
MOTIONS = ("random", "trapezoids", "stop and go", "rest")
LEVELS = ("low", "moderate", "high")
"""Names of the wrench noise in `hefting.simulation.WRENCH_NOISE`."""
RATE = 100.0
"""[Hz]"""
DURATIONS = (6.0, 20.0)
"""[s] Shortest and longest recording."""
MASSES = (0.05, 5.0)
"""[kg] Lightest and heaviest object; their logarithms are evenly spread."""
SLIPS = (0.015, 0.05)
"""[m] Shortest and longest way of a slip."""
PUSHES = (2.0, 10.0)
"""[N] Smallest and largest force of a touch."""
TOUCH = (1.0, 0.55)
"""Shortest touch [s] and longest, as a share of the recording."""
TRANSITION = (0.0, 0.2)
"""[s] Shortest and longest time in which the wrench goes over from one body's to the
other's."""
RATIOS = (1.2, 4.0)
"""Smallest and largest ratio of the masses of two objects that are swapped."""


@dataclass(frozen=True, eq=False)
class Case:
    """A recording and what happened in it."""

    kind: str
    """one of `EVENTS`, `CLEAN` or `MISFITS`"""
    motion: str
    level: str
    biased: bool
    recording: Recording
    time: float | None
    """[s] at which the event begins, from the start; None where there is none"""
    end: float | None = None
    """[s] at which a touch ends"""
    bodies: tuple[InertialParameters, ...] = ()
    """before and after the event"""


def case(kind: str, seed: int) -> Case:
    """A random recording of a kind, the same for the same seed."""
    rng = np.random.default_rng([seed, *kind.encode()])
    motion = MOTIONS[rng.integers(len(MOTIONS))]
    level = LEVELS[rng.integers(len(LEVELS))]
    biased = bool(rng.random() < 0.5)
    duration = float(rng.uniform(*DURATIONS))
    joints = moved(motion, duration, int(rng.integers(1 << 30)))
    faults = Faults(wrench_noise=WRENCH_NOISE[level])
    if biased:
        faults = replace(faults, bias=_six(rng, 10.0, 0.5))
    before, after = _bodies(kind, rng)
    wielding = wield_analytically(UR5, joints, before)
    if kind not in EVENTS:
        faults = _faulty(kind, faults, rng)
        log = record(wielding, faults, seed=int(rng.integers(1 << 30)))
        log = _misread(kind, log, rng)
        return Case(kind, motion, level, biased, log, None, bodies=(before,))
    time = float(rng.uniform(0.2, 0.8) * duration)
    end = None
    if kind == "touched":
        end = min(
            time + float(rng.uniform(TOUCH[0], TOUCH[1] * duration)), 0.95 * duration
        )
        changed = _touched(wielding, time, end, rng)
    else:
        other = wield_analytically(UR5, joints, after).measurements
        share = _passed(wielding.motion.time, time, float(rng.uniform(*TRANSITION)))
        z = wielding.measurements
        changed = z.wrench + share[:, None] * (other.wrench - z.wrench)
    z = replace(wielding.measurements, force=changed[:, :3], torque=changed[:, 3:])
    log = record(
        replace(wielding, measurements=z), faults, seed=int(rng.integers(1 << 30))
    )
    return Case(kind, motion, level, biased, log, time, end, (before, after))


def moved(motion: str, duration: float, seed: int) -> JointMotion:
    """Joint motion of one of `MOTIONS`."""
    rng = np.random.default_rng(seed)
    if motion == "random":
        return random_smooth(duration, RATE, float(rng.uniform(0.5, 1.5)), seed=seed)
    if motion == "trapezoids":
        return trapezoids(duration, RATE, seed=seed)
    joints = stop_and_go(duration, RATE, seed=seed)
    if motion == "stop and go":
        return joints
    still = np.zeros_like(joints.velocity)
    return JointMotion(
        joints.time,
        np.tile(joints.position[len(still) // 2], (len(still), 1)),
        still,
        still,
    )


def random_box(rng: np.random.Generator) -> InertialParameters:
    """A homogeneous box of random mass, sides and grasp, in the sensor frame."""
    mass = float(np.exp(rng.uniform(*np.log(MASSES))))
    # of the density of wood to that of metal with holes
    volume = mass / float(np.exp(rng.uniform(*np.log((500.0, 3000.0)))))
    sides = np.exp(rng.uniform(-0.7, 0.7, 3))
    sides *= (volume / sides.prod()) ** (1.0 / 3.0)
    aside = rng.normal(size=3)
    center = aside / np.linalg.norm(aside) * rng.uniform(0.03, 0.12)
    square = np.square(sides)
    return InertialParameters.from_com(
        mass, center, np.diag(mass / 12.0 * (square.sum() - square))
    )


def _bodies(
    kind: str, rng: np.random.Generator
) -> tuple[InertialParameters, InertialParameters]:
    """What is on the sensor before and after the event: a gripper of a tenth of the
    object's mass, with the object where it is held."""
    held = random_box(rng)
    tool = random_box(rng)
    gripper = InertialParameters(0.1 * held.mass / tool.mass * tool.vector)
    if kind == "picked-up":
        return gripper, gripper + held
    if kind == "put-down":
        return gripper + held, gripper
    if kind == "swapped":
        other = random_box(rng)
        ratio = np.exp(rng.uniform(*np.log(RATIOS)) * rng.choice((-1.0, 1.0)))
        mass = float(np.clip(ratio * held.mass, *MASSES))
        return held, InertialParameters(mass / other.mass * other.vector)
    if kind == "slipped":
        way = rng.normal(size=3)
        way *= rng.uniform(*SLIPS) / np.linalg.norm(way)
        moved = held.moved(
            np.block([[np.eye(3), way[:, None]], [np.zeros((1, 3)), 1.0]])
        )
        return held, moved
    return held, held


def _touched(
    wielding: Wielding, begin: float, end: float, rng: np.random.Generator
) -> Array:
    """(K, 6) wrench with a push on the object, which is constant in world or sensor axes
    but for slow changes of a third of its size."""
    z, time = wielding.measurements, wielding.motion.time
    force = rng.normal(size=3)
    force *= rng.uniform(*PUSHES) / np.linalg.norm(force)
    slow = (
        1.0
        + np.sin(
            2.0 * np.pi * rng.uniform(0.3, 1.0, 3) * time[:, None]
            + rng.uniform(0.0, 6.0, 3)
        )
        / 3.0
    )
    pushed = force * slow
    if rng.random() < 0.5:
        pushed = np.einsum("kji,kj->ki", wielding.motion.rotation, pushed)
    place = wielding.body.center_of_mass + rng.uniform(-0.05, 0.05, 3)
    torque = pushed @ skew(place).T
    inside = _passed(time, begin, 0.1) - _passed(time, end, 0.1)
    return z.wrench - inside[:, None] * np.hstack((pushed, torque))


def _passed(time: Array, begin: float, lasts: float) -> Array:
    """(K,) from 0 to 1, smoothly, within `lasts` [s] from `begin` [s] on."""
    share = np.clip((time - begin) / max(lasts, 1e-9), 0.0, 1.0)
    return share * share * (3.0 - 2.0 * share)


def _faulty(kind: str, faults: Faults, rng: np.random.Generator) -> Faults:
    """The faults of a recording without an event."""
    if kind == "drift":
        return replace(faults, drift=_six(rng, 1.0, 0.05))
    if kind == "settling":
        return replace(faults, drift=_six(rng, 1.0, 0.05), drift_kind="exponential")
    if kind == "offset":
        return replace(faults, wrench_delay=float(rng.uniform(-0.1, 0.3)))
    if kind == "late":
        return replace(faults, wrench_delay=0.3)
    if kind == "spikes":
        return replace(faults, spikes=0.01)
    if kind == "coloured":
        return replace(faults, noise_correlation=0.9)
    return faults


def _misread(kind: str, recording: Recording, rng: np.random.Generator) -> Recording:
    """The recording with what `MISFITS` says done to it."""
    stream = recording["wrench"]
    f, t = stream.values[:, :3], stream.values[:, 3:]
    if kind == "turned":
        R = Rotation.from_euler("xyz"[rng.integers(3)], 0.5 * np.pi).as_matrix()
        wrench = np.hstack((f @ R.T, t @ R.T))
    elif kind == "flipped":
        wrench = stream.values * np.tile(1.0 - 2.0 * np.eye(3)[rng.integers(3)], 2)
    elif kind == "units":
        wrench = np.hstack((f, 1e3 * t))
    elif kind == "tilted":
        quaternion = recording["orientation"]
        tilt = Rotation.from_euler("x", np.radians(rng.uniform(5.0, 20.0)))
        turned = (tilt * Rotation.from_quat(quaternion.values)).as_quat()
        return replace(
            recording,
            streams={
                **recording.streams,
                "orientation": replace(quaternion, values=turned),
            },
        )
    elif kind == "filtered":
        b, a = butter(2, rng.uniform(0.5, 3.0) / (0.5 * RATE))
        first = stream.values[0]
        wrench = np.asarray(lfilter(b, a, stream.values - first, axis=0)) + first
    else:
        return recording
    return replace(
        recording,
        streams={**recording.streams, "wrench": replace(stream, values=wrench)},
    )


def _six(
    rng: np.random.Generator, force: float, torque: float
) -> tuple[float, float, float, float, float, float]:
    """Six normal numbers of these standard deviations."""
    a, b, c, d, e, f = (np.repeat((force, torque), 3) * rng.normal(size=6)).tolist()
    return (a, b, c, d, e, f)
