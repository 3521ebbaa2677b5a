"""Bodies: a joint fit of several bodies, each in intervals of its own, beside one bias
that drifts smoothly and what is left of the clock offset.

The normal equations are composed of those of the intervals, so that another assignment
of bodies to intervals costs one small solution.

Screening finds, in closed form, whether one change may be hidden in a recording. The
gain of a second body from cell t on is the decrease of the sum of squares by ten more
columns. With cumulative sums it is found for all t at once, in about a hundredth of the
time of an identification.
"""

from dataclasses import replace
from functools import cached_property

import numpy as np

from hefting.core.spatial import Array, column_medians, immutable
from hefting.ingest.changes.cells import (
    LARGEST_BIAS,
    LARGEST_PARAMETERS,
    Cells,
    Interval,
)
from hefting.ingest.drift import CLOSEST_KNOTS

PARAMETERS = len(LARGEST_PARAMETERS)
FEWEST_DRIFT_FUNCTIONS = 4
"""Least number of polynomials of time that compose the drift of the bias while changes
are searched for: up to third degree. There is one more for each distance between knots
of the later drift."""
MOST_DRIFT_FUNCTIONS = 12
"""Largest number of these polynomials."""
LARGEST_LAG = 0.03
"""[s] Standard deviation of the clock offset that is left, as a fit of one body misses
that of several: about half the distance of `hefting.ingest.changes.find.OFFSETS`."""
LONGEST_CORRELATION = 20.0
"""[cells] Upper bound of the autocorrelation time."""

NEGLIGIBLE_DIRECTION = 1e-6
"""Singular value of the columns relative to the largest, below which a direction is
neglected."""


def drift_degrees(cells: Cells) -> int:
    """Number of polynomials of time for the bias of a recording."""
    lasts = float(cells.time[-1] - cells.time[0])
    number = FEWEST_DRIFT_FUNCTIONS + int(lasts / (2.0 * CLOSEST_KNOTS))
    return min(number, MOST_DRIFT_FUNCTIONS)


def bias_columns(cells: Cells, drift: int) -> Array:
    """(M, 6, 6 drift) whitened columns of a bias that is a polynomial of time with
    `drift` coefficients; none for 0."""
    time = cells.time - cells.time[0]
    span = max(float(time[-1]), 1e-12)
    if not drift:
        return np.zeros((len(time), 6, 0))
    T = np.polynomial.legendre.legvander(2.0 * time / span - 1.0, drift - 1)
    columns = np.zeros((len(time), 6, 6, drift))
    for c in range(6):
        columns[:, c, c] = T / cells.unit[c]
    return columns.reshape(len(time), 6, 6 * drift)


def ridge_of_shared(drift: int) -> Array:
    """(6 drift + 1,) inverse variances of the prior of the bias and of the lag."""
    return np.append(np.repeat(LARGEST_BIAS**-2.0, drift), LARGEST_LAG**-2.0)


def lag_column(cells: Cells, intervals: list[Interval]) -> Array:
    """(M, 6, 1) change [1/s] of the whitened wrench by a lag; zero outside the
    intervals, at whose ends the wrench may step."""
    column = np.zeros((len(cells), 6, 1))
    for begin, end in intervals:
        wrench, time = cells.whitened[begin:end], cells.time[begin:end]
        column[begin:end, :, 0] = -np.gradient(wrench, time, axis=0)
    return column


@immutable
class JointFit:
    """Least squares of n bodies and a bias in L intervals."""

    bodies: Array
    """(n, 10) parameters, with the sign of the recorded wrench"""
    covariance: Array
    """(10 n, 10 n) of the parameters, for white residuals of variance 1"""
    squares: Array
    """(L, 2) sum of the squared whitened residuals of force and torque in each
    interval"""
    equations: Array
    """(L,) degrees of freedom of the force, and as many of the torque"""
    combinations: tuple[Array | None, ...]
    """(L,) for each interval with a body the combination of the columns of
    `JointModel.rows` that is the residual"""

    @property
    def variance(self) -> Array:
        """(2,) of the residuals of force and torque."""
        return self.squares.sum(axis=0) / max(float(self.equations.sum()), 1.0)

    def difference(self, i: int, j: int) -> tuple[Array, Array]:
        """Parameters (10,) of body j less those of body i, and their covariance (10,
        10)."""
        p = PARAMETERS
        a, b = slice(i * p, i * p + p), slice(j * p, j * p + p)
        C = self.covariance
        return self.bodies[j] - self.bodies[i], C[a, a] + C[b, b] - C[a, b] - C[b, a]

    def increase(self, i: int, j: int) -> float:
        """Increase of the sum of squares if bodies i and j are merged."""
        apart, covariance = self.difference(i, j)
        return float(apart @ np.linalg.solve(covariance, apart))


