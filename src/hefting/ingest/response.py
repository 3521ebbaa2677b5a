"""Response: whether a late wrench is delayed, or low-pass filtered, which also rounds
and weakens it.

A first-order filter of time constant T delays a steady change by T, like a late clock.
It delays the beginning of a change less, and weakens a wrench of frequency f by about
(2 pi f T)² / 2: by 3 % at 0.2 Hz for 0.2 s. If it is taken for a delay, masses are
found too small.

The motion's features are filtered with several time constants. For each, parameters,
bias and the remaining lag are found by least squares, and its likelihood follows from
the residuals.

A filter's tail resembles a drifting bias or contacts, and a part of the object's weight
would be removed as such. A clear filter is therefore looked for first: `felt_path`.
"""

from dataclasses import replace
from itertools import pairwise

import numpy as np

from hefting.core.measurements import Measurements
from hefting.core.messages import Message, note
from hefting.core.regressor import motion_features
from hefting.core.spatial import Array, immutable, interpolated
from hefting.ingest.conditioned import SIGNIFICANT, Conditioned
from hefting.ingest.filtering import SHORTEST_LAG, Ahead
from hefting.ingest.fit import Start, gauss_newton
from hefting.ingest.free_fit import FreeFit
from hefting.ingest.model import FEATURES, REGRESSOR_BY_FEATURE, Problem, features_of
from hefting.ingest.path import Path
from hefting.ingest.robust_fit import InlierFit
from hefting.ingest.samples import Samples

CONSTANTS = (0.0, 0.3, 0.5, 0.7, 0.85, 1.0, 1.2, 1.5, 2.0)
"""Time constants that are tried, over the lag that was found for a delay, which the
start or end of a single move makes too short."""
FELT_CONSTANTS = (0.6, 1.0, 1.4, 1.8)
"""Those that are tried before drifts and contacts are searched for."""
EARLY = 1.1
"""Largest time constant over the lag; poses may be slightly late themselves."""
STEPS = 4
"""Number of Gauss-Newton steps of the lag for each filter."""
REFINEMENTS = 2
"""Number of times that constants between the likeliest and its neighbours are added."""
MOST_SAMPLES = 2000
"""Number of samples on which filters are compared."""
EVIDENCE_RATIO = 3.0
"""Factor by which an imperfect model reduces the evidence, in standard deviations."""
TYPICAL = np.repeat((5.0, 1.0, 0.2), (1, 3, 6))
"""Prior standard deviations of the parameters [kg, kg m, kg m²], of heavy objects."""
WIDE = 1e3
"""The same of the bias [N, N m] and its change [1/s]."""
SHORTEST = 0.05
"""[s] Lag from which on `felt_path` looks for a filter; the tail of a shorter one does
not resemble a drift."""
LONGEST = 1.2
"""[s] Longest time constant; a longer lag is that of a clock."""
CLEARLY_LESS = 0.8
"""Size of the residuals of force and torque together over that for a delay, below which
there is a filter. In parts of 9 s of a recording with a filter of 0.6 s it is 0.4 to
0.9."""
MOST_BLOCKS = 2000
"""Number of blocks on which filters are compared."""
INSTANTS_PER_LAG, FEWEST_PER_LAG, MOST_INSTANTS = 20, 4, 50_000
"""Numbers of instants at which the motion is filtered."""


def felt_path(samples: Samples, found: InlierFit) -> Path | None:
    """The motion through the filter that explains the wrench clearly better than a delay,
    ahead by the lag of that filter; None if there is none.

    The bias is constant, and samples are left out only by their robust weights.
    """
    problem, lag = found.problem, found.fit.offset
    if not problem.free_offset or lag < SHORTEST:
        return None
    if (grid := instants(problem.path, lag)) is None:
        return None
    typical = samples.blocks().with_medians(samples.wrench)
    delayed = replace(problem, blocks=typical, free_gravity=False).every(MOST_BLOCKS)
    start = replace(found.fit.start, reading=None)
    least, best = CLEARLY_LESS * _left(delayed, start), None
    constants = [lag * share for share in FELT_CONSTANTS if lag * share < LONGEST]
    ahead = Ahead.of(grid, problem.path.read(grid, False)[0], LONGEST)
    for constant in constants:
        path = problem.path.felt(grid, ahead.through(constant))
        left = _left(replace(delayed, path=path), start)
        if left < least:
            least, best = left, path
    return best


def _left(problem: Problem, start: Start) -> float:
    """Size of the residuals of robust least squares, of force and torque together."""
    fit = gauss_newton(problem, start, 1, robust=True, steps=6, final=False)
    return float(np.sqrt(fit.scale.prod()))


