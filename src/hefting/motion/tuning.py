"""Tuning: the bandwidth, order and noise of a signal's spline (`hefting.motion.bspline`)
that have the largest restricted likelihood, and the spline's normal equations."""

from dataclasses import dataclass

import numpy as np

from hefting.core.errors import InputError
from hefting.motion.bspline import (
    FEWEST_SEGMENT_SAMPLES,
    SUPPORT,
    Knots,
    Mask,
    Normal,
    Observation,
    multiply,
)

COARSE_STEPS = 8
"""Number of intervals of the coarse scan over ln(h wc). For h wc between 0.15 and 2.5
each is a factor of 1.4."""
NEGLIGIBLE_BANDWIDTH_CHANGE = 0.01
"""Change of ln(h wc) at which the search ends. The likelihood is flat at its
maximum."""
MOST_REFINEMENTS = 12
"""Largest number of evaluations after the coarse scan."""
HOPELESS = 2.0
"""Difference of the log likelihood from the needed one, over the range of the first
values, above which an order is given up, as the slope decreases uphill."""


@dataclass(frozen=True)
class Smoothness:
    """Hyperparameters of a smoothing spline, and how likely they are."""

    order: int
    """m: white noise drives the m-th derivative"""
    bandwidth: float
    """wc, rad/s: above it signal is weaker than noise"""
    variance: float
    """r², of one sample of one component"""
    log_likelihood: float
    """restricted, comparable between orders"""

    def penalty(self, normal: Normal, dt: float) -> float:
        """lambda for samples dt apart."""
        h, w = normal.knots.h, self.bandwidth
        return h / dt * (h * w) ** (-2 * self.order) * normal.lift(w, dt)


class Likelihood:
    """Restricted likelihood of the bandwidth for one order m, with r² at its maximum.

    d independent components share lambda and r² (a unit quaternion's four have three
    degrees of freedom). The polynomials of degree below m, which the model leaves free,
    have a normal prior with the variance that is found: without this penalty a higher
    order is always preferred on short recordings.
    """

    def __init__(self, normal: Normal, m: int, dt: float, d: int, floor: float):
        self.normal, self.order, self.dt, self.d, self.floor = normal, m, dt, d, floor
        self.degrees = normal.averages - m * len(normal.knots.first)
        self.rank = normal.knots.size - m * len(normal.knots.first)
        self.log_det = normal.knots.log_penalty_determinant(m)
        self.free_score = 0.0
        for start, stop in normal.knots.spans:
            places = np.linspace(-1, 1, stop - start)
            free = np.vander(places, m, increasing=True)
            own = np.linalg.cholesky(free.T @ free)
            root = np.linalg.cholesky(
                free.T @ multiply(normal.bands[:, start:stop], free)
            )
            self.log_det += 2.0 * float(np.sum(np.log(np.diag(root) / np.diag(own))))
            # along orthonormal polynomials
            effects = np.linalg.solve(root, free.T @ normal.right[start:stop])
            scale = np.maximum(np.sum(effects**2, axis=1) / d, floor)
            self.free_score -= 0.5 * d * float(np.sum(np.log(scale) + 1.0))

    def at(self, log_h_bandwidth: float) -> Smoothness:
        """Likelihood at ln(h wc)."""
        h = self.normal.knots.h
        trial = Smoothness(self.order, np.exp(log_h_bandwidth) / h, np.nan, np.nan)
        penalty = trial.penalty(self.normal, self.dt)
        square, factor = self.normal.minimum(self.order, penalty)
        variance = max(square / (self.d * self.degrees), self.floor)
        log_det = (
            2.0 * float(np.sum(np.log(factor[0])))
            - self.rank * np.log(penalty)
            - self.log_det
        )
        score = (
            -0.5 * self.d * (self.degrees * (np.log(variance) + 1.0) + log_det)
            + self.free_score
        )
        return Smoothness(self.order, trial.bandwidth, variance, score)

    def maximum(
        self,
        lowest: float,
        highest: float,
        near: float | None = None,
        needed: float = -np.inf,
    ) -> Smoothness:
        """The most likely bandwidth, with h wc between two bounds.

        A coarse scan, or with `near`, an approximate h wc, only uphill from there; then
        parabolas through the three best, until the step is below
        `NEGLIGIBLE_BANDWIDTH_CHANGE`. The search is given up if the log likelihood
        `needed` is far off.
        """
        low, high = float(np.log(lowest)), float(np.log(highest))
        step = (high - low) / COARSE_STEPS
        tried: dict[float, Smoothness] = {}
        if near is None:
            for x in np.linspace(low, high, COARSE_STEPS + 1).tolist():
                tried[x] = self.at(x)
        else:
            middle = float(np.clip(np.log(near), low, high))
            for x in (middle - 0.5 * step, middle, middle + 0.5 * step):
                inside = float(np.clip(x, low, high))
                tried[inside] = self.at(inside)
        scores = [found.log_likelihood for found in tried.values()]
        refinements = MOST_REFINEMENTS
        if needed - max(scores) > HOPELESS * (max(scores) - min(scores)):
            refinements = 0
        for _ in range(refinements):
            x = _next(tried, low, high, step)
            if min(abs(x - other) for other in tried) < NEGLIGIBLE_BANDWIDTH_CHANGE:
                break
            tried[x] = self.at(x)
        return max(tried.values(), key=lambda found: found.log_likelihood)


