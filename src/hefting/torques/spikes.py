"""Spikes: torques that stand out from those just before and after, of lost or damaged
messages; a motor's torque follows its load, which no joint changes so fast."""

from __future__ import annotations

import numpy as np

from hefting.core.spatial import Array, Mask

WINDOW = 7
"""Samples whose median is looked at: spikes of three in a row stand out from it."""
SPIKE = 12.0
"""Distance from that median over its usual size, from which on a sample is a spike: of
normal noise none in a million years."""
HALF_WITHIN = 0.55
"""Standard deviations from that median that half of normal noise is within."""
LEAST_SPIKE = 0.1
"""Least distance over the torque's standard deviation: where the noise is smaller than
the sensor's steps, or none, friction that turns over is no spike."""
LARGEST_SHARE = 0.1
"""Of a joint's samples above which none is a spike: its torque is of another kind."""


def without_spikes(torque: Array) -> tuple[Array, Mask]:
    """Torques (K, n) [N m] in which the median of its neighbours stands for each spike;
    and (K, n) where these were."""
    # SciPy's filters take long to import
    from scipy.ndimage import median_filter

    usual = median_filter(torque, (WINDOW, 1), mode="nearest")
    apart = np.abs(torque - usual)
    size = np.median(apart, axis=0) / HALF_WITHIN
    found = apart > np.maximum(SPIKE * size, LEAST_SPIKE * torque.std(axis=0))
    found &= found.mean(axis=0) <= LARGEST_SHARE
    return np.where(found, usual, torque), found
