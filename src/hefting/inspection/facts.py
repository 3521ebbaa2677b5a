"""Facts about a recording's streams, movement and wrench."""

from dataclasses import dataclass, replace

import numpy as np

from hefting.core.measurements import Measurements
from hefting.core.recording import Recording, Stream
from hefting.core.regressor import dynamism, predict_wrench
from hefting.core.spatial import SPEED_LIMIT, Array, freeze, immutable, median
from hefting.ingest.blocks import residual_size
from hefting.ingest.free_fit import FreeFit, residuals
from hefting.ingest.ingest import Ingested
from hefting.motion import Measured
from hefting.motion.measure import DESCRIPTIONS
from hefting.motion.state import Motion

GAP = 3.0
"""Ratio to the usual step above which a step is a gap."""


@dataclass(frozen=True)
class StreamFacts:
    """Sampling of one stream. For static poses only `samples` and `repeated` have a
    meaning; the rest is 0."""

    samples: int
    rate: float
    """Hz: one over the usual step, the median without lost samples; 0 of one sample"""
    start: float
    """s"""
    end: float
    """s"""
    gaps: int
    """steps longer than `GAP` usual ones"""
    longest_gap: float
    """s; 0 without gaps"""
    gap_time: float
    """s in gaps altogether"""
    missing: float
    """share of the samples expected by the rate that are missing, also in gaps"""
    jitter: float
    """s: root-mean-square deviation of the step from the nearest multiple of the usual
    one, gaps left out"""
    jitter_share: float
    """the same over the usual step"""
    repeated: float
    """share of the samples that equal the previous one in every column, as at rest or if
    a slower source holds its values"""


def stream_facts(stream: Stream, static: bool) -> StreamFacts:
    """Facts about a stream, whose times are only row numbers if `static`."""
    n = len(stream)
    repeated = (
        float((np.diff(stream.values, axis=0) == 0.0).all(axis=1).mean())
        if n > 1
        else 0.0
    )
    if static or n < 2:
        start = 0.0 if static else float(stream.time[0])
        return StreamFacts(n, 0.0, start, start, 0, 0.0, 0.0, 0.0, 0.0, 0.0, repeated)
    steps = np.diff(stream.time)
    usual = median(steps)
    usual = median(steps[steps < 1.5 * usual])
    gap = steps > GAP * usual
    rest = steps[~gap]
    off = rest - usual * np.maximum(np.round(rest / usual), 1.0)
    jitter = float(np.sqrt(np.mean(off**2)))
    promised = round(float(stream.time[-1] - stream.time[0]) / usual) + 1
    return StreamFacts(
        samples=n,
        rate=1.0 / usual,
        start=float(stream.time[0]),
        end=float(stream.time[-1]),
        gaps=int(gap.sum()),
        longest_gap=float(steps[gap].max()) if gap.any() else 0.0,
        gap_time=float(steps[gap].sum()),
        missing=max(1.0 - n / promised, 0.0),
        jitter=jitter,
        jitter_share=jitter / usual,
        repeated=repeated,
    )


@dataclass(frozen=True)
class Movement:
    """Speeds of the sensor origin, and rotation."""

    source: str
    """how velocities and accelerations were found, in words"""
    linear_speed: tuple[float, float] | None
    """mean and largest [m/s]; None if the position is unknown"""
    above_limit: float | None
    """s spent above `SPEED_LIMIT`; None if the linear speed is unknown"""
    angular_speed: tuple[float, float]
    """mean and largest [rad/s]"""
    turn: float
    """rad: the largest angle between any two of gravity's directions in sensor axes"""
    dynamism: float | None
    """median (Nadeau et al. 2022, eq. 4); None if only gravity is modelled although the
    sensor moves"""

    @property
    def keeps_limit(self) -> bool | None:
        """Whether the speed never exceeds `SPEED_LIMIT`; None if unknown."""
        return None if self.above_limit is None else self.above_limit == 0.0


def movement(recording: Recording, found: Measured | Ingested) -> Movement:
    """Movement of the sensor at the instants of its wrench."""
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
        dynamism=None if found.source == "orientation" else median(dynamism(z)),
    )


def time_above(time: Array, values: Array, limit: float) -> float:
    """Time [s] during which values (K,) at times (K,) [s] exceed a limit. Half of each
    step belongs to either of its samples; a step of more than `GAP` medians counts as
    one."""
    above = values > limit
    if len(time) < 2:
        return 0.0
    steps = np.diff(time)
    usual = median(steps)
    steps = np.where(steps > GAP * usual, usual, steps)
    return float(steps @ (0.5 * above[1:] + 0.5 * above[:-1]))


def _mean_and_largest(values: Array) -> tuple[float, float]:
    return float(values.mean()), float(values.max())


