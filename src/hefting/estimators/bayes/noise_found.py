"""The noise that was found for all samples, its likelihood, and whether it holds for
more samples; and the errors of the motion."""

from dataclasses import replace
from typing import Self

import numpy as np

from hefting.core.measurements import MotionNoise
from hefting.core.spatial import Array, immutable
from hefting.estimators.bayes.calibration_errors import CalibrationErrors
from hefting.estimators.bayes.colour import LARGEST_STRETCH_DISAGREEMENT, Colour
from hefting.estimators.bayes.groups import Scores
from hefting.estimators.bayes.likelihood import Equations, Likelihood
from hefting.estimators.bayes.samples import Samples
from hefting.estimators.joint_state import State

LARGEST_GROWTH = 1.1
"""Growth of the mean squared residual up to which the noise that was found holds for more
samples. By chance 2 to 10 % more samples change it by 1.4 % (one standard deviation) where
the noise is white, and by 4.5 % where its correlation from sample to sample is 0.9."""


@immutable
class MotionErrors:
    """Errors of the accelerations."""

    variances: Array | None
    """(6,) Linear [m²/s⁴] and angular [rad²/s⁴]; None if the motion is exact."""
    memory: float
    """Number of samples over which the errors are correlated, at least 1."""

    @classmethod
    def of(cls, noise: MotionNoise | None, state: State) -> Self:
        """Errors for the samples of a state, at their mean interval."""
        if noise is None or not (noise.linear or noise.angular):
            return cls(None, 1.0)
        step = state.duration / max(state.samples - 1, 1)
        memory = max(noise.memory / step, 1.0) if step > 0.0 else 1.0
        return cls(np.repeat((noise.linear**2, noise.angular**2), 3), memory)

    @property
    def white(self) -> bool:
        """Whether there are errors, and not correlated in time."""
        return self.variances is not None and self.memory == 1.0

    def equations(self, samples: Samples, phi: Array, S: Array) -> Equations:
        """`Equations` with these errors."""
        return Equations.of(samples, phi, S, self.variances, self.memory > 1.0)


@immutable
class NoiseFound:
    """Noise of all samples for one covariance of a sample's residual."""

    equations: Equations
    residual_covariance: Array
    """(6, 6) of the residuals that are taken for noise"""
    contradicted: bool
    """whether the residuals exceed a given noise by more than chance"""
    excess: float
    """variance of the residuals over that of a given noise, if contradicted; else 1"""
    level: float
    """mean square of the residuals, whitened by the covariance that is allowed for"""
    at: Array
    """(10,) parameters whose residuals are taken for noise: least squares, or near the
    posterior if the motion has white errors"""
    scores: Scores | None = None
    """of the time scales, at these parameters; None without a time record"""
    colour: Colour | None = None
    sensor: Array | None = None
    """(10, 10) part of the score's covariance by errors of the sensor that more samples
    do not lessen; None where there are none"""
    response: float = 0.0
    """relative error of the body by errors of the wrench in step with the motion"""
    calibration: CalibrationErrors | None = None
    """errors of the sensor's calibration; None where there are none"""
    expected: Array | None = None
    """(J + 1,) variances that these errors have in the residuals at each time scale and
    beyond; None if the noise is given or there are none"""

    @property
    def autocorrelation(self) -> float:
        """Variance of the parameters over that for white noise."""
        return 1.0 if self.colour is None else self.colour.autocorrelation

    def holds_for(self, samples: Samples) -> bool:
        """Whether the residuals of `samples` are no larger than those the noise was found
        from; after a touch they are."""
        now = samples.residual_covariance(samples.least_squares).diagonal()
        before = self.residual_covariance.diagonal() + samples.floor**2
        return bool((now < LARGEST_GROWTH * before).all())

    def of_more(self, samples: Samples, phi: Array, motion: MotionErrors) -> Self:
        """This noise for all of more `samples`, of parameters near phi (10,).

        The score's covariance by noise grows with the information, and that by errors of
        the sensor, which are the same in all samples, with its square.
        """
        before = self.equations
        equations = motion.equations(samples, phi, before.covariance)
        colour = self.colour
        if colour is not None:
            more = self.autocorrelation * (equations.G - before.G)
            colour = replace(colour, noise=colour.noise + more)
        sensor = self.sensor
        if sensor is not None:
            growth = float(equations.G.trace() / before.G.trace())
            sensor = max(growth, 1.0) ** 2 * sensor
        return replace(self, equations=equations, colour=colour, sensor=sensor)

    def likelihood(self, inflation: float = 1.0) -> Likelihood:
        """Likelihood of the parameters, with the noise's variance times `inflation`."""
        white = self.colour is None or self.colour.white_claimed
        if white and self.sensor is None:
            return self.equations.white(inflation)
        V = self.equations.G if self.colour is None else self.colour.noise
        V = V + self.equations.products
        if self.sensor is not None:
            V = V + self.sensor
        return self.equations.likelihood(inflation * V)


def inflation_of(disagreement: float) -> float:
    """Factor of the noise's variance for stretches that disagree significantly."""
    return disagreement if disagreement > LARGEST_STRETCH_DISAGREEMENT else 1.0
