"""Time scales: the features of consecutive samples, divided into changes of ever longer
duration.

The orthonormal Haar transform of a series pairs neighbours: a pair (x1, x2) becomes its
detail (x1 - x2) / sqrt(2) and its sum (x1 + x2) / sqrt(2); the sums are paired in turn.
Level j holds the differences between blocks of 2^j samples. Each level keeps a
triangular factor of its details' features. As residuals are linear in the features,
their energy at every level follows for any parameters after the samples are gone: the
noise spectrum by octaves. A constant offset has no details. See Percival & Walden,
*Wavelet Methods for Time Series Analysis*, 2000.

And the autocorrelation time of a series.
"""

from typing import Self

import numpy as np

from hefting.core.moments import folded, triangular
from hefting.core.regressor import FEATURES
from hefting.core.spatial import Array, immutable

HAAR_FACTOR = 0.5**0.5
"""Factor of the orthonormal Haar transform: 1 / sqrt(2)."""


@immutable
class TimeScales:
    """Triangular factors of Haar details, finest level first. Immutable."""

    factors: tuple[Array, ...] = ()
    """(22, 22) each: level j: differences of neighbouring blocks of 2^j samples"""
    counts: tuple[int, ...] = ()
    """details at each level"""
    pending: tuple[Array | None, ...] = ()
    """(1, 22) each: the sum at each level that waits for its neighbour; None: none"""

    def fold(self, rows: Array) -> Self:
        """With the features `rows` (k, 22) of the samples that follow."""
        factors = list(self.factors)
        counts = list(self.counts)
        pending = list(self.pending)
        level = 0
        while len(rows):
            if level == len(factors):
                factors.append(np.zeros((FEATURES, FEATURES)))
                counts.append(0)
                pending.append(None)
            waiting = pending[level]
            if waiting is not None:
                rows = np.concatenate((waiting, rows))
            pairs = len(rows) // 2
            pending[level] = rows[2 * pairs :].copy() if len(rows) % 2 else None
            if pairs == 0:
                break
            first, second = rows[0 : 2 * pairs : 2], rows[1 : 2 * pairs : 2]
            factors[level] = folded(factors[level], HAAR_FACTOR * (first - second))
            counts[level] += pairs
            rows = HAAR_FACTOR * (first + second)
            level += 1
        return type(self)(tuple(factors), tuple(counts), tuple(pending))

    def scaled(self, weight: float) -> Self:
        """With every weight multiplied by `weight`."""
        scale = weight**0.5
        return type(self)(
            tuple(scale * factor for factor in self.factors),
            self.counts,
            tuple(None if row is None else scale * row for row in self.pending),
        )

    def closed(self) -> Self:
        """With contrasts among the pending sums: all information except the samples'
        total.

        The sums s1 and s2 over n1 and n2 samples give the contrast (sqrt(n2) s1 -
        sqrt(n1) s2) / sqrt(n1 + n2), which stands at the level of blocks of sqrt(n1 n2)
        samples.
        """
        factors, counts = list(self.factors), list(self.counts)
        total: Array | None = None
        number = 0
        for level, waiting in enumerate(self.pending):
            if waiting is None:
                continue
            size = 2**level
            if total is None:
                total, number = waiting, size
                continue
            both = (number + size) ** 0.5
            contrast = (size**0.5 * total - number**0.5 * waiting) / both
            total = (number**0.5 * total + size**0.5 * waiting) / both
            number = number + size
            at: int = round(0.5 * np.log2((number - size) * size))
            factors[at] = folded(factors[at], contrast)
            counts[at] += 1
        while counts and not counts[-1]:
            factors.pop()
            counts.pop()
        return type(self)(tuple(factors), tuple(counts))

    def merge(self, later: "TimeScales") -> Self:
        """With the scales of other samples; no detail spans the two."""
        size = max(len(self.factors), len(later.factors))
        factors: list[Array] = []
        counts: list[int] = []
        for level in range(size):
            both = [part for part in (self, later) if level < len(part.factors)]
            factors.append(
                both[0].factors[level]
                if len(both) == 1
                else triangular(np.concatenate([part.factors[level] for part in both]))
            )
            counts.append(sum(part.counts[level] for part in both))
        pending = (*later.pending, *(None,) * (size - len(later.pending)))
        return type(self)(tuple(factors), tuple(counts), pending)


def autocorrelation_time(series: Array) -> float:
    """Integrated autocorrelation time of the columns of `series` (K, d), averaged; 1
    for white noise, never less."""
    x = series - series.mean(axis=0)
    n = len(x)
    if n < 8 or not x.any():
        return 1.0
    size = 1 << (2 * n - 1).bit_length()
    covariance = np.fft.irfft(np.abs(np.fft.rfft(x, size, axis=0)) ** 2, size, axis=0)[
        : n // 2
    ]
    times: list[float] = []
    for column in covariance.T[covariance[0] > 0.0]:
        rho = column / column[0]
        below = np.flatnonzero(rho < 0.05)
        times.append(
            1.0 + 2.0 * float(rho[1 : below[0] if len(below) else len(rho)].sum())
        )
    return max(1.0, float(np.mean(times))) if times else 1.0
