"""PointEstimator: base of the methods that find a point, which get their intervals from
here.

A scale's reading is one row more of their equations (`MassRow`).

Let m_s be the reading, s its standard deviation. The wrench is wrong by a gain that all
channels share, g, and by other errors. With the parameters as the sensor shows them,
psi = (1 + gain) phi, the gain is minimised out of

    |A psi - b|² + (m - m_s)² / s² + gain² / g²,   m = psi_0 / (1 + gain)

to first order: a row for psi_0 of the deviation d, d² = s² + (g m)², beside the
equations as they are; afterwards the share (g m)² / d² of what is left between psi_0
and m_s is the gain's, and psi is scaled by it. Scaling leaves a body a body, and masses
that are not negative so. Errors that all samples share (`systematic`, of gravity's size
above all) count as gain.

A method's own equations do not tell their errors (`point_intervals`). So the row weighs
as much beside them as the reading beside the mass by the likelihood of all samples: its
square is (c² / q) / d², c² the variance of the mass there without the gain's, q that by
the method's equations if the variance of each were one.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from hefting.core.errors import InputError
from hefting.core.estimate import Estimate
from hefting.core.inertia import InertialParameters
from hefting.core.messages import Message
from hefting.core.quantity import MassReading
from hefting.core.sensor_accuracy import SensorAccuracy
from hefting.core.spatial import Array, immutable
from hefting.estimators.base import Estimator, Known, stated_errors, take_errors
from hefting.estimators.bayes.likelihood import scale_doubts
from hefting.estimators.joint_state import State
from hefting.estimators.point_intervals import intervals_of
from hefting.estimators.possible_bodies import PossibleBodies
from hefting.estimators.quadratic import ScaledSVD
from hefting.estimators.sample_state import SampleState
from hefting.estimators.state_likelihood import StateSamples

LEAST_OWN_SHARE = 1e-6
"""Least share of the mass's variance that is not by the gain."""


@immutable
class MassRow:
    """A scale's reading as a row, and the gain of the sensor implied; else `NO_ROW`."""

    weight: float
    """[1/kg] of the row, in units of the method's equations"""
    mass: float
    """[kg] m_s"""
    gain_share: float
    """share of the difference between reading and wrench attributed to the gain"""
    doubts: tuple[Message, ...] = ()
    """messages on a reading that contradicts the wrench"""

    @classmethod
    def of(
        cls,
        reading: MassReading,
        samples: StateSamples,
        systematic: Array | None,
        A: Array,
    ) -> MassRow:
        """For the equations A (r, 10) of a method, with the bias eliminated; a reading
        that contradicts the wrench is left out."""
        svd = ScaledSVD.of(A)
        own = float(np.sum(np.square(svd.V[:, 0] / svd.S))) / svd.scale[0] ** 2
        if not samples.informative or not own > 0.0:
            return cls(1.0 / reading.std, reading.mass, 0.0)
        likelihood = samples.of_wrench(systematic)
        mass, variance = likelihood.mass
        source = samples.source
        gain = source.allowed.gain_std**2 * (mass + float(source.carried[0])) ** 2
        if systematic is not None:
            gain += float(systematic[0, 0])
        doubts = scale_doubts(likelihood, reading, source.carried)
        if doubts:
            return replace(NO_ROW, doubts=doubts)
        square, other = reading.std**2 + gain, max(variance - gain, 0.0)
        if not np.isfinite(variance):  # only the row determines the mass
            square = other = reading.std**2
        other = max(other, LEAST_OWN_SHARE * (other + gain))
        return cls(
            (other / own / square) ** 0.5, reading.mass, 1.0 - reading.std**2 / square
        )

    @property
    def equation(self) -> Array | None:
        """(11,) row and right-hand side; None without a reading."""
        if self.weight == 0.0:
            return None
        row = np.zeros(11)
        row[[0, 10]] = self.weight, self.weight * self.mass
        return row

    def applied(self, estimate: Estimate) -> Estimate:
        """Estimate of the object, from one of what the sensor shows by the row."""
        if self.weight == 0.0 and not self.doubts:
            return estimate
        warnings = (*estimate.warnings, *self.doubts)
        if self.weight == 0.0:
            return replace(estimate, warnings=warnings)
        shown = estimate.parameters.mass
        gain = self.gain_share * (shown - self.mass) / shown if shown > 0.0 else 0.0
        masses = estimate.point_masses
        return replace(
            estimate,
            parameters=InertialParameters((1.0 - gain) * estimate.parameters.vector),
            point_masses=None if masses is None else (1.0 - gain) * masses,
            covariance=None,
            warnings=warnings,
            provenance=estimate.provenance | {"sensor_gain": gain / (1.0 - gain)},
        )


NO_ROW = MassRow(0.0, 0.0, 0.0)
"""For an object that was not weighed, or a reading that was left out."""


