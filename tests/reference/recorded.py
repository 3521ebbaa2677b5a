"""What the cases of ingest are about: recordings of a few seconds of a box that an arm
moves, each with something wrong with it or with nothing."""

from collections.abc import Callable
from dataclasses import replace
from functools import cache

import numpy as np
from benchmarks.given import Given
from scipy.spatial.transform import Rotation

from disturbances import body
from hefting.core.inertia import InertialParameters
from hefting.core.recording import Recording, Stream
from hefting.core.spatial import STANDARD_GRAVITY, Array
from hefting.shapes import Shape
from hefting.simulation import (
    UR5,
    WRENCH_NOISE,
    Faults,
    JointMotion,
    Rates,
    Wielding,
    random_smooth,
    record,
    stop_and_go,
    wield_analytically,
)

FAULTS = Faults(
    wrench_noise=WRENCH_NOISE["moderate"], bias=(3.0, -2.0, 5.0, 0.1, -0.2, 0.05)
)
"""Of a sensor that is biased, and otherwise good."""
OBJECT = body(1.2)


@cache
def motion(
    seconds: float, rate: float = 100.0, speed: float = 1.2, seed: int = 5
) -> JointMotion:
    """Random smooth motion of the arm [s, Hz, rad/s]."""
    return random_smooth(seconds, rate, speed, seed=seed)


@cache
def wielding(
    joints: Callable[[], JointMotion], thing: InertialParameters = OBJECT
) -> Wielding:
    """The exact motion and wrench."""
    return wield_analytically(UR5, joints(), thing)


def short() -> JointMotion:
    """4 s at 100 Hz."""
    return motion(4.0)


def medium() -> JointMotion:
    """9 s at 50 Hz, in which a bias may drift."""
    return motion(9.0, 50.0)


def long() -> JointMotion:
    """40 s at 20 Hz, in which it may wander."""
    return motion(40.0, 20.0, 0.8)


def fast() -> JointMotion:
    """2.5 s at 500 Hz."""
    return motion(2.5, 500.0)


def stopping() -> JointMotion:
    """10 s at 100 Hz, with rests."""
    return stop_and_go(10.0, 100.0, seed=5)


def other() -> JointMotion:
    """4 s of another motion."""
    return motion(4.0, seed=6)


@cache
def recorded(
    joints: Callable[[], JointMotion] = short,
    faults: Faults = FAULTS,
    rates: Rates = Rates(),  # noqa: B008 (immutable)
    thing: InertialParameters = OBJECT,
    seed: int = 7,
) -> Recording:
    """A recording of the object."""
    return record(wielding(joints, thing), faults, rates, seed)


def only(recording: Recording, *names: str) -> Recording:
    """Some of the streams."""
    return replace(recording, streams={name: recording.streams[name] for name in names})


def changed(
    recording: Recording, name: str, change: Callable[[Array, Array], Array]
) -> Recording:
    """With the values of one stream changed, as a function of time and values."""
    stream = recording[name]
    values = change(np.array(stream.time), np.array(stream.values))
    return replace(
        recording,
        streams={**recording.streams, name: Stream(stream.time, values, stream.rows)},
    )


def stamped_late(recording: Recording, seconds: float) -> Recording:
    """With later times of the wrench."""
    stream = recording["wrench"]
    wrench = Stream(np.array(stream.time) + seconds, stream.values, stream.rows)
    return replace(recording, streams={**recording.streams, "wrench": wrench})


def with_imu() -> Recording:
    """Poses, an accelerometer and a gyroscope."""
    return recorded(short, rates=Rates(imu=100.0))


def accelerated() -> Recording:
    """Orientations and an accelerometer."""
    return only(with_imu(), "wrench", "orientation", "accelerometer")


@cache
def static_poses(count: int = 24) -> Recording:
    """Poses at rest without time, one of them with a wrong wrench."""
    rng = np.random.default_rng(50)
    R = Rotation.random(count, rng=rng)
    g: Array = np.array(R.inv().apply(np.array(STANDARD_GRAVITY)).tolist())
    thing = OBJECT
    force = -thing.mass * g
    wrench = np.hstack((force, np.cross(thing.center_of_mass, force)))
    wrench += np.array(FAULTS.bias)
    wrench += rng.normal(size=wrench.shape) * np.array(FAULTS.wrench_noise)
    wrench[count // 2] += (4.0, 0.0, -3.0, 0.0, 0.2, 0.0)
    rows = np.arange(count, dtype=float)
    q: Array = np.array(R.as_quat().tolist())
    streams = {"orientation": Stream(rows, q), "wrench": Stream(rows, wrench)}
    return Recording(streams, static=True)


@cache
def with_columns() -> Recording:
    """Accelerations that were logged, and the wrench."""
    from hefting.core.measurements import Noise
    from hefting.simulation import simulate

    return simulate(
        UR5.motion(short()), OBJECT, noise=Noise(0.1, 0.005), seed=8, exact=True
    )


@cache
def tilted(degrees: float) -> Recording:
    """Of a base that is tilted, about a horizontal axis."""
    R = Rotation.from_rotvec(np.radians(degrees) * np.array((0.8, -0.6, 0.0)))
    q = recorded(medium)
    q = changed(q, "orientation", lambda _, v: (R * Rotation.from_quat(v)).as_quat())
    return changed(q, "position", lambda _, p: R.apply(p))


@cache
def changing(kind: str) -> Recording:
    """Another body from 4.6 s of 9 on, or a push from 3 to 5.5 s."""
    whole = recorded(medium)
    exact = wielding(medium).measurements.wrench
    time = np.array(whole["wrench"].time)
    if kind == "touched":
        inside = (time > 3.0) & (time < 5.5)
        swing = inside * (1.0 + 0.3 * np.sin(5.0 * time))
        extra = np.outer(swing, (4.0, 3.0, -2.0, 0.1, -0.2, 0.1))
        return changed(whole, "wrench", lambda _, w: w + extra)
    after = {
        "swapped": InertialParameters(1.7 * body(1.2).vector),
        "put-down": InertialParameters(0.02 * body(1.2).vector),
        "picked-up": InertialParameters(0.05 * body(1.2).vector),
        "slipped": InertialParameters.from_com(
            1.2, (0.05, -0.03, 0.05), OBJECT.inertia_at_com
        ),
    }[kind]
    share = np.clip((time - 4.6) / 0.1, 0.0, 1.0)[:, None]
    share = 1.0 - share if kind == "picked-up" else share
    other = wielding(medium, after).measurements.wrench
    return changed(whole, "wrench", lambda _, w: w + share * (other - exact))


@cache
def given() -> Given:
    """A correct recording, as the benchmark's mistakes take it."""
    found = wielding(stopping)
    return Given(
        record(found, FAULTS, seed=9),
        Shape.from_box(-0.05, 0.09, -0.07, 0.01, 0.0, 0.16),
        OBJECT,
        exact=found.measurements,
    )
