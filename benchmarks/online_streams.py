"""Simulated live streams: everything wrong that is wrong with real ones, and an object
that is swapped.

A UR5 moves smoothly at random and holds a homogeneous box of 0.3 to 2 kg; wrench and
poses come at 100 Hz.
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from benchmarks.changing import random_box
from hefting.core.inertia import InertialParameters
from hefting.core.recording import Recording
from hefting.core.spatial import Array
from hefting.online.samples import Samples
from hefting.simulation import (
    UR5,
    WRENCH_NOISE,
    Faults,
    random_smooth,
    record,
    wield_analytically,
)

RATE = 100.0
"""[Hz]"""
MASSES = (0.3, 2.0)
"""[kg]"""
DELAY = 0.03
"""[s] by which the wrench is late"""
BIAS, DRIFT = 20.0, 0.05
"""[N] Size of the bias; [N/s] of its drift. In N m a twentieth."""
SPIKES = 0.02
"""Share of the wrench samples that are spikes."""
TOUCHES = (0.4, 3.0, 8.0)
"""[s] Length of a touch, smallest and largest force [N]."""
TOUCH_EVERY = 5.0
"""[s]"""
STEPS = (0.05, 0.5)
"""Smallest and largest relative difference of the masses of objects that are
swapped."""


@dataclass(frozen=True, eq=False)
class Case:
    """A stream, what was held, and when it was swapped."""

    recording: Recording
    body: InertialParameters
    other: InertialParameters | None = None
    time: float | None = None
    """[s]"""


def faulty(seed: int, duration: float = 10.0) -> Case:
    """A stream with delay, drifting bias, the other sign, spikes and touches."""
    rng = np.random.default_rng([19, seed])
    body = scaled_box(rng, float(np.exp(rng.uniform(*np.log(MASSES)))))
    joints = random_smooth(duration, RATE, 1.0, seed=int(rng.integers(1 << 30)))
    wielding = wield_analytically(UR5, joints, body)
    z = wielding.measurements
    pushed = z.wrench + touches(wielding.motion.time, rng)
    z = replace(z, force=pushed[:, :3], torque=pushed[:, 3:])
    faults = Faults(
        wrench_noise=WRENCH_NOISE["moderate"],
        bias=six(rng, BIAS),
        drift=six(rng, DRIFT * duration),
        wrench_delay=DELAY,
        spikes=SPIKES,
        on_sensor=True,
    )
    log = record(
        replace(wielding, measurements=z), faults, seed=int(rng.integers(1 << 30))
    )
    return Case(log, body)


def swapped(
    seed: int, change: bool = True, duration: float = 16.0, time: float = 9.0
) -> Case:
    """A stream with a bias and noise in which the object may be swapped for one like
    it, of another mass and place."""
    rng = np.random.default_rng([20, seed])
    mass = float(np.exp(rng.uniform(*np.log(MASSES))))
    step = float(np.exp(rng.uniform(*np.log(STEPS)))) * rng.choice((-1.0, 1.0))
    joints = random_smooth(duration, RATE, 1.0, seed=int(rng.integers(1 << 30)))
    body = scaled_box(rng, mass)
    other = InertialParameters((1.0 + step) * body.vector)
    wielding = wield_analytically(UR5, joints, body)
    z = wielding.measurements
    if change:
        later = wield_analytically(UR5, joints, other).measurements.wrench
        new = np.where(wielding.motion.time[:, None] < time, z.wrench, later)
        z = replace(z, force=new[:, :3], torque=new[:, 3:])
    faults = Faults(
        wrench_noise=WRENCH_NOISE["moderate"], bias=six(rng, 5.0), wrench_delay=0.01
    )
    log = record(
        replace(wielding, measurements=z), faults, seed=int(rng.integers(1 << 30))
    )
    return Case(log, body, other if change else None, time if change else None)


def scaled_box(rng: np.random.Generator, mass: float) -> InertialParameters:
    """A random box of this mass [kg]."""
    box = random_box(rng)
    return InertialParameters(mass / box.mass * box.vector)


def touches(time: Array, rng: np.random.Generator) -> Array:
    """(K, 6) wrench of short touches, one in each `TOUCH_EVERY` seconds."""
    push = np.zeros((len(time), 6))
    length, least, most = TOUCHES
    for begin in np.arange(2.5, time[-1], TOUCH_EVERY):
        since = time - begin - rng.uniform(0.0, TOUCH_EVERY - 2.0 * length)
        rise = np.clip(np.minimum(since, length - since) / 0.05, 0.0, 1.0)
        force = rng.normal(size=3)
        force *= rng.uniform(least, most) / np.linalg.norm(force)
        at = rng.uniform(-0.1, 0.1, 3)
        wrench = np.concatenate((force, np.cross(at, force)))
        push += (0.5 - 0.5 * np.cos(np.pi * rise))[:, None] * wrench
    return push


def six(
    rng: np.random.Generator, force: float
) -> tuple[float, float, float, float, float, float]:
    """A force of this size [N] in a random direction, and a torque of a twentieth."""
    pair = rng.normal(size=(2, 3))
    pair /= np.linalg.norm(pair, axis=1)[:, None]
    a, b, c, d, e, f = (force * pair * np.array([[1.0], [0.05]])).ravel().tolist()
    return (a, b, c, d, e, f)


def parts(recording: Recording, period: float) -> Iterator[list[Samples]]:
    """The samples of a recording, those of each period [s] together."""
    begin = recording.start
    steps = int(np.ceil(recording.duration / period)) + 1
    for k in range(steps):
        span = (begin + k * period, begin + (k + 1) * period)
        found = []
        for name, stream in recording.streams.items():
            first, last = np.searchsorted(stream.time, span)
            if last > first:
                part = stream[first:last]
                found.append(Samples(name, part.time, part.values))
        yield found
