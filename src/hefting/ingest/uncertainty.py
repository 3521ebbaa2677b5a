"""Covariance of a fit whose residuals are coloured, and the offset that their spectrum makes most likely.

Least squares with normal matrix H and whitened columns B errs by H^-1 B'u. With the residuals u of a channel a
stationary process of spectrum S(f), the same for the three forces and for the three torques,

    cov = sum over channels of sum over f of S(f) Z(f) Z(f)^*,      Z = B H^-1,

in the unitary discrete Fourier transform. So the colour counts where the columns have their power: noise of the
sensor's own, and errors of the smoothed motion, which hardly have any at the motion's own frequencies. No colour
is counted twice, as it would be by weights that allow for it and an autocorrelation time on top.
Hannan, Multiple Time Series (1970), ch. VII. The spectrum is the residuals' periodogram, averaged over
neighbouring frequencies, over what of it the fit left: one less the leverage.

Weighed by 1/S the same sums give generalised least squares. The offset is taken from it: what a sensor gets wrong,
it gets wrong slowly, and a clock shows best in what is fast.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from hefting.core.spatial import Array
from hefting.ingest.fit import Fit, Layout

SEGMENT_LENGTH = 16384
"""Number of samples in one discrete Fourier transform; it bounds the memory. A power of two is fast to transform."""
TAPERED_SHARE = 0.1
"""Share of a segment's samples, at each end, over which it is tapered."""
FEWEST_AVERAGED_BINS = 5
"""Smallest number of neighbouring frequencies, to each side, over which the periodogram is averaged. At bin i it is
i / 3 where that is more."""
FORCE_AND_TORQUE = (slice(0, 3), slice(3, 6))
"""Channels of force and of torque. The channels of each share a spectrum."""


@dataclass(frozen=True, eq=False)
class Uncertainty:
    """How far the solution of a fit may be off."""

    fit: Fit
    """what it is of"""
    spectrum: Array
    """(F, 6) of its whitened residuals"""
    naive: Array
    """(q,) variances as if the residuals were white"""
    slow: float
    """variance of a whitened residual at the lowest frequencies: what sums of them go by"""
    bias: Array
    """(n, 6) standard deviations of the bias at its knots"""
    step: Array
    """(q,) from the fit to that of generalised least squares"""
    step_std: Array
    """(q,) standard deviations there; infinite where undetermined"""

    @property
    def layout(self) -> Layout:
        """Where each of the q unknowns stands."""
        return self.fit.model.layout

    @cached_property
    def covariance(self) -> Array:
        """(q, q) of phi, offset and tangents of gravity; infinite where undetermined."""
        q, parts = self.layout.core, _parts(len(self.fit.weights))
        covariance = np.zeros((q, q))
        for part in parts:
            covariance += _sum(self.spectrum, _transform(_influences(self.fit, part)))
        covariance *= _cover(self.fit, parts)
        open_ = np.isinf(self.naive)
        covariance[open_], covariance[:, open_] = 0.0, 0.0
        covariance[open_, open_] = np.inf
        return covariance

    @property
    def offset_std(self) -> float:
        """s, of an offset by generalised least squares; infinite where none was looked for."""
        return np.inf if self.layout.offset is None else float(self.step_std[self.layout.offset])

    @property
    def offset_step(self) -> float:
        """s, from the offset to that of generalised least squares; zero where none was looked for."""
        return 0.0 if self.layout.offset is None else float(self.step[self.layout.offset])

    @property
    def tilt_std(self) -> float:
        """rad times m/s², of gravity along each tangent; infinite where its direction was not looked for."""
        if self.layout.tilt is None:
            return np.inf
        return float(np.sqrt(np.mean(self.covariance.diagonal()[self.layout.tilt])))

    @property
    def mass_std(self) -> float:
        """kg"""
        return float(np.sqrt(max(self.covariance[0, 0], 0.0)))

    @property
    def inflation(self) -> Array:
        """(16,) variance of each parameter, and of the six components of a bias, over that of white residuals.

        1 where undetermined.
        """
        ratio, known = np.ones(16), np.isfinite(self.naive[:10]) & (self.naive[:10] > 0.0)
        ratio[:10][known] = self.covariance.diagonal()[:10][known] / self.naive[:10][known]
        ratio[10:] = self.slow
        return ratio


def uncertainty(fit: Fit, fastest: float = 0.5) -> Uncertainty:
    """Covariance of what a fit found; generalised least squares heeds frequencies up to `fastest` [1/sample]."""
    q, inverse, undetermined = fit.model.layout.core, fit.solution.inverse, fit.solution.undetermined
    own = inverse[:q, :q]
    stretches = [_Stretch.of(fit, part) for part in _parts(len(fit.weights))]
    root = _root(own)
    power, left = np.zeros_like(stretches[0].count), np.zeros_like(stretches[0].count)
    for s in stretches:
        leverage = _leverage(s.tapered, root)
        left += np.maximum(s.count - leverage, 0.2 * s.count)
        power += np.abs(s.residual) ** 2
    beyond = (fit.hats.n + 1) // 2 + 1  # below, the bias takes what there is
    left[:beyond], power[:beyond] = 0.0, 0.0
    spectra = [_smoothed(power[:, t].sum(axis=1), left[:, t].sum(axis=1)) for t in FORCE_AND_TORQUE]
    S = np.repeat(np.stack(spectra, axis=1), 3, axis=1)
    floor = np.maximum(S, 1e-6 * max(float(S.max()), 1e-300))
    floor[np.arange(len(S)) > fastest * 2 * (len(S) - 1)] = np.inf
    N, b = np.zeros((q, q)), np.zeros(q)
    for s in stretches:
        N += _sum(1.0 / floor, s.tapered)
        b += np.einsum("fcq,fc->q", s.tapered, s.residual.conj() / floor).real
    length = np.sqrt(np.maximum(N.diagonal(), 1e-300))
    inner = np.linalg.pinv(N / length / length[:, None], rcond=1e-10, hermitian=True) / length / length[:, None]
    step = own @ inner @ b
    step_variance = np.einsum("ij,jk,ik->i", own, inner, own)
    naive = own.diagonal().copy()
    open_ = undetermined[:q] | (6 * int(np.sum(fit.weights > 0.0)) < 2 * np.sum(~undetermined))
    naive[open_] = np.inf
    step_std = np.where(open_, np.inf, np.sqrt(np.maximum(step_variance, 0.0)))
    slow = float(S[: FEWEST_AVERAGED_BINS + 1].mean())
    std = np.sqrt(np.maximum(inverse.diagonal()[q:], 0.0) * slow)
    std[undetermined[q:]] = np.inf
    return Uncertainty(fit, S, naive, slow, std.reshape(fit.hats.n, 6), step, step_std)


