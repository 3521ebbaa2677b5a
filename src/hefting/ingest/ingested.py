"""Ingested: a recording with all that estimators need to know of it."""

from dataclasses import replace
from functools import cached_property
from typing import Any

import numpy as np

from hefting.core.estimate import Estimate
from hefting.core.immutable import immutable
from hefting.core.measurements import Measurements, MotionNoise, Noise
from hefting.core.messages import Message
from hefting.core.spatial import Array
from hefting.estimators.base import BiasModel
from hefting.estimators.joint_state import State
from hefting.ingest.changes.stretches import Changes
from hefting.ingest.condensed import Condensed, Excitation
from hefting.ingest.conditioned import Conditioned, WrenchSign
from hefting.ingest.free_fit import FreeFit
from hefting.ingest.left_out import Span
from hefting.ingest.rivals.consequence import Doubt
from hefting.motion.measure import DESCRIPTIONS
from hefting.motion.state import Motion


@immutable
class Ingested:
    """A recording as estimators take it, and what was found and assumed."""

    log: str
    """Path of the log, or a description of its source."""
    static: bool
    """Whether it consists of poses without time."""
    measurements: Measurements
    """With the sign convention of `hefting.core.spatial`, without a given bias and the
    tool, with weights. Of a fast sensor they are averages over 10 ms, each with the
    weight of its number of samples."""
    counts: Array
    """(K,) number of samples of the log that are averaged in each of these."""
    motion: Motion | None
    """Smoothed motion at the same instants, with standard deviations; None where the
    log gave it, or there is none."""
    source: str
    """How the motion was found: a key of `hefting.motion.measure.DESCRIPTIONS`."""
    sign: WrenchSign
    """Sign convention of the recorded wrench, with the t value of the mass."""
    sign_found: bool
    """Whether the sign convention was found rather than given."""
    bias: BiasModel
    """Whether a constant bias is to be estimated with the object."""
    bias_found: bool
    """Whether the bias model was chosen rather than given."""
    given_bias: Array | None
    """(6,) bias that was subtracted, in the sign of the recorded wrench [N, N m]; None
    where none was given"""
    conditioned: Conditioned
    """Clock offset, drift, gravity and outliers."""
    tool: Estimate | None
    """Estimate of the tool whose wrench was subtracted."""
    fit: FreeFit
    """Unconstrained least squares of the object, with a bias according to `bias`."""
    beside_bias: FreeFit
    """Unconstrained least squares of object and tool together with a free bias,
    whatever `bias` says."""
    alone: FreeFit
    """Unconstrained least squares of object and tool together without bias."""
    noise: Noise
    """Root-mean-square residuals of the unconstrained fit, of one sample of the log and
    one axis."""
    within: Array
    """(6, 6) covariance of the wrench within the averages. Added to that of their
    residuals it gives that of a sample's residuals"""
    systematic: Array | None
    """(10, 10) covariance of the parameters' error due to tool and gravity's direction,
    the same for all samples; None where there is none."""
    clock_error: Array | None
    """(10,) error of the parameters by one standard deviation of the clock offset; None
    where there is no clock or no motion."""
    doubt: Doubt | None
    """A mistake that explains the recording far better than that there is none, or that
    much is unexplained; it is among the warnings."""
    gravity_std: float
    """[m/s²] standard deviation of gravity's size; 0 where it was given"""
    gravity_error: Array | None
    """(10,) error of the parameters by one standard deviation of gravity's size; None
    where that is exact."""
    warnings: tuple[Message, ...]
    read_notes: tuple[Message, ...]
    """What reader and smoother chose and found, for the user."""
    changes: Changes | None = None
    """Changes of the object in the log, with times since its first sample; None where
    none were found."""
    left_out: tuple[Span, ...] = ()
    """What of the log was left out, with times since its first sample."""
    log_start: float = 0.0
    """[s] time of the first sample of the log, on the clock of the measurements"""
    kept: Condensed | None = None
    """What was found of the measurements before; they themselves may be gone then."""

    @property
    def notes(self) -> tuple[Message, ...]:
        """What reader, smoother and conditioning found and did."""
        return (*self.read_notes, *self.conditioned.findings)

    @cached_property
    def condensed(self) -> Condensed:
        """What is needed of the measurements once they are understood."""
        return self.kept or Condensed.of(self.measurements, self.counts)

    def without_samples(self) -> "Ingested":
        """The same without measurements and all that is as long as these; what shows
        them has nothing to show then."""
        none = np.zeros(0, dtype=int)  # copies: a view would keep all samples
        return replace(
            self,
            measurements=self.measurements[none],
            counts=self.counts[none],
            motion=None,
            conditioned=self.conditioned.without_samples(),
            left_out=(),
            kept=self.condensed,
        )

    def weighed(self, weight: float) -> "Ingested":
        """The same with so many times the weight of each measurement."""
        z = self.measurements
        own = np.ones(len(z)) if z.weights is None else z.weights
        z = replace(z, weights=weight * own)
        return replace(self, measurements=z, kept=self.condensed.weighed(weight))

    @property
    def has_samples(self) -> bool:
        """Whether the measurements are there."""
        return len(self.measurements) == self.rows

    @property
    def rows(self) -> int:
        """Number of measurements, also where they are gone."""
        return self.condensed.rows

    @property
    def samples(self) -> float:
        """Number of samples of the log that are averaged in these."""
        return self.condensed.samples

    @property
    def motion_noise(self) -> MotionNoise | None:
        """Errors of the accelerations, where known."""
        return self.condensed.motion_noise

    @property
    def wrench_rms(self) -> Array:
        """(2,) root mean square of one axis of force [N] and torque [N m]."""
        return np.sqrt(self.condensed.wrench_square / (3.0 * max(self.rows, 1)))

    @property
    def excitation(self) -> Excitation:
        """What the motion can tell of a body."""
        return Excitation(self.condensed.state.full, self.condensed.directions)

    @property
    def weighted_by_count(self) -> Measurements:
        """The measurements with weights of one on average for each sample of the log,
        not for each row."""
        z = self.measurements
        if z.weights is None:
            return z
        return replace(z, weights=z.weights * float(self.counts.mean()))

    @property
    def common_errors(self) -> Array | None:
        """(10, 10) covariance of all errors of the parameters that the samples share:
        `systematic`, and those of the clock and of gravity's size; None where there are
        none."""
        errors = [e for e in (self.clock_error, self.gravity_error) if e is not None]
        parts = [np.outer(error, error) for error in errors]
        parts += [] if self.systematic is None else [self.systematic]
        return np.sum(parts, axis=0) if parts else None

    @property
    def recordings(self) -> "tuple[Ingested, ...]":
        """Each recording, where there are several (`hefting.ingest.joint`)."""
        return (self,)

    @property
    def duration(self) -> float | None:
        """[s] from the first to the last of the measurements, summed over recordings;
        None for static poses."""
        if self.static:
            return None
        moving = [part for part in self.recordings if not part.static]
        return sum(part.condensed.span for part in moving)

    @property
    def covariance_with_gravity(self) -> Array | None:
        """(10, 10) covariance of the parameters by the fit that found gravity too; None
        where gravity was given."""
        c = self.conditioned
        return None if c.tilt_std is None else c.covariance

    @property
    def state(self) -> State:
        """The full model's moments of the measurements, with a record of time."""
        return self.condensed.state

    def residual(self, vector: Array, bias: Array | None) -> Array:
        """Root mean square (2,) of the force [N] and torque [N m] residuals, of one
        sample of the log and one axis.

        `vector` (10,) are the parameters, `bias` (6,) the bias [N, N m].
        """
        square = self.condensed.residual_square(vector, bias) + self.within.diagonal()
        return np.sqrt(square.reshape(2, 3).mean(axis=1))

    @property
    def provenance(self) -> dict[str, Any]:
        """What was read and assumed, as in an estimate."""
        return {
            "log": self.log,
            "gravity": self.conditioned.gravity,
            "gravity_std": self.gravity_std,
            "gravity_found": self.conditioned.tilt_std is not None,
            "wrench": self.sign.name,
            "wrench_found": self.sign_found,
            "bias": "given" if self.given_bias is not None else self.bias,
            "bias_searched": self.bias_found,
            "bias_subtracted": self.given_bias,
            "noise": {"force": self.noise.force, "torque": self.noise.torque},
            "motion": DESCRIPTIONS[self.source],
            "clock_offset": self.conditioned.offset,
            "outliers": self.conditioned.reasons,
            "tool": None if self.tool is None else self.tool.parameters.vector.tolist(),
            "stretches": [] if self.changes is None else self.changes.to_dicts(),
            "notes": list(self.notes),
        }
