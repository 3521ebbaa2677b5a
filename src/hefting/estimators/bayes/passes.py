"""Passes: the posterior of the parameters and the noise, found in turn, as each depends
on the other."""

from dataclasses import dataclass

import numpy as np

from hefting.core.estimate import Estimate
from hefting.core.spatial import Array
from hefting.estimators.bayes.colour import (
    FEWEST_SAMPLES_FOR_NOISE,
    LARGEST_CLAIM_EXCESS,
    LARGEST_STRETCH_DISAGREEMENT,
    Colour,
    TimeSamples,
)
from hefting.estimators.bayes.likelihood import (
    Equations,
    Likelihood,
    Samples,
    motion_effect,
)
from hefting.estimators.bayes.mixture import Mixture
from hefting.estimators.bayes.motion_errors import MotionErrors
from hefting.estimators.bayes.prior import Placed, Prior


@dataclass(frozen=True, eq=False)
class Data:
    """What the samples and the given noise provide to every pass."""

    samples: Samples
    time: TimeSamples | None
    """samples by time scale and stretch; None where the state keeps no record of
    time"""
    wrench_noise: Array | None
    """(6, 6) known covariance of the wrench's noise; None where it is found from the
    residuals"""
    motion: MotionErrors


@dataclass(frozen=True, eq=False)
class Pass:
    """Parameters and noise before a pass."""

    placed: Placed
    """prior about the shape's distortion"""
    phi: Array
    """(10,) parameters"""
    judged_at: Array
    """(10,) parameters at which the noise is judged"""
    residual_covariance: Array
    """(6, 6) of the residuals there"""
    covariance: Array
    """(6, 6) modelled, of one sample's residual"""
    excess: float = 1.0
    """factor of the modelled covariance where the residuals contradict a given noise"""
    contradicted: bool = False
    """whether they do"""
    spent: Array | None = None
    """P (10, 10) of the previous pass: see `Equations.spent`"""


@dataclass(frozen=True, eq=False)
class Fitted:
    """Results of a pass for a given noise."""

    placed: Placed
    scale: float
    """of the prior [kg]"""
    equations: Equations
    colour: Colour | None
    """of the noise; None where it is given, or there is no record of time"""
    likelihood: Likelihood
    own: Mixture
    """posterior without systematic errors"""
    mixture: Mixture
    """posterior with systematic errors"""
    spent: Array | None
    """P (10, 10): see `Equations.spent`; None where the noise is given"""
    determined: float
    """number of residuals, or sum of squared ones, that the fit absorbs"""

    @property
    def autocorrelation(self) -> float:
        """Variance of the parameters over that for white noise."""
        return 1.0 if self.colour is None else self.colour.autocorrelation


@dataclass(frozen=True, eq=False)
class Doubts:
    """The posterior widened for doubts about the noise."""

    mixture: Mixture
    colour: Colour | None
    disagreement: float
    """variance between stretches over what they claim"""
    response: float
    """relative error of the body by errors of the wrench in step with the motion"""


