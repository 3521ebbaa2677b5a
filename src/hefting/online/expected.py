"""Expected: the wrench of new samples if the same object is held, and how far they deviate.

The samples of a stream so far give a body, a bias and a linear drift of the bias, x (22,),
by least squares with a wide prior. The residuals r of later samples, with A (6, 4) the
columns of the regressor for mass and first moment and W the weights, give a change of these

    d = (sum A' W A)^-1 sum A' W r,

whose covariance is that of the noise and of the prediction. d' cov(d)^-1 d is chi-square
with four degrees of freedom while nothing changes. At rest A holds little but errors of the
accelerations along some changes, as of a COM along gravity. The prediction has the same
errors, times the body: d is then less that body, and the covariance allows for it. In x
these errors would look like information on the inertia, and are taken out of A' W A.
"""

from dataclasses import replace
from typing import Self

import numpy as np

from hefting.core.estimate import Estimate
from hefting.core.measurements import Measurements
from hefting.core.regressor import FULL_MAP, motion_features
from hefting.core.spatial import Array, immutable
from hefting.ingest.ingested import Ingested

LENGTHS = (0.5, 1.0)
"""[s] Lengths of the windows of new samples. A large change shows in the shorter one first;
one of 15 g beside a noise of 0.1 N shows in the longer one."""
SHORTEST = 3.0
"""[s] Shorter recordings predict nothing: their clock offset and drift may still change."""
LARGEST_OFFSET_STD = 0.05
"""[s] Standard deviation that is assumed of an unknown clock offset."""
FEWEST = 10
"""Fewest samples in a window."""
PRIOR_STD = np.repeat((100.0, 10.0, 1.0, 1e3, 1e2, 0.2, 0.01), (1, 3, 6, 3, 3, 3, 3))
"""Prior standard deviations of the parameters [kg, kg m, kg m²], the bias [N, N m] and its
drift [N/s, N m/s]: many times those of objects and sensors."""
KNOWN_RATIO = 3.0
"""Prior standard deviations of a body that is known from other samples, over those of its
estimate; its correlations are neglected."""
WANDER = np.repeat((0.01, 5e-4), 3)
"""[N/s, N m/s] Standard deviation of later changes of the bias's drift."""
INITIAL_WINDOWS = 4.0
"""Number of windows of white noise in the prior of the noise's scale."""
SPIKE = 8.0
"""Deviation from a window's median, in standard deviations of the noise, of a spike."""

LARGEST = 40.0
"""Size of a deviation above which the samples are not of the same object: chi-square
with four degrees of freedom exceeds it with a probability of 4e-8."""
PERSISTS = 0.7
"""[s] Duration from which on a deviation that a body explains is another object."""
LATEST = 0.4
"""[s] Length of the window that shows whether a touch is over."""
STILL = 20.0
"""Size of its deviation above which the touch is not over."""
LARGEST_MISFIT = 2.5
"""Misfit of another body, above which none explains a window."""
ACCELERATION_ERROR = 0.006
"""Error of the accelerations over gravity, as at the corners of a trapezoidal velocity, by
which a body of the deviation's weight misses it."""
INERTIA_ARM = 0.3
"""[m] Prior standard deviation of another body's radius of gyration."""
LONGEST = 6.0
"""[s] Duration from which on a deviation is another object unless the poses rest."""
REST = 1e-3
"""Change of gravity in sensor axes, over its size, below which the poses rest."""


@immutable
class Deviation:
    """Deviation of a window of samples from the prediction."""

    size: float
    """d' cov(d)^-1 d over the scale of the noise, as errors that make the noise coloured,
    such as hysteresis, are larger in samples that were not fitted"""
    misfit: float
    """root mean square of the residuals of a fit of another body, over the noise and what
    `ACCELERATION_ERROR` makes of the deviation"""


