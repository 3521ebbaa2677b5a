"""Noise of the samples: the covariance of the score h - H phi (`likelihood`), judged at
the parameters of least squares.

What least squares leaves is noise for any shape: a prior that contradicts the wrench
cannot explain its own misfit as noise, and the noise does not depend on the prior.
"""

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Self

import numpy as np

from hefting.core.measurements import MotionNoise, Noise
from hefting.core.sensor_accuracy import EXACT, TYPICAL, SensorAccuracy
from hefting.core.spatial import Array
from hefting.estimators.bayes.calibration_errors import CalibrationErrors
from hefting.estimators.bayes.colour import (
    FEWEST_SAMPLES_FOR_NOISE,
    LARGEST_CLAIM_EXCESS,
    LARGEST_STRETCH_DISAGREEMENT,
    Colour,
    TimeSamples,
    response_errors,
)
from hefting.estimators.bayes.groups import Scores
from hefting.estimators.bayes.likelihood import (
    Equations,
    Likelihood,
    Samples,
    motion_effect,
)
from hefting.estimators.bayes.motion_errors import MotionErrors
from hefting.estimators.bayes.sensor_errors import InStep, slow_variances
from hefting.estimators.joint_state import State, motion_record
from hefting.estimators.quadratic import WrenchNoise
from hefting.estimators.whitened_state import WhitenedState

LARGEST_RESIDUAL_RATIO = 10.0
"""Largest ratio of the mean squared residuals to those of least squares that is
attributed to noise."""
LARGEST_GROWTH = 1.1
"""Factor by which residuals of some samples more may be larger, squared and averaged
over all samples, before their noise is another one. By chance 2 to 10 % more samples
change them by 1.4 % (one deviation) where the noise is white, and by 4.5 % where it
correlates by 0.9 from sample to sample: by more than this in none and 15 of 100 steps."""


@dataclass(frozen=True, eq=False)
class NoiseFound:
    """Noise of all samples for one covariance of a sample's residual."""

    equations: Equations
    residual_covariance: Array
    """(6, 6) of the residuals that count as noise"""
    contradicted: bool
    """whether the residuals exceed a given noise by more than chance"""
    excess: float
    """variance of the residuals over that of a given noise, where it is contradicted;
    else 1"""
    at: Array
    """(10,) parameters at which the noise is judged: those of least squares, or near
    the posterior's where the motion has white errors"""
    scores: Scores | None
    """of the time scales there; None without a record of time"""
    colour: Colour | None
    sensor: Array
    """(10, 10) part of the score's covariance by errors of the sensor that more samples
    do not lessen"""
    response: float
    """relative error of the body by errors of the wrench in step with the motion"""
    calibration: CalibrationErrors | None
    """errors of the sensor's calibration; None where there are none"""
    expected: Array | None
    """(J + 1,) variances that these have in the residuals at each time scale and
    beyond; None where the noise is given, or there are none"""

    @property
    def autocorrelation(self) -> float:
        """Variance of the parameters over that for white noise."""
        return 1.0 if self.colour is None else self.colour.autocorrelation

    def holds_for(self, samples: Samples) -> bool:
        """Whether samples leave no larger residuals than those it was found by, as a
        touch would."""
        now = samples.residual_covariance(samples.least_squares).diagonal()
        before = self.residual_covariance.diagonal() + samples.floor**2
        return bool((now < LARGEST_GROWTH * before).all())

    def of_more(self, samples: Samples, phi: Array, motion: MotionErrors) -> Self:
        """The same noise in more samples, of parameters near phi (10,)."""
        known = self.equations
        equations = Equations.of(samples, phi, known.covariance, motion.white)
        colour = self.colour
        if colour is not None:
            more = self.autocorrelation * (equations.G - known.G)
            colour = replace(colour, noise=colour.noise + more)
        growth = float(equations.G.trace() / known.G.trace())
        return replace(
            self,
            equations=equations,
            colour=colour,
            sensor=max(growth, 1.0) ** 2 * self.sensor,
        )

    def likelihood(self, inflation: float = 1.0) -> Likelihood:
        """Likelihood of the parameters, the noise's variance so many times as large."""
        white = self.colour is None or self.colour.white_claimed
        if white and not self.sensor.any():
            return self.equations.white(inflation)
        noise = self.equations.G if self.colour is None else self.colour.noise
        V = noise + self.sensor + self.equations.products
        return self.equations.likelihood(inflation * V)