@dataclass(frozen=True, eq=False)
class Passes:
    """The steps of a pass, for given samples and prior."""

    data: Data
    prior: Prior
    systematic: Array | None
    """(10, 10) covariance of the parameters' error that all samples share; None where
    there is none"""

    def first_pass(self, start: Estimate | None) -> tuple[Pass, float]:
        """Parameters and noise before the first pass, and the rough mass [kg] by which
        the prior is scaled."""
        samples, known = self.data.samples, self.data.wrench_noise
        level = samples.least_residual if known is None else known
        rough_mass = samples.mass_scale(float(level[:3, :3].trace() / 3.0) ** 0.5)
        phi = rough_mass * self.prior.mean if start is None else start.parameters.vector
        judged_at, residual_covariance = phi, level
        if known is None:
            if start is None:
                judged_at = samples.least_squares
            else:
                residual_covariance = samples.residual_covariance(phi)
            level = samples.limited_to_noise(residual_covariance)
        covariance = self._covariance(phi, level, autocorrelation=1.0)
        placed = self.prior.about(np.zeros(len(self.prior.distortions.shifts)))
        return Pass(placed, phi, judged_at, residual_covariance, covariance), rough_mass

    def fit(self, current: Pass, scale: float) -> Fitted:
        """The posterior of the parameters with the noise known before the pass; `scale`
        is the prior's [kg]."""
        covariance = current.excess * current.covariance
        equations = Equations.of(
            self.data.samples, current.phi, covariance, self.data.motion.white
        )
        prior, colour = current.placed.prior, None
        if self.data.time is not None and self.data.wrench_noise is None:
            spent = equations.inverse if current.spent is None else current.spent
            scores = self.data.time.scales.scores(
                equations.whitening, current.judged_at, equations.attenuation
            )
            mean_square = _mean_square(covariance, current.residual_covariance)
            colour = self.data.time.colour(
                scores, equations.G, spent, mean_square, False
            )
        if colour is None:
            likelihood = equations.white()
        else:
            likelihood = equations.likelihood(colour.noise_seen + equations.products)
        own = mixture = Mixture.of(prior, scale, likelihood)
        spent = (
            None
            if self.data.wrench_noise is not None
            else equations.spent(likelihood, mixture.covariance)
        )
        determined = mixture.determined(likelihood) if colour is None else colour.fitted
        if self.systematic is not None:
            likelihood = likelihood.blurred(self.systematic)
            mixture = Mixture.of(prior, scale, likelihood)
        return Fitted(
            current.placed,
            scale,
            equations,
            colour,
            likelihood,
            own,
            mixture,
            spent,
            determined,
        )

    def update_noise(self, current: Pass, fitted: Fitted) -> Pass:
        """Parameters and noise after a pass."""
        samples, known = self.data.samples, self.data.wrench_noise
        phi, judged_at = fitted.mixture.mean, fitted.own.mean
        residual_covariance = samples.residual_covariance(judged_at, fitted.determined)
        excess, contradicted, autocorrelation = 1.0, False, fitted.autocorrelation
        if known is None:
            # residuals of a wrong shape are not noise
            if samples.excess_over_noise(residual_covariance) > 1.0:
                judged_at = samples.least_squares
            limited = samples.limited_to_noise(residual_covariance)
            covariance = self._covariance(phi, limited, autocorrelation)
        else:
            covariance = self._covariance(phi, residual_covariance, autocorrelation)
            ratio = _mean_square(covariance, residual_covariance)
            chance = LARGEST_CLAIM_EXCESS * (autocorrelation / (3.0 * samples.K)) ** 0.5
            contradicted = ratio > 1.0 + chance
            excess = (
                max(ratio / samples.excess_over_noise(residual_covariance), 1.0)
                if contradicted
                else 1.0
            )
        return Pass(
            current.placed,
            phi,
            judged_at,
            residual_covariance,
            covariance,
            excess,
            contradicted,
            fitted.spent,
        )

    def widen_for_doubts(
        self, current: Pass, fitted: Fitted, covariance: Array
    ) -> Doubts:
        """The posterior widened by colour as it may be, by disagreement between
        stretches and by uneven response.

        `covariance` (6, 6) is that of the residuals in the last pass.
        """
        time, equations, colour = self.data.time, fitted.equations, fitted.colour
        if time is None:
            return Doubts(fitted.mixture, colour, 0.0, 0.0)
        response, at = 0.0, current.judged_at
        scores = time.scales.scores(equations.whitening, at, equations.attenuation)
        if colour is None:
            spent = equations.spent(equations.white(), fitted.own.covariance)
            mean_square = _mean_square(covariance, current.residual_covariance)
            colour = time.colour(scores, equations.G, spent, mean_square, True)
        else:
            response = time.response(scores, equations.G, at, colour)
        disagreement = time.disagreement(
            equations.whitening, at, equations.attenuation, scores, colour
        )
        inflation = disagreement if disagreement > LARGEST_STRETCH_DISAGREEMENT else 1.0
        mixture = fitted.mixture
        if self.data.wrench_noise is None or inflation > 1.0:
            likelihood = equations.likelihood(
                inflation * (colour.noise + equations.products)
            )
            if self.systematic is not None:
                likelihood = likelihood.blurred(self.systematic)
            mixture = Mixture.of(fitted.placed.prior, fitted.scale, likelihood)
        if response:
            mixture = mixture.scaled(response)
        return Doubts(mixture, colour, disagreement, response)

    def _covariance(
        self, phi: Array, residual_covariance: Array, autocorrelation: float
    ) -> Array:
        """S (6, 6), the modelled covariance of one sample's residual for parameters
        near phi (10,).

        `residual_covariance` (6, 6) is that of the residuals, which count as noise
        where the noise is not known.
        """
        samples, motion = self.data.samples, self.data.motion
        if self.data.wrench_noise is None:
            S = samples.noise_left(residual_covariance) + samples.unproven(
                FEWEST_SAMPLES_FOR_NOISE
            )
            memory = motion.memory - 1.0
        else:
            S = self.data.wrench_noise + np.diag(samples.floor**2)
            memory = motion.memory
        if motion.variances is not None and memory > 0.0:
            E = motion_effect(phi)
            S = S + memory / autocorrelation * (E * motion.variances) @ E.T
        return S


def _mean_square(S: Array, R: Array) -> float:
    """Mean square of residuals of covariance R (6, 6), whitened by S (6, 6)."""
    return max(float(np.trace(np.linalg.solve(S, R))) / 6.0, 1e-12)