class JointModel:
    """Normal equations of intervals of cells for any assignment of bodies to them."""

    def __init__(
        self, cells: Cells, intervals: list[Interval], drift: int | None = None
    ) -> None:
        self.intervals = intervals
        self.drift = drift_degrees(cells) if drift is None else drift
        self.rows = np.concatenate(
            (
                cells.regressor,
                bias_columns(cells, self.drift),
                lag_column(cells, intervals),
                cells.whitened[:, :, None],
            ),
            axis=2,
        )

    @cached_property
    def grams(self) -> Array:
        """(L, 2, q + 1, q + 1) of the rows of force and of torque."""
        grams = []
        for begin, end in self.intervals:
            rows = self.rows[begin:end].reshape(end - begin, 2, 3, -1)
            flat = np.swapaxes(rows, 0, 1).reshape(2, -1, rows.shape[-1])
            grams.append(np.swapaxes(flat, 1, 2) @ flat)
        return np.array(grams)

    @cached_property
    def lengths(self) -> Array:
        """(L,) cells of the intervals."""
        return np.array([end - begin for begin, end in self.intervals], dtype=float)

    def fit(self, labels: list[int]) -> JointFit:
        """Least squares with body `labels[i]` in interval i, which is left out for -1;
        the bodies are in the order of their labels."""
        names = sorted({label for label in labels if label >= 0})
        n, p = len(names), PARAMETERS
        ridge = ridge_of_shared(self.drift)
        shared = n * p + np.arange(len(ridge))
        places = [
            None
            if label < 0
            else np.append(names.index(label) * p + np.arange(p), shared)
            for label in labels
        ]
        prior = np.append(np.tile(LARGEST_PARAMETERS**-2.0, n), ridge)
        normal, right = np.diag(prior), np.zeros(len(prior))
        for gram, at in zip(self.grams, places, strict=True):
            if at is not None:
                both = gram.sum(axis=0)
                normal[np.ix_(at, at)] += both[:-1, :-1]
                right[at] += both[:-1, -1]
        inverse: Array = np.asarray(np.linalg.inv(normal), dtype=float)
        solution = inverse @ right
        squares, equations = np.zeros((len(labels), 2)), np.zeros(len(labels))
        combinations: list[Array | None] = []
        for i, (gram, at) in enumerate(zip(self.grams, places, strict=True)):
            x = None if at is None else np.append(-solution[at], 1.0)
            combinations.append(x)
            if x is not None:
                squares[i] = np.maximum(np.einsum("i,gij,j->g", x, gram, x), 0.0)
                both = gram.sum(axis=0)[:-1, :-1]
                spent = float(np.sum(inverse[np.ix_(at, at)] * both))  # type: ignore[arg-type]
                equations[i] = 3.0 * self.lengths[i] - 0.5 * spent
        own = slice(0, n * p)
        bodies = solution[own].reshape(n, p)
        return JointFit(
            bodies, inverse[own, own], squares, equations, tuple(combinations)
        )

    def residuals(self, fit: JointFit) -> Array:
        """(K, 6) whitened residuals of the cells of the intervals with a body."""
        parts = [
            self.rows[begin:end] @ x
            for (begin, end), x in zip(self.intervals, fit.combinations, strict=True)
            if x is not None
        ]
        return np.concatenate(parts)


def log_ratio(one: JointFit, other: JointFit) -> float:
    """Twice the log likelihood ratio of the `other` fit, with more bodies, to `one`,
    for white residuals, whose variance counts as that of the noise at least."""
    apart = np.log(np.maximum(one.variance, 1.0) / np.maximum(other.variance, 1.0))
    return float(other.equations.sum() * apart.sum())


def autocorrelation(residuals: Array) -> float:
    """Autocorrelation time [cells] of a first-order process with the correlation of the
    residuals (K, 6) from one cell to the next."""
    total = max(float(np.sum(residuals * residuals)), 1e-300)
    rho = float(np.sum(residuals[1:] * residuals[:-1])) / total
    if rho >= 1.0:
        return LONGEST_CORRELATION
    return float(np.clip((1.0 + rho) / (1.0 - rho), 1.0, LONGEST_CORRELATION))


def variance_of_any_linear_function(cells: Cells) -> Array:
    """(2,) variance of the whitened residuals of force and torque if each channel is
    the best linear function of features, axes and drift."""
    drift = bias_columns(cells, drift_degrees(cells))[:, 0, : drift_degrees(cells)]
    columns = np.hstack((cells.features, cells.axes, drift))
    size = np.maximum(np.linalg.norm(columns, axis=0), 1e-300)
    left, singular, _ = np.linalg.svd(columns / size, full_matrices=False)
    left = left[:, singular > NEGLIGIBLE_DIRECTION * singular[0]]
    residual = cells.whitened - left @ (left.T @ cells.whitened)
    square = np.sum(residual.reshape(-1, 2, 3) ** 2, axis=(0, 2))
    return square / max(3.0 * (len(cells) - left.shape[1]), 1.0)


