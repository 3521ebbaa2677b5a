"""Colour: autocorrelation of the noise from the residuals.

`TimeSamples.colour` finds from a state's time record the spectrum of the noise by octaves
(`spectrum`), and from it the covariance of the whole record's score, the sum of v_j G_j
over the time scales. Two doubts widen it:

- time scales at which the wrench answers with another gain than on the whole
  (`response_errors`);
- stretches of the record that contradict each other by more than
  `LARGEST_STRETCH_DISAGREEMENT`.

The variance of Haar details of level j (`hefting.estimators.timescales`) is 1 at all
levels for white noise. For a first-order process of correlation rho and variance 1 a
sum over m samples has the variance S(m), and the details of level j, with m = 2^j, have

    S(m) = m (1 + rho)/(1 - rho) - 2 rho (1 - rho^m)/(1 - rho)²
    v_j = (4 S(m) - S(2 m)) / 2 m,   from 1 - rho at level 0 to (1 + rho)/(1 - rho) at long ones.

A family of spectra, white noise with none, one or two such processes beside it, is
weighed by how likely each makes the energies that were seen; the variances are means
over the family. What the record is too short to show counts as
possible by its share of the family: a short record has wide intervals.
"""

from functools import lru_cache

import numpy as np

from hefting.core.spatial import Array, immutable
from hefting.estimators.bayes.groups import Scores

PROBABILITY_WHITE = 0.85
"""Prior probability of white noise. Most sensors are specified as white, and a white
record should not have much wider intervals for noise that it rules out."""
PROBABILITY_ONE_PROCESS = 0.1
"""Prior probability of one first-order process beside white noise; the remaining 0.05
is for two."""
PROCESS_VARIANCES = 4.0 ** np.arange(-4, 7)
"""(11,) variances of a process over that of the white noise, equally probable."""
LONGEST_CORRELATION = 4.0
"""Longest correlation time of a process, in lengths of the record. A slower process is
a bias or a drift."""
MOST_LIKELIHOOD_DEGREES = 200.0
"""Largest number of degrees of freedom of an energy in the likelihood of a spectrum: no
true spectrum is closer than a tenth to one of the family."""
PRIOR_DEGREES = 10.0
"""Degrees of freedom of the family's mean at a level, beside the observed energy's."""
SCALE_DEGREES = 4.0
"""Degrees of freedom of the prior that the level is 1, that of whitened residuals; it
matters in short records."""


def spectrum(
    energies: Array, degrees: Array, samples: float, free_bias: bool = True
) -> tuple[Array, float]:
    """Variances (J + 1,) of the residuals' details at J levels and of all longer sums, and
    the variance of the white noise in each.

    They are means over a family of spectra, weighed by their likelihood, and at levels of
    which the record shows enough those of its own energies.

    Parameters
    ----------
    energies : (J,) sums of squared details of residuals, whitened by their covariance
        at one instant.
    degrees : (J,) degrees of freedom of the energies: six a detail, less those of the
        fit.
    samples : length of the record.
    free_bias : whether a constant bias is free; if not, the longest sums hold whatever
        seems constant.
    """
    J = len(energies)
    longest = max(int(np.log2(max(LONGEST_CORRELATION * samples, 1.0))), 0)
    table, inverse, log_table, log_prior = _family(J, longest, free_bias)
    counted = np.minimum(degrees, MOST_LIKELIHOOD_DEGREES)
    seen = counted > 0.0
    energy = np.where(seen, energies * counted / np.where(seen, degrees, 1.0), 0.0)
    total = float(counted.sum()) + SCALE_DEGREES
    level = (energy @ inverse[:J] + SCALE_DEGREES) / total
    log = log_prior - 0.5 * (counted @ log_table[:J] + total * np.log(level))
    weights = np.exp(log - log.max())
    weights *= level / weights.sum()
    variances, white = table @ weights, float(weights.sum())
    mean = PRIOR_DEGREES * variances[:J]
    variances[:J] = (energies + mean) / (degrees + PRIOR_DEGREES)
    return variances, white


