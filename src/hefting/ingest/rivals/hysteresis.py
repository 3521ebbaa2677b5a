"""Hysteresis, or play: each channel follows the load only after it has moved by some
share of its range."""

import numpy as np

from hefting.core.spatial import Array, distinct
from hefting.ingest.rivals.case import Case
from hefting.ingest.rivals.evidence import fit_rows, is_hopeless
from hefting.ingest.rivals.explanation import (
    Explanation,
    fit_as_given,
    newton_euler,
    of_each_wrench,
)

CODE = "hysteresis"
SHARES = np.array((0.005, 0.01, 0.02, 0.03, 0.05, 0.1))
"""Play over the range of each channel that is tried."""
PASSES = 2
"""Number of times that the play is found, from improved predictions of the load."""


def explain(case: Case) -> Explanation | None:
    """The likeliest play."""
    if not case.path.moves:
        return None
    given, late = fit_as_given(case)
    # play looks like a delay, which the recording as given may have taken it for
    offsets = distinct((0.0, 0.5 * late, late))
    rows = newton_euler(case, case.motion_late(offsets))
    fitted = fit_rows(case, rows)
    load = case.wrench - fitted.residual[fitted.best]
    for _ in range(PASSES):
        wrenches = case.wrench - _lags(load, SHARES)
        fitted = of_each_wrench(case, rows, wrenches)
        if is_hopeless(case, fitted, given):
            return None
        index = fitted.best // len(offsets)
        load = wrenches[index] - fitted.residual[fitted.best]
    what = (
        f"the sensor seems to follow the load with some {100.0 * SHARES[index]:.2g} % of "
        "play or hysteresis"
    )
    fix = "check how it is mounted, and its cable"
    return Explanation(CODE, what, fix, fitted, 1, rarity=2.0, of_many_laws=True)


def _lags(load: Array, shares: Array) -> Array:
    """(S, K, 6) readings of followers with play of each of the shares (S,), less their
    load (K, 6)."""
    half = 0.5 * shares[:, None] * np.ptp(load, axis=0)
    shown = np.empty((len(load), *half.shape))
    shown[0] = load[0]
    low, high = load[:, None] - half, load[:, None] + half
    for k in range(1, len(load)):
        np.minimum(np.maximum(shown[k - 1], low[k]), high[k], out=shown[k])
    return np.swapaxes(shown - load[:, None], 0, 1)