SENSOR_ERROR = 0.005
"""Error of a good sensor as a share of the wrench's changes, which averaging does not
reduce."""
MEDIAN_OF_NORMAL = 0.6745
"""Median absolute value of a standard normal number."""
THIRD_DIFFERENCE = np.sqrt(20.0)
"""Standard deviation of the third difference of white noise of variance 1."""
SUSPICIOUS = 100.0
"""Twice the log likelihood ratio of two bodies to one from which on changes are
searched for. In 72 simulated recordings without a change it is at most 23; in 48 in
which the object is picked up, put down, swapped or slips it is 34 to 6,500. Weaker
changes are not distinguished from a sensor's errors anyway."""
UNEXPLAINED_VARIANCE = 12.0
"""Variance of one body's residuals, over that of the noise, from which on changes are
searched for, as one change explains little of a contact. In recordings of three real
sensors it is 1 to 10."""
FEWEST_CELLS_EACH_SIDE = 5


def with_noise_scale(cells: Cells, rounding: Array) -> Cells:
    """The cells with the scale of their noise: that of the differences of neighbouring
    residuals, and no less than the error of a good sensor and that of `rounding` (2,),
    of force [N] and torque [N m]."""
    changes = np.linalg.norm(np.std(cells.wrench, axis=0).reshape(2, 3), axis=1)
    smallest = 1e-9 * float(np.abs(cells.wrench).max()) + 1e-12
    floor = np.maximum(SENSOR_ERROR * changes, np.maximum(rounding, smallest))
    cells = replace(cells, scale=np.maximum(0.1 * changes, smallest))
    for _ in range(2):
        apart = np.diff(_one_body(cells)[2], n=3, axis=0) * cells.unit
        sizes = column_medians(
            np.abs(apart).reshape(-1, 2, 3).swapaxes(1, 2).reshape(-1, 2)
        )
        noise = sizes / (MEDIAN_OF_NORMAL * THIRD_DIFFERENCE)
        cells = replace(cells, scale=np.hypot(noise, floor))
    return cells


def is_suspicious(cells: Cells) -> bool:
    """Whether two successive bodies explain much more than one, or one explains
    little."""
    at = _best_change(cells)
    model = JointModel(cells, [(0, at), (at, len(cells))])
    one, two = model.fit([0, 0]), model.fit([0, 1])
    if float(one.variance.max()) > UNEXPLAINED_VARIANCE:
        return True
    tau = autocorrelation(model.residuals(two))
    return log_ratio(one, two) / tau > SUSPICIOUS


def _one_body(cells: Cells) -> tuple[Array, Array, Array]:
    """The fit of one body beside a smoothly drifting bias: columns (M, 6, q), normal
    matrix (q, q), residuals (M, 6)."""
    drift = drift_degrees(cells)
    columns = np.concatenate((cells.regressor, bias_columns(cells, drift)), axis=2)
    flat = columns.reshape(-1, columns.shape[2])
    ridge = np.append(LARGEST_PARAMETERS**-2.0, ridge_of_shared(drift)[:-1])
    normal = flat.T @ flat + np.diag(ridge)
    solution = np.linalg.solve(normal, flat.T @ cells.whitened.ravel())
    residual = cells.whitened.ravel() - flat @ solution
    return columns, normal, residual.reshape(-1, 6)


def _best_change(cells: Cells) -> int:
    """The cell at which a second body, from there on, explains most."""
    columns, normal, residual = _one_body(cells)
    A = np.swapaxes(cells.regressor, 1, 2)

    def from_here_on(values: Array) -> Array:
        return np.cumsum(values[::-1], axis=0)[::-1]

    shared = from_here_on(A @ columns)
    score = from_here_on(A @ residual[:, :, None])
    rows = slice(FEWEST_CELLS_EACH_SIDE, len(cells) - FEWEST_CELLS_EACH_SIDE)
    shared, score = shared[rows], score[rows]
    q = shared.shape[2]
    explained = (shared.reshape(-1, q) @ np.linalg.inv(normal)).reshape(shared.shape)
    information = shared[:, :, :PARAMETERS] - explained @ np.swapaxes(shared, 1, 2)
    information = information + np.diag(LARGEST_PARAMETERS**-2.0)
    gain = np.sum(score * np.linalg.solve(information, score), axis=(1, 2))
    return int(np.argmax(gain)) + FEWEST_CELLS_EACH_SIDE
