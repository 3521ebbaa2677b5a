"""A signal as a smooth curve: the penalised quintic spline of most likely bandwidth,
noise and order."""

from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np

from hefting.core.spatial import (
    Array,
    Indices,
    Mask,
    changed_rows,
    lengths,
    median,
    quantile,
)
from hefting.motion.bspline import (
    SUPPORT,
    TIMES_EVALUATED_TOGETHER,
    Integers,
    Knots,
    Observation,
    basis,
)
from hefting.motion.local import (
    LOCAL_KNOT_SPACING,
    LocalSmoothness,
    fit_locally,
    inverse_bands,
    is_white,
)
from hefting.motion.tuning import (
    ORDERS,
    Smoothness,
    normal_equations,
    sampling_interval,
    tune,
    variance_floor,
)

CHECKED_STRETCH, CHECKED_STRETCHES = 100, 50
"""Number of samples in a stretch, and of stretches, of a long recording that show
whether the noise is white, and whether values were interpolated."""
SMOOTHER_THAN_MODEL = 0.72
"""Factor on the variance due to smoothing if the highest order is the most likely one,
as the motion is then smoother than the model. Smoothing makes (2k + 1)/(2m) of the
variance of the k-th derivative. Measured on random smooth motion of 0.5 to 1.8 rad/s at
100 and 500 Hz, where the accelerations' errors were 0.71 to 0.83 of the model's
standard deviations."""


UNRESOLVED = 0.5
"""Deviation of the second derivative by motion between the samples, over the sixth
difference of the coefficients: six times an acceleration that lasts for one sample, a
hundredth of one of 1 Hz at 20 Hz."""
FEW_SAMPLES = 1.0
"""Bandwidth times sampling interval up to which the samples resolve the signal."""
STRAIGHT = 0.05
"""Bend relative to the largest ones up to which a signal counts as straight."""
BRIEF = 20.0
"""Mean square of the rows' squared differences over their squared mean, above which one
penalty suits no part of a signal: 5/3 if it lasts all the time, 20 for a twelfth of it."""
LARGE_BEND = 0.995
"""Quantile of the bends that counts as a large one: a few spikes are larger."""
FEWEST_ROWS = 30
"""Least number of rows that show at which of them a stream was interpolated."""
AS_USUAL = 0.6
"""Least share of the distances between new rows that are the median one: values of a
slower stream come at a fixed rate, but for some that are late or lost."""


def fresh_rows(time: Array, values: Array) -> Mask:
    """Mask (K,) of the rows with new values; False for repeats of a slower stream, and
    for rows interpolated linearly between its values.

    Equal rows count as repeats only if the median run of equal rows is at least two
    rows long. Runs longer than twice the median occur at rest: of these, one row in
    twice the median is kept, and at least one per 0.1 s.
    """
    changed = _changed_lines(time, values)
    begins = np.flatnonzero(changed)
    usual = int(median(np.diff(np.append(begins, len(values)))))
    at_most = int(0.1 / median(np.diff(time))) + 1
    stride = min(2 * usual, at_most) if usual > 1 else 1
    age = np.arange(len(values)) - begins[np.cumsum(changed) - 1]
    return age % stride == 0


def _changed_lines(time: Array, values: Array) -> Mask:
    """Mask (K,) of the new rows of a stream that was interpolated linearly: those at
    which it bends, which are evenly apart, alone or in pairs."""
    changed = changed_rows(values)
    if len(time) < FEWEST_ROWS:
        return changed
    if len(time) > CHECKED_STRETCH * CHECKED_STRETCHES:
        rows = _stretches(len(time))
        size, speed = _bends(time[rows], values[rows])
        if median(size.ravel()) >= STRAIGHT * median(speed.ravel()):
            return changed
    size, speed = _bends(time, values)
    bent = np.pad(size > STRAIGHT * quantile(size, LARGE_BEND), 1)
    begins = bent & ~np.roll(bent, 1)
    gaps = np.diff(np.flatnonzero(begins))
    usual = median(gaps) if len(gaps) else 0.0
    if usual < 2.0:
        return changed
    # values may lie between rows: two rows bend, and distances are one row off
    slack = usual > 3.0
    is_even = np.mean(np.abs(gaps - usual) <= slack) >= AS_USUAL
    single_or_pairs = bent.sum() <= (1.1 + slack) * begins.sum()
    is_straight = median(size) < STRAIGHT * median(speed)
    if not (is_even and single_or_pairs and is_straight):
        return changed
    begins[0] = True
    return begins


def _stretches(count: int) -> Indices:
    """(CHECKED_STRETCHES, CHECKED_STRETCH) indices of evenly spaced stretches of
    `count` samples."""
    starts = np.linspace(0, count - CHECKED_STRETCH, CHECKED_STRETCHES).astype(int)
    return starts[:, None] + np.arange(CHECKED_STRETCH)


