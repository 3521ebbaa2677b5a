"""Drift of a bias: constant, linear, or piecewise linear between knots."""

from collections.abc import Iterator
from itertools import pairwise

import numpy as np

from hefting.core.spatial import Array, Indices, freeze, immutable, interpolated

SHORTEST_DRIFTING_RECORDING = 7.9
"""[s] In shorter recordings the bias counts as constant, as a drift is not
distinguished from model errors. Samples of 8 s, and their averages, span a little less.
"""
CLOSEST_KNOTS = 12.0
"""[s] Smallest distance between knots of a drifting bias. With closer knots the bias
would fit the object's wrench."""
MOST_KNOTS = 81
"""Largest number of knots of a drifting bias; to bound the normal equations."""
DRIFT_KINDS = ("constant", "linear", "random walk")
"""Names of a bias with one, two, and three or more knots."""


@immutable
class Drift:
    """A sensor's bias as a function of time: linear between knots, constant before the
    first and after the last."""

    knots: Array
    """(n,) [s]; one for a constant bias, two for a linear drift"""
    values: Array
    """(n, 6) bias at the knots, as recorded [N, N m]"""
    std: Array
    """(n, 6) standard deviations; infinite if the motion does not separate the bias
    from the object"""
    mean: Array
    """(6,) average over the samples that were kept"""
    rise: Array | None = None
    """(6, 6) covariance of the last value less the first of a linear drift [N², N² m,
    N² m²]; None if it is not linear or undetermined"""

    def __post_init__(self):
        freeze(self, "knots", "values", "std", "mean", "rise")

    @property
    def kind(self) -> str:
        """``"constant"``, ``"linear"`` or ``"random walk"``."""
        return DRIFT_KINDS[min(len(self.knots), 3) - 1]

    @property
    def range(self) -> Array:
        """(6,) largest less smallest value of each component [N, N m]."""
        return np.ptp(self.values, axis=0)

    def __call__(self, time: Array) -> Array:
        """Bias (K, 6) at times (K,) [s]."""
        return interpolated(time, self.knots, self.values)

    def change(self, time: Array) -> Array:
        """Bias (K, 6) at times (K,) [s] less its mean."""
        return self(time) - self.mean


def candidates(duration: float, closest: float) -> tuple[int, ...]:
    """Numbers of knots to compare, in increasing order, for a duration [s] and knots at
    least `closest` [s] apart."""
    if not duration >= SHORTEST_DRIFTING_RECORDING:
        return (1,)
    most = min(int(duration / max(closest, CLOSEST_KNOTS)) + 1, MOST_KNOTS)
    numbers = [1, 2]
    while numbers[-1] * 2 - 1 < most:
        numbers.append(numbers[-1] * 2 - 1)
    return tuple(numbers) if most <= numbers[-1] else (*numbers, most)


@immutable
class HatFunctions:
    """Piecewise-linear basis functions of a drift at sorted samples."""

    knots: Array
    """(n,) [s]"""
    functions: Array
    """(K, 1) or (K, 2) values at each sample of the functions not zero there"""
    bounds: Indices
    """(s + 1,) indices of the first sample of each interval between knots, and the
    number of samples"""

    @classmethod
    def over(cls, time: Array, n: int) -> "HatFunctions":
        """`n` knots evenly over the times (K,) [s]; one zero function for n = 0."""
        if n == 0:
            return cls(time[:1], np.zeros((len(time), 1)), np.array([0, len(time)]))
        if n == 1 or time[-1] <= time[0]:
            middle = np.array([0.5 * (time[0] + time[-1])])
            return cls(middle, np.ones((len(time), 1)), np.array([0, len(time)]))
        knots = np.linspace(time[0], time[-1], n)
        segment = np.clip(np.searchsorted(knots, time, side="right") - 1, 0, n - 2)
        s = (time - knots[segment]) / (knots[1] - knots[0])
        bounds = np.concatenate(
            ([0], np.searchsorted(segment, np.arange(1, n - 1)), [len(time)])
        )
        return cls(knots, np.column_stack((1.0 - s, s)), bounds)

    @property
    def n(self) -> int:
        """Number of functions."""
        return len(self.knots)

    @property
    def values(self) -> Array:
        """(K, n) values of all functions, zeros included."""
        return self.combine(np.eye(self.n))

    def part(self, rows: slice) -> "HatFunctions":
        """At consecutive samples."""
        start, stop, _ = rows.indices(len(self.functions))
        return HatFunctions(
            self.knots, self.functions[rows], np.clip(self.bounds, start, stop) - start
        )

    def combine(self, coefficients: Array) -> Array:
        """Sums (K, ...) of the functions with coefficients (n, ...)."""
        out = np.empty((len(self.functions), *coefficients.shape[1:]))
        flat, shape = out.reshape(len(out), -1), coefficients.reshape(self.n, -1)
        for i, piece in enumerate(self._intervals()):
            flat[piece] = self.functions[piece] @ shape[i : i + self.functions.shape[1]]
        return out

    def project(self, rows: Array) -> Array:
        """(n, d) inner products of the functions with the columns of `rows` (K, d)."""
        if self.n == 1:
            return self.functions.T @ rows
        products = np.zeros((self.n, rows.shape[1]))
        nonzero = self.functions.shape[1]
        # on the i-th interval only functions i and i + 1 are not zero
        for i, interval in enumerate(self._intervals()):
            products[i : i + nonzero] += self.functions[interval].T @ rows[interval]
        return products

    def gram(self, weights: Array) -> Array:
        """Weighted inner products (n, n) of the functions, weights (K,)."""
        out = np.zeros((self.n, self.n))
        width = self.functions.shape[1]
        for i, piece in enumerate(self._intervals()):
            f = self.functions[piece]
            out[i : i + width, i : i + width] += f.T @ (f * weights[piece, None])
        return out

    def _intervals(self) -> Iterator[slice]:
        return (slice(a, b) for a, b in pairwise(self.bounds))
