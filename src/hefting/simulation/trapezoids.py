"""Trapezoid moves: what a teach pendant's point-to-point command makes a robot do."""

import numpy as np

from hefting.core.errors import InputError
from hefting.core.spatial import Array
from hefting.simulation.arm import UR5, Arm, JointMotion

WRIST_REACH, ARM_REACH = np.radians(60.0), np.radians(10.0)
"""Largest distance of a goal from the arm's start [rad], of the last three joints and of
those before them."""


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

    All joints of a move start and stop together. The one with the longest way
    accelerates at `acceleration` [rad/s²] to at most `speed` [rad/s]; the defaults are
    those of a UR's programs. The acceleration jumps up to four times a move. Rests last
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
    time = np.arange(max(int(np.floor(duration * rate + 1e-9)), 1)) / rate
    reach = np.full(arm.n, ARM_REACH)
    reach[-3:] = WRIST_REACH
    reach = np.minimum(reach, arm.room)
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
    """Share of the way, its first and second derivative (K,) at times (K,) [s] after
    the start, and the duration [s], for limits in shares of the way."""
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