def instants(path: Path, lag: float) -> Array | None:
    """(n,) [s] even instants at which to filter a motion for a wrench that lags by
    `lag` [s]; None if it is too long for such a short lag."""
    lags = (path.last - path.first) / lag
    if lags * FEWEST_PER_LAG > MOST_INSTANTS:
        return None
    count = int(min(lags * INSTANTS_PER_LAG, MOST_INSTANTS)) + 2
    return np.linspace(path.first, path.last, count)


@immutable
class Response:
    """How the wrench follows the motion, apart from a delay."""

    lag: float
    """[s] of the wrench in steady motion"""
    share: float
    """of the lag that is due to a filter: 0 for a delay, 1 for a first-order filter"""
    share_std: float
    change: Array
    """(K, 6) contribution of the filter to the wrench of each sample, and of the drift
    that was removed in its place [N, N m]"""
    errors: Array
    """(10, n) E with E E' the covariance of the parameters by its uncertainty"""

    def corrected(self, z: Measurements) -> Measurements:
        """The samples with a wrench that is only delayed."""
        return replace(
            z, force=z.force - self.change[:, :3], torque=z.torque - self.change[:, 3:]
        )

    def messages(self) -> list[Message]:
        """A note if the filter is significant."""
        if not self.share > SIGNIFICANT * self.share_std:
            return []
        return [
            note(
                "wrench-response",
                f"the wrench lags by {self.lag:.2g} s as through a low-pass filter: corrected",
            )
        ]


def response_of(found: Conditioned, z: Measurements, fit: FreeFit) -> Response | None:
    """The response of the wrench by the residuals, in addition to the clock offset.

    None without a clock or motion, or if the wrench is hardly late.

    `fit` is unconstrained least squares of the samples `z`, with the delay removed.
    """
    path, lag = found.path, found.offset
    if found.offset_std is None or path is None or lag < SHORTEST_LAG or len(z) < 3:
        return None
    path = path.plain or path
    gravity = np.zeros(3) if path.gravity_measured else found.gravity
    if (grid := instants(path, lag)) is None:
        return None
    features = features_of(path.read(grid, False)[0], gravity)
    ahead = Ahead.of(grid, features, LONGEST)
    plain = interpolated(z.time, grid, features)
    samples = _Samples.of(found, z, fit, plain)
    known: list[_Beside] = []
    constants = [lag * ratio for ratio in CONSTANTS if lag * ratio < LONGEST]
    for _ in range(1 + REFINEMENTS):
        tried = [samples.beside(T, lag, grid, ahead.through(T)) for T in constants]
        known += [each for each in tried if each.constant <= EARLY * each.lag]
        if len(known) < 2:
            return None
        known.sort(key=lambda each: each.constant)
        best = int(np.argmax([each.score for each in known]))
        near = [each.constant for each in known[max(best - 1, 0) : best + 2]]
        constants = [0.5 * (one + two) for one, two in pairwise(near)]
    score = np.array([each.score for each in known])
    share = np.exp((score - score.max()) / EVIDENCE_RATIO**2)
    share *= _spacing(np.array([each.constant for each in known]))
    share /= share.sum()
    parameters = np.array([each.parameters for each in known])
    ratio = np.array([each.constant / max(each.lag, each.constant) for each in known])
    part = float(share @ ratio)
    return Response(
        float(share @ [each.lag for each in known]),
        part,
        float(np.sqrt(share @ (ratio - part) ** 2)),
        np.asarray(
            np.tensordot(share, [each.change for each in known], 1), dtype=float
        ),
        (np.sqrt(share)[:, None] * (parameters - share @ parameters)).T,
    )


@immutable
class _Beside:
    """Least squares for one filter."""

    constant: float
    """[s]"""
    lag: float
    """[s] in steady motion"""
    parameters: Array
    """(10,)"""
    change: Array
    """(K, 6) contribution of the filter to the wrench [N, N m]"""
    score: float
    """log likelihood, up to a constant"""