@dataclass(frozen=True, eq=False)
class NoiseSource:
    """What samples and given noise tell of the noise."""

    samples: Samples
    state: State
    """of the estimator, which has them, and perhaps a record of time"""
    given: Array | None
    """(6, 6) known covariance of the wrench's noise; None where it is found from the
    residuals"""
    motion: MotionErrors
    carried: Array
    """(10,) parameters of what the sensor holds besides the object, whose wrench was
    subtracted"""
    sensor_accuracy: SensorAccuracy | None
    """of the sensor; None where nothing is said of it"""
    free_bias: bool
    """whether a constant bias is free"""

    @classmethod
    def of(
        cls,
        state: State,
        free_bias: bool,
        noise: WrenchNoise,
        carried: Array | None,
        sensor_accuracy: SensorAccuracy | None,
    ) -> Self:
        """Of a state; `noise` of the wrench, and what is `carried`, are None where they
        are not known, or there is nothing.

        Errors of the motion are those that the samples state, else those of `noise`,
        else, where `noise` is None, white ones that the samples show.
        Equations that are whitened have unit noise, all errors in it.
        """
        if isinstance(state, WhitenedState):
            noise, sensor_accuracy = np.eye(6), EXACT
        record = motion_record(state)
        motion_noise = None if record is None else record.motion_noise
        given = None
        if isinstance(noise, Noise):
            given = np.diag(np.repeat((noise.force**2, noise.torque**2), 3))
            if motion_noise is None:
                motion_noise = MotionNoise(
                    noise.linear_acceleration, noise.angular_acceleration
                )
        elif noise is not None:
            given = np.array(noise, dtype=float)
        elif motion_noise is None and record is not None:
            motion_noise = record.found_motion_noise
        return cls(
            Samples.of(state, free_bias),
            state,
            given,
            MotionErrors.of(motion_noise, state),
            np.zeros(10) if carried is None else carried,
            sensor_accuracy,
            free_bias,
        )

    @cached_property
    def time(self) -> TimeSamples | None:
        """Samples by time scale and stretch; None where the state keeps no record of
        time."""
        return TimeSamples.of(self.state, self.free_bias)

    @property
    def allowed(self) -> SensorAccuracy:
        """Errors of the sensor that are allowed for: those it is said to have; where
        nothing is said, none beside a given noise, which is taken at its word, and else
        typical ones."""
        if self.sensor_accuracy is not None:
            return self.sensor_accuracy
        return TYPICAL if self.given is None else EXACT

    def level(self) -> Array:
        """(6, 6) covariance of the wrench's noise, before any pass."""
        return self.samples.least_residual if self.given is None else self.given

    def found(self, phi: Array, before: NoiseFound | None = None) -> NoiseFound:
        """The noise, if the parameters are near phi (10,), which tell what errors of
        the motion do to the wrench; `before` is what was found in the last pass."""
        samples, time = self.samples, self.time
        at = self._judged_at(phi, before)
        autocorrelation = 1.0 if before is None else before.autocorrelation
        R = samples.residual_covariance(at)
        S, contradicted, excess = self._covariance(phi, R, autocorrelation), False, 1.0
        mean_square = _mean_square(S, R)
        if self.given is not None:
            chance = (autocorrelation / (3.0 * samples.K)) ** 0.5
            contradicted = mean_square > 1.0 + LARGEST_CLAIM_EXCESS * chance
            excess = max(mean_square, 1.0) if contradicted else 1.0
            S = excess * S
            mean_square /= excess
        equations = Equations.of(samples, phi, S, self.motion.white)
        if self.motion.white is None:
            at = equations.least_squares
        calibration = None
        if not self.allowed.none:
            calibration = CalibrationErrors.of(
                samples, equations, at + self.carried, self.allowed, self.free_bias
            )
        scores = colour = expected = None
        sensor, response = np.zeros((10, 10)), 0.0
        if time is not None:
            scores = time.scales.scores(equations.whitening, at, equations.attenuation)
            colour = time.colour(
                scores,
                equations.G,
                equations.inverse,
                mean_square,
                self.given is not None,
            )
            if calibration is not None and self.given is None:
                # of the first pass: later ones hardly change the whitening
                expected = (
                    calibration.residual_variances(time)
                    if before is None or before.expected is None
                    else before.expected
                )
                colour = colour.less(expected, scores, equations.G)
            sensor, response = self._errors_in_time(equations, at, scores, colour)
            if calibration is not None:
                sensor += calibration.slow_score(time, samples)
        if calibration is not None:
            sensor = sensor + calibration.score
        return NoiseFound(
            equations,
            R,
            contradicted,
            excess,
            at,
            scores,
            colour,
            sensor,
            response,
            calibration,
            expected,
        )

    def disagreement(self, found: NoiseFound) -> tuple[float, float]:
        """Variance of mass and first moment between stretches over what they claim by
        noise alone, and by noise and errors in step with the motion; zeros where there
        are too few (`TimeSamples.disagreement`)."""
        time, colour = self.time, found.colour
        if time is None or colour is None or found.scores is None:
            return 0.0, 0.0
        W, more = found.equations.whitening, None
        if not colour.white_claimed:
            counts = time.scales.counts
            mean = float(counts @ colour.coloured) / max(float(counts.sum()), 1.0)
            stretches = InStep.of(time.stretches, W, found.at + self.carried)
            more = stretches.of_each(np.full(len(stretches.counts), mean))
        attenuation = found.equations.attenuation
        ratios = time.disagreement(W, found.at, attenuation, found.scores, colour, more)
        if found.calibration is None or inflation_of(ratios[1]) == 1.0:
            return ratios
        own = found.calibration.of_stretches(time)
        more = own if more is None else more + own
        return time.disagreement(W, found.at, attenuation, found.scores, colour, more)

    def _judged_at(self, phi: Array, before: NoiseFound | None) -> Array:
        """(10,) parameters whose residuals are the noise.

        They are those of least squares. White errors of the motion attenuate these, so
        that their residuals follow the motion; then phi (10,) serves, unless the prior
        contradicts the wrench.
        """
        samples = self.samples
        if before is None or self.motion.white is None:
            return samples.least_squares if before is None else before.at
        ratio = samples.residual_covariance(phi).diagonal() / (
            samples.least_residual.diagonal() + samples.floor**2
        )
        contradicts = float(ratio.mean()) > LARGEST_RESIDUAL_RATIO
        return samples.least_squares if contradicts else phi

    def _covariance(self, phi: Array, R: Array, autocorrelation: float) -> Array:
        """S (6, 6), the modelled covariance of one sample's residual for parameters
        near phi (10,), if those of least squares have the covariance R."""
        samples, motion = self.samples, self.motion
        if self.given is None:
            S = samples.noise_left(R, autocorrelation)
            S = S + samples.unproven(FEWEST_SAMPLES_FOR_NOISE)
            memory = motion.memory - 1.0
        else:
            S = self.given + np.diag(samples.floor**2)
            memory = motion.memory
        if motion.variances is not None and memory > 0.0:
            E = motion_effect(phi)
            S = S + memory / autocorrelation * (E * motion.variances) @ E.T
        return S

    def _errors_in_time(
        self, equations: Equations, at: Array, scores: Scores, colour: Colour
    ) -> tuple[Array, float]:
        """(10, 10) part of the score's covariance by slow errors of the sensor and,
        unless the noise is given, by those in step with the motion (`sensor_errors`);
        and the relative error of the body by uneven response."""
        time, samples, G = self.time, self.samples, equations.G
        assert time is not None
        W, whole = equations.whitening, at + self.carried
        load = float(whole @ G @ whole) / samples.K
        if time.free_bias:
            load += samples.constant_load(W, whole)
        information = np.concatenate(
            (scores.information, (G - scores.information.sum(axis=0))[None])
        )
        slow = slow_variances(
            self.allowed.slow_std,
            load / 6.0,
            time.samples,
            len(time.scales.counts),
            time.free_bias,
        )
        sensor = np.tensordot(slow, information, 1)
        if self.given is not None:
            return sensor, 0.0
        variances = colour.variances[:-1]
        gain = response_errors(scores, variances, time.scales.counts, whole)
        signal = information @ whole @ whole
        response = float(gain @ signal) / (float(signal.sum()) or 1.0)
        in_step = InStep.of(time.scales, W, whole)
        sensor += in_step.covariance(colour.coloured, gain[:-1])
        return sensor, response


def inflation_of(disagreement: float) -> float:
    """Factor of the noise's variance for stretches that disagree by more than
    chance."""
    return disagreement if disagreement > LARGEST_STRETCH_DISAGREEMENT else 1.0


def _mean_square(S: Array, R: Array) -> float:
    """Mean square of residuals of covariance R (6, 6), whitened by S (6, 6)."""
    return max(float(np.trace(np.linalg.solve(S, R))) / 6.0, 1e-12)
