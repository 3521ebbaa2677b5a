"""Smoothing of finished recordings: poses in, velocities and accelerations with believable spreads out.

Position, and the four components of the orientation's quaternion, are each smoothed by one penalised quintic
spline (`hefting.motion.bspline`) whose bandwidth, noise level and order are the most likely ones.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from hefting.errors import InputError
from hefting.motion.bspline import (
    CHUNK,
    FEWEST,
    SUPPORT,
    Knots,
    Likelihood,
    Mask,
    Normal,
    Smoothness,
    basis,
    inverse_bands,
)
from hefting.motion.state import Motion, motion_from_channels
from hefting.spatial import Array

ORDERS = (3, 4, 5)
"""Orders of smoothness tried: 5 suits smooth motion, 3 stop-and-go."""
KNOT_SPACING = 0.02
"""s, to begin with; it then follows the bandwidth, so that h wc stays between 0.3 and 1."""
LOWEST, HIGHEST = 0.15, 2.5
"""Bounds of h wc in the search."""
TUNED_COEFFICIENTS = 10_000
"""Longer recordings choose their smoothness on evenly spaced stretches of this many coefficients in all."""


def smooth(
    time: ArrayLike,
    position: ArrayLike | None,
    orientation: ArrayLike,
    at: ArrayLike | None = None,
    position_time: ArrayLike | None = None,
) -> Motion:
    """Motion of the sensor from its measured poses.

    time:        (K,) s, increasing, any spacing
    position:    (K, 3) m, sensor origin in world, or None
    orientation: (K, 4) quaternions xyzw, sensor in world; signs and lengths do not matter
    at:          (L,) s, where the motion is wanted; `time` by default
    position_time: (P,) s, when positions (P, 3) come at times of their own; `time` by default

    The variances are those of the spline as a Gaussian process of the smoothness found: in the interior, at
    the ends and beside gaps. Inside a gap too long to bridge the motion is NaN, its deviation infinite.
    Held values, repeated as often as a slower stream repeats between its updates, count once.

    Raises `InputError` for arrays that do not fit, times that do not increase, fewer than eight poses, and
    times `at` outside the recording.
    """
    if position is None or position_time is None:
        time, position, orientation = check_poses(time, position, orientation)
        own_time = time
    else:
        still = np.tile((0.0, 0.0, 0.0, 1.0), (len(np.atleast_1d(position_time)), 1))
        own_time, position, _ = check_poses(position_time, position, still)
        time, _, orientation = check_poses(time, None, orientation)
    if min(len(time), len(own_time)) < FEWEST:
        few = min(len(time), len(own_time))
        raise InputError(f"{few} poses are too few to differentiate", fix=f"record at least {FEWEST}")
    at = time if at is None else np.atleast_1d(np.asarray(at, dtype=float))
    first, last = max(time[0], own_time[0]), min(time[-1], own_time[-1])
    if len(at) and (at.min() < first or at.max() > last):
        raise InputError(
            f"the motion is wanted from {at.min():.6g} to {at.max():.6g} s, but known from {first:.6g} to {last:.6g} s",
            fix="ask only for times inside the recording",
        )
    q = _Curve.fit(time, aligned(orientation), "orientation")
    channels = q.evaluate(at)
    quaternion = (*channels[:3], channels[3], channels[4])
    if position is None:
        return motion_from_channels(at, None, quaternion, q.smoothness.bandwidth)
    p = _Curve.fit(own_time, position, "position")
    p0, p1, p2, _, p2_std = p.evaluate(at)
    bandwidth = np.sqrt(p.smoothness.bandwidth * q.smoothness.bandwidth)
    return motion_from_channels(at, (p0, p1, p2, p2_std), quaternion, bandwidth)


def check_poses(time, position, orientation) -> tuple[Array, Array | None, Array]:
    """Float arrays (K,), (K, 3) or None, (K, 4) of unit length; `InputError` when they do not fit."""
    time = np.atleast_1d(np.asarray(time, dtype=float))
    arrays = {
        "time": (time, (len(time),)),
        "orientation": (np.asarray(orientation, dtype=float), (len(time), 4)),
    }
    if position is not None:
        arrays["position"] = (np.asarray(position, dtype=float), (len(time), 3))
    for name, (array, shape) in arrays.items():
        if array.shape != shape:
            raise InputError(f"has shape {array.shape}, expected {shape}", where=name)
        if not np.isfinite(array).all():
            row = int(np.argwhere(~np.isfinite(array))[0][0])
            raise InputError(f"row {row} is not finite", where=name, fix="leave out the rows that were not measured")
    if (np.diff(time) <= 0).any():
        row = int(np.argmax(np.diff(time) <= 0)) + 1
        raise InputError(f"row {row} is not later than the row before it", where="time", fix="sort it, drop doubles")
    orientation = arrays["orientation"][0]
    norm = np.linalg.norm(orientation, axis=1, keepdims=True)
    if (norm < 1e-6).any():
        raise InputError(f"row {int(np.argmin(norm))} is no rotation: its quaternion is zero", where="orientation")
    return time, arrays["position"][0] if position is not None else None, orientation / norm


def aligned(quaternions: Array, previous: Array | None = None) -> Array:
    """(K, 4) quaternions, their signs such that each is near the one before (the first: near `previous`)."""
    if len(quaternions) == 0:
        return quaternions
    flips = np.sum(quaternions[1:] * quaternions[:-1], axis=1) < 0
    first = previous is not None and quaternions[0] @ previous < 0
    signs = 1.0 - 2.0 * (np.cumsum(np.concatenate(([first], flips))) % 2)
    return quaternions * signs[:, None]


def fresh_rows(time: Array, values: Array) -> Mask:
    """(K,) mask of the rows that are news: without the repeats of a slower stream that holds its value.

    Runs of equal rows are repeats only when they are the rule (half of all runs at least two rows long); of a
    run longer than twice the usual, as at rest, one row in that many stays.
    """
    changed = np.concatenate(([True], (np.diff(values, axis=0) != 0).any(axis=1)))
    begins = np.flatnonzero(changed)
    usual = int(np.median(np.diff(np.append(begins, len(values)))))
    at_most = max(int(0.1 / np.median(np.diff(time))), 1)
    stride = min(2 * usual, at_most) if usual > 1 else 1
    age = np.arange(len(values)) - begins[np.cumsum(changed) - 1]
    return age % stride == 0


@dataclass(frozen=True)
class _Curve:
    """One smoothed multi-component signal."""

    knots: Knots
    coefficients: Array
    """(n, d)"""
    covariance: Array
    """(6, n): lower bands of the coefficients' covariance, the same for every component"""
    smoothness: Smoothness

    @classmethod
    def fit(cls, time: Array, values: Array, name: str) -> "_Curve":
        end = time[-1]
        kept = fresh_rows(time, values)
        time, values = time[kept], values[kept]
        smoothness, h, dt = tune(time, values, ORDERS, name)
        normal = _normal(time, values, h, end)
        penalty = smoothness.penalty(h, dt)
        normal.refine_pilot(smoothness.order, penalty)
        coefficients, factor = normal.solve(smoothness.order, penalty)
        overlap = int(np.ceil(12.0 / min(h * smoothness.bandwidth, 1.0)))
        return cls(normal.knots, coefficients, smoothness.variance * inverse_bands(factor, overlap), smoothness)

    def evaluate(self, at: Array) -> tuple[Array, ...]:
        """Value and two derivatives (L, d) at the times (L,), and the deviations (L,) of the derivatives."""
        out = [np.empty((len(at), self.coefficients.shape[1])) for _ in range(3)]
        std = [np.empty(len(at)) for _ in range(2)]
        for begin in range(0, len(at), CHUNK):
            part = slice(begin, begin + CHUNK)
            index, u, covered = self.knots.locate(at[part])
            neighbours = self.coefficients[index[:, None] + np.arange(SUPPORT)]
            rows = [basis(u, k) / self.knots.h**k for k in range(3)]
            for k in range(3):
                out[k][part] = np.einsum("lj,ljd->ld", rows[k], neighbours)
                out[k][part][~covered] = np.nan
            variance = np.zeros((2, len(u)))
            for a in range(SUPPORT):
                for b in range(a, SUPPORT):
                    covariance = (1.0 if a == b else 2.0) * self.covariance[b - a, index + a]
                    for k in (1, 2):
                        variance[k - 1] += covariance * rows[k][:, a] * rows[k][:, b]
            for k in range(2):
                std[k][part] = np.where(covered, np.sqrt(np.maximum(variance[k], 0.0)), np.inf)
        return (*out, *std)


