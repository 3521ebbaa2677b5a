"""Movement: how fast the sensor went, whether that was safe, and how far it turned
against gravity."""

from dataclasses import dataclass

import numpy as np

from hefting.core.recording import Recording
from hefting.core.regressor import dynamism
from hefting.core.spatial import SPEED_LIMIT, Array
from hefting.ingest.ingest import Ingested
from hefting.inspection.streams import GAP
from hefting.motion import Measured
from hefting.motion.measure import DESCRIPTIONS


@dataclass(frozen=True)
class Movement:
    """Speeds are those of the sensor origin."""

    source: str
    """how velocities and accelerations are found, in words"""
    linear_speed: tuple[float, float] | None
    """mean and largest [m/s]; None where the position is not known"""
    above_limit: float | None
    """s spent above `SPEED_LIMIT`; None where the linear speed is not known"""
    angular_speed: tuple[float, float]
    """mean and largest [rad/s]"""
    turn: float
    """rad: the largest angle between any two of gravity's directions in sensor axes"""
    dynamism: float | None
    """median (Nadeau et al. 2022, eq. 4); None where only gravity is modelled although
    the sensor moves"""

    @property
    def keeps_limit(self) -> bool | None:
        """Whether the speed never exceeds `SPEED_LIMIT`; None where it is not known."""
        return None if self.above_limit is None else self.above_limit == 0.0


def movement(recording: Recording, found: Measured | Ingested) -> Movement:
    """How a recording moves, at the instants of its wrench."""
    z, motion = found.measurements, found.motion
    angular = np.linalg.norm(
        z.angular_velocity if motion is None else motion.angular_velocity, axis=1
    )
    time = linear = None
    if recording.has("linear_velocity"):
        time = recording["linear_velocity"].time
        velocity = recording["linear_velocity"].values
        linear = np.linalg.norm(velocity, axis=1)
    elif motion is not None and motion.linear_velocity is not None:
        time, linear = motion.time, np.linalg.norm(motion.linear_velocity, axis=1)
    return Movement(
        source=DESCRIPTIONS[found.source],
        linear_speed=None if linear is None else _mean_and_largest(linear),
        above_limit=None
        if linear is None or time is None
        else time_above(time, linear, SPEED_LIMIT),
        angular_speed=_mean_and_largest(angular),
        turn=_widest(z.gravity),
        dynamism=None
        if found.source == "orientation"
        else float(np.median(dynamism(z))),
    )


def time_above(time: Array, values: Array, limit: float) -> float:
    """Time during which values exceed a limit.

    Parameters
    ----------
    time : Array
        (K,) [s].
    values : Array
        (K,).
    limit : float
        In the unit of the values.

    Returns
    -------
    float
        [s]; each step counts by half for either of its two samples. A step longer than
        `GAP` times the median counts as long as the median.
    """
    above = values > limit
    if len(time) < 2:
        return 0.0
    steps = np.diff(time)
    median = float(np.median(steps))
    steps = np.where(steps > GAP * median, median, steps)
    return float(steps @ (0.5 * above[1:] + 0.5 * above[:-1]))


def _mean_and_largest(values: Array) -> tuple[float, float]:
    return float(values.mean()), float(values.max())


def _widest(gravity: Array) -> float:
    """The largest angle [rad] between two directions (K, 3), to a few degrees: of those
    furthest along many axes."""
    unit = gravity / np.maximum(np.linalg.norm(gravity, axis=1, keepdims=True), 1e-300)
    k = np.arange(200) + 0.5  # evenly over the sphere
    polar, azimuth = np.arccos(1.0 - k / 100.0), np.pi * (1.0 + 5.0**0.5) * k
    axes = np.stack(
        (
            np.cos(azimuth) * np.sin(polar),
            np.sin(azimuth) * np.sin(polar),
            np.cos(polar),
        )
    )
    ends = unit[np.unique(np.argmax(unit @ axes, axis=0))]
    return float(np.arccos(np.clip((ends @ ends.T).min(), -1.0, 1.0)))
