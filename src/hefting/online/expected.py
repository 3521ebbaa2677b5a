"""Expected: what new samples look like while the same object is held, and how far some
of them are from that.

The samples of a stream so far are fitted by a body, a bias and a linear drift of the
bias, x (22,), by least squares beside a prior that is as wide as held objects are. The
residual r of later samples, under the part A (6, 4) of the regressor that belongs to
mass and first moment, is a change of these by

    d = (sum A' W A)^-1 sum A' W r

with the covariance of the noise and of the prediction. d' cov(d)^-1 d is chi-square with
four degrees of freedom while nothing changes.
"""

from dataclasses import replace
from typing import Self

import numpy as np

from hefting.core.estimate import Estimate
from hefting.core.immutable import immutable
from hefting.core.measurements import Measurements
from hefting.core.regressor import FULL_MAP, motion_features
from hefting.core.spatial import Array
from hefting.ingest.ingested import Ingested

LENGTHS = (0.5, 1.0)
"""[s] Lengths of the windows: a large change shows in the shorter one at once, one of
15 g beside a noise of 0.1 N in the longer."""
SHORTEST = 3.0
"""[s] By shorter recordings nothing is expected: what they say of clock and drift may
change with the next second."""
LARGEST_OFFSET_STD = 0.05
"""[s] What is not known of a clock offset: few are larger."""
FEWEST = 10
"""Fewest samples in a window."""
PRIOR_STD = np.repeat((100.0, 10.0, 1.0, 1e3, 1e2, 0.2, 0.01), (1, 3, 6, 3, 3, 3, 3))
"""Standard deviations before any sample of the parameters [kg, kg m, kg m²], the bias
[N, N m], and its drift [N/s, N m/s]: many times those of objects and sensors."""
KNOWN_RATIO = 3.0
"""Prior standard deviations of a body that other samples tell, over those of its
estimate, whose correlations are left out."""
WANDER = np.repeat((0.01, 5e-4), 3)
"""[N/s, N m/s] Standard deviation by which a drift goes on otherwise than before."""
INITIAL_WINDOWS = 4.0
"""Windows of white noise that the scale of the noise begins with: a short recording has
few of its own, and its fit follows them."""
SPIKE = 8.0
"""Standard deviations of the noise beyond which a sample of a window is a spike."""

LARGEST = 40.0
"""Size of a deviation above which the samples are not of the same object: chi-square
with four degrees of freedom exceeds it with a probability of 4e-8."""
PERSISTS = 0.7
"""[s] A deviation that lasts so long, and is that of a body, is another object."""
LATEST = 0.4
"""[s] Latest samples, which tell whether a touch is over."""
STILL = 20.0
"""Size of their deviation above which it is not."""
LARGEST_MISFIT = 2.5
"""Residual beside another body, over the noise, above which no body explains it."""
INERTIA_ARM = 0.3
"""[m] Standard deviation of another body's moments of inertia over its mass, as a
length: they are many times the noise where a heavy one is turned quickly."""
LONGEST = 6.0
"""[s] A deviation that lasts longer is no touch, whatever explains it but rest."""
REST = 1e-3
"""Change of gravity in sensor axes, over its size, below which the poses rest."""


@immutable
class Deviation:
    """How far a window of samples is from what is expected."""

    size: float
    """d' cov(d)^-1 d, over the scale of the noise: what makes that more than white, as
    the hysteresis of a sensor does, errs more in samples that were not fitted"""
    misfit: float
    """Root mean square of what another body leaves, over the noise."""


@immutable
class Expected:
    """What is known of the wrench of samples to come."""

    x: Array
    """(22,) parameters, bias at `end`, and its drift [1/s]"""
    covariance: Array
    """(22, 22)"""
    noise: Array
    """(6,) standard deviation of a sample's residual"""
    scale: Array
    """(n,) by `LENGTHS`: variance of the residual's mean over a window over that of
    white noise"""
    offset_std: float
    """[s] standard deviation of the clock offset that was removed"""
    end: float
    """[s] Last sample that was used."""

    @classmethod
    def of(cls, found: Ingested, known: Estimate | None = None) -> Self | None:
        """By the samples of a recording, beside what is `known` of the body from
        others; None where there are too few."""
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
        x = center + _solved(H, v, prior_std)[0]
        residual = z.wrench - X @ x
        scale = np.array([_scale(z, X, residual, noise, each) for each in LENGTHS])
        covariance = _solved(H / scale.max(), v, prior_std)[1]
        return replace(begin, x=x, covariance=covariance, scale=scale)

    def residual(self, z: Measurements) -> Array:
        """(K, 6) measured less expected wrench."""
        return z.wrench - self._columns(z) @ self.x

    def deviation(self, z: Measurements) -> Deviation | None:
        """The largest deviation of windows of samples (K,) that end with the last of
        them; None where there are too few."""
        found = [self.of_latest(z, length) for length in LENGTHS]
        return max(
            (each for each in found if each is not None),
            key=lambda each: each.size,
            default=None,
        )

    def of_latest(self, z: Measurements, length: float) -> Deviation | None:
        """The deviation of the latest `length` [s] of samples (K,); None where they do
        not fill that."""
        if not len(z):
            return None
        first = int(np.searchsorted(z.time, z.time[-1] - length))
        # up to a window that is full but for the samples' steps
        full = z.time[-1] - z.time[0] >= 0.9 * length
        if not full or len(z) - first < FEWEST:
            return None
        return self._deviation(z[slice(first, None)], float(self.scale.max()))

    def _deviation(self, z: Measurements, scale: float) -> Deviation:
        X = self._columns(z)
        expected = X @ self.x
        shifted = np.gradient(expected, z.time, axis=0) * self.offset_std
        r = z.wrench - expected
        off = np.abs(r - np.median(r, axis=0)) / self.noise
        kept = np.flatnonzero((off < SPIKE).all(axis=1))
        if 2 * len(kept) > len(r):
            X, r, shifted = X[kept], r[kept], shifted[kept]
            z = z[kept]  # type: ignore[index]
        w = _weights(z)
        A, W = X[:, :, :4], w[:, None] * self.noise**-2.0
        white = _inverse(np.einsum("kia,ki,kib->ab", A, W, A))
        M = white @ np.einsum("kia,ki,kib->ab", A, W, X)
        ahead = float(z.time[-1]) - self.end
        B = M[:, 10:16] * (WANDER * ahead)
        late = white @ np.einsum("kia,ki,ki->a", A, W, shifted)
        covariance = scale * white + M @ self.covariance @ M.T + B @ B.T
        covariance += np.outer(late, late)
        change = white @ np.einsum("kia,ki,ki->a", A, W, r)
        root = np.sqrt(W)
        left = _unexplained(X[:, :, :10] * root[:, :, None], r * root, abs(change[0]))
        size = float(change @ np.linalg.lstsq(covariance, change, rcond=1e-12)[0])
        return Deviation(size / scale, float(np.sqrt(np.square(left).mean())))

    def _columns(self, z: Measurements) -> Array:
        """(K, 6, 22) derivatives of the wrench."""
        body = (motion_features(z) @ FULL_MAP).reshape(len(z), 6, 10)
        bias = np.broadcast_to(np.eye(6), (len(z), 6, 6))
        drift = (z.time - self.end)[:, None, None] * bias
        return np.concatenate((body, bias, drift), axis=2)