def _next(
    tried: dict[float, Smoothness], low: float, high: float, step: float
) -> float:
    """Next place to try, from the best one and its neighbours."""
    at = sorted(tried)
    scores = [tried[x].log_likelihood for x in at]
    k = int(np.argmax(scores))
    if k == 0:
        return max(at[0] - step, low)
    if k == len(at) - 1:
        return min(at[-1] + step, high)
    (a, b, c), (fa, fb, fc) = at[k - 1 : k + 2], scores[k - 1 : k + 2]
    left, right = (b - a) * (fb - fc), (b - c) * (fb - fa)
    vertex = b
    if left != right:
        vertex = b - 0.5 * ((b - a) * left - (b - c) * right) / (left - right)
    return float(np.clip(vertex, 0.5 * (a + b), 0.5 * (b + c)))


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
"""Number of spline coefficients from which the smoothness is chosen; longer recordings
are represented by evenly spaced stretches."""


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
        Orders of smoothness that are compared, in the middle the one to begin with.
    name : str
        Name of the signal in errors.
    near : Smoothness or None
        An approximate smoothness, whose order is kept and near whose bandwidth the
        bandwidth is searched.

    Raises
    ------
    InputError
        If there are too few samples, or these are too far apart.
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

    def spacing(smoothness: Smoothness) -> float:
        return float(np.clip(0.6 / smoothness.bandwidth, finest, coarsest))

    excess = duration / h / TUNED_COEFFICIENTS
    if excess > 1:
        data = _spaced_stretches(data, duration, excess)
        if len(data[0].time) < FEWEST_SEGMENT_SAMPLES:
            raise InputError(
                f"{len(time)} poses in {duration:.3g} s are too far apart to differentiate",
                where=name,
                fix="check their times",
            )
    floor = variance_floor(data)
    if near is not None:
        orders, h = (near.order,), spacing(near)
    middle = orders[len(orders) // 2]
    normal, dt = normal_equations(data, h), sampling_interval(data[0], h)
    found = _most_likely_smoothness(normal, middle, dt, floor, near)
    for _ in range(3):
        wanted = spacing(found)
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


def _spaced_stretches(
    data: tuple[Observation, ...], duration: float, excess: float
) -> tuple[Observation, ...]:
    """Evenly spaced stretches of signals of a `duration` [s] that is `excess` times what
    is tuned at once: the first of each ⌈excess⌉ stretches, of which there are about ten
    times `excess`."""
    begin = data[0].time[0]
    stretch = duration / excess / 10
    each = int(np.ceil(excess))
    return tuple(o[((o.time - begin) // stretch).astype(int) % each == 0] for o in data)


def variance_floor(data: tuple[Observation, ...]) -> float:
    """Smallest variance of a sample of the signal, by rounding."""
    return (1e-12 * max(float(np.abs(data[0].values).max()), 1e-3)) ** 2


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
    """Mask (K - 1,) of the intervals between samples that separate segments."""
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
