"""The sensor's calibration matrix is off: channels have different gains, or respond to
one another. A gain that all channels share cannot be told from another mass."""

import numpy as np

from hefting.core.spatial import Array
from hefting.ingest.rivals.case import Case
from hefting.ingest.rivals.evidence import (
    Fitted,
    LinearPart,
    Rows,
    correlation,
    fit_rows,
)
from hefting.ingest.rivals.explanation import Explanation, fit_as_given, newton_euler

GAIN, CROSS_TALK = "gain-uneven", "cross-talk"
USUAL_ERROR = 0.03
"""Standard deviation of the matrix's errors, as a share of the channels' ranges."""
RANGES = np.repeat((1.0, 0.1), 3)
"""Ranges of the channels [N, N m], up to a factor: those of common sensors."""
PASSES = 3
"""Times the matrix is found beside a better prediction of the wrench."""
CHANNELS = ("fx", "fy", "fz", "tx", "ty", "tz")


def explain(case: Case) -> Explanation | None:
    """The likeliest errors of the matrix (6, 6), to first order."""
    _, offset = fit_as_given(case)
    rows = newton_euler(case, case.motion_at(case.time[None] - offset))
    precision = (np.divide.outer(RANGES, RANGES) * USUAL_ERROR).ravel() ** -2.0
    fitted, errors, cost = fit_rows(case, rows), np.zeros((6, 6)), 0.0
    for _ in range(PASSES):
        wrench = rows.predict(fitted.solution[0, :10])[0]
        errors, cost = _step(fitted, wrench, errors, precision)
        mended = case.wrench - wrench @ errors.T
        fitted = fit_rows(case, Rows(rows.known, rows.maps, rows.used, mended[None]))
    code, what = _told(errors, np.sqrt(np.mean(wrench**2, axis=0)))
    fix = "check its calibration matrix, or weigh something known"
    return Explanation(code, what, fix, fitted, 36, cost=cost, rarity=2.0)


def _step(
    fitted: Fitted, wrench: Array, before: Array, precision: Array
) -> tuple[Array, float]:
    """Errors of the matrix (6, 6), and what they cost (see `Explanation.cost`), beside
    a prediction of the wrench (K, 6) and a fit with the errors `before` taken away."""
    columns = np.einsum("kj,ci->kcij", wrench, np.eye(6)).reshape(len(wrench), 6, 36)
    S, g = LinearPart.of(fitted, 0).beside(columns)
    independent = 1.0 / correlation(fitted, 0)
    S, g = independent * S, independent * g
    g = g + S @ before.ravel()
    errors = np.linalg.solve(S + np.diag(precision), g)
    scale = precision**-0.5
    _, logdet = np.linalg.slogdet(np.eye(36) + S * scale * scale[:, None])
    cost = 0.5 * float(logdet + errors @ (precision * errors))
    return np.array(errors, dtype=float).reshape(6, 6), cost


def _told(errors: Array, size: Array) -> tuple[str, str]:
    """Code and text of the largest error beside the size (6,) of the channels."""
    effects = np.abs(errors) * size / RANGES[:, None]
    to, of = (int(i) for i in np.unravel_index(np.argmax(effects), effects.shape))
    if to == of:
        gain = 100.0 * errors[to, to]
        what = (
            f"the sensor's channels seem to have different gains, {CHANNELS[to]} "
            f"{gain:+.1f} % against the others"
        )
        return GAIN, what
    share = 100.0 * errors[to, of] * RANGES[of] / RANGES[to]
    what = (
        f"the sensor's channels seem to respond to one another, {CHANNELS[to]} to "
        f"{CHANNELS[of]} by {share:+.1f} % of its range"
    )
    return CROSS_TALK, what
