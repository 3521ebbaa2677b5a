"""The wrench was low-pass filtered: its fast part is weaker and late."""

from dataclasses import replace

import numpy as np

from hefting.core.spatial import Array
from hefting.ingest.filtering import Complex, Signal, filtered
from hefting.ingest.model import REGRESSOR_BY_FEATURE
from hefting.ingest.rivals.case import Case
from hefting.ingest.rivals.evidence import (
    Rows,
    fit_rows,
    is_hopeless,
    with_bias,
)
from hefting.ingest.rivals.explanation import Explanation, fit_as_given

CODE = "wrench-filtered"
BANDWIDTHS = (0.3, 0.5, 0.7, 1.0, 1.4, 2.0, 2.8, 4.0, 5.6, 8.0, 11.0, 16.0)
"""[Hz] Cut-off frequencies that are tried."""
ORDERS = (1, 2)
"""Orders of the Butterworth filters that are tried."""
RATE = 50.0
"""[Hz] Rate at which the motion is filtered: far above the cut-off frequencies."""
FIRST_ITERATIONS = 2
"""Number of reweightings of the first comparison."""
KEPT = 8
"""Number of likeliest filters that are compared in full."""
MOST_INSTANTS = 6000
"""Largest number of instants of the filtered motion."""


def explain(case: Case) -> Explanation | None:
    """The likeliest bandwidth."""
    if not case.path.moves:
        return None
    names, rows = _rows(case)
    if rows is None:
        return None
    given, _ = fit_as_given(case)
    quick = fit_rows(case, rows, FIRST_ITERATIONS)
    if is_hopeless(case, quick, given):
        return None
    kept = np.argsort(quick.likelihood)[-KEPT:]
    fitted = fit_rows(case, rows.part(kept))
    _, bandwidth = names[kept[fitted.best]]
    what = (
        f"the wrench seems to be low-pass filtered at some {bandwidth:.2g} Hz, which "
        "weakens and delays what the motion needs"
    )
    fix = "record it unfiltered, or move slower"
    return Explanation(CODE, what, fix, fitted, 1, of_many_laws=True)


def as_filtered(case: Case) -> Case | None:
    """The case with its motion filtered by the wrench's lag; None if it is too long for
    that."""
    lag, path = case.offset, case.path
    step = max(0.1 * lag, 5e-5 * (path.last - path.first))
    grid = np.arange(path.first, path.last, step)
    value = filtered(grid, path.read(grid, False)[0], lag)
    return None if value is None else replace(case, path=path.felt(grid, value))


def _rows(case: Case) -> tuple[list[tuple[int, float]], Rows | None]:
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
