"""A signal as a smooth curve: the penalised quintic spline whose bandwidth, noise and
order have the largest likelihood."""

from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np

from hefting.core.errors import InputError
from hefting.core.spatial import Array
from hefting.motion.bspline import (
    FEWEST_SEGMENT_SAMPLES,
    SUPPORT,
    TIMES_EVALUATED_TOGETHER,
    Integers,
    Knots,
    Mask,
    Normal,
    Observation,
    basis,
    inverse_bands,
)
from hefting.motion.likelihood import Likelihood, Smoothness
from hefting.motion.local import (
    LOCAL_KNOT_SPACING,
    LocalSmoothness,
    fit_locally,
    is_white,
)

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
SMOOTHER_THAN_MODEL = 0.72
"""Share of the variance due to smoothing that is absent where the highest order is the
most likely one: the motion is then smoother than the model. Smoothing makes (2k +
1)/(2m) of the variance of the k-th derivative. Measured on random smooth motion of 0.5
to 1.8 rad/s at 100 and 500 Hz, where the accelerations' errors were 0.71 to 0.83 of the
model's standard deviations."""
TUNED_COEFFICIENTS = 10_000
"""Number of spline coefficients used to choose the smoothness; for longer recordings it
is chosen from evenly spaced stretches."""


def fresh_rows(time: Array, values: Array) -> Mask:
    """Mask (K,) of the rows with new values; False for repeats of a slower stream.

    Equal rows count as repeats only if the median run of equal rows is at least two
    rows long. Runs longer than twice the median occur at rest: of these, one row in
    twice the median is kept, and at least one per 0.1 s.
    """
    changed = np.concatenate(([True], (np.diff(values, axis=0) != 0).any(axis=1)))
    begins = np.flatnonzero(changed)
    usual = int(np.median(np.diff(np.append(begins, len(values)))))
    at_most = max(int(0.1 / np.median(np.diff(time))), 1)
    stride = min(2 * usual, at_most) if usual > 1 else 1
    age = np.arange(len(values)) - begins[np.cumsum(changed) - 1]
    return age % stride == 0


