"""Possible: which samples of a stream can be."""

from collections import Counter

import numpy as np

from hefting.core.magnitudes import LARGEST, LARGEST_TIME
from hefting.core.recording import COLUMNS, JOINT_STREAMS
from hefting.core.spatial import Array, Mask
from hefting.online.samples import Samples

UNIT_NORM = 0.01
"""Largest distance of a quaternion's norm from one, as in `hefting.Recording`."""


def arrays_of(samples: Samples) -> tuple[Array, Array] | None:
    """Times (n,) and values (n, d); None where they are no stream's."""
    columns = COLUMNS.get(samples.stream)
    time, values = np.asarray(samples.time), np.asarray(samples.values)
    if (
        columns is None
        or time.dtype.kind not in "fiu"
        or values.dtype.kind not in "fiu"
    ):
        return None
    if time.ndim != 1 or values.ndim != 2 or len(time) != len(values):
        return None
    joints = samples.stream in JOINT_STREAMS and values.shape[1] > 0
    if not joints and values.shape[1] != len(columns):
        return None
    return time.astype(float, copy=False), values.astype(float, copy=False)


def possible(name: str, time: Array, values: Array, skipped: Counter[str]) -> Mask:
    """Samples (n,) that are finite, and not larger than anything is; the others are
    counted in `skipped`."""
    with np.errstate(all="ignore"):
        finite = np.isfinite(time) & np.isfinite(values).all(axis=1)
        size = np.abs(values).max(axis=1, initial=0.0)
        good = (np.abs(time) < LARGEST_TIME) & (size <= LARGEST.get(name, np.inf))
        if name == "orientation":
            norm = np.linalg.norm(values, axis=1)
            good &= np.abs(norm - 1.0) <= UNIT_NORM
    for reason, which in (("not finite", ~finite), ("impossible", finite & ~good)):
        if which.any():
            skipped[reason] += int(which.sum())
    return finite & good
