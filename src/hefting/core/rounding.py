"""Rounding: as many digits of a number as it is worth.

A number known to half a width h of its 95 % interval is worth two significant digits of
h. One without an interval gets `MOST_DIGITS` digits, and none gets more.
"""

import numpy as np
from numpy.typing import ArrayLike

from hefting.core.spatial import Array

MOST_DIGITS = 6
"""Significant digits of the largest of several numbers that belong together: enough for
any sensor, and few enough that rounding errors of arithmetic do not show."""
DIGITS_OF_HALF_WIDTH = 2
"""As uncertainties are commonly stated (GUM, JCGM 100:2008, 7.2.6)."""


def decimals(half_widths: ArrayLike, size: float, least_digits: int = 0) -> np.ndarray:
    """Decimal places to which numbers are rounded.

    Parameters
    ----------
    half_widths : half the widths of their intervals; zero, infinite or NaN where there
        is none.
    size : size of the largest of the numbers, which are of one kind.
    least_digits : significant digits of `size` that are kept however wide the intervals
        are.

    Returns
    -------
    ndarray
        Integers of the same shape as `half_widths`; negative where tens are rounded.
    """
    half = np.asarray(half_widths, dtype=float)
    finest = MOST_DIGITS - 1 - _exponent(size) if size > 0.0 else MOST_DIGITS
    known = np.isfinite(half) & (half > 0.0)
    exponents = np.floor(np.log10(np.where(known, half, 1.0))).astype(int)
    worth = np.where(known, DIGITS_OF_HALF_WIDTH - 1 - exponents, finest)
    coarsest = least_digits - 1 - _exponent(size) if least_digits and size else -300
    return np.clip(worth, min(coarsest, finest), finest)


def rounded(values: ArrayLike, places: ArrayLike) -> Array:
    """Numbers rounded to decimal `places` each; the nearest doubles of those decimals,
    and zero without a sign."""
    each = np.broadcast_arrays(np.asarray(values, dtype=float), np.asarray(places))
    flat = [
        round(float(v), int(d)) + 0.0 if np.isfinite(v) else float(v)
        for v, d in zip(each[0].ravel(), each[1].ravel(), strict=True)
    ]
    return np.array(flat).reshape(each[0].shape)


def _exponent(size: float) -> int:
    """Power of ten of the first digit."""
    return int(np.floor(np.log10(size)))