def _unexplained(X: Array, r: Array, mass: float) -> Array:
    """(K, 6) what of r (K, 6) a body leaves whose inertia is one of its mass [kg], by
    the derivatives X (K, 6, 10); all over the noise."""
    X = X * np.repeat((1.0, 0.1, INERTIA_ARM**2 * mass), (1, 3, 6))
    H = np.einsum("kia,kib->ab", X, X)
    H += np.diag(np.repeat((1e-9 * np.trace(H), 1.0), (4, 6)))
    return r - X @ np.linalg.solve(H, np.einsum("kia,ki->a", X, r))


def _weights(z: Measurements) -> Array:
    """(K,) weights by the errors of the motion, none more than one."""
    return np.ones(len(z)) if z.weights is None else np.minimum(z.weights, 1.0)


def _solved(H: Array, v: Array, prior_std: Array) -> tuple[Array, Array]:
    """Solution (22,) and covariance (22, 22) of normal equations beside a prior about
    zero."""
    scaled = H * prior_std[:, None] * prior_std + np.eye(len(H))
    inverse = np.linalg.inv(scaled) * prior_std[:, None] * prior_std
    covariance = np.asarray(inverse, dtype=float)
    return covariance @ v, covariance


def _scale(z: Measurements, X: Array, r: Array, noise: Array, length: float) -> float:
    """Variance of d over that of white noise, in windows of the samples that it was
    found by."""
    begins = np.arange(float(z.time[0]), float(z.time[-1]) - length, length)
    first = np.searchsorted(z.time, begins)
    last = np.searchsorted(z.time, begins + length)
    W, total, number = _weights(z)[:, None] * noise**-2.0, 0.0, 0
    for i, j in zip(first, last, strict=True):
        if j - i < FEWEST:
            continue
        A = X[i:j, :, :4]
        v = np.einsum("kia,ki,ki->a", A, W[i:j], r[i:j])
        S = np.einsum("kia,ki,kib->ab", A, W[i:j], A)
        total += float(v @ _inverse(S) @ v) / 4.0
        number += 1
    return max((INITIAL_WINDOWS + total) / (INITIAL_WINDOWS + number), 1.0)


def _inverse(S: Array) -> Array:
    """Inverse of a positive matrix (4, 4) that may be near singular: a body at the
    origin of the axes."""
    units = np.diag((1.0, 0.1, 0.1, 0.1))
    scaled = units @ S @ units
    floor = 1e-9 * np.trace(scaled) * np.eye(4)
    return units @ np.linalg.inv(scaled + floor) @ units


@immutable
class Watch:
    """Whether the object is still the same."""

    onset: float | None = None
    """[s] When a deviation was seen first; None while there is none."""
    changed: bool = False
    """Whether it is another object."""
    rests: bool = False
    """Whether the poses have rested all the while, or repeat."""

    def looked(self, expected: Expected, z: Measurements) -> Self:
        """After a look at the latest samples (K,)."""
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
        """[s] Samples up to here are of the object; None where all are."""
        return None if self.onset is None else self.onset - LENGTHS[-1]


def _rests(gravity: Array) -> bool:
    """Whether gravity (K, 3) keeps its direction in sensor axes."""
    change = np.abs(gravity - gravity[-1]).max()
    return bool(change <= REST * np.linalg.norm(gravity[-1]))


def _is_body(expected: Expected, z: Measurements, lasted: float) -> bool:
    """Whether the latest samples deviate still, and another body explains all since the
    deviation began."""
    latest = expected.of_latest(z, LATEST)
    since = expected.of_latest(z, min(lasted, LENGTHS[-1]))
    return (
        latest is not None
        and since is not None
        and latest.size > STILL
        and since.misfit < LARGEST_MISFIT
    )
