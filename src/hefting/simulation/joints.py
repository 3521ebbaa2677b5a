"""Joint motions to wield an object with, the same for the same `seed`.

Joints stay within their limits: amplitudes are reduced near limits, and prismatic joints
do not move. `Arm.exceeded` reports joint speeds that the real arm does not reach.
"""

from collections.abc import Callable
from functools import cache
from typing import Any

import numpy as np

from hefting.core.errors import InputError
from hefting.core.spatial import SPEED_LIMIT, Array
from hefting.simulation.arm import UR5, Arm, JointMotion

FREQUENCIES = (0.10, 0.13, 0.16)
"""Frequencies of the paper's sinusoids [Hz], of the arm's last joints, before scaling to
the wanted speed."""

LARGEST_SCALE = 1e4
"""Largest scale of the clock over the wanted angular speed [1 / (rad/s)]: above it a
motion is too short to start from rest."""

FASTEST_TURN = 1.5
"""[rad/s] Mean angular speed of the sensor, unless its origin's speed limits it."""

BETWEEN = 0.999
"""Largest share of a speed limit at samples, so that it is kept between them."""


def sinusoids(
    duration: float = 35.0,
    rate: float = 240.0,
    angular_speed: float = 1.0,
    arm: Arm = UR5,
    speed_limit: float | None = None,
) -> JointMotion:
    """The last three joints follow 45° sin(2 pi s f t) about the arm's start (Nadeau et
    al. 2022, sec. V-D).

    The common scale s of the frequencies is such that the sensor's mean angular speed
    over the `duration` [s] is `angular_speed` [rad/s], or smaller if the sensor's origin
    would exceed `speed_limit` [m/s]. Samples are at `rate` [Hz]. The motion begins at
    full speed.
    """
    time = _instants(duration, rate, angular_speed)
    moving = min(arm.n, len(FREQUENCIES))
    frequency = np.zeros((1, arm.n))
    frequency[0, arm.n - moving :] = FREQUENCIES[len(FREQUENCIES) - moving :]
    amplitude = np.where(frequency > 0.0, np.minimum(np.radians(45.0), arm.room), 0.0)
    clock = time, np.ones_like(time), np.zeros_like(time)
    phase = np.zeros_like(frequency)
    return _at_speed(
        arm, angular_speed, speed_limit, time, clock, amplitude, frequency, phase
    )


def random_smooth(
    duration: float = 10.0,
    rate: float = 100.0,
    angular_speed: float = 1.0,
    seed: int = 0,
    arm: Arm = UR5,
    speed_limit: float | None = None,
) -> JointMotion:
    """All joints follow sums of three random sinusoids of 5° to 15°, starting from rest
    within a second.

    Speed, its limit and sampling as in `sinusoids`; the same for the same `seed`.
    """
    time = _instants(duration, rate, angular_speed)
    return _random_sums(time, seed, arm, (5.0, 15.0), angular_speed, speed_limit)


def wide_smooth(
    duration: float = 30.0, rate: float = 100.0, seed: int = 0, arm: Arm = UR5
) -> JointMotion:
    """All joints follow sums of three random sinusoids, the last three of 15° to 30°
    each and the others of 5° to 12°, starting from rest within a second: for joint
    torques, which give information on the centre of mass when the wrist turns it.

    It is as fast as `SPEED_LIMIT` of the sensor's origin allows, and the same for the
    same `seed`.
    """
    time = _instants(duration, rate, SPEED_LIMIT)
    wrist = np.arange(arm.n) >= arm.n - 3
    sizes = np.where(wrist, 15.0, 5.0), np.where(wrist, 30.0, 12.0)
    return _random_sums(time, seed, arm, sizes, FASTEST_TURN, SPEED_LIMIT)


def _random_sums(
    time: Array,
    seed: int,
    arm: Arm,
    sizes: tuple[Any, Any],
    angular_speed: float,
    speed_limit: float | None,
) -> JointMotion:
    """Three random sinusoids per joint, with amplitudes between the two `sizes` [°]."""
    rng = np.random.default_rng(seed)
    shape = (3, arm.n)
    amplitude = np.radians(rng.uniform(*sizes, shape))
    frequency = rng.uniform(0.05, 0.3, shape)
    amplitude = amplitude * np.minimum(1.0, arm.room / (2.0 * amplitude.sum(axis=0)))
    phase = rng.uniform(0.0, 2.0 * np.pi, shape)
    clock = _from_rest(time)
    return _at_speed(
        arm, angular_speed, speed_limit, time, clock, amplitude, frequency, phase
    )