@immutable
class Expected:
    """Prediction of the wrench of samples to come."""

    x: Array
    """(22,) parameters, bias at `end`, and its drift [1/s]"""
    covariance: Array
    """(22, 22)"""
    noise: Array
    """(6,) standard deviation of a sample's residual [N, N m]"""
    scale: Array
    """(n,) for windows of each of `LENGTHS`: variance of d over that by white noise"""
    offset_std: float
    """[s] standard deviation of the clock offset that was removed"""
    end: float
    """[s] last sample that was used"""

    @classmethod
    def of(cls, found: Ingested, known: Estimate | None = None) -> Self | None:
        """From the samples of a recording, and an estimate `known` from others; None for
        too few samples."""
        z = found.measurements
        if len(z) < FEWEST or z.time[-1] - z.time[0] < SHORTEST:
            return None
        level = np.repeat((found.noise.force, found.noise.torque), 3)
        noise = np.maximum(level, 1e-9 + 1e-6 * np.abs(z.wrench).max())
        begin = cls(
            np.zeros(22),
            np.eye(22),
            noise,
            np.ones(len(LENGTHS)),
            min(found.conditioned.offset_std or 0.0, LARGEST_OFFSET_STD),
            float(z.time[-1]),
        )
        X = begin._columns(z)
        W = _weights(z)[:, None] * noise**-2.0
        H = np.einsum("kia,ki,kib->ab", X, W, X, optimize=True)
        center, prior_std = np.zeros(22), PRIOR_STD.copy()
        if known is not None and known.covariance is not None:
            center[:10] = known.parameters.vector
            known_std = KNOWN_RATIO * np.sqrt(known.covariance.diagonal())
            prior_std[:10] = np.fmin(prior_std[:10], known_std)
        v = np.einsum("kia,ki,ki->a", X, W, z.wrench - X @ center)
        by_motion = np.zeros_like(H)
        by_motion[:10, :10] = _by_motion(z, W)
        axes, gain, variance = _solved(H, by_motion, prior_std)
        x = center + axes @ (gain * (axes.T @ v))
        residual = z.wrench - X @ x
        scale = np.array([_scale(z, X, residual, noise, each) for each in LENGTHS])
        covariance = (axes * np.where(gain, scale.max() * gain**2, variance)) @ axes.T
        return replace(begin, x=x, covariance=covariance, scale=scale)

    def residual(self, z: Measurements) -> Array:
        """(K, 6) measured less expected wrench [N, N m]."""
        return z.wrench - self._columns(z) @ self.x

    def deviation(self, z: Measurements) -> Deviation | None:
        """The largest deviation of the windows of `LENGTHS` that end with the last of K
        samples; None for too few samples."""
        found = [self.of_latest(z, length) for length in LENGTHS]
        return max(
            (each for each in found if each is not None),
            key=lambda each: each.size,
            default=None,
        )

    def of_latest(self, z: Measurements, length: float) -> Deviation | None:
        """The deviation of the last `length` [s] of K samples; None if not filled."""
        if not len(z):
            return None
        first = int(np.searchsorted(z.time, z.time[-1] - length))
        full = z.time[-1] - z.time[0] >= 0.9 * length
        if not full or len(z) - first < FEWEST:
            return None
        return self._deviation(z[slice(first, None)], float(self.scale.max()))

    def _deviation(self, z: Measurements, scale: float) -> Deviation:
        """Of a window of samples, with white noise's covariance of d times `scale`."""
        X = self._columns(z)
        expected = X @ self.x
        by_offset = np.gradient(expected, z.time, axis=0) * self.offset_std
        r = z.wrench - expected
        off = np.abs(r - np.median(r, axis=0)) / self.noise
        kept = np.flatnonzero((off < SPIKE).all(axis=1))
        if 2 * len(kept) > len(r):
            X, r, by_offset = X[kept], r[kept], by_offset[kept]
            z = z[kept]  # type: ignore[index]
        A, W = X[:, :, :4], _weights(z)[:, None] * self.noise**-2.0
        S = _normal(A, W, A)
        white = _inverse(S)
        by_x = white @ _normal(A, W, X)
        by_drift = by_x[:, 10:16] * (WANDER * (float(z.time[-1]) - self.end))
        late = white @ _right(A, W, by_offset)
        covariance = scale * white + by_x @ self.covariance @ by_x.T
        covariance = covariance + by_drift @ by_drift.T
        covariance += np.outer(late, late)
        errors = _by_motion(z, W)[:4]
        # the samples need not have the errors that are expected, as poses that repeat
        by_motion = _inverse(S + errors[:, :4]) @ errors @ self.x[:10]
        covariance += np.outer(by_motion, by_motion)
        change = white @ _right(A, W, r)
        root = np.sqrt(W)
        left = _unexplained(X[:, :, :10] * root[:, :, None], r * root, abs(change[0]))
        square = 1.0 + ACCELERATION_ERROR**2 * np.square(r * root).mean()
        size = float(change @ np.linalg.lstsq(covariance, change, rcond=1e-12)[0])
        return Deviation(size / scale, float(np.sqrt(np.square(left).mean() / square)))

    def _columns(self, z: Measurements) -> Array:
        """(K, 6, 22) derivatives of the wrench by x."""
        body = (motion_features(z) @ FULL_MAP).reshape(len(z), 6, 10)
        bias = np.broadcast_to(np.eye(6), (len(z), 6, 6))
        drift = (z.time - self.end)[:, None, None] * bias
        return np.concatenate((body, bias, drift), axis=2)


def _unexplained(X: Array, r: Array, mass: float) -> Array:
    """(K, 6) residuals of a fit of a body to r (K, 6), with a prior of its inertia for a
    `mass` [kg]; r and the derivatives X (K, 6, 10) are over the noise."""
    X = X * np.repeat((1.0, 0.1, INERTIA_ARM**2 * mass), (1, 3, 6))
    H = np.einsum("kia,kib->ab", X, X)
    H += np.diag(np.repeat((1e-9 * np.trace(H), 1.0), (4, 6)))
    return r - X @ np.linalg.solve(H, np.einsum("kia,ki->a", X, r))


