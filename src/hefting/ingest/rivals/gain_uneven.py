"""The channels of the sensor have different gains. One that all share cannot be told
from another mass."""

import numpy as np

from hefting.ingest.rivals.case import Case
from hefting.ingest.rivals.evidence import Rows, fit_rows, linear_step
from hefting.ingest.rivals.explanation import Explanation, newton_euler, over_offsets

CODE = "gain-uneven"
STEPS = 4
"""Gauss-Newton steps of the gains."""
CONTRASTS = np.kron(np.eye(2), np.array(((1, -1, 0), (1, 1, -2))).T / 6.0**0.5)
"""(6, 4) changes of the gains that leave the mean of force's and of torque's."""
DATA_SHEET = 0.005
"""Standard deviation of a channel's gain, as on data sheets."""


def explain(case: Case) -> Explanation | None:
    """Gains of the channels relative to their mean."""
    _, offset = over_offsets(case, lambda motion: newton_euler(case, motion))
    rows = newton_euler(case, case.motion_at(case.time[None] - offset))
    gains, covariance = np.zeros(4), np.eye(4)
    fitted = fit_rows(case, rows)
    for _ in range(STEPS):
        wrench = fitted.rows.predict(fitted.solution[0, :10])[0]
        columns = np.einsum("kc,cj->kcj", wrench, CONTRASTS)
        step = linear_step(fitted, 0, columns)
        gains, covariance = gains + step.change, step.covariance
        maps = rows.maps.copy()
        maps[:, :, :10] *= (1.0 + CONTRASTS @ gains)[None, :, None]
        fitted = fit_rows(case, Rows(rows.known, maps, rows.used))
    each = CONTRASTS @ gains
    names = ("fx", "fy", "fz", "tx", "ty", "tz")
    worst = int(np.argmax(np.abs(each)))
    C = covariance + DATA_SHEET**2 * np.eye(4)
    what = (
        f"the sensor's channels seem to have different gains, {names[worst]} "
        f"{100.0 * each[worst]:+.1f} % against the others"
    )
    return Explanation(
        CODE,
        what,
        "check its calibration matrix, or weigh something known",
        fitted,
        4,
        rarity=2.0,
        effect=float(np.sqrt(gains @ np.linalg.solve(C, gains))),
    )
