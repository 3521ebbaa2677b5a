"""Result of conditioning a recording, and the corrected recording."""

from dataclasses import dataclass, field, replace

import numpy as np

from hefting.core.measurements import Noise
from hefting.core.messages import Message
from hefting.core.recording import Recording, Stream
from hefting.core.spatial import Array, Mask, freeze, immutable, own
from hefting.ingest.changes.stretches import Changes
from hefting.ingest.drift import Drift
from hefting.ingest.outliers import Outliers
from hefting.ingest.path import Path
from hefting.motion import Curves

SIGNIFICANT = 3.0
"""Number of standard deviations from zero at which a clock offset, a mass or a bias
counts as significant."""
LEAST_MASS = 0.005
"""[kg] Upper bound of a mass below which nothing is held."""
SIGN_CONFIDENCE = 10.0
"""Least |t| of the mass for its sign to decide the wrench's sign convention."""


def mass_over_std(mass: float, std: float) -> float:
    """A mass over its standard deviation [kg], bounded where there is no noise."""
    return mass / max(std, 1e-12 * abs(mass), 1e-300)


def mean_inflation(inflation: Array, covariance: Array) -> float:
    """Mean inflation of the determined parameters; 1 if none is."""
    known = np.isfinite(covariance.diagonal()[:10])
    return float(np.mean(inflation[:10][known])) if known.any() else 1.0


@dataclass(frozen=True)
class WrenchSign:
    """Sign convention of the recorded wrench, from the sign of the estimated mass."""

    on_object: bool
    """True if the log holds what the sensor exerts on the object; False if what the
    object exerts on the sensor."""
    t: float
    """Mass over its standard deviation, as recorded: positive for on-object."""

    @property
    def certain(self) -> bool:
        """Whether the data determine it."""
        return abs(self.t) >= SIGN_CONFIDENCE

    @property
    def doubt(self) -> str:
        """Reason why it is uncertain."""
        if abs(self.t) < 1.0:
            return "beside a bias of the wrench, the mass cannot be told from zero"
        return (
            f"the mass is {abs(self.t):.1f} standard deviations from zero, and "
            f"{SIGN_CONFIDENCE:g} would tell"
        )

    @property
    def name(self) -> str:
        """``"on-object"`` or ``"on-sensor"``."""
        return "on-object" if self.on_object else "on-sensor"


@immutable
class GravityEstimate:
    """Gravity as estimated for information, where its direction was given."""

    gravity: Array
    """(3,) in world axes [m/s²]"""
    std: float
    """[rad] of the direction about each axis"""


@immutable
class Conditioned:
    """Clock offset, sign, bias, gravity, noise and outliers of a recording."""

    parameters: Array
    """(10,) by least squares on the inliers, with the sign convention of
    `hefting.core.spatial`"""
    covariance: Array
    """(10, 10) of the parameters for coloured residuals, with the uncertainty of
    offset, bias and gravity; infinite where open"""
    offset: float
    """[s] by which the wrench is late: stamped t, it shows the motion at t - offset.
    Zero unless significant."""
    offset_std: float | None
    """[s] infinite if the recording does not determine it, None if it was not asked for
    or there is no motion"""
    sign: WrenchSign
    """sign convention of the recorded wrench"""
    bias: Drift
    """as recorded, as a function of time"""
    biased: bool
    """whether the motion separates a bias from the weight; if not, none is assumed"""
    gravity: Array
    """(3,) in world axes [m/s²], as given or found"""
    tilt_std: float | None
    """[rad] of gravity's direction about each axis; infinite if the motion does not
    determine it, None if it was given or is measured"""
    tilted: GravityEstimate | None
    """gravity as estimated for information; None if not asked for"""
    noise: Noise
    """of the wrench, by the root mean square of the residuals; of the accelerations, by
    smoothing"""
    rejected: Mask
    """(K,) wrench samples left out"""
    reasons: dict[str, int]
    """number of samples left out as contact, spikes and saturation"""
    inflation: Array
    """(16,) variance of parameters and bias components over that for white residuals"""
    findings: tuple[Message, ...]
    """sentences on what was found and corrected"""
    warnings: tuple[Message, ...] = ()
    """messages on what was not found, and on doubts"""
    offset_left: float = 0.0
    """[s] a significant clock offset that was not removed, as it explains too little of
    the wrench, or half of the difference to a longer lag that fits as well; else zero
    """
    path: Path | None = field(default=None, repr=False)
    """the motion that was fitted: as logged, or filtered like a filtered wrench"""
    changes: Changes | None = None
    """of the object; None if there are none"""
    curves: Curves | None = field(default=None, repr=False)
    """smooth curves of the poses, if these were smoothed"""
    outliers: Outliers | None = field(default=None, repr=False)
    """the samples left out, by cause"""

    def __post_init__(self):
        freeze(self, "parameters", "covariance", "gravity", "inflation")
        object.__setattr__(self, "rejected", own(np.array(self.rejected, dtype=bool)))

    @property
    def autocorrelation(self) -> float:
        """Mean ratio of the parameters' variances to those for white residuals."""
        return mean_inflation(self.inflation, self.covariance)

    @property
    def std(self) -> Array:
        """(10,) standard deviations of the parameters."""
        return np.sqrt(self.covariance.diagonal())

    def without_samples(self) -> "Conditioned":
        """The same without arrays as long as the recording."""
        return replace(
            self,
            rejected=self.rejected[:0],
            path=None,
            changes=None,
            curves=None,
            outliers=None,
        )

    @property
    def kept(self) -> Mask:
        """(K,) wrench samples that were not rejected; all if all were."""
        return np.ones_like(self.rejected) if self.rejected.all() else ~self.rejected

    def corrected(self, recording: Recording, drift: bool = True) -> Recording:
        """The recording with its wrench synchronised with the motion, without drift and
        rejected samples.

        The constant part of the bias is not removed: every estimator determines it
        along with the inertial parameters. Where every sample was rejected, all are
        kept. With `drift` the drift of the bias is removed, which is not where the bias is
        known. Where nothing is to be corrected it is the `recording` itself.
        """
        remove_drift = drift and self.bias.kind != "constant"
        if not (self.offset or remove_drift or self.rejected.any()):
            return recording
        wrench, kept = recording["wrench"], self.kept
        values = wrench.values
        if remove_drift:
            values = values - self.bias.change(wrench.time)
        wrench = Stream(
            (wrench.time - self.offset)[kept], values[kept], wrench.rows[kept]
        )
        streams = {**recording.streams, "wrench": wrench}
        if recording.static:  # a static pose is dropped together with its wrench
            streams = {
                name: s if name == "wrench" else s[np.isin(s.rows, wrench.rows)]
                for name, s in streams.items()
            }
        return replace(recording, streams=streams)