def _bends(time: Array, values: Array) -> tuple[Array, Array]:
    """Sizes (..., K - 2) of the changes of the slope between values (..., K, d) at
    times (..., K), and sizes (..., K - 1) of the slope."""
    slope = np.diff(values, axis=-2) / np.diff(time)[..., None]
    bend = np.diff(slope, axis=-2)
    if values.shape[-1] == 4:  # a steady turn is an arc
        q = values[..., 1:-1, :]
        bend -= np.sum(bend * q, axis=-1)[..., None] * q
    return lengths(bend), lengths(slope)


@dataclass(frozen=True)
class Curve:
    """One smoothed signal of d components."""

    knots: Knots
    coefficients: Array
    """(n, d)"""
    smoothness: Smoothness
    observations: tuple[Observation, ...]
    """Samples it was fitted to: the signal, then its measured derivatives."""
    factor: Array = field(repr=False)
    """(6, n): lower Cholesky bands of the normal equations"""
    local: LocalSmoothness | None = field(default=None, repr=False)
    """The penalty as it varies along the curve; None if it is constant."""

    @classmethod
    def fit(cls, time: Array, values: Array, name: str) -> "Curve":
        """Fit the curve to samples (K, d) of a signal at times (K,) [s] that increase;
        `name` is that of the signal in error messages."""
        kept = fresh_rows(time, values)
        samples = Observation(time, values)
        return cls.through((samples if kept.all() else samples[kept],), name, time[-1])

    @classmethod
    def through(
        cls,
        data: tuple[Observation, ...],
        name: str,
        end: float,
        near: Smoothness | None = None,
    ) -> "Curve":
        """Fit the curve to samples of a signal, none of them a repeat of the one
        before, and of its derivatives.

        Parameters
        ----------
        data : the samples, then measured derivatives.
        name : name of the signal in error messages.
        end : [s] time up to which the last value holds.
        near : an approximate smoothness, as that of a fit without the derivatives; only
            its neighbourhood is searched.
        """
        smoothness, h, dt, normal = tune(data, ORDERS, name, near)
        if normal is None or end > data[0].time[-1]:
            normal = normal_equations(data, h, end)
            normal.refine_pilot(smoothness.order, smoothness.penalty(normal, dt))
        penalty = smoothness.penalty(normal, dt)
        coefficients, factor = normal.solve(smoothness.order, penalty)
        curve = cls(normal.knots, coefficients, smoothness, data, factor)
        varies = smoothness.order == min(ORDERS) or curve._is_brief()
        if varies and is_white(curve._residual()):
            return cls._fit_locally(data, smoothness, h, end) or curve
        return curve

    def _is_brief(self) -> bool:
        """Whether the signal changes in a small part of the time only."""
        rows = self.knots.differences(self.coefficients, self.smoothness.order)
        square = np.sum(rows**2, axis=0)
        return bool(np.mean(square**2) > BRIEF * np.mean(square) ** 2)

    def _residual(self) -> Array:
        """(K, d) residuals of samples of the signal inside a segment; for a long
        recording in evenly spaced stretches."""
        time, values = self.observations[0].time, self.observations[0].values
        if len(time) > CHECKED_STRETCH * CHECKED_STRETCHES:
            chosen = _stretches(len(time)).ravel()
            time, values = time[chosen], values[chosen]
        residual = values - self.derivatives(time, (0,))[0].T
        return residual[np.isfinite(residual[:, 0])]

    @classmethod
    def _fit_locally(
        cls, data: tuple[Observation, ...], smoothness: Smoothness, h: float, end: float
    ) -> "Curve | None":
        """The curve with a penalty that varies along it, where that can be solved.

        `h` [s] is the knot spacing for the global smoothness, which also decides what
        is a gap; `end` [s] is that of the recording.
        """
        interval = data[0].interval
        spacing = max(LOCAL_KNOT_SPACING, interval)
        normal = normal_equations(data, h, end, spacing)
        dt = sampling_interval(data[0], h)
        found = fit_locally(normal, smoothness, dt, variance_floor(data))
        if found is None:
            return None
        smoothness = replace(smoothness, variance=found.variance)
        return cls(
            normal.knots, found.coefficients, smoothness, data, found.factor, found
        )

    @cached_property
    def covariance(self) -> Array:
        """(6, n) lower bands of the covariance of the coefficients, the same for each
        component."""
        slowest = self.smoothness.bandwidth
        if self.local is not None:
            slowest = min(slowest, quantile(self.local.bandwidth, 0.1))
        overlap = int(np.ceil(12.0 / min(self.knots.h * slowest, 1.0)))
        return self.smoothness.variance * inverse_bands(self.factor, overlap)

    def evaluate(self, at: Array, spread: bool = True) -> tuple[Array, ...]:
        """Value, first and second derivative (L, d) at times (L,) [s], the standard
        deviations (L,) of the two derivatives, and the standard deviation (L,) that
        jumps add to the second.

        Outside the segments the values are NaN and the deviations infinite. If `spread`
        is False the deviations, which take as long as the values, are zero inside.
        """
        values = self.derivatives(at, (0, 1, 2))
        without = np.where(np.isnan(values[0, 0]), np.inf, np.zeros((3, 1)))
        std = self.deviations(at) if spread else without
        return (*np.swapaxes(values, 1, 2), *std)

    def derivatives(self, at: Array, orders: tuple[int, ...]) -> Array:
        """(n, d, L) derivatives of n `orders` at times (L,) [s]; NaN outside the
        segments."""
        out = np.empty((len(orders), self.coefficients.shape[1], len(at)))
        for begin in range(0, len(at), TIMES_EVALUATED_TOGETHER):
            part = slice(begin, begin + TIMES_EVALUATED_TOGETHER)
            index, u, covered = self.knots.locate(at[part])
            neighbours = self._neighbours(index)
            rows = self._basis(u, orders)
            np.einsum("njl,djl->ndl", rows, neighbours, out=out[:, :, part])
            if not covered.all():
                out[:, :, part][:, :, ~covered] = np.nan
        return out

    def deviations(self, at: Array) -> Array:
        """(3, L) standard deviations of the first and the second derivative at times
        (L,) [s], and the one that jumps add to the second; infinite outside the
        segments."""
        index, u, covered = self.knots.locate(at)
        std = np.sqrt(self._variances(index, u, (1, 2)))
        std = np.vstack((std, self._jump_spread(index, u)))
        return np.where(covered, std, np.inf)

    def lasting_variance(self, at: Array) -> Array:
        """(L,) error variance of the second derivative at times (L,) [s], without that
        at jumps; infinite outside the segments."""
        index, u, covered = self.knots.locate(at)
        return np.where(covered, self._variances(index, u, (2,))[0], np.inf)

    def _basis(self, u: Array, orders: tuple[int, ...]) -> Array:
        """(n, 6, L) derivatives by time of n `orders` of the basis functions in effect,
        at places u (L,) in a knot interval."""
        return basis(u, orders) / self.knots.h ** np.array(orders)[:, None, None]

    def _neighbours(self, index: Integers) -> Array:
        """(d, 6, L) coefficients in effect, from the index (L,) of the first of
        them."""
        return self._columns.take(index + np.arange(SUPPORT)[:, None], axis=1)

    @cached_property
    def _columns(self) -> Array:
        return np.ascontiguousarray(self.coefficients.T)

    def _jump_spread(self, index: Integers, u: Array) -> Array:
        """(L,) standard deviation of the second derivative of a component by jumps;
        zero for a constant penalty."""
        if self.local is None:
            return np.zeros(len(index))
        third = np.einsum("njl,djl->dl", self._basis(u, (3,)), self._neighbours(index))
        jump_time = self.local.jump_time[index + SUPPORT // 2 - 1]
        return jump_time * np.sqrt(np.sum(third**2, axis=0) / 3.0)

    @cached_property
    def _unresolved(self) -> Array:
        """(n,) variance of the second derivative by motion between the samples."""
        found, h = np.zeros(self.knots.size), self.knots.h
        interval = min(each.interval for each in self.observations)
        if interval * self.smoothness.bandwidth > FEW_SAMPLES:
            rows = self.knots.rows_of_differences(SUPPORT)
            rough = self.knots.differences(self.coefficients, SUPPORT) / h**2
            found[rows + SUPPORT // 2] = np.mean((UNRESOLVED * rough) ** 2, axis=0)
        return found

    def _variances(self, index: Integers, u: Array, orders: tuple[int, ...]) -> Array:
        """(n, L) variances of the derivatives of n orders."""
        variances = np.zeros((len(orders), len(index)))
        rows = self._basis(u, orders)
        for band, covariance in enumerate(self.covariance):
            first = index + np.arange(SUPPORT - band)[:, None]
            part = np.einsum(
                "jl,njl,njl->nl",
                covariance.take(first),
                rows[:, : SUPPORT - band],
                rows[:, band:],
            )
            variances += 2.0 * part if band else part
        if self.local is None and self.smoothness.order == max(ORDERS):
            for k, variance in zip(orders, variances, strict=True):
                variance *= 1.0 - SMOOTHER_THAN_MODEL * (2 * k + 1) / (2 * max(ORDERS))
        variances[-1] += self._unresolved[index + SUPPORT // 2 - 1]
        return np.maximum(variances, 0.0)
