"""Thinning: as many samples of a curve as a screen shows, its peaks among them."""

import numpy as np
from numpy.typing import ArrayLike

from hefting.core.spatial import Array, Indices

MOST = 2_000
"""Samples of a curve that are drawn at most: two a pixel column of a wide screen."""


GAP = 5.0
"""Steps of the median length that a step is longer than over which no line is drawn."""


def gaps_between(time: Array, shown: Indices) -> Indices:
    """Positions of those of the `shown` samples of times (K,) [s] that a gap
    precedes."""
    steps = np.diff(time)
    if not len(steps):
        return np.zeros(0, dtype=np.intp)
    before = np.append(0, np.cumsum(steps > GAP * np.median(steps)))
    return 1 + np.flatnonzero(np.diff(before[shown]))


def thinned(values: ArrayLike, most: int = MOST) -> Indices:
    """Indices of at most `most` samples of curves that have their time in common.

    Of short curves all. Else the first and the last, and of consecutive parts of equal
    length the lowest and the highest sample of each curve: no peak is lost.

    Parameters
    ----------
    values : ArrayLike
        (K,) or (K, c) of c curves; what is not finite is passed over.
    most : int
        At least 2 c + 2.
    """
    columns = np.asarray(values, dtype=float)
    columns = columns.reshape(len(columns), -1)
    if len(columns) <= most:
        return np.arange(len(columns))
    parts = (most - 2) // (2 * columns.shape[1])
    length = -(-len(columns) // parts)
    padded = np.full((parts * length, columns.shape[1]), np.nan)
    padded[: len(columns)] = columns
    blocks = padded.reshape(parts, length, -1)
    begin = length * np.arange(parts)[:, None]
    lowest = begin + np.where(np.isnan(blocks), np.inf, blocks).argmin(axis=1)
    highest = begin + np.where(np.isnan(blocks), -np.inf, blocks).argmax(axis=1)
    chosen = np.unique((lowest, highest))
    chosen = np.append(chosen[chosen < len(columns)], (0, len(columns) - 1))
    return np.unique(chosen)
