"""Colour: autocorrelation of the noise from the residuals.

`TimeSamples.colour` finds from a state's time record the spectrum of the noise by octaves
(`spectrum`), and from it the covariance of the whole record's score, the sum of v_j G_j
over the time scales. Two doubts widen it:

- time scales at which the wrench answers with another gain than on the whole
  (`response_errors`);
- stretches of the record that contradict each other by more than
  `LARGEST_STRETCH_DISAGREEMENT`.
"""

from dataclasses import dataclass

import numpy as np

from hefting.core.spatial import Array
from hefting.estimators.bayes.groups import Scores
from hefting.estimators.bayes.spectrum import PRIOR_DEGREES

FEWEST_SAMPLES_FOR_NOISE = 20
"""Number of samples from which on the noise counts as known: they have about a hundred
residuals."""
LARGEST_STRETCH_DISAGREEMENT = 3.0
"""Largest ratio of the variance between stretches to the variance they claim that is
attributed to chance."""
GAIN_CHANCE = 12.0
"""Squared error of one time scale's gain over its variance that is attributed to
chance: it exceeds 12 once in 2,000 times."""
FEWEST_DEGREES_FOR_CLAIM = 12.0
"""Degrees of freedom of an energy below which it does not contradict a claim of white
noise."""
LARGEST_CLAIM_EXCESS = 5.0
"""Standard deviations by which residuals may exceed the noise that was given without
contradicting it."""
GAIN_BOUND_STDS = 2.0
"""Standard deviations above a time scale's own gain error that bound the error inferred
from faster scales."""
GAIN_FADE_PER_OCTAVE = 0.5 ** (1.0 / 3.0)
"""Factor of the relative gain error from one time scale to the next, which is twice as
slow.

Errors of viscous friction and of a late clock decrease faster. Creep of elastic sensors
follows small powers of time; the power 1/3 represents them.
"""


@dataclass(frozen=True, eq=False)
class Colour:
    """Noise of a record by time scale, at one body and one covariance of the wrench."""

    noise: Array
    """(10, 10) covariance of the score of all samples"""
    autocorrelation: float
    """variance of the parameters over that with white noise, on average"""
    variances: Array
    """(J + 1,) of the noise at each time scale and beyond, over that of one sample"""
    white: float
    """how much of these is white noise"""
    energies: Array
    """(J,) sums of squared residuals at each scale, whitened to a mean square of 1"""
    degrees: Array
    """(J,) their degrees of freedom"""
    level: float
    """mean square of the residuals, whitened by the covariance that is allowed for"""
    white_claimed: bool
    """whether the noise was claimed to be white"""
    exceeds_claim: bool
    """whether that is contradicted"""

    @property
    def coloured(self) -> Array:
        """(J,) variances at each time scale beyond white noise and one standard
        deviation of chance."""
        chance = np.sqrt(2.0 / (self.degrees + PRIOR_DEGREES))
        return np.maximum(self.variances[:-1] - self.white * (1.0 + chance), 0.0)


def without_expected(
    variances: Array, expected: Array, white: float, degrees: Array
) -> Array:
    """Variances (J + 1,) without those that errors of another kind are expected to
    have, as far as there is more than white noise.

    Scales at which nothing was seen, those without `degrees` (J,) of freedom, whose
    variances follow from the others, keep the share that the slowest of those keeps.
    """
    least = np.minimum(variances, white)
    left = np.maximum(variances - expected, least)
    seen = np.flatnonzero(degrees > 0.0)
    if len(seen):
        last = seen[-1]
        share = left[last] / max(float(variances[last]), 1e-300)
        unseen = slice(last + 1, None)
        left[unseen] = np.maximum(share * variances[unseen], least[unseen])
    return left


def exceeds(energies: Array, degrees: Array) -> bool:
    """Whether the energy of a scale (J,) is more than that of white noise by more than
    chance."""
    enough = degrees >= FEWEST_DEGREES_FOR_CLAIM
    return bool(
        (energies > degrees + LARGEST_CLAIM_EXCESS * np.sqrt(2.0 * degrees))[
            enough
        ].any()
    )


def response_errors(
    found: Scores, variances: Array, details: Array, phi: Array
) -> Array:
    """(J + 1,) relative errors that the wrench may have in step with the motion, at
    each time scale and beyond.

    Causes are a sensor whose gain depends on frequency, an arm that bends, a late
    clock, and smoothed motion. The gain error of a scale is the part beyond
    `GAIN_CHANCE`. Towards slower scales it is assumed to decrease by no more than the
    factor `GAIN_FADE_PER_OCTAVE` an octave, unless a scale bounds its own error: by
    `GAIN_BOUND_STDS` standard deviations above the error it shows. White errors of the
    motion attenuate the score of every detail by the same amount; that part is
    subtracted.
    """
    signal = found.information @ phi @ phi
    score, moves = found.scores @ phi, signal > 0.0
    told = details[moves] / (variances * signal)[moves]
    unknown = -float(told @ score[moves]) / max(float(told @ details[moves]), 1e-300)
    explained = max(unknown, 0.0) * details
    score = np.maximum(np.abs(score) - explained, 0.0)
    seen = np.where(moves, signal, np.inf)
    gain = score / seen
    significance = gain**2 * signal / variances
    shown = gain * np.sqrt(
        np.maximum(1.0 - GAIN_CHANCE / np.maximum(significance, GAIN_CHANCE), 0.0)
    )
    possible = gain + GAIN_BOUND_STDS * np.sqrt(variances / seen)
    possible[~moves] = np.inf
    errors = [0.0]
    for own, most in zip(shown.tolist(), possible.tolist(), strict=True):
        errors.append(max(own, min(GAIN_FADE_PER_OCTAVE * errors[-1], most)))
    return np.array((*errors[1:], GAIN_FADE_PER_OCTAVE * errors[-1]))
