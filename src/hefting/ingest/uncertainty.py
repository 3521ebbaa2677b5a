"""Covariance of a fit with coloured residuals, and the clock offset of generalised
least squares.

Least squares with normal matrix H and whitened design matrix B has the error H^-1 B'u.
With the residuals u of a channel a stationary process of spectrum S(f), the same for
the three forces and for the three torques,

    cov = sum over channels of sum over f of S(f) Z(f) Z(f)^*,      Z = B H^-1,

in the unitary discrete Fourier transform (Hannan, Multiple Time Series, 1970, ch. VII).
Coloured noise therefore counts at the frequencies at which the design matrix has its
power. The errors of smoothed motion have hardly any power at the motion's own
frequencies. No colour is counted twice, as it would be by weights for it together with
an autocorrelation time.

The spectrum is the periodogram of the residuals, averaged over neighbouring
frequencies, divided by the share of it
that the fit leaves: one less the leverage.

The same sums weighted by 1/S give generalised least squares. The clock offset is taken
from it: the errors of sensors are mostly slow, while the clock offset shows best in
fast changes.
"""

from functools import cached_property

import numpy as np

from hefting.core.spatial import Array, Mask, immutable
from hefting.ingest.fit import Fit
from hefting.ingest.model import Layout

SEGMENT_LENGTH = 16384
"""Number of samples in one discrete Fourier transform; it bounds the memory. A power of
two is fast to transform."""
TAPERED_SHARE = 0.1
"""Share of a segment's samples, at each end, over which it is tapered."""
FEWEST_AVERAGED_BINS = 5
"""Smallest number of neighbouring frequencies, to each side, over which the periodogram
is averaged. At bin i it is i / 3 where that is more."""
FORCE_AND_TORQUE = (slice(0, 3), slice(3, 6))
"""Channels of force and of torque. The channels of each share a spectrum."""


@immutable
class Uncertainty:
    """Covariance of a fit's solution for coloured residuals."""

    fit: Fit
    spectrum: Array
    """(F, 6) of its whitened residuals; white residuals of the fit's scale have 1"""
    naive: Array
    """(q,) variances of the unknowns for white residuals; infinite if undetermined"""
    slow: float
    """spectrum at lowest frequencies, which sets the variance of sums of residuals"""
    bias: Array
    """(n, 6) standard deviations of the bias at its knots [N, N m]; infinite where
    undetermined"""
    rise: Array | None
    """(6, 6) covariance of a linear drift, the bias at its last knot less that at its
    first [N², N² m, N² m²]; None without two determined knots"""
    step: Array
    """(q,) difference of the solution of generalised least squares from that of the
    fit"""
    step_std: Array
    """(q,) standard deviations of the solution of generalised least squares; infinite
    where undetermined"""

    @property
    def layout(self) -> Layout:
        """Position of each of the q unknowns."""
        return self.fit.model.layout

    @cached_property
    def covariance(self) -> Array:
        """(q, q) of parameters, offset and gravity's change along its tangents;
        infinite where undetermined."""
        q, segments = self.layout.core, _segments(len(self.fit.weights))
        covariance = np.zeros((q, q))
        for segment in segments:
            weights = np.sqrt(self.fit.weights[segment])
            influences = _influences(self.fit, segment, weights)
            covariance += _weighted_gram(self.spectrum, influences)
        covered = sum(segment.stop - segment.start for segment in segments)
        covariance *= len(self.fit.weights) / covered
        undetermined = np.isinf(self.naive)
        covariance[undetermined], covariance[:, undetermined] = 0.0, 0.0
        covariance[undetermined, undetermined] = np.inf
        return covariance

    @property
    def offset_std(self) -> float:
        """[s] of the offset of generalised least squares; infinite if not free."""
        if self.layout.offset is None:
            return np.inf
        return float(self.step_std[self.layout.offset])

    @property
    def offset_step(self) -> float:
        """[s] from the fit's offset to that of generalised least squares; zero if it is
        not free."""
        return (
            0.0 if self.layout.offset is None else float(self.step[self.layout.offset])
        )

    @property
    def tilt_std(self) -> float:
        """[m/s²] of gravity along each tangent, root mean square; infinite if its
        direction is not free."""
        if self.layout.tilt is None:
            return np.inf
        return float(np.sqrt(np.mean(self.covariance.diagonal()[self.layout.tilt])))

    @property
    def mass_std(self) -> float:
        """[kg]"""
        return float(np.sqrt(max(self.covariance[0, 0], 0.0)))

    @property
    def inflation(self) -> Array:
        """(16,) ratio of the variances of ten parameters and six bias components to
        those for white residuals; 1 where undetermined."""
        ratio = np.ones(16)
        known = np.isfinite(self.naive[:10]) & (self.naive[:10] > 0.0)
        ratio[:10][known] = (
            self.covariance.diagonal()[:10][known] / self.naive[:10][known]
        )
        ratio[10:] = self.slow
        return ratio


