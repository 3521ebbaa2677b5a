"""Ingested: a recording with all that estimators need to know of it."""

from dataclasses import replace
from functools import cached_property
from typing import Any

import numpy as np

from hefting.core.estimate import Estimate
from hefting.core.measurements import Measurements, MotionNoise, Noise
from hefting.core.messages import Message
from hefting.core.spatial import Array, immutable
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
    """A recording as estimators take it, with what was found and assumed."""

    log: str
    """Path of the log, or a description of its source."""
    static: bool
    """Whether it consists of poses without time."""
    measurements: Measurements
    """With the sign convention of `hefting.core.spatial`, without a given bias and the
    tool. With a fast sensor they are averages over 10 ms, weighted by their numbers of
    samples."""
    counts: Array
    """(K,) number of samples of the log averaged in each measurement."""
    motion: Motion | None
    """Smoothed motion at the same instants, with standard deviations; None if the log
    has the motion, or there is none."""
    source: str
    """Source of the motion: a key of `hefting.motion.measure.DESCRIPTIONS`."""
    sign: WrenchSign
    """Sign convention of the recorded wrench."""
    sign_found: bool
    """Whether the sign convention was found rather than given."""
    bias: BiasModel
    """Whether to estimate a constant bias with the object."""
    bias_found: bool
    """Whether the bias model was chosen rather than given."""
    given_bias: Array | None
    """(6,) bias that was subtracted, with the sign of the recorded wrench [N, N m];
    None for none."""
    conditioned: Conditioned
    """Clock offset, drift, gravity and outliers."""
    tool: Estimate | None
    """Estimate of the tool whose wrench was subtracted."""
    fit: FreeFit
    """Unconstrained least squares of the object, with a bias as in `bias`."""
    beside_bias: FreeFit
    """Unconstrained least squares of object and tool together with a free bias,
    whatever `bias` says."""
    alone: FreeFit
    """Unconstrained least squares of object and tool together without bias."""
    noise: Noise
    """Root-mean-square residuals of the unconstrained fit, of a sample of the log and
    one axis."""
    within: Array
    """(6, 6) covariance of the wrench about the averages. Added to that of the
    averages' residuals it gives that of a sample's."""
    systematic: Array | None
    """(10, 10) covariance of the parameters' error by the tool and gravity's direction,
    which all samples share; None for none."""
    clock_error: Array | None
    """(10,) error of the parameters by one standard deviation of the clock offset; None
    without a clock or motion."""
    doubt: Doubt | None
    """A mistake that explains the recording far better, or that much is unexplained; it
    is among the warnings."""
    gravity_std: float
    """[m/s²] Standard deviation of gravity's size; 0 if it was given."""
    gravity_error: Array | None
    """(10,) error of the parameters by one standard deviation of gravity's size; None
    if that is exact."""
    warnings: tuple[Message, ...]
    read_notes: tuple[Message, ...]
    """Notes of reader and smoother."""
    changes: Changes | None = None
    """Changes of the object, with times since the log's first sample; None for none."""
    left_out: tuple[Span, ...] = ()
    """Parts of the log that were left out, with times since its first sample."""
    log_start: float = 0.0
    """[s] Time of the log's first sample on the clock of the measurements."""
    kept: Condensed | None = None
    """Sums over the measurements, if those were let go."""

    @property
    def notes(self) -> tuple[Message, ...]:
        """Notes of reader, smoother and conditioning."""
        return (*self.read_notes, *self.conditioned.findings)

    @cached_property
    def condensed(self) -> Condensed:
        """Sums over the measurements that replace them once they are understood."""
        return self.kept or Condensed.of(self.measurements, self.counts)

    def without_samples(self) -> "Ingested":
        """The same without measurements and other arrays of their length."""
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
        """The same with every weight multiplied by `weight`."""
        z = self.measurements
        own = np.ones(len(z)) if z.weights is None else z.weights
        z = replace(z, weights=weight * own)
        return replace(self, measurements=z, kept=self.condensed.weighed(weight))

    @property
    def has_samples(self) -> bool:
        """Whether it has its measurements."""
        return len(self.measurements) == self.rows

    @property
    def rows(self) -> int:
        """Number of measurements, also if those were let go."""
        return self.condensed.rows

    @property
    def samples(self) -> float:
        """Number of samples of the log that the measurements average."""
        return self.condensed.samples

    @property
    def motion_noise(self) -> MotionNoise | None:
        """Errors of the accelerations, if known."""
        return self.condensed.motion_noise

    @property
    def wrench_rms(self) -> Array:
        """(2,) root mean square of one axis of force [N] and torque [N m]."""
        return np.sqrt(self.condensed.wrench_square / (3.0 * max(self.rows, 1)))

    @property
    def excitation(self) -> Excitation:
        """How the motion excites the parameters."""
        return Excitation(self.condensed.state.full, self.condensed.directions)

    @property
    def weighted_by_count(self) -> Measurements:
        """The measurements with a mean weight of one a sample of the log, not a row."""
        z = self.measurements
        if z.weights is None:
            return z
        return replace(z, weights=z.weights * float(self.counts.mean()))

    @property
    def common_errors(self) -> Array | None:
        """(10, 10) covariance of all errors that the samples share: `systematic`, and
        those of the clock and of gravity's size; None for none."""
        errors = [e for e in (self.clock_error, self.gravity_error) if e is not None]
        parts = [np.outer(error, error) for error in errors]
        parts += [] if self.systematic is None else [self.systematic]
        return np.sum(parts, axis=0) if parts else None

    @property
    def recordings(self) -> "tuple[Ingested, ...]":
        """The recordings, of which there may be several (`hefting.ingest.joint`)."""
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
    def state(self) -> State:
        """State of the full model, with a time record."""
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
        """What was read and assumed, for an estimate's provenance."""
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
