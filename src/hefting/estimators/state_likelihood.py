"""Likelihood of the ten parameters from a state alone: its noise, and the noise's
colour, are found in the residuals of least squares.

A method's own equations may leave out part of the model: the gravity-only model of slow
motion, or the weights of newtons against newton-metres. The errors of its estimate then
are not those of its equations. The likelihood here is that of the full Newton-Euler
model for all samples that the state's time record holds, whatever the method; the parts
are those of Bayes (`hefting.estimators.bayes.likelihood` and `.colour`).
"""

from dataclasses import dataclass
from typing import Self

import numpy as np

from hefting.core.measurements import MotionNoise, Noise
from hefting.core.moments import Moments, triangular
from hefting.core.spatial import Array
from hefting.estimators.bayes.colour import (
    FEWEST_SAMPLES_FOR_NOISE,
    LARGEST_CLAIM_EXCESS,
    LARGEST_STRETCH_DISAGREEMENT,
    Colour,
    TimeSamples,
)
from hefting.estimators.bayes.groups import Scores
from hefting.estimators.bayes.likelihood import (
    Equations,
    Likelihood,
    Samples,
    motion_effect,
)
from hefting.estimators.bayes.motion_errors import MotionErrors
from hefting.estimators.quadratic import WrenchNoise
from hefting.estimators.sample_state import SampleState
from hefting.estimators.stretches import Stretches
from hefting.estimators.time_record import TimeRecord
from hefting.estimators.timescales import TimeScales


@dataclass(frozen=True, eq=False)
class StateLikelihood:
    """Likelihood of a state, with all that widens it."""

    likelihood: Likelihood
    """of the ten parameters (10,) in sensor axes about the sensor's origin"""
    rough_mass: float
    """[kg] the force over the acceleration; never zero"""
    response: float
    """relative error of the whole body by errors of the wrench in step with the
    motion"""


