"""What the wrench says: the object as least squares sees it, bias, noise, SNR, and how
far gravity dominates."""

from dataclasses import dataclass, replace

import numpy as np

from hefting.core.measurements import Measurements
from hefting.core.regressor import predict_wrench
from hefting.core.spatial import Array, frozen
from hefting.ingest.averages import residual_size
from hefting.ingest.free_fit import FreeFit
from hefting.ingest.ingest import Ingested
from hefting.motion.state import Motion


@dataclass(frozen=True, eq=False)
class Channels:
    """Signal and noise of three channels, x, y and z in sensor axes."""

    unit: str
    signal: Array
    """(3,) root mean square"""
    noise: Array
    """(3,) standard deviation"""

    def __post_init__(self):
        for name in ("signal", "noise"):
            object.__setattr__(self, name, frozen(getattr(self, name)))

    @property
    def snr(self) -> Array:
        """(3,) mean-squared signal over the variance of the noise; infinite without
        noise."""
        with np.errstate(divide="ignore", invalid="ignore"):
            return np.where(self.noise > 0.0, (self.signal / self.noise) ** 2, np.inf)


@dataclass(frozen=True, eq=False)
class WrenchFacts:
    """What the wrench says of sensor and object."""

    mass: float
    """kg, by least squares beside a free bias, where that is determined, else
    without"""
    mass_std: float
    """kg; infinite where undetermined"""
    quick_mass_less_bias: float | None
    """kg: mean |f| / |g| once the bias is taken away; None where the bias is not
    known"""
    bias: Array | None
    """(6,) as recorded [N, N m], its mean where it drifts; None where the motion cannot
    tell it from the object"""
    bias_t: Array | None
    """(6,) the bias over its standard deviation"""
    noise: tuple[float, float]
    """root-mean-square residual of force [N] and torque [N m]"""
    channels: dict[str, Channels]
    """``force`` and ``torque``: what the object's motion and weight need, beside what
    is left unexplained; and where the motion was smoothed here ``linear acceleration``,
    ``angular velocity``, ``angular acceleration`` beside their standard deviations"""
    gravity_dominance: tuple[float, float] | None
    """root-mean-square of what gravity needs over that of what motion needs, of force
    and of torque; infinite without motion. In daily living it is about five (Nadeau et
    al. 2022, sec. III). None where no mass is found, or only gravity is modelled
    although the sensor moves"""


def wrench_facts(found: Ingested, fit: FreeFit, comparable: bool) -> WrenchFacts:
    """Facts of a recording and an unconstrained fit to it.

    `comparable`: a mass was found, and motion is modelled beside gravity.
    """
    z, turn = found.measurements, 1.0 if found.sign.on_object else -1.0
    explained = predict_wrench(z, fit.vector)
    left = z.wrench - explained if fit.bias is None else z.wrench - explained - fit.bias
    channels = {}
    parts = (("force", "N", slice(0, 3)), ("torque", "N m", slice(3, 6)))
    for name, unit, part in parts:
        square = (
            found.counts @ left[:, part] ** 2 / found.counts.sum()
            + found.within.diagonal()[part]
        )
        channels[name] = Channels(unit, _rms(explained[:, part]), np.sqrt(square))
    if found.motion is not None:
        channels |= _motion_channels(found.motion)
    noise = residual_size(left, found.counts, found.within)
    g = float(np.linalg.norm(z.gravity, axis=1).mean())
    bare = (
        None
        if fit.bias is None
        else float(np.linalg.norm(z.force - fit.bias[:3], axis=1).mean())
        / max(g, 1e-300)
    )
    return WrenchFacts(
        mass=abs(float(fit.vector[0])),
        mass_std=float(np.sqrt(fit.covariance[0, 0])),
        quick_mass_less_bias=bare,
        bias=None if fit.bias is None else turn * fit.bias,
        bias_t=None if fit.bias is None else turn * fit.bias_t,
        noise=(float(noise[0]), float(noise[1])),
        channels=channels,
        gravity_dominance=_dominance(z, fit.vector, explained) if comparable else None,
    )


def _motion_channels(motion: Motion) -> dict[str, Channels]:
    found = {}
    quantities = (
        ("linear_acceleration", "m/s²"),
        ("angular_velocity", "rad/s"),
        ("angular_acceleration", "rad/s²"),
    )
    for name, unit in quantities:
        values, std = getattr(motion, name), getattr(motion, f"{name}_std")
        if values is not None and std is not None:
            noise = np.full(3, float(np.sqrt(np.mean(np.square(std)))))
            found[name.replace("_", " ")] = Channels(unit, _rms(values), noise)
    return found


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
    """(3,) of the columns of (K, 3)."""
    return np.sqrt(np.mean(np.square(values), axis=0))
