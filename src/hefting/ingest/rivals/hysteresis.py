"""Hysteresis, or play: each channel follows the load only after it has moved by some
share of its range."""

import numpy as np

from hefting.core.spatial import Array
from hefting.ingest.rivals.case import Case
from hefting.ingest.rivals.evidence import Rows, fit_rows
from hefting.ingest.rivals.explanation import Explanation, newton_euler, over_offsets

CODE = "hysteresis"
SHARES = np.array((0.005, 0.01, 0.02, 0.03, 0.05, 0.1))
"""Play over the range of each channel, as tried."""
PASSES = 2
"""Times the play is found from a better prediction of the load."""


def explain(case: Case) -> Explanation | None:
    """The likeliest play."""
    if not case.path.moves:
        return None
    _, offset = over_offsets(case, lambda motion: newton_euler(case, motion))
    rows = newton_euler(case, case.motion_at(case.time[None] - offset))
    fitted = fit_rows(case, rows)
    index = 0
    load = case.wrench - fitted.residual[0]
    for _ in range(PASSES):
        lag = np.array([_lag(load, share) for share in SHARES])
        wrench = case.wrench - lag
        O = len(SHARES)
        known = np.broadcast_to(rows.known, (O, *rows.known.shape[1:]))
        used = np.broadcast_to(rows.used, (O, rows.used.shape[1]))
        fitted = fit_rows(case, Rows(known, rows.maps, used, wrench))
        index = fitted.best
        load = wrench[index] - fitted.residual[index]
    what = (
        f"the sensor seems to follow the load with some {100.0 * SHARES[index]:.2g} % of "
        "play or hysteresis"
    )
    fix = "check how it is mounted, and its cable"
    return Explanation(CODE, what, fix, fitted, 1, rarity=2.0)


def _lag(load: Array, share: float) -> Array:
    """(K, 6) what a follower with play shows less its load (K, 6)."""
    half = 0.5 * share * np.ptp(load, axis=0)
    shown = load.copy()
    low, high = load - half, load + half
    for k in range(1, len(load)):
        shown[k] = np.minimum(np.maximum(shown[k - 1], low[k]), high[k])
    return shown - load