@immutable
class _Samples:
    """Motion and wrench of the samples."""

    time: Array
    """(K,) [s] of the motion"""
    features: Array
    """(K, 12)"""
    error: Array
    """(K, 12) difference from the features of the motion that is filtered"""
    wrench: Array
    """(K, 6) [N, N m]"""
    weights: Array
    """(K,)"""
    variance: Array
    """(6,) of the noise"""
    bias: Array
    """(K, n) constant and linear functions of time, as far as the bias is free"""
    number: float
    """of independent samples"""

    @classmethod
    def of(
        cls, found: Conditioned, z: Measurements, fit: FreeFit, plain: Array
    ) -> "_Samples":
        """From samples, and features (K, 12) of the motion that is filtered."""
        weights = np.ones(len(z)) if z.weights is None else z.weights
        noise = np.repeat((fit.noise.force, fit.noise.torque), 3)
        free = 0 if fit.bias is None else 1
        if free and found.bias.kind != "constant" and found.offset >= SHORTEST:
            free = 2  # a filter's tail may have been taken for the drift
        features = motion_features(z)
        return cls(
            z.time,
            features,
            features - plain,
            z.wrench,
            weights,
            np.maximum(noise, 1e-12) ** 2,
            np.vander(z.time - z.time.mean(), free, increasing=True),
            float(np.count_nonzero(weights)) / fit.autocorrelation,
        )

    def beside(self, constant: float, lag: float, grid: Array, late: Array) -> _Beside:
        """Least squares for a filter of time constant `constant` [s], of samples from
        which a `lag` [s] was removed; `late` (n, 12) are the filtered features at
        instants `grid` (n,)."""
        parameters, more = np.zeros(10), 0.0
        some = slice(None, None, -(-len(self.time) // MOST_SAMPLES))
        rate, beside = np.gradient(late, grid, axis=0), self.bias
        if constant > 0.0:  # the decay of the filter's initial state
            left = np.exp(-np.maximum(self.time - grid[0], 0.0) / constant)
            beside = np.column_stack((beside, left))
        for _ in range(STEPS):
            at = self.time[some] - more
            x = self.error[some] + interpolated(at, grid, late)
            r = interpolated(at, grid, rate)
            found, _ = self._solve(some, x, r, parameters, beside)
            parameters, more = found[:10], more + float(found[10])
        x = self.error + interpolated(self.time - more, grid, late)
        still = np.zeros_like(x[some])
        found, square = self._solve(some, x[some], still, parameters, beside)
        parameters, others = found[:10], found[11:].reshape(-1, 6)
        others[: self.bias.shape[1]][:1] = 0.0  # a constant bias stays
        change = (x - self.features) @ (REGRESSOR_BY_FEATURE @ parameters)
        change += beside @ others
        score = -1.5 * self.number * float(np.log(square).sum())
        if constant > 0.0:  # the initial state has six more unknowns
            score -= 3.0 * np.log(max(self.number, 1.0))
        return _Beside(constant, lag + more, parameters, change, score)

    def _solve(
        self, some: slice, x: Array, rate: Array, parameters: Array, beside: Array
    ) -> tuple[Array, Array]:
        """Linearised least squares on the samples `some`, with features x and their
        rates (k, 12): parameters (10,), the change of the lag about the given ones, and
        wrenches (n, 6) per unit of the columns `beside` (K, n); and the residual
        squares (2,) of force and torque over their noise."""
        n = beside.shape[1]
        known = np.hstack((x, rate, beside[some], self.wrench[some]))
        gram = known.T @ (self.weights[some, None] * known)
        maps = np.zeros((2 * FEATURES + n, 6, 11 + 6 * n))
        maps[:FEATURES, :, :10] = REGRESSOR_BY_FEATURE
        maps[FEATURES : 2 * FEATURES, :, 10] = -REGRESSOR_BY_FEATURE @ parameters
        for k in range(n):
            maps[2 * FEATURES + k, :, 11 + 6 * k : 17 + 6 * k] = np.eye(6)
        by_channel = maps.transpose(1, 0, 2)
        z = len(maps)
        each = by_channel.transpose(0, 2, 1) @ gram[:z, :z] @ by_channel
        right = np.einsum("czp,zc->cp", by_channel, gram[:z, z:])
        precision = np.concatenate((TYPICAL, [1.0], np.full(6 * n, WIDE))) ** -2.0
        inverse = 1.0 / self.variance
        normal = np.tensordot(inverse, each, 1) + np.diag(precision)
        found = np.linalg.solve(normal, inverse @ right)
        left = gram.diagonal()[z:] - 2.0 * right @ found + found @ each @ found
        square = (np.maximum(left, 1e-9 * gram.diagonal()[z:]) * inverse).reshape(2, 3)
        return found, np.maximum(square.sum(axis=1), 1e-300)


def _spacing(at: Array) -> Array:
    """Weights of the trapezoidal rule at increasing places."""
    gaps = np.diff(at)
    return 0.5 * (np.append(gaps, 0.0) + np.append(0.0, gaps))