def _normal(A: Array, W: Array, B: Array) -> Array:
    """(a, b) sum of A' W B over samples: A (K, 6, a), W (K, 6), B (K, 6, b)."""
    return np.einsum("kia,ki,kib->ab", A, W, B)


def _right(A: Array, W: Array, r: Array) -> Array:
    """(a,) sum of A' W r over samples: A (K, 6, a), W and r (K, 6)."""
    return np.einsum("kia,ki,ki->a", A, W, r)


def _weights(z: Measurements) -> Array:
    """(K,) weights by the errors of the motion, at most one."""
    return np.ones(len(z)) if z.weights is None else np.minimum(z.weights, 1.0)


def _by_motion(z: Measurements, W: Array) -> Array:
    """(10, 10) expected sum of E' W E over samples with weights W (K, 6), for the errors E
    of the body's columns by those of the accelerations."""
    noise = z.motion_noise
    if noise is None:
        return np.zeros((10, 10))
    variance = np.square(np.repeat((noise.linear, noise.angular), 3))
    each = FULL_MAP[:6].reshape(6, 6, 10)
    return np.einsum("k,kia,i,kib->ab", variance, each, W.sum(axis=0), each)


def _solved(H: Array, by_motion: Array, prior_std: Array) -> tuple[Array, Array, Array]:
    """Axes T (22, 22), gains and prior variances (22,) along them: x is T (gain T' v) with
    normal equations H, v and a prior of zero mean. T' H T is one less the prior's share. Of
    H the part `by_motion` tells nothing; along axes of which it is most the gain is zero.
    """
    factor = np.linalg.cholesky(H * prior_std[:, None] * prior_std + np.eye(len(H)))
    root = np.linalg.inv(factor) * prior_std
    share, turned = np.linalg.eigh(root @ by_motion @ root.T)
    gain = np.where(share < 0.5, 1.0 / (1.0 - np.minimum(share, 0.5)), 0.0)
    return root.T @ turned, gain, np.square(factor @ turned).sum(axis=0)


def _scale(z: Measurements, X: Array, r: Array, noise: Array, length: float) -> float:
    """Mean square of d over that by white noise, in consecutive windows of `length` [s] of
    the fitted samples with residuals r (K, 6); at least 1."""
    begins = np.arange(float(z.time[0]), float(z.time[-1]) - length, length)
    first = np.searchsorted(z.time, begins)
    last = np.searchsorted(z.time, begins + length)
    W = _weights(z)[:, None] * noise**-2.0
    chi_square, windows = 0.0, 0
    for i, j in zip(first, last, strict=True):
        if j - i < FEWEST:
            continue
        A = X[i:j, :, :4]
        v = _right(A, W[i:j], r[i:j])
        chi_square += float(v @ _inverse(_normal(A, W[i:j], A)) @ v) / 4.0
        windows += 1
    return max((INITIAL_WINDOWS + chi_square) / (INITIAL_WINDOWS + windows), 1.0)


def _inverse(S: Array) -> Array:
    """Inverse of a positive semidefinite matrix (4, 4), which is singular for a body at
    the sensor's origin."""
    units = np.diag((1.0, 0.1, 0.1, 0.1))
    scaled = units @ S @ units
    floor = 1e-9 * np.trace(scaled) * np.eye(4)
    return units @ np.linalg.inv(scaled + floor) @ units


@immutable
class Watch:
    """Whether the object that is held is still the same."""

    onset: float | None = None
    """[s] Time at which the present deviation was first seen; None without one."""
    changed: bool = False
    """Whether another object is held."""
    rests: bool = False
    """Whether the poses have been the same since the onset."""

    def looked(self, expected: Expected, z: Measurements) -> Self:
        """The state after the latest K samples."""
        deviation = expected.deviation(z)
        if deviation is None:
            return self
        now = float(z.time[-1])
        if deviation.size <= LARGEST:
            return replace(self, onset=None, rests=False)
        onset = now if self.onset is None else self.onset
        lasted = now - onset
        changed = lasted >= PERSISTS and _is_body(expected, z, lasted)
        rests = lasted >= PERSISTS and _rests(z.gravity[z.time >= onset])
        changed |= lasted >= LONGEST and not rests
        return replace(self, onset=onset, changed=changed, rests=rests)

    @property
    def trusted_until(self) -> float | None:
        """[s] End of the samples that are of the object; None where all are."""
        return None if self.onset is None else self.onset - LENGTHS[-1]


def _rests(gravity: Array) -> bool:
    change = np.abs(gravity - gravity[-1]).max()
    return bool(change <= REST * np.linalg.norm(gravity[-1]))


def _is_body(expected: Expected, z: Measurements, lasted: float) -> bool:
    """Whether the latest samples still deviate, and another body explains the samples
    since the deviation began."""
    latest = expected.of_latest(z, LATEST)
    since = expected.of_latest(z, min(lasted, LENGTHS[-1]))
    return (
        latest is not None
        and since is not None
        and latest.size > STILL
        and since.misfit < LARGEST_MISFIT
    )
