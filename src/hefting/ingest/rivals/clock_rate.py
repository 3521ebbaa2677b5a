"""The clock of the poses runs faster or slower than that of the wrench."""

import numpy as np

from hefting.core.spatial import Array
from hefting.ingest.rivals.case import Case
from hefting.ingest.rivals.evidence import (
    Fitted,
    Rows,
    fit_rows,
    is_hopeless,
    linear_step,
)
from hefting.ingest.rivals.explanation import (
    OFFSET_STEP,
    Explanation,
    fit_as_given,
    newton_euler,
)

CODE = "clock-rate"
RATES = np.array(
    (-0.05, -0.03, -0.02, -0.01, -0.005, -0.002, 0.002, 0.005, 0.01, 0.02, 0.03, 0.05)
)
"""Relative differences of the clocks that are tried; they are refined."""
OFFSETS = 0.04 * np.arange(-6.0, 7.0)
"""[s] Clock offsets in the middle of the recording that are tried with each rate."""
FIRST_SAMPLES = 50
"""Largest number of averages on which pairs are compared."""
FIRST_ITERATIONS = 2
"""Number of reweightings of the first comparison."""
KEPT = 6
"""Number of likeliest pairs of a rate and an offset that are compared in full."""
STEPS = 5
"""Gauss-Newton steps of rate and offset."""


def explain(case: Case) -> Explanation | None:
    """The relative rate of the poses' clock."""
    if not case.path.moves or np.ptp(case.time) < 3.0:
        return None
    rate, offset = _coarse(case)
    fitted, around = _fit(case, rate, offset, None)
    given, _ = fit_as_given(case)
    for taken in range(STEPS):
        if taken and is_hopeless(case, fitted, given):
            return None
        step = linear_step(fitted, _columns(case, around, fitted))
        rate += float(np.clip(step.change[0], -0.01, 0.01))
        offset += float(np.clip(step.change[1], -0.04, 0.04))
        fitted, around = _fit(case, rate, offset, fitted)
    std = float(np.sqrt(step.covariance[0, 0]))
    what = (
        f"the clock of the poses seems to run {abs(100.0 * rate):.2g} ± "
        f"{100.0 * std:.1g} % {'fast' if rate > 0.0 else 'slow'} against the wrench's"
    )
    fix = "stamp both by one clock"
    return Explanation(CODE, what, fix, fitted, 2, effect=abs(rate) / std)


def _times(case: Case, rate: Array | float, offset: Array | float) -> Array:
    """Times of the poses at the wrench's samples (..., K) [s]."""
    middle = 0.5 * (case.time[0] + case.time[-1])
    since = case.time - middle
    rates, offsets = np.asarray(rate)[..., None], np.asarray(offset)[..., None]
    return middle + since * (1.0 + rates) - offsets


def _coarse(case: Case) -> tuple[float, float]:
    rates, offsets = (x.ravel() for x in np.meshgrid(RATES, OFFSETS, indexing="ij"))
    nth = -(-len(case.time) // FIRST_SAMPLES)
    thin, times = case.every(nth), _times(case, rates, offsets)[:, ::nth]
    rows = newton_euler(thin, thin.motion_at(times))
    quick = fit_rows(thin, rows, FIRST_ITERATIONS).likelihood
    kept = np.argsort(quick)[-KEPT:]
    best = kept[fit_rows(thin, rows.part(kept)).best]
    return float(rates[best]), float(offsets[best])


def _fit(
    case: Case, rate: float, offset: float, start: Fitted | None
) -> tuple[Fitted, Rows]:
    """The fit, and the rows `OFFSET_STEP` before and after it."""
    around = offset + OFFSET_STEP * np.array((0.0, -1.0, 1.0))
    rows = newton_euler(case, case.motion_at(_times(case, rate, around)))
    return fit_rows(case, rows.part(slice(1)), start=start), rows.part(slice(1, 3))


def _columns(case: Case, around: Rows, fitted: Fitted) -> Array:
    """(K, 6, 2) derivative of the wrench by rate and offset."""
    wrench = around.predict(fitted.solution[0])
    late = (wrench[1] - wrench[0]) / (2.0 * OFFSET_STEP)
    since = case.time - 0.5 * (case.time[0] + case.time[-1])
    return np.stack((-since[:, None] * late, late), axis=2)