@lru_cache(maxsize=64)
def _family(
    levels: int, longest: int, free_bias: bool
) -> tuple[Array, Array, Array, Array]:
    """Variances (levels + 1, n) of the family's spectra, their inverses and logarithms,
    and the log prior probabilities (n,).

    Processes last 1, 2, .. 2^longest samples. The last row is that of a level beyond
    all others or, without a free bias, of sums over 2^levels samples.
    """
    times = 2.0 ** np.arange(longest + 1)
    each = np.array([first_order(np.exp(-1.0 / t), levels + 1) for t in times])
    if not free_bias:
        each[:, -1] = [
            _sums(np.exp(-1.0 / t), np.array((2.0**levels,)))[0] / 2.0**levels
            for t in times
        ]
    one = (1.0 + PROCESS_VARIANCES[:, None, None] * each).reshape(-1, levels + 1)
    pairs = [(i, k) for i in range(len(times)) for k in range(i + 2, len(times))]
    coarse = PROCESS_VARIANCES[::2]
    two = [
        1.0 + coarse[:, None, None] * each[i] + (coarse[:, None] * each[k])[None]
        for i, k in pairs
    ]
    parts = [np.ones((1, levels + 1)), one]
    prior = [
        np.array((PROBABILITY_WHITE,)),
        np.full(len(one), PROBABILITY_ONE_PROCESS / len(one)),
    ]
    if two:
        both = np.array(two).reshape(-1, levels + 1)
        parts.append(both)
        prior.append(
            np.full(
                len(both),
                (1.0 - PROBABILITY_WHITE - PROBABILITY_ONE_PROCESS) / len(both),
            )
        )
    table = np.ascontiguousarray(np.concatenate(parts).T)
    return table, 1.0 / table, np.log(table), np.log(np.concatenate(prior))


def first_order(rho: float, levels: int) -> Array:
    """(levels,) variance of Haar details of a first-order process of variance 1."""
    m = np.exp2(np.arange(levels + 1, dtype=float))
    S = _sums(rho, m)
    return (4.0 * S[:-1] - S[1:]) / (2.0 * m[:-1])


def _sums(rho: float, m: Array) -> Array:
    """Variance of sums over m samples of a first-order process of variance 1."""
    return m * (1.0 + rho) / (1.0 - rho) - 2.0 * rho * (1.0 - rho**m) / (1.0 - rho) ** 2


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


@immutable
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
    """Variances (J + 1,) less those `expected` (J + 1,) of other errors, but no less than
    the `white` noise.

    Time scales without `degrees` (J,) of freedom, whose variances are inferred from the
    others, keep the share that the slowest other one keeps.
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
    """Whether the energies (J,) of any time scale significantly exceed those of white
    noise, which are chi-square with `degrees` (J,) of freedom."""
    enough = degrees >= FEWEST_DEGREES_FOR_CLAIM
    limit = degrees + LARGEST_CLAIM_EXCESS * np.sqrt(2.0 * degrees)
    return bool((energies > limit)[enough].any())


def response_errors(
    found: Scores, variances: Array, details: Array, phi: Array
) -> Array:
    """(J + 1,) relative errors of the wrench in step with the motion, at each time scale
    and beyond.

    Causes are a sensor whose gain depends on frequency, an arm that bends, a late
    clock, and smoothed motion. The gain error of a scale is its part beyond
    `GAIN_CHANCE`. Towards slower scales it is assumed to decrease by no more than the
    factor `GAIN_FADE_PER_OCTAVE` an octave, unless a scale bounds its own error: by
    `GAIN_BOUND_STDS` standard deviations above the error it shows. White errors of the
    motion attenuate the score of every detail by the same amount, which is subtracted.
    """
    signal = found.information @ phi @ phi
    score, moves = found.scores @ phi, signal > 0.0
    weights = details[moves] / (variances * signal)[moves]
    square = max(float(weights @ details[moves]), 1e-300)
    attenuation = -float(weights @ score[moves]) / square
    score = np.maximum(np.abs(score) - max(attenuation, 0.0) * details, 0.0)
    seen = np.where(moves, signal, np.inf)
    gain = score / seen
    significance = np.maximum(gain**2 * signal / variances, GAIN_CHANCE)
    shown = gain * np.sqrt(np.maximum(1.0 - GAIN_CHANCE / significance, 0.0))
    possible = gain + GAIN_BOUND_STDS * np.sqrt(variances / seen)
    possible[~moves] = np.inf
    errors = [0.0]
    for own, most in zip(shown.tolist(), possible.tolist(), strict=True):
        errors.append(max(own, min(GAIN_FADE_PER_OCTAVE * errors[-1], most)))
    return np.array((*errors[1:], GAIN_FADE_PER_OCTAVE * errors[-1]))
