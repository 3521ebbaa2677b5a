"""Noise of the samples: the covariance of the score h - H phi (`likelihood`), judged at
the parameters of least squares.

What least squares leaves is noise for any shape: a prior that contradicts the wrench
cannot explain its own misfit as noise, and the noise does not depend on the prior.
"""

from dataclasses import replace
from functools import cached_property
from typing import Self

import numpy as np

from hefting.core.measurements import MotionNoise, Noise
from hefting.core.sensor_accuracy import EXACT, TYPICAL, SensorAccuracy
from hefting.core.spatial import Array, immutable
from hefting.estimators.bayes.calibration_errors import CalibrationErrors
from hefting.estimators.bayes.colour import (
    FEWEST_SAMPLES_FOR_NOISE,
    LARGEST_CLAIM_EXCESS,
    Colour,
    response_errors,
)
from hefting.estimators.bayes.groups import Scores, combined
from hefting.estimators.bayes.likelihood import motion_effect
from hefting.estimators.bayes.noise_found import MotionErrors, NoiseFound, inflation_of
from hefting.estimators.bayes.samples import Samples
from hefting.estimators.bayes.sensor_errors import InStep
from hefting.estimators.bayes.time_samples import TimeSamples
from hefting.estimators.joint_state import State, WhitenedState, motion_record
from hefting.estimators.quadratic import WrenchNoise

LARGEST_RESIDUAL_RATIO = 10.0
"""Largest ratio of the mean squared residuals to those of least squares that is
attributed to noise."""
UNCHANGED_VARIANCE = 0.003
"""Change of a sample's covariance, whitened by it, up to which the noise counts as
unchanged; standard deviations of the parameters change by half as much."""