@dataclass(frozen=True, eq=False)
class PointEstimator(Estimator):
    """A method whose estimate is a point; `with_intervals` adds the intervals, for the
    objects that `possible_bodies` allows."""

    gives_covariance = True
    keeps_time_record = True

    systematic: Array | None = field(default=None, kw_only=True)
    """Covariance (10, 10) of an error in the parameters that more samples do not
    lessen, for the intervals: that of a tool whose wrench was subtracted, or of
    gravity's direction."""
    carried: Array | None = field(default=None, kw_only=True)
    """Parameters (10,) of what the sensor holds besides the object, a tool whose wrench
    was subtracted, for the intervals: errors of the sensor follow the wrench of
    both."""
    sensor_accuracy: SensorAccuracy | str | None = field(default=None, kw_only=True)
    """How far the sensor may be off, for the intervals, as in ``0.5% 0.3N 0.01Nm``, or
    a sensor's name (`SensorAccuracy`). None: half a percent, and nothing beside a given
    `noise`."""
    mass: MassReading | tuple[float, float] | str | None = field(
        default=None, kw_only=True
    )
    """What a scale showed of the object alone, as in ``0.512kg±1g``, with one standard
    deviation (`MassReading`): a row more of the method's equations. It needs
    `intervals`, which tell what the row weighs."""
    noise_found: bool = field(default=False, kw_only=True)
    """Whether `noise`, by which the method weighs, was found in the residuals; the
    intervals then find it anew, with its colour."""
    intervals: bool = field(default=True, kw_only=True)
    """Whether estimates have intervals. Without them a state keeps no record of time,
    and an estimate takes the time of the method alone."""

    def __post_init__(self):
        super().__post_init__()
        take_errors(self)
        if self.mass is not None and not self.intervals:
            raise InputError(
                "without intervals it is not known what a scale's reading weighs beside "
                "the wrench",
                fix="intervals=True, or no mass",
            )

    @classmethod
    def settings(cls, known: Known, model: str | None = None) -> dict[str, Any]:
        """As `Estimator.settings`, with the error of all samples, and the tool."""
        own = {
            "systematic": known.systematic,
            "carried": known.carried,
            "noise_found": True,
        }
        return super().settings(known, model) | own

    @property
    def provenance(self) -> dict[str, Any]:
        """As `Estimator.provenance`; what only the intervals depend on is left out
        without them."""
        found = super().provenance | stated_errors(self)
        unused = () if self.intervals else ("sensor_accuracy",)
        left_out = ("intervals", "noise_found", *unused)
        return {name: value for name, value in found.items() if name not in left_out}

    def start(self) -> SampleState:
        """The state before any sample."""
        return SampleState.empty(self.intervals)

    def possible_bodies(self, center: Array) -> PossibleBodies | None:
        """Objects that the method takes for possible, given the COM of least squares
        `center` (3,) [m]; None for any ten numbers. By default, for a method whose
        estimates are bodies, any body."""
        return PossibleBodies.any(center) if self.consistent else None

    def mass_row(self, state: State, A: Array) -> MassRow:
        """A scale's reading as a row beside the method's equations A (r, 10); `NO_ROW`
        without one. Raises `InputError` for a state without a time record."""
        reading = MassReading.of(self.mass)
        if reading is None:
            return NO_ROW
        samples = self._require_samples(state)
        return MassRow.of(reading, samples, self.systematic, A)

    def answer(
        self, vector: Array, state: State, row: MassRow, **more: Any
    ) -> Estimate:
        """The estimate with parameters `vector` (10,) and `more` of its fields, see
        `with_intervals`."""
        found = Estimate(
            method=self.name,
            parameters=InertialParameters(vector),
            samples=state.samples,
            duration=state.duration,
            **more,
        )
        return self.with_intervals(found, state, row)

    def with_intervals(
        self, estimate: Estimate, state: State, row: MassRow = NO_ROW
    ) -> Estimate:
        """The estimate, corrected by the `row` of a scale, with intervals and their
        covariance about it, infinite also where that of the estimate is; unchanged for a
        state without a time record."""
        estimate = row.applied(estimate)
        samples = self._samples(state) if self.intervals else None
        if samples is None:
            return estimate
        reading = MassReading.of(self.mass) if row.weight else None
        found, covariance = self._uncertainty(estimate.parameters, samples, reading)
        if (own := estimate.covariance) is not None:  # what the method leaves open
            covariance = np.where(np.isfinite(own), covariance, own)
        return replace(estimate, intervals=found, covariance=covariance)

    def uncertainty(
        self, body: InertialParameters, state: State
    ) -> tuple[dict[str, Array], Array]:
        """95 % intervals about an estimate, and the mean square (10, 10) of the truth's
        distance from it, with all errors that are allowed for; infinite where the
        samples leave something open. Raises `InputError` for a state without a time
        record."""
        reading = MassReading.of(self.mass)
        return self._uncertainty(body, self._require_samples(state), reading)

    def _require_samples(self, state: State) -> StateSamples:
        """Samples of a state; `InputError` without a time record."""
        samples = self._samples(state)
        if samples is None:
            raise InputError("the state keeps no record of time", fix="intervals=True")
        return samples

    def _samples(self, state: State) -> StateSamples | None:
        free_bias = getattr(self, "bias", "none") == "estimate"
        noise = None if self.noise_found else getattr(self, "noise", None)
        accuracy = SensorAccuracy.of(self.sensor_accuracy)
        return StateSamples.of(state, free_bias, noise, self.carried, accuracy)

    def _uncertainty(
        self,
        body: InertialParameters,
        samples: StateSamples,
        reading: MassReading | None,
    ) -> tuple[dict[str, Array], Array]:
        return intervals_of(
            body, samples, self.systematic, self.possible_bodies, reading
        )
