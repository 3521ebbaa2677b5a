"""Simulated recordings with one thing wrong with them, or everything, and what an
oracle would know of it.

A UR5 follows random smooth motion at 1 rad/s, by default for 10 s at 100 Hz, and wields
a box of 12 x 8 x 16 cm held askew; wrench noise is 0.1 N and 0.005 N m, pose noise 0.1
mm and 0.02°.
"""

from dataclasses import dataclass, replace
from functools import cache

import numpy as np
from scipy.signal import lfilter
from scipy.spatial.transform import Rotation

from hefting.core.inertia import InertialParameters
from hefting.core.measurements import Noise
from hefting.core.recording import Recording, Stream
from hefting.core.spatial import Array, vector_to_tensor
from hefting.estimators.quadratic import least_squares
from hefting.estimators.sample_state import SampleState
from hefting.ingest import Conditioned
from hefting.ingest.free_fit import fit_freely
from hefting.motion import measure, sample_weights
from hefting.simulation import UR5, random_smooth, simulate, wield
from hefting.simulation.arm import SensorMotion

GRAVITY = np.array((0.0, 0.0, -9.80665))
NOISE = Noise(force=0.1, torque=0.005)
SCALE = np.repeat((1.0, 0.05), 3)
"""N m for each N, of noise, bias, drift and spikes."""
KINDS = (
    "clean",
    "drift",
    "offset",
    "flipped",
    "tilt",
    "spikes",
    "dropped",
    "contact",
    "all",
    "coloured",
)
BOUTS, PART, RISE = 10, 0.3, 0.05
"""Contacts, spread evenly over the recording; their part of it; s in which each comes
and goes."""


def body(mass: float) -> InertialParameters:
    """A homogeneous box of a mass [kg], in the sensor frame."""
    square = np.square((0.12, 0.08, 0.16))
    R = Rotation.from_euler("xyz", (0.3, 0.5, 0.2)).as_matrix()
    inertia = mass / 12.0 * (square.sum() - square)
    return InertialParameters.from_com(mass, (0.02, -0.03, 0.08), (R * inertia) @ R.T)


@dataclass(frozen=True, eq=False)
class Disturbed:
    """A recording, and what was done to it."""

    recording: Recording
    body: InertialParameters
    offset: float
    drift: Array
    """(K, 6) what varies of the bias"""
    sign: float
    gravity: Array
    bad: Array
    """(K,) wrench samples that are spikes or contact"""

    @property
    def repaired(self) -> Recording:
        """As an oracle would have it; a constant bias stays."""
        wrench, kept = self.recording["wrench"], ~self.bad
        values = self.sign * (wrench.values - self.drift)
        return with_wrench(
            self.recording, (wrench.time - self.offset)[kept], values[kept]
        )


def with_wrench(recording: Recording, time: Array, values: Array) -> Recording:
    """A recording with another wrench."""
    return replace(
        recording, streams={**recording.streams, "wrench": Stream(time, values)}
    )


def disturbed(kind: str, mass: float, seed: int, duration: float = 10.4) -> Disturbed:
    """One of `KINDS`: the same motion and noise for the same seed, whatever the kind.

    drift: bias of 20 N and 1 N m that drifts by 0.5 N and 0.025 N m; offset: wrench 30
    ms late; tilt: base tilted by 15°; spikes: 5 % of the samples, of 20 N and 1 N m;
    dropped: 10 % of poses and of wrenches; contact: see `contact`; all: all of these,
    and the other sign; coloured: wrench noise correlated by 0.9 from sample to sample.
    """
    motion, clean, exact = undisturbed(mass, seed, duration)
    thing, rng = body(mass), np.random.default_rng([9, seed])
    time, K = motion.time, len(motion.time)
    noise = clean["wrench"].values - exact
    offset, sign, gravity = 0.0, 1.0, GRAVITY
    bias, drift, extra = np.zeros(6), np.zeros((K, 6)), np.zeros((K, 6))
    bad = np.zeros(K, dtype=bool)
    kept = np.ones(K, dtype=bool)
    posed = np.ones(K, dtype=bool)
    if kind in ("drift", "all"):
        bias = 20.0 * SCALE * _direction(rng)
        drift = 0.5 * SCALE * _direction(rng) * (time / time[-1])[:, None]
    if kind in ("offset", "all"):
        offset = 0.03
    if kind in ("flipped", "all"):
        sign = -1.0
    if kind in ("tilt", "all"):
        axis = rng.normal(size=2)
        tilt = np.radians(15.0) * np.append(axis / np.linalg.norm(axis), 0.0)
        gravity = Rotation.from_rotvec(tilt).apply(GRAVITY)
        exact = wield(motion, thing, gravity).wrench
    if kind in ("spikes", "all"):
        bad = rng.random(K) < 0.05
        extra[bad] += 20.0 * SCALE * rng.normal(size=(int(bad.sum()), 6))
    if kind in ("contact", "all"):
        touched, push = contact(time, rng)
        extra, bad = extra + push, bad | touched
    if kind in ("dropped", "all"):
        kept, posed = rng.random(K) > 0.1, rng.random(K) > 0.1
    if kind == "coloured":
        noise = (
            0.1
            * SCALE
            * lfilter(
                [np.sqrt(1.0 - 0.9**2)], [1.0, -0.9], rng.normal(size=(K, 6)), axis=0
            )
        )
    wrench = sign * (exact + extra) + bias + drift + noise
    streams = {name: clean[name][posed] for name in ("position", "orientation")}
    streams["wrench"] = Stream((time + offset)[kept], wrench[kept])
    return Disturbed(
        Recording(streams), thing, offset, drift[kept], sign, gravity, bad[kept]
    )


