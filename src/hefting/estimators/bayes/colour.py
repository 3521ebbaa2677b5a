"""Coloured residuals and recordings that contradict themselves: what white noise with a constant bias leaves out."""

from dataclasses import replace

import numpy as np

from hefting.errors import NotIdentifiableError
from hefting.estimators.bayes import Bayes
from hefting.measurements import Measurements
from hefting.regressor import predict_wrench
from hefting.spatial import Array

ROUNDS = 4
"""Times the residuals, which depend on the answer, are looked at."""
SIGNIFICANT = 3.0
"""Standard deviations that the correlation of neighbours must be from zero."""
LONGEST = 0.5
"""Of the recording: the longest time over which a correlation is believed."""
STRETCHES = 4
"""Pieces of a recording that are compared."""
SHORTEST = 50
"""Samples of one of them."""
DISAGREE = 3.0
"""Variance between them over what they claim that is more than chance."""


def coloured(estimator: Bayes, measurements: Measurements) -> Bayes:
    """`estimator` with the autocorrelation that its own residuals have, and with the disagreement of stretches.

    The samples are in order of time, and evenly spaced; the shape is not grossly wrong.
    """
    alone = replace(estimator, systematic=None)  # that is no noise, and the same for all stretches
    found = _coloured(alone, measurements)
    ratio = disagreement(alone, measurements)
    return replace(found, systematic=estimator.systematic, disagreement=ratio if ratio > DISAGREE else 1.0)


def _coloured(estimator: Bayes, z: Measurements) -> Bayes:
    state = estimator.update(estimator.start(), z)
    for _ in range(ROUNDS):
        posterior = estimator.posterior(state)
        r = z.wrench - predict_wrench(z, posterior.mixture.mean)
        if posterior.bias is not None:
            r = r - posterior.bias
        if z.weights is not None:
            r = r * np.sqrt(z.weights)[:, None]
        before = estimator.autocorrelation
        found = residual_colour(r / np.sqrt(posterior.residual_covariance.diagonal()))
        estimator = replace(estimator, autocorrelation=found)
        if abs(found / before - 1.0) < 0.05:
            break
    return estimator


def residual_colour(residuals: Array) -> float:
    """Variance of the sum of residuals (K, c), of one variance, over that of white ones; never less than one.

    Of all columns together, as if white noise were added to a first-order process: autocorrelation a rho^h at lag h,
    rho and a by least squares. A short series shows too little of a long correlation: rho is raised by (1 + 4 rho) / K,
    what it is too small by on average (Kendall 1954).
    """
    K = len(residuals)
    if K < 8 or not residuals.any():
        return 1.0
    size = 1 << (2 * K - 1).bit_length()
    power = (np.abs(np.fft.rfft(residuals, size, axis=0)) ** 2).sum(axis=1)
    lags = np.arange(K // 2)
    covariance = np.fft.irfft(power, size)[: len(lags)] / (K - lags)
    r = covariance / covariance[0]
    deviation = residuals.size**-0.5
    if r[1] < SIGNIFICANT * deviation:
        return 1.0
    below = np.flatnonzero(r < max(0.1 * r[1], deviation))
    head = r[1 : max(int(below[0]) if len(below) else len(r), 3)]
    rho = min(max(float(head[1:] @ head[:-1] / (head[:-1] @ head[:-1])), 0.0), 1.0)
    powers = rho ** np.arange(1, len(head) + 1)
    a = min(float(powers @ head / (powers @ powers)), 1.0) if rho > 0.0 else 0.0
    rho = min(rho + (1.0 + 4.0 * rho) / K, 1.0 - 1.0 / (LONGEST * K))
    return 1.0 + 2.0 * max(a * rho / (1.0 - rho), float(r[1]))


def disagreement(estimator: Bayes, measurements: Measurements) -> float:
    """Variance of mass and first moment between stretches over what each stretch's posterior claims (Birge 1932).

    Each stretch has its own colour, and its own bias where one is free. About 1 where all is as modelled; 0 where
    there is too little data.
    """
    K = len(measurements)
    if K < STRETCHES * SHORTEST:
        return 0.0
    means, weights = [], []
    for part in np.array_split(np.arange(K), STRETCHES):
        piece = measurements[part[0] : part[-1] + 1]
        try:
            alone = _coloured(estimator, piece)
            mixture = alone.posterior(alone.update(alone.start(), piece)).mixture
        except NotIdentifiableError:
            return 0.0
        means.append(mixture.mean[:4])
        weights.append(np.linalg.pinv(mixture.covariance[:4, :4], rcond=1e-12, hermitian=True))
    total = np.sum(weights, axis=0)
    sums = np.sum([w @ x for w, x in zip(weights, means, strict=True)], axis=0)
    common = np.linalg.lstsq(total, sums, rcond=1e-12)[0]
    square = sum(float((x - common) @ w @ (x - common)) for w, x in zip(weights, means, strict=True))
    return square / (4.0 * (STRETCHES - 1))