@dataclass(frozen=True, eq=False)
class StateSamples:
    """What a state tells of all its samples under the full model."""

    samples: Samples
    time: TimeSamples | None
    motion: MotionErrors
    given: Array | None
    """(6, 6) noise of the wrench that was given, for samples of weight 1"""
    free_bias: bool
    """whether a constant bias is free"""

    @classmethod
    def of(cls, state: SampleState, free_bias: bool, noise: WrenchNoise) -> Self | None:
        """Of a state; None where it has no time record, or no samples of any weight."""
        record = state.record
        if record is None or not record.motion[0]:
            return None
        whole, weight = _of_mean_weight_one(state, record)
        motion_noise, given = record.motion_noise, None
        if isinstance(noise, Noise):
            given = np.diag(np.repeat((noise.force**2, noise.torque**2), 3))
            if motion_noise is None:
                motion_noise = MotionNoise(
                    noise.linear_acceleration, noise.angular_acceleration
                )
        elif noise is not None:
            given = np.array(noise, dtype=float)
        return cls(
            Samples.of(whole, free_bias),
            TimeSamples.of(whole, free_bias),
            MotionErrors.of(motion_noise, whole),
            None if given is None else given / weight,
            free_bias,
        )

    @property
    def informative(self) -> bool:
        """Whether the samples tell anything beside a free bias."""
        size = float(
            np.abs(self.samples.A_mean).max() * max(self.samples.K, 1.0) ** 0.5
        )
        return (
            self.samples.K > 0.0 and float(np.abs(self.samples.A).max()) > 1e-9 * size
        )

    def likelihood(self, phi: Array) -> StateLikelihood:
        """The likelihood, its noise judged at least squares.

        Parameters `phi` (10,) near the right ones tell what errors of the motion do to
        the wrench. Noise that was given is taken at its word unless the residuals
        contradict it, by their size or their colour.
        """
        at = self.samples.least_squares
        if self.given is not None:
            found = self._claimed(phi, at, self.given)
            if found is not None:
                return found
        return self._found(phi, at)

    def _claimed(self, phi: Array, at: Array, given: Array) -> StateLikelihood | None:
        """With the given noise; None where the residuals contradict it."""
        samples, motion = self.samples, self.motion
        S = given + np.diag(samples.floor**2)
        S = self._with_motion(S, phi, motion.memory)
        equations = Equations.of(samples, phi, S, motion.white)
        ratio = _mean_square(S, samples.least_residual)
        chance = LARGEST_CLAIM_EXCESS * (3.0 * samples.K) ** -0.5
        if ratio > 1.0 + chance:
            return None
        inflation = 1.0
        if self.time is not None:
            scores = self._scores(equations, at)
            colour = self.time.colour(
                scores, equations.G, equations.inverse, ratio, True
            )
            if colour.exceeds_claim:
                return None
            inflation = self._disagreement(equations, at, scores, colour)
        V = inflation * (equations.G + equations.products)
        return self._wrapped(equations, V, 0.0)

    def _found(self, phi: Array, at: Array) -> StateLikelihood:
        """With the noise that least squares leaves, as coloured as it may be."""
        samples, motion = self.samples, self.motion
        R = samples.least_residual
        S = samples.noise_left(R) + samples.unproven(FEWEST_SAMPLES_FOR_NOISE)
        S = self._with_motion(S, phi, motion.memory - 1.0)
        equations = Equations.of(samples, phi, S, motion.white)
        if self.time is None:
            return self._wrapped(equations, equations.G + equations.products, 0.0)
        scores = self._scores(equations, at)
        colour = self.time.colour(
            scores, equations.G, equations.inverse, _mean_square(S, R), False
        )
        response = self.time.response(scores, equations.G, at, colour)
        inflation = self._disagreement(equations, at, scores, colour)
        V = inflation * (colour.noise + equations.products)
        return self._wrapped(equations, V, response)

    def _scores(self, equations: Equations, at: Array) -> Scores:
        assert self.time is not None
        return self.time.scales.scores(equations.whitening, at, equations.attenuation)

    def _disagreement(
        self, equations: Equations, at: Array, scores: Scores, colour: Colour
    ) -> float:
        """Factor of the noise by which stretches contradict each other, at least 1."""
        assert self.time is not None
        found = self.time.disagreement(
            equations.whitening, at, equations.attenuation, scores, colour
        )
        return found if found > LARGEST_STRETCH_DISAGREEMENT else 1.0

    def _with_motion(self, S: Array, phi: Array, memory: float) -> Array:
        """S (6, 6) with what errors of the motion that last do to the wrench."""
        if self.motion.variances is None or memory <= 0.0:
            return S
        E = motion_effect(phi)
        return S + memory * (E * self.motion.variances) @ E.T

    def _wrapped(
        self, equations: Equations, V: Array, response: float
    ) -> StateLikelihood:
        force_std = float(equations.covariance[:3, :3].trace() / 3.0) ** 0.5
        return StateLikelihood(
            equations.likelihood(V), self.samples.mass_scale(force_std), response
        )


def _mean_square(S: Array, R: Array) -> float:
    """Mean square of residuals of covariance R (6, 6), whitened by S (6, 6)."""
    return max(float(np.trace(np.linalg.solve(S, R))) / 6.0, 1e-12)


def _of_mean_weight_one(
    state: SampleState, record: TimeRecord
) -> tuple[SampleState, float]:
    """The state of the full model for all samples of a record, and the mean weight of a
    sample.

    Samples that are averages weigh as many as they are, but each is one observation of
    the noise: the weights are divided by their mean where it is more than 1.
    """
    scales, stretches = record.complete
    samples = sum(stretches.counts) + stretches.open_count
    weight = max(record.motion[0] / samples, 1.0)
    scale = weight**-0.5
    rows = [*stretches.factors, stretches.open_factor]
    whole = Moments(
        scale * triangular(np.concatenate(rows)),
        samples,
        min(state.full.start, state.reduced.start),
        state.end,
    )
    if scale != 1.0:
        scales = TimeScales(
            tuple(scale * factor for factor in scales.factors),
            scales.counts,
            tuple(None if row is None else scale * row for row in scales.pending),
        )
        stretches = Stretches(
            tuple(scale * factor for factor in stretches.factors),
            stretches.counts,
            stretches.length,
            scale * stretches.open_factor,
            stretches.open_count,
        )
    kept = TimeRecord(scales, stretches, motion=record.motion)
    return SampleState(Moments.empty(), whole, samples, kept), weight
