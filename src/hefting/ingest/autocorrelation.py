"""Autocorrelation: how many samples of a series count as one."""

import numpy as np

from hefting.core.spatial import Array


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
    times = []
    for column in covariance.T[covariance[0] > 0.0]:
        rho = column / column[0]
        below = np.flatnonzero(rho < 0.05)
        times.append(
            1.0 + 2.0 * float(rho[1 : below[0] if len(below) else len(rho)].sum())
        )
    return max(1.0, float(np.mean(times))) if times else 1.0