@cache
def _motion(seed: int, duration: float) -> SensorMotion:
    """Random smooth motion of the UR5."""
    return UR5.motion(random_smooth(duration, 100.0, 1.0, seed))


@cache
def undisturbed(
    mass: float, seed: int, duration: float
) -> tuple[SensorMotion, Recording, Array]:
    """The motion, its recording with noise alone, and the exact wrench (K, 6)."""
    motion = _motion(seed, duration)
    clean = simulate(motion, body(mass), noise=NOISE, seed=seed)
    return motion, clean, wield(motion, body(mass)).wrench


def contact(time: Array, rng: np.random.Generator) -> tuple[Array, Array]:
    """When (K,) something touches the object, and its wrench (K, 6).

    Ten bouts of 0.03 of the recording each, evenly spread; 3 to 8 N in a random
    direction at a point up to 10 cm from the object's centre along each axis; each
    comes and goes within 50 ms.
    """
    slot = time[-1] / BOUTS
    length = PART * slot
    touched, push = np.zeros(len(time), dtype=bool), np.zeros((len(time), 6))
    for i in range(BOUTS):
        since = time - i * slot - rng.uniform(0.0, slot - length)
        inside = (since > 0.0) & (since < length)
        rise = np.clip(np.minimum(since, length - since) / RISE, 0.0, 1.0)
        force = rng.normal(size=3)
        force *= rng.uniform(3.0, 8.0) / np.linalg.norm(force)
        at = rng.uniform(-0.1, 0.1, 3) + np.array((0.02, -0.03, 0.08))
        wrench = np.concatenate((force, np.cross(at, force)))
        push += (
            np.where(inside, 0.5 - 0.5 * np.cos(np.pi * rise), 0.0)[:, None] * wrench
        )
        touched |= inside
    return touched, push


def identified(
    recording: Recording,
    gravity: Array,
    sign: float = 1.0,
    inflation: Array | None = None,
) -> tuple[Array, Array]:
    """Ten parameters and their deviations, by least squares beside a constant bias, as
    of any good recording."""
    measured = measure(recording, gravity)
    z = measured.measurements
    z = replace(z, force=sign * z.force, torque=sign * z.torque)
    rough = fit_freely(z, True, inflation)
    weights = sample_weights(
        rough.vector, measured.motion, rough.noise.force, rough.noise.torque
    )
    fit = least_squares(
        SampleState.of(replace(z, weights=weights / weights.mean())), True, rough.noise
    )
    return fit.solution[:10], np.sqrt(
        rough.inflation[:10] * fit.covariance.diagonal()[:10]
    )


def identified_after(found: Conditioned, recording: Recording) -> tuple[Array, Array]:
    """The same of a recording as conditioned."""
    return identified(
        found.corrected(recording),
        found.gravity,
        1.0 if found.sign.on_object else -1.0,
        found.inflation,
    )


def errors(vector: Array, thing: InertialParameters) -> Array:
    """(3,) of mass [relative], centre of mass [m], and inertia about the sensor origin
    [kg m²]."""
    truth = thing.vector
    return np.array(
        (
            abs(vector[0] / truth[0] - 1.0),
            np.linalg.norm(vector[1:4] / vector[0] - thing.center_of_mass),
            np.linalg.norm(vector_to_tensor(vector[4:] - truth[4:])),
        )
    )


def rms(values) -> Array:
    """Root mean square over the first axis."""
    return np.sqrt(np.mean(np.square(values), axis=0))


def _direction(rng: np.random.Generator) -> Array:
    """(6,) unit vectors of a force and a torque."""
    pair = rng.normal(size=(2, 3))
    return (pair / np.linalg.norm(pair, axis=1, keepdims=True)).ravel()
