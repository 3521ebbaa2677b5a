"""Spectrum of the noise by octaves, from the energies of the residuals at each time
scale.

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

from hefting.core.spatial import Array

PROBABILITY_WHITE = 0.85
"""Prior probability of white noise. Most sensors are specified as white, and a white
record should not have much wider intervals for noise that it rules out."""
PROBABILITY_ONE_PROCESS = 0.1
"""Prior probability of one first-order process beside white noise; the remaining 0.05
is for two."""
PROCESS_VARIANCES = 4.0 ** np.arange(-4, 7)
"""(11,) variances of a process relative to that of the white noise, all equally
probable."""
LONGEST_CORRELATION = 4.0
"""Longest correlation time of a process, in lengths of the record. A slower process is
a bias or a drift."""
MOST_LIKELIHOOD_DEGREES = 200.0
"""Largest number of degrees of freedom of an energy in the likelihood of a spectrum: no
true spectrum is closer than a tenth to one of the family."""
PRIOR_DEGREES = 10.0
"""Degrees of freedom of the family's mean at a level, beside those of the observed
energy."""
SCALE_DEGREES = 4.0
"""Degrees of freedom of the prior that the level is 1, that of whitened residuals; it
matters in short records."""


def spectrum(
    energies: Array, degrees: Array, samples: float, free_bias: bool = True
) -> tuple[Array, float]:
    """Variances (J + 1,) of residuals' details at J levels, and of still longer sums;
    and how much of each is white noise.

    They allow for what the record is too short to show.

    Parameters
    ----------
    energies : (J,) sums of squared details of residuals, whitened by their covariance
        at one instant.
    degrees : (J,) degrees of freedom of each: what is left of six a detail after the
        fit.
    samples : length of the record.
    free_bias : whether a constant bias is free; if not, the longest sums hold whatever
        seems constant.
    """
    J = len(energies)
    table, inverse, log_table, log_prior = _family(
        J, max(int(np.log2(max(LONGEST_CORRELATION * samples, 1.0))), 0), free_bias
    )
    d = np.minimum(degrees, MOST_LIKELIHOOD_DEGREES)
    some = d > 0.0
    E = np.where(some, energies * d / np.where(some, degrees, 1.0), 0.0)
    total = float(d.sum())
    scale = (E @ inverse[:J] + SCALE_DEGREES) / (total + SCALE_DEGREES)
    log = log_prior - 0.5 * (
        d @ log_table[:J] + (total + SCALE_DEGREES) * np.log(scale)
    )
    weights = np.exp(log - log.max())
    weights *= scale / weights.sum()
    variances, white = table @ weights, float(weights.sum())
    variances[:J] = (energies + PRIOR_DEGREES * variances[:J]) / (
        degrees + PRIOR_DEGREES
    )
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
