"""The sensor's calibration matrix is off: channels respond to one another."""

import numpy as np

from hefting.ingest.rivals.case import Case
from hefting.ingest.rivals.evidence import Rows, fit_rows, linear_step
from hefting.ingest.rivals.explanation import Explanation, newton_euler, over_offsets

CODE = "cross-talk"
LARGEST_SHARE = 0.5
"""Largest response of a channel to another one, over its own, that a sensor has."""


def explain(case: Case) -> Explanation | None:
    """The matrix (6, 6) by which the wrench differs from that of a body, to first
    order."""
    _, offset = over_offsets(case, lambda motion: newton_euler(case, motion))
    rows = newton_euler(case, case.motion_at(case.time[None] - offset))
    fitted = fit_rows(case, rows)
    wrench = rows.predict(fitted.solution[0, :10])[0]
    columns = np.einsum("kj,ci->kcij", wrench, np.eye(6)).reshape(len(wrench), 6, 36)
    step = linear_step(fitted, 0, columns)
    matrix = step.change.reshape(6, 6)
    mended = case.wrench - wrench @ matrix.T
    fitted = fit_rows(case, Rows(rows.known, rows.maps, rows.used, mended[None]))
    size = np.sqrt(np.mean(wrench**2, axis=0))
    shares = np.abs(matrix) * size / np.maximum(size[:, None], 1e-12)
    np.fill_diagonal(shares, 0.0)
    to, of = np.unravel_index(int(np.argmax(shares)), shares.shape)
    if shares[to, of] > LARGEST_SHARE:
        return None
    names = ("fx", "fy", "fz", "tx", "ty", "tz")
    what = (
        f"the sensor's channels seem to respond to one another, {names[to]} to "
        f"{names[of]} by {100.0 * shares[to, of]:.2g} % of its size"
    )
    fix = "check its calibration matrix"
    return Explanation(CODE, what, fix, fitted, 36, rarity=2.0)
