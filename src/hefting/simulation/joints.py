"""Joint motions to wield an object with: the paper's sinusoids, random smooth motion, stop-and-go."""

import numpy as np

from hefting.errors import InputError
from hefting.simulation.arm import UR5, Arm, JointMotion
from hefting.spatial import Array

START = tuple(np.radians((0.0, -90.0, 60.0, -90.0, -90.0, 0.0)).tolist())
"""Initial joint angles in the paper's simulations [rad]."""

FREQUENCIES = (0.0, 0.0, 0.0, 0.10, 0.13, 0.16)
"""Frequencies of the paper's sinusoids [Hz], before they are scaled to the wanted speed."""


def sinusoids(duration: float = 35.0, rate: float = 240.0, angular_speed: float = 1.0, arm: Arm = UR5) -> JointMotion:
    """The last three joints follow 45° sin(2 pi s f t) about `START` (Nadeau et al. 2022, sec. V-D).

    The common scale s of the frequencies is the one at which the sensor's angular speed, averaged over the
    `duration` [s], is `angular_speed` [rad/s]. Samples come at `rate` [Hz]. The motion begins at full speed.
    """
    time = _instants(duration, rate, angular_speed)
    frequency = np.array([FREQUENCIES])
    amplitude = np.where(frequency > 0.0, np.radians(45.0), 0.0)
    return _at_speed(arm, angular_speed, time, (time, np.ones_like(time), np.zeros_like(time)), amplitude, frequency)


def random_smooth(
    duration: float = 10.0, rate: float = 100.0, angular_speed: float = 1.0, seed: int = 0, arm: Arm = UR5
) -> JointMotion:
    """All joints follow sums of three random sinusoids of 5° to 15°, starting from rest within a second.

    Speed and sampling as in `sinusoids`; the same for the same `seed`.
    """
    time = _instants(duration, rate, angular_speed)
    rng = np.random.default_rng(seed)
    shape = (3, len(START))
    amplitude, frequency = np.radians(rng.uniform(5.0, 15.0, shape)), rng.uniform(0.05, 0.3, shape)
    return _at_speed(
        arm, angular_speed, time, _from_rest(time), amplitude, frequency, rng.uniform(0.0, 2.0 * np.pi, shape)
    )


def stop_and_go(
    duration: float = 10.0, rate: float = 100.0, dwell: float = 1.0, move: float = 1.0, seed: int = 0
) -> JointMotion:
    """Rest for `dwell` [s], then a minimum-jerk move of `move` [s] to a random pose near `START`, and so on.

    Each pose turns the last three joints by up to 60° and the others by up to 10°. Jerk jumps where a move
    begins and ends. The same for the same `seed`.
    """
    time = _instants(duration, rate, 1.0 / move if move > 0.0 else 0.0)
    if not dwell >= 0.0:
        raise InputError(f"the dwell must not be negative, but is {dwell} s")
    number, within = np.divmod(time, dwell + move)
    number = number.astype(int)
    reach = np.radians((10.0, 10.0, 10.0, 60.0, 60.0, 60.0))
    poses = START + reach * np.random.default_rng(seed).uniform(-1.0, 1.0, (number.max() + 2, len(START)))
    poses[0] = START
    u = np.clip((within - dwell) / move, 0.0, 1.0)[:, None]
    step = poses[number + 1] - poses[number]
    return JointMotion(
        time,
        poses[number] + step * u**3 * (10.0 - 15.0 * u + 6.0 * u * u),
        step / move * 30.0 * (u * (1.0 - u)) ** 2,
        step / move**2 * 60.0 * u * (1.0 - u) * (1.0 - 2.0 * u),
    )


def _instants(duration: float, rate: float, speed: float) -> Array:
    if not (duration > 0.0 and rate > 0.0 and speed > 0.0 and np.isfinite(duration * rate * speed)):
        raise InputError("duration, rate and speed of a motion must be positive")
    return np.arange(max(int(np.floor(duration * rate + 1e-9)), 1)) / rate


def _from_rest(time: Array) -> tuple[Array, Array, Array]:
    """A clock that starts with the first second: reading, rate and its derivative (K,)."""
    u = np.clip(time, 0.0, 1.0)
    reading = u**4 * (2.5 - 3.0 * u + u * u) + (time - u)
    return reading, u**3 * (10.0 - 15.0 * u + 6.0 * u * u), 30.0 * (u * (1.0 - u)) ** 2


def _at_speed(
    arm: Arm,
    angular_speed: float,
    time: Array,
    clock: tuple[Array, Array, Array],
    amplitude: Array,
    frequency: Array,
    phase: Array | float = 0.0,
) -> JointMotion:
    """Sums of sinusoids (k, n) about `START`, their clock scaled to the wanted mean angular speed."""
    from scipy.optimize import brentq

    def joints(scale: float) -> JointMotion:
        reading, rate, change = (scale * c[:, None, None] for c in clock)
        w = 2.0 * np.pi * frequency
        angle = w * reading + phase
        slope = amplitude * w * np.cos(angle)
        return JointMotion(
            time,
            START + (amplitude * (np.sin(angle) - np.sin(phase))).sum(axis=1),
            (slope * rate).sum(axis=1),
            (slope * change - amplitude * w * w * np.sin(angle) * rate**2).sum(axis=1),
        )

    def excess(scale: float) -> float:
        return arm.motion(joints(scale)).mean_speeds[0] - angular_speed

    low, high = 0.0, angular_speed
    while excess(high) < 0.0:
        low, high = high, 2.0 * high
    return joints(float(brentq(excess, low, high, xtol=1e-12)))  # pyright: ignore[reportArgumentType]
