"""PointEstimator: base of the methods that find a point, which get their intervals from
here."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from hefting.core.errors import InputError
from hefting.core.estimate import Estimate
from hefting.core.inertia import InertialParameters
from hefting.core.mass_reading import MassReading
from hefting.core.sensor_accuracy import SensorAccuracy
from hefting.core.spatial import Array
from hefting.estimators.base import Estimator, Known
from hefting.estimators.joint_state import State
from hefting.estimators.mass_row import NO_ROW, MassRow
from hefting.estimators.point_intervals import intervals_of
from hefting.estimators.possible_bodies import PossibleBodies
from hefting.estimators.sample_state import (
    SampleState,
    require_body,
    require_common_covariance,
)
from hefting.estimators.state_likelihood import StateSamples


@dataclass(frozen=True, eq=False)
class PointEstimator(Estimator):
    """A method that finds a point, and passes its estimate through `with_intervals`.

    `possible_bodies` says which objects it takes for possible.
    """

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
    """Whether `noise`, by which the method weighs, was found in the residuals: the
    intervals then find it, and its colour, themselves."""
    intervals: bool = field(default=True, kw_only=True)
    """Whether estimates have intervals. Without them a state keeps no record of time,
    and an estimate takes the time of the method alone."""

    def __post_init__(self):
        super().__post_init__()
        accuracy = SensorAccuracy.of(self.sensor_accuracy)
        object.__setattr__(self, "sensor_accuracy", accuracy)
        object.__setattr__(self, "mass", MassReading.of(self.mass))
        if self.mass is not None and not self.intervals:
            raise InputError(
                "without intervals it is not known what a scale's reading weighs beside "
                "the wrench",
                fix="intervals=True, or no mass",
            )
        require_body("what is carried", self.carried)
        require_common_covariance(self.systematic)

    @classmethod
    def settings(cls, known: Known, model: str | None = None) -> dict[str, Any]:
        """As of every method, with the error that all samples share, and the tool."""
        own = {
            "systematic": known.systematic,
            "carried": known.carried,
            "noise_found": True,
        }
        return super().settings(known, model) | own

    @property
    def provenance(self) -> dict[str, Any]:
        """As of every method, of what the intervals rest on if there are any."""
        found = super().provenance
        own = {"intervals", "noise_found"}
        found = {name: value for name, value in found.items() if name not in own}
        if self.intervals and self.sensor_accuracy is not None:
            found["sensor_accuracy"] = str(self.sensor_accuracy)
        if self.mass is not None:
            found["mass"] = str(self.mass)
        return found

    def start(self) -> SampleState:
        """The state before any sample."""
        return SampleState.empty(self.intervals)

    def possible_bodies(self, center: Array) -> PossibleBodies | None:
        """What the method takes an object to be, the COM of least squares being
        `center` (3,) [m]; None for any ten numbers.

        A method that finds bodies which can exist takes any of them for possible,
        unless it says otherwise.
        """
        return PossibleBodies.any(center) if self.consistent else None

    def mass_row(self, state: State, A: Array) -> MassRow:
        """What a scale showed, as a row beside the method's equations A (r, 10);
        `NO_ROW` where nothing was weighed.

        Raises `InputError` for a state without a record of time.
        """
        reading = MassReading.of(self.mass)
        if reading is None:
            return NO_ROW
        samples = self._require_samples(state)
        return MassRow.of(reading, samples, self.systematic, A)

    def with_intervals(
        self, estimate: Estimate, state: State, row: MassRow = NO_ROW
    ) -> Estimate:
        """The estimate, as the `row` of a scale makes it, with intervals, and with a
        covariance about it where it has none; as it is where the state keeps no record
        of time."""
        estimate = row.applied(estimate)
        samples = self._samples(state) if self.intervals else None
        if samples is None:
            return estimate
        reading = MassReading.of(self.mass) if row.weight else None
        found, covariance = self._uncertainty(estimate.parameters, samples, reading)
        if estimate.covariance is not None:
            covariance = np.array(estimate.covariance)
        return replace(estimate, intervals=found, covariance=covariance)

    def uncertainty(
        self, body: InertialParameters, state: State
    ) -> tuple[dict[str, Array], Array]:
        """Intervals about an estimate that hold the truth with 95 % probability, and
        the mean square of the truth's distance (10, 10) from it, with all errors that
        are allowed for; infinite where the samples leave something open.

        Raises `InputError` for a state without a record of time.
        """
        reading = MassReading.of(self.mass)
        return self._uncertainty(body, self._require_samples(state), reading)

    def _require_samples(self, state: State) -> StateSamples:
        """What a state tells; `InputError` where it keeps no record of time."""
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
