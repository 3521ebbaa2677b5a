"""Likelihood of the ten parameters from a state alone: its noise, and the noise's
colour, are found in the residuals of least squares.

A method's own equations may leave out part of the model: the gravity-only model of slow
motion, or the weights of newtons against newton-metres. The errors of its estimate then
are not those of its equations. The likelihood here is that of the full Newton-Euler
model for all samples that the state's time record holds, whatever the method; the parts
are those of Bayes (`hefting.estimators.bayes.likelihood` and `.colour`).
"""

from dataclasses import replace
from typing import Self

import numpy as np

from hefting.core.moments import Moments, triangular
from hefting.core.sensor_accuracy import SensorAccuracy
from hefting.core.spatial import Array, immutable
from hefting.estimators.bayes.likelihood import Likelihood
from hefting.estimators.bayes.noise import NoiseSource
from hefting.estimators.bayes.noise_found import inflation_of
from hefting.estimators.bayes.samples import Samples
from hefting.estimators.joint_state import (
    JointState,
    State,
    WhitenedState,
    motion_record,
    states_by_bias,
)
from hefting.estimators.quadratic import WrenchNoise
from hefting.estimators.sample_state import SampleState
from hefting.estimators.time_record import TimeRecord

NOISE_PASSES = 2
"""Number of passes in which the noise is found, as covariance depends on colour."""


@immutable
class StateLikelihood:
    """Likelihood of a state, with all errors that widen it."""

    likelihood: Likelihood
    """of the ten parameters (10,) in sensor axes about the sensor's origin"""
    rough_mass: float
    """[kg] the force over the acceleration; never zero"""


@immutable
class StateSamples:
    """All samples of a state under the full model, with their noise."""

    source: NoiseSource
    """samples and their noise"""
    free_bias: bool
    """whether a constant bias is free"""

    @property
    def samples(self) -> Samples:
        """All samples under the full model."""
        return self.source.samples

    @classmethod
    def of(
        cls,
        state: State,
        free_bias: bool,
        noise: WrenchNoise,
        carried: Array | None = None,
        sensor_accuracy: SensorAccuracy | None = None,
    ) -> Self | None:
        """From a state; None without a time record, or without samples of positive
        weight. For the other arguments see `NoiseSource.of`."""
        if isinstance(state, WhitenedState):
            return cls(NoiseSource.of(state, False, None, carried, None), False)
        seen = motion_record(state)
        if seen is None or not seen.motion[0]:
            return None
        states = states_by_bias(state, free_bias)
        samples = sum(map(_samples_recorded, states))
        weight = max(seen.motion[0] / samples, 1.0)
        wholes = tuple(_of_all_samples(each, weight) for each in states)
        whole = wholes[0] if len(wholes) == 1 else JointState(wholes)
        source = NoiseSource.of(whole, free_bias, noise, carried, sensor_accuracy)
        if source.given is not None:
            source = replace(source, given=source.given / weight)
        return cls(source, free_bias)

    @property
    def informative(self) -> bool:
        """Whether the samples contain information beside a free bias."""
        size = float(
            np.abs(self.samples.A_mean).max() * max(self.samples.K, 1.0) ** 0.5
        )
        return (
            self.samples.K > 0.0 and float(np.abs(self.samples.A).max()) > 1e-9 * size
        )

    def likelihood(self, phi: Array) -> StateLikelihood:
        """The likelihood, with the noise found at least squares. Parameters phi (10,)
        near the right ones give the effect of the motion's errors on the wrench. A
        given noise is used unless the size or colour of the residuals contradicts it.
        """
        source, found = self.source, None
        for _ in range(NOISE_PASSES):
            found = source.found(phi, found)
        assert found is not None
        found = source.judged(found)
        coloured = found.colour is not None and found.colour.exceeds_claim
        if source.given is not None and (found.contradicted or coloured):
            source = replace(source, given=None)
            found = source.found(phi, source.found(phi))
        inflation = inflation_of(source.disagreement(found)[1])
        force_std = float(found.equations.covariance[:3, :3].trace() / 3.0) ** 0.5
        return StateLikelihood(
            found.likelihood(inflation), source.samples.mass_scale(force_std)
        )

    def of_wrench(self, systematic: Array | None) -> Likelihood:
        """The likelihood near least squares, with an error of covariance (10, 10) that
        all samples share."""
        likelihood = self.likelihood(self.samples.least_squares).likelihood
        return likelihood if systematic is None else likelihood.blurred(systematic)


def _samples_recorded(state: SampleState) -> int:
    """Number of samples in a state's time record."""
    assert state.record is not None
    stretches = state.record.complete[1]
    return sum(stretches.counts) + stretches.open_count


def _of_all_samples(state: SampleState, weight: float) -> SampleState:
    """The state with the full model for every sample of its time record.

    An average weighs as much as its samples, but is one observation of the noise: the
    weights are divided by their mean, `weight`.
    """
    record = state.record
    assert record is not None
    scales, stretches = record.complete
    samples = _samples_recorded(state)
    scale = weight**-0.5
    rows = [*stretches.factors, stretches.open_factor]
    whole = Moments(
        scale * triangular(np.concatenate(rows)),
        samples,
        min(state.full.start, state.reduced.start),
        state.end,
    )
    if weight != 1.0:
        scales, stretches = scales.scaled(1.0 / weight), stretches.scaled(1.0 / weight)
    kept = TimeRecord(scales, stretches, motion=record.motion, rough=record.rough_whole)
    return SampleState(Moments.empty(), whole, samples, kept)
