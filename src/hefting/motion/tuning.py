"""Tuning: the smoothness of a signal that has the largest likelihood, and the normal
equations of its spline."""

import numpy as np

from hefting.core.errors import InputError
from hefting.motion.bspline import (
    FEWEST_SEGMENT_SAMPLES,
    SUPPORT,
    Knots,
    Mask,
    Normal,
    Observation,
)
from hefting.motion.likelihood import Likelihood, Smoothness

ORDERS = (3, 4, 5)
"""Orders of smoothness that are compared: 5 suits smooth motion, 3 stop-and-go
motion."""
FIRST_KNOT_SPACING = 0.02
"""[s] Knot spacing h at the start of the search. It then follows the bandwidth wc, so
that 0.3 < h wc < 1."""
SMALLEST_SCALED_BANDWIDTH = 0.15
"""Lower bound of h wc in the search."""
LARGEST_SCALED_BANDWIDTH = 2.5
"""Upper bound of h wc in the search."""
TUNED_COEFFICIENTS = 10_000
"""Number of spline coefficients used to choose the smoothness; for longer recordings it
is chosen from evenly spaced stretches."""


def tune(
    data: tuple[Observation, ...],
    orders: tuple[int, ...],
    name: str,
    near: Smoothness | None = None,
) -> tuple[Smoothness, float, float, Normal | None]:
    """The most likely smoothness of a signal, its knot spacing [s], the sampling
    interval [s], and the normal equations of all data, if the search has built them.

    Parameters
    ----------
    data : tuple of Observation
        Samples of the signal, then of its derivatives, if any.
    orders : tuple of int
        Orders of smoothness to compare.
    name : str
        What the signal is, for error messages.
    near : Smoothness, optional
        An approximate smoothness: its order is kept, and the bandwidth searched near
        its own.

    Raises
    ------
    InputError
        If there are too few samples.
    """
    time = data[0].time
    if len(time) < FEWEST_SEGMENT_SAMPLES:
        raise InputError(
            f"{len(time)} different poses are too few to differentiate",
            where=name,
            fix="record longer",
        )
    dt = data[0].interval
    duration = time[-1] - time[0]
    coarsest = max(duration / 6.0, dt)
    finest = min(o.interval for o in data)
    h = min(max(FIRST_KNOT_SPACING, dt), coarsest)
    excess = duration / h / TUNED_COEFFICIENTS
    if excess > 1:
        stretch = duration / excess / 10
        data = tuple(
            o[((o.time - time[0]) // stretch).astype(int) % int(np.ceil(excess)) == 0]
            for o in data
        )
    floor = variance_floor(data)
    if near is not None:
        orders, h = (near.order,), _knot_spacing(data, near)
    middle = orders[len(orders) // 2]
    normal, dt = normal_equations(data, h), sampling_interval(data[0], h)
    found = _most_likely_smoothness(normal, middle, dt, floor, near)
    for _ in range(3):
        wanted = float(np.clip(0.6 / found.bandwidth, finest, coarsest))
        if 0.3 <= h * found.bandwidth <= 1.0 or np.isclose(wanted, h):
            break
        h = wanted
        normal, dt = normal_equations(data, h), sampling_interval(data[0], h)
        found = _most_likely_smoothness(normal, middle, dt, floor, found)
    best = found
    for m in orders:
        if m != middle:
            needed = best.log_likelihood
            other = _most_likely_smoothness(normal, m, dt, floor, found, needed)
            best = max(best, other, key=lambda c: c.log_likelihood)
    return best, h, dt, normal if excess <= 1 else None


def variance_floor(data: tuple[Observation, ...]) -> float:
    """Smallest variance of a sample of the signal: that of rounding."""
    return (1e-12 * max(float(np.abs(data[0].values).max()), 1e-3)) ** 2


def _knot_spacing(data: tuple[Observation, ...], smoothness: Smoothness) -> float:
    """Knot spacing [s] for a smoothness: 0.6/bandwidth, within the limits that the
    sampling intervals and the duration set."""
    duration, dt = float(np.ptp(data[0].time)), data[0].interval
    finest = min(o.interval for o in data)
    return float(np.clip(0.6 / smoothness.bandwidth, finest, max(duration / 6.0, dt)))


def _most_likely_smoothness(
    normal: Normal,
    m: int,
    dt: float,
    floor: float,
    near: Smoothness | None,
    needed: float = -np.inf,
) -> Smoothness:
    """The most likely smoothness of order `m`; `near` may have another order. It is not
    refined where the log likelihood `needed` is far off."""
    h, bounds = normal.knots.h, (SMALLEST_SCALED_BANDWIDTH, LARGEST_SCALED_BANDWIDTH)
    guess = None if near is None else float(np.clip(h * near.bandwidth, *bounds))
    for scaled in (LARGEST_SCALED_BANDWIDTH, 0.6) if guess is None else (guess,):
        trial = Smoothness(m, scaled / h, 0.0, 0.0)
        normal.refine_pilot(m, trial.penalty(normal, dt))
    return Likelihood(normal, m, dt, 3, floor).maximum(*bounds, guess, needed)


def _is_gap(samples: Observation, h: float) -> Mask:
    """Mask (K - 1,) of the intervals between samples that separate two segments."""
    return np.diff(samples.time) > max(10.0 * h, 20.0 * samples.interval, 0.1)


def sampling_interval(samples: Observation, h: float) -> float:
    """Mean sampling interval outside gaps."""
    return float(np.mean(np.diff(samples.time)[~_is_gap(samples, h)]))


def normal_equations(
    data: tuple[Observation, ...],
    h: float,
    end: float = -np.inf,
    spacing: float | None = None,
) -> Normal:
    """Normal equations with knots at spacing `h` [s], or at another `spacing` [s]
    between the same gaps.

    The last segment extends to `end` [s], where the samples after its last one are
    repeats of that.
    """
    time = data[0].time
    cuts = np.flatnonzero(_is_gap(data[0], h)) + 1
    begin, stop = np.concatenate(([0], cuts)), np.concatenate((cuts, [len(time)]))
    apart = np.concatenate(([True], np.diff(np.floor((time - time[0]) / (h / 2))) > 0))
    long_enough = (stop - begin >= FEWEST_SEGMENT_SAMPLES) & (
        np.add.reduceat(apart.astype(int), begin) > SUPPORT
    )
    if not long_enough.any():
        raise InputError(
            f"gaps leave no {FEWEST_SEGMENT_SAMPLES} poses in a row",
            where="poses",
            fix="record more often",
        )
    last = time[stop[long_enough] - 1]
    if long_enough[-1]:
        last[-1] = max(last[-1], end)
    spacing = h if spacing is None else spacing
    knots = Knots(spacing, time[begin[long_enough]], last)
    return Normal(knots, data, block=spacing / 2)