@immutable
class NoiseSource:
    """A state's samples and a given noise, from which their noise is found."""

    samples: Samples
    state: State
    """of the estimator, with the samples and perhaps a time record"""
    given: Array | None
    """(6, 6) known covariance of the wrench's noise; None where it is found from the
    residuals"""
    motion: MotionErrors
    carried: Array
    """(10,) parameters of a tool whose wrench was subtracted; zeros for none"""
    sensor_accuracy: SensorAccuracy | None
    """of the sensor; None if it is not given"""
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
        """From a state, the wrench's `noise` if it is known, and a tool that is `carried`.

        Errors of the motion are those that the samples state, else those of `noise`,
        else, if `noise` is None, white ones that the samples show. A `WhitenedState` has
        unit noise, which includes all errors.
        """
        if isinstance(state, WhitenedState):
            noise, sensor_accuracy = np.eye(6), EXACT
        record = motion_record(state)
        motion_noise = None if record is None else record.motion_noise
        given = None
        if isinstance(noise, Noise):
            given = np.diag((noise.force**2,) * 3 + (noise.torque**2,) * 3)
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
        """Samples by time scale and stretch; None without a time record."""
        return TimeSamples.of(self.state, self.free_bias)

    @property
    def allowed(self) -> SensorAccuracy:
        """Accuracy of the sensor: the given one, else that of an exact sensor if the
        noise is given, else a typical one."""
        if self.sensor_accuracy is not None:
            return self.sensor_accuracy
        return TYPICAL if self.given is None else EXACT

    def level(self) -> Array:
        """(6, 6) covariance of the wrench's noise before the first pass."""
        return self.samples.least_residual if self.given is None else self.given

    def found(self, phi: Array, before: NoiseFound | None = None) -> NoiseFound:
        """The noise for parameters near phi (10,), on which the effect of the motion's
        errors depends; `before` is that of the last pass."""
        samples = self.samples
        at, R = self._judged_at(phi, before)
        autocorrelation = 1.0 if before is None else before.autocorrelation
        S = self._covariance(phi, R, autocorrelation)
        equations = self.motion.equations(samples, phi, S)
        level, excess = equations.mean_square(R), 1.0
        known = self.given is not None
        contradicted = known and self._contradicts(level, autocorrelation)
        if contradicted:
            excess, level = level, 1.0
            equations = self.motion.equations(samples, phi, excess * S)
        if not self.motion.white:
            at = equations.least_squares
        found = NoiseFound(equations, R, contradicted, excess, level, at)
        if known and self.allowed.none:
            return found
        return self.judged(found, None if before is None else before.expected)

    def again(self, found: NoiseFound, phi: Array) -> NoiseFound | None:
        """The noise `found` for other parameters near phi (10,); None if it changes, or
        depends on the residuals."""
        known = self.given is not None and not found.contradicted
        if not known or found.colour is not None:
            return None
        at, R = self._judged_at(phi, found)
        W, level = found.equations.whitening, found.equations.mean_square(R)
        change = W @ (self._covariance(phi, R, 1.0) - found.equations.covariance) @ W.T
        same = float(np.abs(change).max()) < UNCHANGED_VARIANCE
        if not same or self._contradicts(level, 1.0):
            return None
        return replace(found, residual_covariance=R, level=level, at=at)

    def judged(self, found: NoiseFound, expected: Array | None = None) -> NoiseFound:
        """The noise with its colour, from the time record, and with the sensor's
        errors; `expected` as in `NoiseFound`, from the last pass."""
        if found.colour is not None:
            return found
        equations, time, known = found.equations, self.time, self.given is not None
        calibration = sensor = None
        if not self.allowed.none:
            whole = found.at + self.carried
            calibration = CalibrationErrors.of(
                self.samples, equations, whole, self.allowed, self.free_bias
            )
            sensor = calibration.score
        if time is None:
            return replace(found, calibration=calibration, sensor=sensor)
        if calibration is None or known:
            expected = None
        elif expected is None:
            # later passes hardly change the whitening
            expected = calibration.residual_variances(time)
        scores = time.scales.scores(
            equations.whitening, found.at, equations.attenuation
        )
        colour = time.colour(scores, equations, found.level, known, expected)
        response = 0.0
        if calibration is not None or not known:
            own, response = self._errors_in_time(found, scores, colour)
            if calibration is not None:
                own = own + calibration.slow_score(time, self.samples)
            sensor = own if sensor is None else own + sensor
        return replace(
            found,
            scores=scores,
            colour=colour,
            sensor=sensor,
            response=response,
            calibration=calibration,
            expected=expected,
        )

    def disagreement(self, found: NoiseFound) -> tuple[float, float]:
        """Variance of mass and first moment between stretches over the claimed one: by
        noise alone, and by noise and errors in step with the motion. Zeros for too few
        stretches (`TimeSamples.disagreement`)."""
        time, colour = self.time, found.colour
        if time is None or colour is None or found.scores is None:
            return 0.0, 0.0
        W, more = found.equations.whitening, None
        if not colour.white_claimed:
            counts = time.scales.counts
            mean = float(counts @ colour.coloured) / max(float(counts.sum()), 1.0)
            counts = time.stretches.counts
            stretches = InStep.of(
                time.stretches.whitened(W), counts, found.at + self.carried
            )
            more = stretches.of_each(np.full(len(counts), mean))
        attenuation = found.equations.attenuation
        ratios = time.disagreement(W, found.at, attenuation, found.scores, colour, more)
        if found.calibration is None or inflation_of(ratios[1]) == 1.0:
            return ratios
        own = found.calibration.of_stretches(time)
        more = own if more is None else more + own
        return time.disagreement(W, found.at, attenuation, found.scores, colour, more)

    def _contradicts(self, level: float, autocorrelation: float) -> bool:
        """Whether whitened residuals of mean square `level` significantly exceed a
        given noise."""
        chance = (autocorrelation / (3.0 * self.samples.K)) ** 0.5
        return level > 1.0 + LARGEST_CLAIM_EXCESS * chance

    def _judged_at(self, phi: Array, before: NoiseFound | None) -> tuple[Array, Array]:
        """(10,) parameters whose residuals are the noise, and the covariance (6, 6) of
        these.

        They are those of least squares. White errors of the motion attenuate these, so
        that their residuals follow the motion; then phi (10,) serves, unless the prior
        contradicts the wrench.
        """
        samples = self.samples
        if before is not None and not self.motion.white:
            return before.at, samples.residual_covariance(before.at)
        if before is not None:
            R, least = samples.residual_covariance(phi), samples.least_residual
            ratio = R.diagonal() / (least.diagonal() + samples.floor**2)
            if not float(ratio.mean()) > LARGEST_RESIDUAL_RATIO:
                return phi, R
        return samples.least_squares, samples.least_residual

    @cached_property
    def _of_every_pass(self) -> Array:
        """(6, 6) part of S that is the same in every pass."""
        if self.given is None:
            return self.samples.unproven(FEWEST_SAMPLES_FOR_NOISE)
        return self.given + np.diag(self.samples.floor**2)

    def _covariance(self, phi: Array, R: Array, autocorrelation: float) -> Array:
        """S (6, 6), the modelled covariance of a sample's residual for parameters near
        phi (10,), if the residuals have the covariance R (6, 6)."""
        motion = self.motion
        S, memory = self._of_every_pass, motion.memory
        if self.given is None:
            S = S + self.samples.noise_left(R, autocorrelation)
            memory -= 1.0
        if motion.variances is not None and memory > 0.0:
            E = motion_effect(phi)
            S = S + memory / autocorrelation * (E * motion.variances) @ E.T
        return S

    def _errors_in_time(
        self, found: NoiseFound, scores: Scores, colour: Colour
    ) -> tuple[Array, float]:
        """(10, 10) part of the score's covariance by slow errors of the sensor and,
        unless the noise is given, by errors in step with the motion (`sensor_errors`);
        and the relative error of the body by uneven response."""
        time, G, whole = self.time, found.equations.G, found.at + self.carried
        assert time is not None
        signal = float(whole @ G @ whole)
        load = signal / self.samples.K
        if self.free_bias:
            load += self.samples.constant_load(found.equations.whitening, whole)
        rest = G - scores.information.sum(axis=0)
        slow = combined(time.slow[:-1], scores.information) + time.slow[-1] * rest
        sensor = self.allowed.slow_std**2 * load / 6.0 * slow
        if self.given is not None:
            return sensor, 0.0
        counts = time.scales.counts
        gain = response_errors(scores, colour.variances[:-1], counts, whole)
        signals = scores.information @ whole @ whole
        shown = float(gain[:-1] @ signals + gain[-1] * (signal - signals.sum()))
        in_step = InStep.of(scores.A, counts, whole)
        sensor += in_step.covariance(colour.coloured, gain[:-1])
        return sensor, shown / (signal or 1.0)