@dataclass(frozen=True)
class Curve:
    """One smoothed multi-component signal."""

    knots: Knots
    coefficients: Array
    """(n, d)"""
    smoothness: Smoothness
    observations: tuple[Observation, ...]
    """Samples it was fitted to: the signal, then its measured derivatives."""
    factor: Array = field(repr=False)
    """(6, n): lower Cholesky bands of the normal equations"""
    local: LocalSmoothness | None = field(default=None, repr=False)
    """The penalty as it varies along the curve; None where it is the same
    everywhere."""

    @classmethod
    def fit(
        cls,
        time: Array,
        values: Array,
        name: str,
        rates: tuple[Observation, ...] = (),
        near: Smoothness | None = None,
    ) -> "Curve":
        """Fit the curve to samples of a signal and, optionally, of its derivatives.

        Parameters
        ----------
        time : Array
            (K,) [s], increasing.
        values : Array
            (K, d).
        name : str
            What the signal is, for error messages.
        rates : tuple of Observation
            Measured derivatives.
        near : Smoothness, optional
            An approximate smoothness, as that of a fit without the derivatives; only
            its neighbourhood is searched.
        """
        end = time[-1]
        kept = fresh_rows(time, values)
        if not kept.all():
            time, values = time[kept], values[kept]
        data = (Observation(time, values), *rates)
        smoothness, h, dt, normal = _tune_with_equations(data, ORDERS, name, near)
        if normal is None or end > data[0].time[-1]:
            normal = _normal_equations(data, h, end)
            normal.refine_pilot(smoothness.order, smoothness.penalty(normal, dt))
        penalty = smoothness.penalty(normal, dt)
        coefficients, factor = normal.solve(smoothness.order, penalty)
        curve = cls(normal.knots, coefficients, smoothness, data, factor)
        if smoothness.order == min(ORDERS) and is_white(curve._residual()):
            return cls._fit_locally(data, smoothness, h, end) or curve
        return curve

    def _residual(self) -> Array:
        """(K, d) residuals of the samples of the signal, of those inside a segment."""
        samples = self.observations[0]
        index, u, covered = self.knots.locate(samples.time)
        neighbours = self.coefficients.T[:, index + np.arange(SUPPORT)[:, None]]
        fitted = np.einsum("jl,djl->ld", basis(u), neighbours)
        return (samples.values - fitted)[covered]

    @classmethod
    def _fit_locally(
        cls,
        data: tuple[Observation, ...],
        smoothness: Smoothness,
        h: float,
        end: float,
    ) -> "Curve | None":
        """The curve with a penalty that varies along it, where that can be solved.

        `h` [s] is the knot spacing for the global smoothness, which also decides what
        is a gap; `end` [s] is that of the recording.
        """
        interval = float(np.median(np.diff(data[0].time)))
        spacing = max(LOCAL_KNOT_SPACING, interval)
        normal = _normal_equations(data, h, end, spacing)
        dt = _sampling_interval(data[0].time, h)
        found = fit_locally(normal, smoothness, dt, _variance_floor(data))
        if found is None:
            return None
        smoothness = replace(smoothness, variance=found.variance)
        return cls(
            normal.knots, found.coefficients, smoothness, data, found.factor, found
        )

    @cached_property
    def covariance(self) -> Array:
        """(6, n): lower bands of the covariance of the coefficients of one component;
        it is the same for all components."""
        slowest = self.smoothness.bandwidth
        if self.local is not None:
            slowest = min(slowest, float(np.quantile(self.local.bandwidth, 0.1)))
        overlap = int(np.ceil(12.0 / min(self.knots.h * slowest, 1.0)))
        return self.smoothness.variance * inverse_bands(self.factor, overlap)

    def evaluate(self, at: Array, spread: bool = True) -> tuple[Array, ...]:
        """Value, first and second derivative (L, d) at times (L,) [s], the standard
        deviations (L,) of the two derivatives, and the standard deviation (L,) that
        jumps add to the second.

        Outside the segments the values are NaN and the deviations infinite. If `spread`
        is False the deviations, which take as long as the values, are zero inside.
        """
        out = np.empty((3, self.coefficients.shape[1], len(at)))
        std = np.zeros((3, len(at)))
        columns = np.ascontiguousarray(self.coefficients.T)
        for begin in range(0, len(at), TIMES_EVALUATED_TOGETHER):
            part = slice(begin, begin + TIMES_EVALUATED_TOGETHER)
            index, u, covered = self.knots.locate(at[part])
            neighbours = columns[:, index + np.arange(SUPPORT)[:, None]]
            rows = [basis(u, k) / self.knots.h**k for k in range(3)]
            for k in range(3):
                np.einsum("jl,djl->dl", rows[k], neighbours, out=out[k, :, part])
            out[:, :, part][:, :, ~covered] = np.nan
            if spread:
                std[:2, part] = np.sqrt(self._variances(index, rows))
                std[2, part] = self._jump_spread(index, u, neighbours)
            std[:, part][:, ~covered] = np.inf
        return (*np.swapaxes(out, 1, 2), *std)

    def _jump_spread(self, index: Integers, u: Array, neighbours: Array) -> Array:
        """(L,) standard deviation that jumps add to the second derivative of one
        component; zero where the penalty does not vary.

        `neighbours` (d, 6, L) are the coefficients in effect at each time.
        """
        if self.local is None:
            return np.zeros(len(index))
        rows = basis(u, 3) / self.knots.h**3
        third = np.einsum("jl,djl->dl", rows, neighbours)
        jump_time = self.local.jump_time[index + SUPPORT // 2 - 1]
        return jump_time * np.sqrt(np.sum(third**2, axis=0) / 3.0)

    def _variances(self, index: Integers, rows: list[Array]) -> Array:
        """(2, L) variances of the first and the second derivative.

        `rows` holds the basis functions (6, L) and their first two derivatives.
        """
        variances = np.zeros((2, len(index)))
        for a in range(SUPPORT):
            for b in range(a, SUPPORT):
                covariance = (1.0 if a == b else 2.0) * self.covariance[
                    b - a, index + a
                ]
                for k in (1, 2):
                    variances[k - 1] += covariance * rows[k][a] * rows[k][b]
        if self.local is None and self.smoothness.order == max(ORDERS):
            for k in (1, 2):
                variances[k - 1] *= 1.0 - SMOOTHER_THAN_MODEL * (2 * k + 1) / (
                    2 * max(ORDERS)
                )
        return np.maximum(variances, 0.0)


def tune(
    data: tuple[Observation, ...],
    orders: tuple[int, ...],
    name: str,
    near: Smoothness | None = None,
) -> tuple[Smoothness, float, float]:
    """The most likely smoothness of a signal, its knot spacing [s], and the sampling
    interval [s].

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
    return _tune_with_equations(data, orders, name, near)[:3]


def _variance_floor(data: tuple[Observation, ...]) -> float:
    """Smallest variance of a sample of the signal: that of rounding."""
    return (1e-12 * max(float(np.abs(data[0].values).max()), 1e-3)) ** 2


def _knot_spacing(data: tuple[Observation, ...], smoothness: Smoothness) -> float:
    """Knot spacing [s] for a smoothness: 0.6/bandwidth, within the limits that the
    sampling intervals and the duration set."""
    duration, dt = float(np.ptp(data[0].time)), float(np.median(np.diff(data[0].time)))
    finest = min(float(np.median(np.diff(o.time))) for o in data)
    return float(np.clip(0.6 / smoothness.bandwidth, finest, max(duration / 6.0, dt)))


def _tune_with_equations(
    data: tuple[Observation, ...],
    orders: tuple[int, ...],
    name: str,
    near: Smoothness | None,
) -> tuple[Smoothness, float, float, Normal | None]:
    """As `tune`; also the normal equations of all data, if the search has built
    them."""
    time = data[0].time
    if len(time) < FEWEST_SEGMENT_SAMPLES:
        raise InputError(
            f"{len(time)} different poses are too few to differentiate",
            where=name,
            fix="record longer",
        )
    dt = float(np.median(np.diff(time)))
    duration = time[-1] - time[0]
    coarsest = max(duration / 6.0, dt)
    finest = min(float(np.median(np.diff(o.time))) for o in data)
    h = min(max(FIRST_KNOT_SPACING, dt), coarsest)
    excess = duration / h / TUNED_COEFFICIENTS
    if excess > 1:
        stretch = duration / excess / 10
        data = tuple(
            o[((o.time - time[0]) // stretch).astype(int) % int(np.ceil(excess)) == 0]
            for o in data
        )
    whole = excess <= 1
    floor = _variance_floor(data)
    if near is not None:
        orders, h = (near.order,), _knot_spacing(data, near)
    middle = orders[len(orders) // 2]
    normal = _normal_equations(data, h)
    found = _most_likely_smoothness(
        normal, middle, _sampling_interval(data[0].time, h), floor, near
    )
    for _ in range(3):
        wanted = float(np.clip(0.6 / found.bandwidth, finest, coarsest))
        if 0.3 <= h * found.bandwidth <= 1.0 or np.isclose(wanted, h):
            break
        h = wanted
        normal = _normal_equations(data, h)
        found = _most_likely_smoothness(
            normal, middle, _sampling_interval(data[0].time, h), floor, found
        )
    dt = _sampling_interval(data[0].time, normal.knots.h)
    best = found
    for m in orders:
        if m != middle:
            best = max(
                best,
                _most_likely_smoothness(normal, m, dt, floor, found),
                key=lambda c: c.log_likelihood,
            )
    same = whole and np.isclose(normal.knots.h, h)
    return best, h, _sampling_interval(data[0].time, h), normal if same else None


def _most_likely_smoothness(
    normal: Normal, m: int, dt: float, floor: float, near: Smoothness | None
) -> Smoothness:
    """The most likely smoothness of order `m`; `near` may have another order."""
    h = normal.knots.h
    guesses = (
        (LARGEST_SCALED_BANDWIDTH, 0.6)
        if near is None
        else (
            float(
                np.clip(
                    h * near.bandwidth,
                    SMALLEST_SCALED_BANDWIDTH,
                    LARGEST_SCALED_BANDWIDTH,
                )
            ),
        )
    )
    for h_bandwidth in guesses:
        normal.refine_pilot(
            m, Smoothness(m, h_bandwidth / h, 0.0, 0.0).penalty(normal, dt)
        )
    return Likelihood(normal, m, dt, 3, floor).maximum(
        SMALLEST_SCALED_BANDWIDTH,
        LARGEST_SCALED_BANDWIDTH,
        None if near is None else guesses[0],
    )


def _is_gap(time: Array, h: float) -> Mask:
    """Mask (K - 1,) of the intervals between samples that separate two segments."""
    return np.diff(time) > max(10.0 * h, 20.0 * float(np.median(np.diff(time))), 0.1)


def _sampling_interval(time: Array, h: float) -> float:
    """Mean sampling interval outside gaps."""
    return float(np.mean(np.diff(time)[~_is_gap(time, h)]))


def _normal_equations(
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
    cuts = np.flatnonzero(_is_gap(time, h)) + 1
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
