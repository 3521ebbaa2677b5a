"""The sensor's calibration matrix is wrong: channels have different gains, or respond
to one another. A gain common to all channels is the same as another mass."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from hefting.core.spatial import WRENCH, Array, Indices
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
ALL = np.arange(36)
GAINS = 7 * np.arange(6)
"""Indices of the matrix's entries, row by row, and of the gains among them."""
USUAL_ERROR = 0.03
"""Standard deviation of the matrix's errors, as a share of the channels' ranges."""
DATA_SHEET_ERROR = 0.005
"""The same for a sensor within its data sheet."""
LARGE_DATA_SHEET_ERROR = 0.01
"""The same for one that is used in a small part of its range."""
RANGES = np.repeat((1.0, 0.1), 3)
"""Ranges [N, N m] of the channels of common sensors, up to a factor."""
PASSES = 3
"""Number of times that the matrix is found, each with a better prediction of the
wrench."""


def explain(case: Case) -> Explanation | None:
    """The likeliest errors of the matrix (6, 6), to first order."""
    return _likeliest(
        case, ALL, USUAL_ERROR, lambda: _likeliest(case, GAINS, USUAL_ERROR)
    )


def errors_on_data_sheet(case: Case, size: float = DATA_SHEET_ERROR) -> Explanation:
    """Errors of a `size` as on data sheets, which are no mistake; `effect` is their
    root mean square over that size."""
    return replace(_likeliest(case, ALL, size), rarity=0.0)


def _likeliest(
    case: Case,
    free: Indices,
    std: float,
    alternative: Callable[[], Explanation | None] | None = None,
) -> Explanation:
    """The likeliest errors of the entries with indices `free` (q,), each with a
    standard deviation `std` as a share of the channels' ranges."""
    _, offset = fit_as_given(case)
    rows = newton_euler(case, case.motion_late(offset))
    fitted, errors, cost = fit_rows(case, rows), np.zeros(36), 0.0
    for _ in range(PASSES):
        wrench = rows.predict(fitted.solution[0, :10])[0]
        errors[free], cost = _step(fitted, wrench, errors[free], free, std)
        mended = case.wrench - wrench @ errors.reshape(6, 6).T
        other = Rows(rows.known, rows.maps, rows.used, mended[None])
        fitted = fit_rows(case, other, start=fitted)
    code, what = _largest_error(
        errors.reshape(6, 6), np.sqrt(np.mean(wrench**2, axis=0))
    )
    fix = "check its calibration matrix, or weigh something known"
    return Explanation(
        code,
        what,
        fix,
        fitted,
        len(free),
        cost=cost,
        rarity=2.0,
        alternative=alternative,
        effect=float(np.sqrt(np.mean(np.square(errors / _scale(std)))))
        if std < USUAL_ERROR
        else None,
    )


def _step(
    fitted: Fitted, wrench: Array, before: Array, free: Indices, std: float
) -> tuple[Array, float]:
    """Errors (q,) of the free entries and their cost (`Explanation.cost`), given a
    prediction of the wrench (K, 6) and a fit with the errors `before` (q,) corrected.
    """
    columns = np.einsum("kj,ci->kcij", wrench, np.eye(6)).reshape(len(wrench), 6, 36)
    S, g = LinearPart.of(fitted).beside(columns[:, :, free])
    independent = 1.0 / correlation(fitted)
    S, g = independent * S, independent * g
    g = g + S @ before
    scale = _scale(std)[free]
    errors = np.linalg.solve(S + np.diag(scale**-2.0), g)
    _, logdet = np.linalg.slogdet(np.eye(len(free)) + S * scale * scale[:, None])
    cost = 0.5 * float(logdet + np.sum(np.square(errors / scale)))
    return np.array(errors, dtype=float), cost


def _scale(std: float) -> Array:
    """(36,) standard deviations of the entries, for `std` as a share of the ranges."""
    return std * np.divide.outer(RANGES, RANGES).ravel()


def _largest_error(errors: Array, size: Array) -> tuple[str, str]:
    """Code and text of the largest of the errors (6, 6), for channels of root mean
    square `size` (6,)."""
    effects = np.abs(errors) * size / RANGES[:, None]
    to, of = (int(i) for i in np.unravel_index(np.argmax(effects), effects.shape))
    if to == of:
        gain = 100.0 * errors[to, to]
        what = (
            f"the sensor's channels seem to have different gains, {WRENCH[to]} "
            f"{gain:+.1f} % against the others"
        )
        return GAIN, what
    share = 100.0 * errors[to, of] * RANGES[of] / RANGES[to]
    what = (
        f"the sensor's channels seem to respond to one another, {WRENCH[to]} to "
        f"{WRENCH[of]} by {share:+.1f} % of its range"
    )
    return CROSS_TALK, what