def stop_and_go(
    duration: float = 10.0,
    rate: float = 100.0,
    dwell: float = 1.0,
    move: float = 1.0,
    seed: int = 0,
    arm: Arm = UR5,
    speed_limit: float | None = None,
) -> JointMotion:
    """Rests of `dwell` [s] and minimum-jerk moves of `move` [s] to random poses near the
    start in turn.

    Poses differ from the start by up to 60° in the last three joints and 10° in the
    others. Jerk is discontinuous at both ends of a move. If the sensor's origin exceeds
    `speed_limit` [m/s], all moves are slowed by the same factor. The same for the same
    `seed`.
    """
    time = _instants(duration, rate, 1.0 / move if move > 0.0 else 0.0)
    if not dwell >= 0.0:
        raise InputError(f"the dwell must not be negative, but is {dwell} s")
    reach = _reach(arm)
    most = int(time[-1] // (dwell + move)) + 2
    poses = arm.start + reach * np.random.default_rng(seed).uniform(
        -1.0, 1.0, (most, arm.n)
    )
    poses[0] = arm.start
    joints = _moves(time, poses, dwell, move)
    if speed_limit is not None:
        fastest = _fastest(arm, joints)
        if fastest > _limit(speed_limit):
            joints = _moves(time, poses, dwell, move * fastest / _limit(speed_limit))
    return joints


def _reach(arm: Arm) -> Array:
    """(n,) largest distance of random poses from the arm's start [rad]."""
    own = np.where(np.arange(arm.n) < arm.n - 3, np.radians(10.0), np.radians(60.0))
    return np.minimum(own, arm.room)


def _moves(time: Array, poses: Array, dwell: float, move: float) -> JointMotion:
    """Rests in `poses` (m, n), and moves between."""
    number, within = np.divmod(time, dwell + move)
    number = number.astype(int)
    u = np.clip((within - dwell) / move, 0.0, 1.0)[:, None]
    step = poses[number + 1] - poses[number]
    return JointMotion(
        time,
        poses[number] + step * u**3 * (10.0 - 15.0 * u + 6.0 * u * u),
        step / move * 30.0 * (u * (1.0 - u)) ** 2,
        step / move**2 * 60.0 * u * (1.0 - u) * (1.0 - 2.0 * u),
    )


def _instants(duration: float, rate: float, speed: float) -> Array:
    if not (
        duration > 0.0
        and rate > 0.0
        and speed > 0.0
        and np.isfinite(duration * rate * speed)
    ):
        what = f"but are {duration:g} s, {rate:g} Hz and {speed:g} rad/s"
        raise InputError(
            f"duration, rate and speed of a motion must be positive, {what}"
        )
    return _sampled(duration, rate)


def _sampled(duration: float, rate: float) -> Array:
    return np.arange(max(int(np.floor(duration * rate + 1e-9)), 1)) / rate


def _from_rest(time: Array) -> tuple[Array, Array, Array]:
    """A clock that starts within a second: reading, rate and its derivative (K,)."""
    u = np.clip(time, 0.0, 1.0)
    reading = u**4 * (2.5 - 3.0 * u + u * u) + (time - u)
    return reading, u**3 * (10.0 - 15.0 * u + 6.0 * u * u), 30.0 * (u * (1.0 - u)) ** 2


def _fastest(arm: Arm, joints: JointMotion) -> float:
    """Highest speed of the sensor's origin [m/s]."""
    return float(arm.motion(joints).linear_speed().max())


def _limit(speed_limit: float) -> float:
    if not speed_limit > 0.0:
        raise InputError(f"the speed limit must be positive, but is {speed_limit} m/s")
    return BETWEEN * speed_limit


def _at_speed(
    arm: Arm,
    angular_speed: float,
    speed_limit: float | None,
    time: Array,
    clock: tuple[Array, Array, Array],
    amplitude: Array,
    frequency: Array,
    phase: Array,
) -> JointMotion:
    """Sums of sinusoids (k, n) about the start, with the clock scaled to the wanted mean
    angular speed, or to the speed limit."""
    if not (amplitude * frequency).any():
        fix = "start it away from its joints' limits"
        raise InputError("no joint of the arm can turn", arm.robot.source, fix)

    def joints(scale: float) -> JointMotion:
        reading, rate, change = (scale * c[:, None, None] for c in clock)
        w = 2.0 * np.pi * frequency
        angle = w * reading + phase
        slope, sin = amplitude * w * np.cos(angle), np.sin(angle)
        return JointMotion(
            time,
            arm.start + (amplitude * (sin - np.sin(phase))).sum(axis=1),
            (slope * rate).sum(axis=1),
            (slope * change - amplitude * w * w * sin * rate**2).sum(axis=1),
        )

    low, high = 0.0, angular_speed

    @cache
    def angular(scale: float) -> float:
        w = arm.angular_velocity(joints(scale))
        return float(np.linalg.norm(w, axis=1).mean()) - angular_speed

    while angular(high) < 0.0:
        low, high = high, 2.0 * high
        if high > LARGEST_SCALE * angular_speed:
            what = f"{len(time)} samples up to {time[-1]:g} s are too few to reach a mean of {angular_speed:g} rad/s"
            raise InputError(what, fix="simulate longer")
    scale = _root(angular, low, high)
    if speed_limit is not None:
        highest = _limit(speed_limit)
        excess = cache(lambda scale: _fastest(arm, joints(scale)) - highest)
        if excess(scale) > 0.0:
            scale = _root(excess, 0.0, scale)
    return joints(scale)


def _root(function: Callable[[float], float], low: float, high: float) -> float:
    from scipy.optimize import brentq

    return float(brentq(function, low, high, xtol=1e-12))  # pyright: ignore[reportArgumentType]


def trapezoids(
    duration: float = 12.0,
    rate: float = 100.0,
    speed: float = 1.05,
    acceleration: float = 1.4,
    dwell: tuple[float, float] = (0.2, 0.6),
    seed: int = 0,
    arm: Arm = UR5,
) -> JointMotion:
    """Moves between random poses near the start, with a rest before each.

    All joints of a move start and stop together. The one that turns farthest
    accelerates at `acceleration` [rad/s²] to at most `speed` [rad/s], by default those
    of a UR's programs. The acceleration jumps up to four times per move. Rests last
    between the two times of `dwell` [s]. The same for the same `seed`. Raises
    `InputError` for numbers that are not positive.
    """
    for name, value in (
        ("duration", duration),
        ("rate", rate),
        ("speed", speed),
        ("acceleration", acceleration),
    ):
        if not (value > 0.0 and np.isfinite(value)):
            raise InputError(f"the {name} must be positive, but is {value:g}")
    rng = np.random.default_rng(seed)
    time = _sampled(duration, rate)
    reach = _reach(arm)
    if not reach.any():
        raise InputError("no joint of the arm can turn", arm.robot.source)
    position = np.tile(arm.start, (len(time), 1))
    velocity, change = np.zeros_like(position), np.zeros_like(position)
    here, begin = np.array(arm.start), rng.uniform(*dwell)
    while begin < time[-1]:
        way = arm.start + reach * rng.uniform(-1.0, 1.0, arm.n) - here
        longest = float(np.abs(way).max())
        started = time >= begin
        share, lasts = _trapezoid(
            time[started] - begin, speed / longest, acceleration / longest
        )
        position[started] = here + share[0][:, None] * way
        velocity[started] = share[1][:, None] * way
        change[started] = share[2][:, None] * way
        here, begin = here + way, begin + lasts + rng.uniform(*dwell)
    return JointMotion(time, position, velocity, change)


def _trapezoid(
    since: Array, speed: float, acceleration: float
) -> tuple[tuple[Array, Array, Array], float]:
    """Position, speed and acceleration (K,) at times (K,) [s] of a move from 0 to 1 with
    limits of speed and acceleration, and its duration [s]."""
    ramp = min(speed / acceleration, acceleration**-0.5)
    top = acceleration * ramp
    lasts = 1.0 / top + ramp
    left = lasts - since
    phases = [since < ramp, since < lasts - ramp, since < lasts]
    share = np.select(
        phases,
        [
            0.5 * acceleration * since**2,
            top * (since - 0.5 * ramp),
            1.0 - 0.5 * acceleration * left**2,
        ],
        1.0,
    )
    rate = np.select(phases, [acceleration * since, top, acceleration * left], 0.0)
    change = np.select(phases, [acceleration, 0.0, -acceleration], 0.0)
    return (share, rate, change), lasts