def tune(time: Array, values: Array, orders: tuple[int, ...], name: str) -> tuple[Smoothness, float, float]:
    """The most likely smoothness of a signal (K, d), the knot spacing to suit, and the sampling interval."""
    if len(time) < FEWEST:
        raise InputError(f"{len(time)} different poses are too few to differentiate", where=name, fix="record longer")
    dt = float(np.median(np.diff(time)))
    duration = time[-1] - time[0]
    coarsest = max(duration / 6.0, dt)
    h = min(max(KNOT_SPACING, dt), coarsest)
    excess = duration / h / TUNED_COEFFICIENTS
    if excess > 1:
        stretch = duration / excess / 10
        kept = ((time - time[0]) / stretch).astype(int) % int(np.ceil(excess)) == 0
        time, values = time[kept], values[kept]
    floor = (1e-12 * max(float(np.abs(values).max()), 1e-3)) ** 2
    middle = orders[len(orders) // 2]
    for _ in range(4):
        found = _most_likely(time, values, middle, h, floor)
        wanted = float(np.clip(0.6 / found.bandwidth, dt, coarsest))
        if 0.3 <= h * found.bandwidth <= 1.0 or np.isclose(wanted, h):
            break
        h = wanted
    candidates = [found if m == middle else _most_likely(time, values, m, h, floor) for m in orders]
    best = max(candidates, key=lambda c: c.log_likelihood)
    return best, h, _interval(time, h)


def _most_likely(time, values, m, h, floor) -> Smoothness:
    normal = _normal(time, values, h)
    dt = _interval(time, h)
    for h_bandwidth in (HIGHEST, 0.6):
        normal.refine_pilot(m, Smoothness(m, h_bandwidth / h, 0.0, 0.0).penalty(h, dt))
    return Likelihood(normal, m, dt, 3, floor).maximum(LOWEST, HIGHEST)


def _segments(time: Array, h: float) -> Mask:
    """Where a new segment begins: mask (K - 1,) of the gaps too long to bridge."""
    return np.diff(time) > max(10.0 * h, 20.0 * float(np.median(np.diff(time))), 0.1)


def _interval(time: Array, h: float) -> float:
    """Mean sampling interval outside gaps."""
    return float(np.mean(np.diff(time)[~_segments(time, h)]))


def _normal(time: Array, values: Array, h: float, end: float = -np.inf) -> Normal:
    """Normal equations; the last segment reaches to `end`, rows of which only repeat the last value."""
    cuts = np.flatnonzero(_segments(time, h)) + 1
    begin, stop = np.concatenate(([0], cuts)), np.concatenate((cuts, [len(time)]))
    apart = np.concatenate(([True], np.diff(np.floor((time - time[0]) / (h / 2))) > 0))
    long_enough = (stop - begin >= FEWEST) & (np.add.reduceat(apart.astype(int), begin) > SUPPORT)
    if not long_enough.any():
        raise InputError(f"gaps leave no {FEWEST} poses in a row", where="poses", fix="record more often")
    last = time[stop[long_enough] - 1]
    if long_enough[-1]:
        last[-1] = max(last[-1], end)
    knots = Knots(h, time[begin[long_enough]], last)
    return Normal(knots, time, values, block=h / 2)
