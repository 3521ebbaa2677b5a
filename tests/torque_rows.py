"""Samples of joint torques folded row by row, without time scales."""

from dataclasses import replace

import numpy as np

from hefting.core.spatial import Array, Mask
from hefting.core.torque_moments import TorqueMoments, payload_factor


def folded(
    moments: TorqueMoments, rows: Array, time: Array, used: Mask | None = None
) -> TorqueMoments:
    """With samples `rows` (K, n, c) at `time` (K,) of which `used` (K, n) count."""
    used = np.ones(rows.shape[:2], dtype=bool) if used is None else used
    return replace(
        moments.fold_rows(rows * used[:, :, None]),
        counts=moments.counts + used.sum(axis=0),
        samples=moments.samples + len(time),
        start=min(moments.start, float(time.min(initial=np.inf))),
        end=max(moments.end, float(time.max(initial=-np.inf))),
    )


def payload(moments: TorqueMoments, std: float | Array = 1.0) -> Array:
    """(11, 11) factor of the payload's equations, the joints' noise `std` (n,)."""
    return payload_factor(moments.shared(std))