@dataclass(frozen=True, eq=False)
class _Stretch:
    """Transforms of a row of samples; frequencies but the first and last stand for their negatives too."""

    residual: Array
    """(F, 6) whitened residuals, tapered"""
    tapered: Array
    """(F, 6, q) influences, tapered"""
    count: Array
    """(F, 6) what unit white residuals' power would be"""

    @classmethod
    def of(cls, fit: Fit, part: slice) -> "_Stretch":
        """Samples `part` of a fit."""
        length = part.stop - part.start
        weights = fit.weights[part]
        taper = _taper(length)[:, None]
        count = np.full((length // 2 + 1, 6), 2.0 * float(np.sum(taper[weights > 0.0] ** 2)) / length)
        count[0] *= 0.5
        residual = _transform(fit.residual[part] * _whitening(fit, part) * taper)
        return cls(residual, _transform(_influences(fit, part) * taper[:, :, None]), count)


def _whitening(fit: Fit, part: slice) -> Array:
    """(K, 6) by which residuals of some samples become unit ones."""
    return np.sqrt(fit.weights[part])[:, None] / np.repeat(fit.scale, 3)


def _influences(fit: Fit, part: slice) -> Array:
    """(K, 6, q) change of the q unknowns by each whitened sample: Z."""
    q = fit.model.layout.core
    own, bias = fit.solution.inverse[:q, :q], fit.solution.inverse[q:, :q]
    Z = (fit.columns[part].reshape(-1, q) @ own).reshape(-1, 6, q)
    Z += fit.hats.part(part).combine(bias.reshape(fit.hats.n, 6, q))
    Z *= _whitening(fit, part)[:, :, None]
    return Z


def _parts(K: int) -> list[slice]:
    """Stretches of one length, of nearly all samples."""
    length = min(K, SEGMENT_LENGTH)
    return [slice(start, start + length) for start in range(0, K - length + 1, length)]


def _cover(fit: Fit, parts: list[slice]) -> float:
    """Number of samples over that in the stretches."""
    return len(fit.weights) / sum(part.stop - part.start for part in parts)


def _taper(length: int) -> Array:
    """(K,) one, falling to zero at the ends: what is slow must not leak into what is fast."""
    u = np.minimum(np.arange(length) + 0.5, length - np.arange(length) - 0.5) / max(TAPERED_SHARE * length, 1.0)
    return np.sin(0.5 * np.pi * np.minimum(u, 1.0))


def _transform(values: Array) -> Array:
    length = len(values)
    turned = np.fft.rfft(values, axis=0) / np.sqrt(length)
    turned[1 : (length + 1) // 2] *= np.sqrt(2.0)
    return turned


def _root(own: Array) -> Array:
    """(q, k) X with X X' the pseudo-inverse of a positive semidefinite matrix (q, q)."""
    length = np.sqrt(np.maximum(own.diagonal(), 1e-300))
    values, vectors = np.linalg.eigh(own / length / length[:, None])
    good = values > 1e-15 * max(float(values[-1]), 1e-300)
    return vectors[:, good] / np.sqrt(values[good]) / length[:, None]


def _leverage(Z: Array, root: Array) -> Array:
    """(F, 6) what of unit white noise in each power the fit takes, of influences Z (F, 6, q)."""
    F, c, q = Z.shape
    flat = Z.reshape(-1, q)
    return (np.square(flat.real @ root) + np.square(flat.imag @ root)).sum(axis=1).reshape(F, c)


def _sum(weights: Array, Z: Array) -> Array:
    """(q, q) sum of weights (F, 6) times Z Z^* over frequencies and channels, Z (F, 6, q)."""
    flat = (Z * np.sqrt(weights)[:, :, None]).reshape(-1, Z.shape[2])
    return flat.real.T @ flat.real + flat.imag.T @ flat.imag


def _smoothed(power: Array, count: Array) -> Array:
    """Spectrum (F,): powers averaged over neighbouring frequencies, each average over its own count."""
    n = len(power)
    i = np.arange(n)
    half = np.maximum(FEWEST_AVERAGED_BINS, i // 3)
    low, high = np.maximum(i - half, 0), np.minimum(i + half + 1, n)
    sums, counts = (np.concatenate(([0.0], np.cumsum(x))) for x in (power, count))
    average = sums[-1] / max(counts[-1], 1e-300)
    weight = counts[high] - counts[low]
    return np.where(weight > 0.0, (sums[high] - sums[low]) / np.maximum(weight, 1e-300), average)