def _widest(gravity: Array) -> float:
    """The largest angle [rad] between two of the directions (K, 3), to a few degrees:
    that between those which reach farthest along each of 200 axes."""
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
    ends = unit[np.argmax(unit @ axes, axis=0)]
    return float(np.arccos(np.clip((ends @ ends.T).min(), -1.0, 1.0)))


@immutable
class Channels:
    """Signal and noise of three channels, x, y and z in sensor axes."""

    unit: str
    signal: Array
    """(3,) root mean square"""
    noise: Array
    """(3,) standard deviation"""

    def __post_init__(self):
        freeze(self, "signal", "noise")

    @property
    def snr(self) -> Array:
        """(3,) mean-squared signal over noise variance; infinite without noise."""
        with np.errstate(divide="ignore", invalid="ignore"):
            return np.where(self.noise > 0.0, (self.signal / self.noise) ** 2, np.inf)


@immutable
class WrenchFacts:
    """Facts about sensor and object from the wrench."""

    mass: float
    """kg, by least squares with a free bias if that determines it, otherwise without"""
    mass_std: float
    """kg; infinite if undetermined"""
    quick_mass_less_bias: float | None
    """kg: mean |f| / |g| without the bias; None if the bias is unknown"""
    bias: Array | None
    """(6,) as recorded [N, N m], its mean if it drifts; None if the motion does not
    separate it from the object"""
    bias_t: Array | None
    """(6,) the bias over its standard deviation"""
    noise: tuple[float, float]
    """root-mean-square residual of force [N] and torque [N m]"""
    channels: dict[str, Channels]
    """``force`` and ``torque``: as predicted from the object's motion and weight, with
    the residual as noise; and if the motion was smoothed here ``linear acceleration``,
    ``angular velocity``, ``angular acceleration`` with their standard deviations"""
    gravity_dominance: tuple[float, float] | None
    """root mean square of the part of gravity over that of motion, of force and of
    torque; infinite without motion. In daily living it is about five (Nadeau et al. 2022,
    sec. III). None if no mass is found, or only gravity is modelled although the sensor
    moves"""


def wrench_facts(found: Ingested, fit: FreeFit, comparable: bool) -> WrenchFacts:
    """Facts of a recording and an unconstrained fit to it.

    `comparable`: whether a mass was found, and motion is modelled as well as gravity.
    """
    z, turn = found.measurements, 1.0 if found.sign.on_object else -1.0
    explained = predict_wrench(z, fit.vector)
    residual = residuals(z, fit.vector, fit.bias)
    channels = {}
    parts = (("force", "N", slice(0, 3)), ("torque", "N m", slice(3, 6)))
    for name, unit, part in parts:
        square = (
            found.counts @ residual[:, part] ** 2 / found.counts.sum()
            + found.within.diagonal()[part]
        )
        channels[name] = Channels(unit, _rms(explained[:, part]), np.sqrt(square))
    if found.motion is not None:
        channels |= _motion_channels(found.motion)
    noise = residual_size(residual, found.counts, found.within)
    g = float(np.linalg.norm(z.gravity, axis=1).mean())
    bare = (
        None
        if fit.bias is None
        else float(np.linalg.norm(z.force - fit.bias[:3], axis=1).mean())
        / max(g, 1e-300)
    )
    return WrenchFacts(
        mass=abs(fit.mass),
        mass_std=fit.mass_std,
        quick_mass_less_bias=bare,
        bias=None if fit.bias is None else turn * fit.bias,
        bias_t=None if fit.bias is None else turn * fit.bias_t,
        noise=(float(noise[0]), float(noise[1])),
        channels=channels,
        gravity_dominance=_dominance(z, fit.vector, explained) if comparable else None,
    )


def _motion_channels(motion: Motion) -> dict[str, Channels]:
    channels = {}
    quantities = (
        ("linear_acceleration", "m/s²"),
        ("angular_velocity", "rad/s"),
        ("angular_acceleration", "rad/s²"),
    )
    for name, unit in quantities:
        values, std = getattr(motion, name), getattr(motion, f"{name}_std")
        if values is not None and std is not None:
            noise = np.full(3, float(np.sqrt(np.mean(np.square(std)))))
            channels[name.replace("_", " ")] = Channels(unit, _rms(values), noise)
    return channels


def _dominance(z: Measurements, vector: Array, explained: Array) -> tuple[float, float]:
    zero = np.zeros_like(z.gravity)
    still = replace(
        z, linear_acceleration=zero, angular_velocity=zero, angular_acceleration=zero
    )
    weight = predict_wrench(still, vector)
    moving = explained - weight
    ratios = []
    for part in (slice(0, 3), slice(3, 6)):
        heavy, other = (
            float(np.sqrt(np.mean(x[:, part] ** 2))) for x in (weight, moving)
        )
        ratios.append(heavy / other if other > 1e-9 * heavy else float("inf"))
    return ratios[0], ratios[1]


def _rms(values: Array) -> Array:
    return np.sqrt(np.mean(np.square(values), axis=0))