def estimate_uncertainty(fit: Fit, fastest: float = 0.5) -> Uncertainty:
    """Covariance of the solution of a fit, and its difference from generalised least
    squares.

    Parameters
    ----------
    fit : the fit, by least squares with q unknowns beside the bias.
    fastest : largest frequency used by generalised least squares [1/block].
    """
    q, inverse = fit.model.layout.core, fit.solution.inverse
    own = inverse[:q, :q]
    transforms = [
        _Transforms.of(fit, segment) for segment in _segments(len(fit.weights))
    ]
    S = _residual_spectrum(transforms, own, bias_functions=fit.hats.n)
    step, step_variance = _generalised_step(transforms, own, S, fastest)

    undetermined = _undetermined(fit)
    naive = own.diagonal().copy()
    naive[undetermined] = np.inf
    step_std = np.where(undetermined, np.inf, np.sqrt(np.maximum(step_variance, 0.0)))
    slow = float(S[: FEWEST_AVERAGED_BINS + 1].mean())
    bias_std = np.sqrt(np.maximum(inverse.diagonal()[q:], 0.0) * slow)
    bias_std[fit.solution.undetermined[q:]] = np.inf
    rise = _covariance_of_rise(fit, slow)
    return Uncertainty(
        fit, S, naive, slow, bias_std.reshape(fit.hats.n, 6), rise, step, step_std
    )


def _covariance_of_rise(fit: Fit, slow: float) -> Array | None:
    """`Uncertainty.rise`; `slow` is the spectrum at the lowest frequencies."""
    bias = slice(fit.model.layout.core, None)
    if fit.hats.n != 2 or fit.solution.undetermined[bias].any():
        return None
    rise = np.hstack((-np.eye(6), np.eye(6)))
    return slow * (rise @ fit.solution.inverse[bias, bias] @ rise.T)


def _undetermined(fit: Fit) -> Mask:
    """(q,) undetermined unknowns: all if there are fewer than two equations for each
    determined one."""
    undetermined = fit.solution.undetermined
    equations = 6 * int(np.sum(fit.weights > 0.0))
    return undetermined[: fit.model.layout.core] | (
        equations < 2 * np.sum(~undetermined)
    )


def _residual_spectrum(
    transforms: list["_Transforms"], own: Array, bias_functions: int
) -> Array:
    """(F, 6) spectrum of the whitened residuals; `own` (q, q) is the covariance of the
    unknowns for white residuals."""
    root = _inverse_root(own)
    power = np.zeros_like(transforms[0].count)
    remaining = np.zeros_like(transforms[0].count)
    for t in transforms:
        remaining += np.maximum(t.count - _leverage(t.influences, root), 0.2 * t.count)
        power += np.square(t.residual).sum(axis=0)
    first = (bias_functions + 1) // 2 + 1  # the bias fits lower frequencies
    remaining[:first], power[:first] = 0.0, 0.0
    spectra = [
        _average_over_neighbours(
            power[:, channels].sum(axis=1), remaining[:, channels].sum(axis=1)
        )
        for channels in FORCE_AND_TORQUE
    ]
    return np.repeat(np.stack(spectra, axis=1), 3, axis=1)


def _generalised_step(
    transforms: list["_Transforms"], own: Array, S: Array, fastest: float
) -> tuple[Array, Array]:
    """Change (q,) of the unknowns to generalised least squares with spectrum S (F, 6),
    and their variances (q,) there.

    Frequencies above `fastest` [1/block] are not used.
    """
    q = len(own)
    spectrum = np.maximum(S, 1e-6 * max(float(S.max()), 1e-300))
    spectrum[np.arange(len(S)) > fastest * 2 * (len(S) - 1)] = np.inf
    N, b = np.zeros((q, q)), np.zeros(q)
    for t in transforms:
        N += _weighted_gram(1.0 / spectrum, t.influences)
        b += np.einsum("pfcq,pfc->q", t.influences, t.residual / spectrum)
    length = np.sqrt(np.maximum(N.diagonal(), 1e-300))
    scaled = N / length / length[:, None]
    inverse = (
        np.linalg.pinv(scaled, rcond=1e-10, hermitian=True) / length / length[:, None]
    )
    return own @ inverse @ b, np.einsum("ij,jk,ik->i", own, inverse, own)


