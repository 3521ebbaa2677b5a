"""Wrench and poses differ in time: the clock of the poses runs faster or slower than
that of the wrench, or the wrench was low-pass filtered, so that its fast part is weaker
and late."""

from dataclasses import replace

import numpy as np

from hefting.core.spatial import Array
from hefting.ingest.filtering import Complex, Signal, filtered
from hefting.ingest.model import REGRESSOR_BY_FEATURE
from hefting.ingest.rivals.case import Case
from hefting.ingest.rivals.evidence import (
    Fitted,
    Rows,
    fit_rows,
    is_hopeless,
    linear_step,
    with_bias,
)
from hefting.ingest.rivals.explanation import (
    OFFSET_STEP,
    Explanation,
    fit_as_given,
    newton_euler,
)

CLOCK_RATE = "clock-rate"
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
KEPT_RATES = 6
"""Number of likeliest pairs of a rate and an offset that are compared in full."""
STEPS = 5


def explain_clock_rate(case: Case) -> Explanation | None:
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
    return Explanation(CLOCK_RATE, what, fix, fitted, 2, effect=abs(rate) / std)


def _times(case: Case, rate: Array | float, offset: Array | float) -> Array:
    """Times of the poses at the wrench's samples (..., K) [s], within those
    of the path: all samples count."""
    middle = 0.5 * (case.time[0] + case.time[-1])
    since = case.time - middle
    rates, offsets = np.asarray(rate)[..., None], np.asarray(offset)[..., None]
    times = middle + since * (1.0 + rates) - offsets
    return times.clip(case.path.first, case.path.last)


def _coarse(case: Case) -> tuple[float, float]:
    rates, offsets = (x.ravel() for x in np.meshgrid(RATES, OFFSETS, indexing="ij"))
    nth = -(-len(case.time) // FIRST_SAMPLES)
    thin, times = case.every(nth), _times(case, rates, offsets)[:, ::nth]
    rows = newton_euler(thin, thin.motion_at(times))
    quick = fit_rows(thin, rows, FIRST_ITERATIONS).likelihood
    kept = np.argsort(quick)[-KEPT_RATES:]
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


FILTERED = "wrench-filtered"
BANDWIDTHS = (0.3, 0.5, 0.7, 1.0, 1.4, 2.0, 2.8, 4.0, 5.6, 8.0, 11.0, 16.0)
ORDERS = (1, 2)
RATE = 50.0
"""[Hz] Rate at which the motion is filtered: far above the cut-off frequencies."""
KEPT_FILTERS = 8
"""Number of likeliest filters that are compared in full."""
MOST_INSTANTS = 6000


def explain_filter(case: Case) -> Explanation | None:
    """The likeliest bandwidth."""
    if not case.path.moves:
        return None
    names, rows = _filtered_rows(case)
    if rows is None:
        return None
    given, _ = fit_as_given(case)
    quick = fit_rows(case, rows, FIRST_ITERATIONS)
    if is_hopeless(case, quick, given):
        return None
    kept = np.argsort(quick.likelihood)[-KEPT_FILTERS:]
    fitted = fit_rows(case, rows.part(kept))
    _, bandwidth = names[kept[fitted.best]]
    what = (
        f"the wrench seems to be low-pass filtered at some {bandwidth:.2g} Hz, which "
        "weakens and delays what the motion needs"
    )
    fix = "record it unfiltered, or move slower"
    return Explanation(FILTERED, what, fix, fitted, 1, of_many_laws=True)


def as_filtered(case: Case) -> Case | None:
    """The case with its motion filtered by the wrench's lag; None if it is too long for
    that."""
    lag, path = case.offset, case.path
    step = max(0.1 * lag, 5e-5 * (path.last - path.first))
    grid = np.arange(path.first, path.last, step)
    value = filtered(grid, path.read(grid, False)[0], lag)
    return None if value is None else replace(case, path=path.felt(grid, value))


def _filtered_rows(case: Case) -> tuple[list[tuple[int, float]], Rows | None]:
    """Orders and bandwidths, and the rows of each; None if the motion is filtered at
    too low a rate."""
    first = case.time[0] - 1.0 / RATE
    count = int(np.clip((case.time[-1] - first) * RATE, 8, MOST_INSTANTS)) + 2
    grid = np.linspace(first, case.time[-1] + 1.0 / RATE, count)
    rate = (count - 1) / (grid[-1] - grid[0])
    motion = case.motion_at(grid[None])
    features = Signal(case.features(motion)[0], rate)
    names: list[tuple[int, float]] = []
    known: list[Array] = []
    for order in ORDERS:
        for bandwidth in BANDWIDTHS:
            if bandwidth > 0.4 * rate:
                continue
            smooth = low_passed(features, order, bandwidth)
            # a clock offset is possible besides: what the filter's own delay leaves
            offsets = np.zeros(1)
            if abs(case.offset) > 1e-4:
                own = order**0.5 / (2.0 * np.pi * bandwidth)
                offsets = np.array((0.0, case.offset - own))
            # the wrench's samples among the instants, and how far each is from the one
            # before
            places = (case.time - offsets[:, None] - grid[0]) * rate
            before = np.clip(places.astype(int), 0, count - 2)
            beyond = np.clip(places - before, 0.0, 1.0)[:, :, None]
            names += [(order, bandwidth)] * len(offsets)
            known.append(smooth[before] * (1.0 - beyond) + smooth[before + 1] * beyond)
    if not known:
        return names, None
    used = np.interp(case.time, grid, motion.known[0].astype(float)) > 0.99
    used = np.broadcast_to(used, (len(names), len(case.time)))
    return names, with_bias(case, np.concatenate(known), REGRESSOR_BY_FEATURE, used)


def low_passed(signal: Signal, order: int, bandwidth: float) -> Array:
    """A signal (K, n) through a Butterworth filter of first or second order."""
    w = 2.0 * np.pi * bandwidth

    def response(s: Complex) -> Complex:
        bend = 2.0**0.5 * s / w + np.square(s / w) if order == 2 else s / w
        return 1.0 / (1.0 + bend)

    return signal.values[0] + signal.change_through(response, 2.0**0.5 / w)