@immutable
class _Transforms:
    """Fourier transforms of a segment of samples, with real parts before imaginary
    ones. Frequencies except the first and last include their negatives."""

    residual: Array
    """(2, F, 6) whitened residuals, tapered"""
    influences: Array
    """(2, F, 6, q) influences of the samples on the unknowns, tapered"""
    count: Array
    """(F, 6) expected power of unit white residuals"""

    @classmethod
    def of(cls, fit: Fit, segment: slice) -> "_Transforms":
        """Of the blocks of a fit in `segment`."""
        length = segment.stop - segment.start
        taper = _taper(length)
        used = fit.weights[segment] > 0.0
        count = np.full(
            (length // 2 + 1, 6), 2.0 * float(np.sum(taper[used] ** 2)) / length
        )
        count[0] *= 0.5
        weights = np.sqrt(fit.weights[segment]) * taper
        whitened = fit.residual[segment] * weights[:, None] / np.repeat(fit.scale, 3)
        return cls(_transform(whitened), _influences(fit, segment, weights), count)


def _influences(fit: Fit, segment: slice, weights: Array) -> Array:
    """Fourier transform (2, F, 6, q) of the influences Z (K, 6, q): change of the q
    unknowns per unit of each whitened sample of a segment, which are multiplied by
    `weights` (K,), the square roots of the samples', tapered or not.

    Z is linear in the known row of a sample and in its hat functions: these few are
    transformed.
    """
    model, q, n = fit.model, fit.model.layout.core, fit.hats.n
    own, bias = fit.solution.inverse[:q, :q], fit.solution.inverse[q:, :q]
    hats = fit.hats.part(segment).values
    present = hats.any(axis=0)
    # the wrench, at the end of the known rows, is in no column
    rows = np.hstack((model.known[segment, :-6], hats[:, present])) * weights[:, None]
    maps = np.concatenate(
        (model.maps(fit.phi)[:-6] @ own, bias.reshape(n, 6, q)[present])
    )
    maps /= np.repeat(fit.scale, 3)[:, None]
    transformed = _transform(rows) @ maps.reshape(len(maps), -1)
    return transformed.reshape(*transformed.shape[:2], 6, q)


def _segments(K: int) -> list[slice]:
    """Consecutive segments of equal length that cover at least half of K samples."""
    length = min(K, SEGMENT_LENGTH)
    return [slice(start, start + length) for start in range(0, K - length + 1, length)]


def _taper(length: int) -> Array:
    """(K,) window that falls from one to zero at the ends, so that low frequencies do
    not leak into high ones."""
    from_end = np.minimum(np.arange(length) + 0.5, length - np.arange(length) - 0.5)
    u = from_end / max(TAPERED_SHARE * length, 1.0)
    return np.sin(0.5 * np.pi * np.minimum(u, 1.0))


def _transform(values: Array) -> Array:
    """Real and imaginary parts (2, F, d) of the unitary Fourier transform of values (K,
    d), scaled to include the negative frequencies."""
    length = len(values)
    transformed = np.fft.rfft(values, axis=0) / np.sqrt(length)
    transformed[1 : (length + 1) // 2] *= np.sqrt(2.0)
    return np.stack((transformed.real, transformed.imag))


def _inverse_root(own: Array) -> Array:
    """X (q, k), X X' the pseudo-inverse of a positive semidefinite matrix (q, q)."""
    length = np.sqrt(np.maximum(own.diagonal(), 1e-300))
    values, vectors = np.linalg.eigh(own / length / length[:, None])
    good = values > 1e-15 * max(float(values[-1]), 1e-300)
    return vectors[:, good] / np.sqrt(values[good]) / length[:, None]


def _leverage(Z: Array, root: Array) -> Array:
    """(F, 6) power that the fit removes from white residuals of unit variance, z X X'
    z^* for each frequency and channel: from the Fourier transform Z (2, F, 6, q) of the
    influences on the q unknowns, and the `root` (q, k) X of their covariance X X' for
    white residuals."""
    power = np.square(Z.reshape(-1, Z.shape[3]) @ root).sum(axis=1)
    return power.reshape(Z.shape[:3]).sum(axis=0)


def _weighted_gram(weights: Array, Z: Array) -> Array:
    """(q, q) sum of weights (F, 6) times Z Z^* over frequencies and channels."""
    flat = (Z * np.sqrt(weights)[:, :, None]).reshape(-1, Z.shape[3])
    return flat.T @ flat


def _average_over_neighbours(power: Array, count: Array) -> Array:
    """Spectrum (F,): ratio of sums over neighbouring frequencies of the power (F,) and
    of the expected counts (F,)."""
    n = len(power)
    i = np.arange(n)
    half = np.maximum(FEWEST_AVERAGED_BINS, i // 3)
    low, high = np.maximum(i - half, 0), np.minimum(i + half + 1, n)
    sums, counts = (np.concatenate(([0.0], np.cumsum(x))) for x in (power, count))
    average = sums[-1] / max(counts[-1], 1e-300)
    weight = counts[high] - counts[low]
    return np.where(
        weight > 0.0, (sums[high] - sums[low]) / np.maximum(weight, 1e-300), average
    )
