"""Errors of the sensor's calibration: gain, cross-talk and offset, which are the same
for all samples of a recording or change slowly.

With the accuracy a sensor is said to have (`hefting.core.sensor_accuracy`) the measured
wrench is (1 + M) w + b. To the score h - H phi it adds, S the covariance of a sample's
residual and A_k, w_k its regressor and true wrench,

    sum_k A_k' S^-1 (M w_k + b_k),

which is linear in M. Its covariance, a part of V (`likelihood`), is a sum over the
entries of M: it grows with the square of the number of samples, so that more of them do
not lessen what it does to the parameters. The offset has a constant part, which a free
bias takes away, and one that varies: half of its variance with the load, as a part of
M, and half slowly with time.

A part of these errors shows in the residuals of least squares. What is expected there
is not counted once more as noise, nor as a contradiction between stretches.
"""

from typing import Self

import numpy as np

from hefting.core.regressor import FEATURES
from hefting.core.sensor_accuracy import SensorAccuracy
from hefting.core.spatial import Array, immutable, median
from hefting.estimators.bayes.groups import Groups, combined
from hefting.estimators.bayes.likelihood import Equations
from hefting.estimators.bayes.samples import Samples
from hefting.estimators.bayes.time_samples import TimeSamples


@immutable
class CalibrationErrors:
    """Effect of errors of the sensor's calibration on the score of a recording."""

    score: Array
    """(10, 10) covariance of the score by the constant errors"""
    entries: Array
    """(6, 6) standard deviations of the entries of M, with the offset that varies with
    the load and without the gain that all channels share"""
    by_entry: Array
    """(6, 6, 10) score by each entry of M"""
    inverse: Array
    """(10, 10) inverse of the information of all samples"""
    slow: Array
    """(6,) standard deviations of the offset that varies slowly [N, N m]"""
    precision: Array
    """(6, 6) S^-1"""
    whole: Array
    """(10,) parameters of all that the sensor holds"""

    @classmethod
    def of(
        cls,
        samples: Samples,
        equations: Equations,
        whole: Array,
        accuracy: SensorAccuracy,
        free_bias: bool,
    ) -> Self:
        """Errors of a sensor of some `accuracy` that holds a body `whole` (10,)."""
        W = equations.whitening
        precision = W.T @ W
        w = (samples.by_channel.reshape(-1, 10) @ whole).reshape(6, -1)
        A = (precision @ samples.by_channel).reshape(6, -1, 10)
        by_entry = w @ A
        entries, offset = accuracy.channel_stds, accuracy.force or accuracy.torque
        if offset:
            square = float(np.sum((w.T / accuracy.scale) ** 2)) / samples.K
            if free_bias:
                square += samples.constant_load(np.diag(1.0 / accuracy.scale), whole)
            load = max((square / 6.0) ** 0.5, 1e-12)  # root mean square of a channel
            with_load = np.outer(accuracy.offset_std, 1.0 / accuracy.scale)
            entries = np.hypot(entries, with_load / (12.0**0.5 * load))
        rows = (entries[:, :, None] * by_entry).reshape(36, 10)
        common = accuracy.gain_std * by_entry.reshape(36, 10)[::7].sum(axis=0)
        score = rows.T @ rows + common[:, None] * common
        if offset and not free_bias:
            constant = samples.K * (precision @ samples.A_mean[0])
            constant = accuracy.offset_std[:, None] * constant
            score += constant.T @ constant
        return cls(
            score,
            entries,
            by_entry,
            equations.inverse,
            accuracy.offset_std * 0.5**0.5,
            precision,
            whole,
        )

    def slow_score(self, time: TimeSamples, samples: Samples) -> Array:
        """(10, 10) covariance of the score by the offset that varies slowly."""
        if not self.slow.any():
            return np.zeros((10, 10))
        B = self.slow[:, None] * self.precision
        information = time.scales.information(B)
        rows = (B @ samples.by_channel).reshape(-1, 10)
        rest = rows.T @ rows - information.sum(axis=0)
        return combined(time.slow[:-1], information) + time.slow[-1] * rest

    def residual_variances(self, time: TimeSamples) -> Array:
        """(J + 1,) expected variances by these errors of the whitened residuals, a channel
        on average, at each time scale and beyond."""
        energies = self._left(time.scales)[1].reshape(-1, 36)
        by_entries = energies @ np.square(self.entries).ravel()
        by_entries /= 6.0 * np.maximum(time.scales.counts, 1.0)
        by_slow_offset = float(self.precision.diagonal() @ self.slow**2) / 6.0
        variances = by_slow_offset * time.slow
        variances[:-1] += by_entries
        return variances

    def of_stretches(self, time: TimeSamples) -> Array:
        """(g, 10, 10) covariance of the stretches' scores at least squares."""
        off = self.entries[:, :, None] * self._left(time.stretches)[0]
        rows = off.reshape(len(off), 36, 10)
        found = rows.transpose(0, 2, 1) @ rows
        if self.slow.any():
            length = median(time.stretches.counts) + 1.0
            level = min(int(np.log2(length)), len(time.slow) - 1)
            B = self.slow[:, None] * self.precision
            found += time.slow[level] * time.stretches.information(B)
        return found

    def _left(self, groups: Groups) -> tuple[Array, Array]:
        """Score (g, 6, 6, 10) and energy (g, 6, 6) of the whitened residuals of least
        squares by each entry of M, per unit of it, in each group."""
        g = len(groups.counts)
        A = groups.A.reshape(g, 6 * FEATURES, 10)
        B = groups.whitened(self.precision)
        w = (A @ self.whole).reshape(g, 6, FEATURES)
        score = w[:, None] @ B.reshape(g, 6, FEATURES, 10)
        information = A.transpose(0, 2, 1) @ B
        fitted = self.by_entry @ self.inverse  # parameters by each entry
        taken = (fitted.reshape(36, 10) @ information).reshape(g, 6, 6, 10)
        energy = self.precision.diagonal()[:, None] * np.square(w).sum(axis=2)[:, None]
        energy = energy - np.einsum("gcdi,cdi->gcd", 2.0 * score - taken, fitted)
        return score - taken, np.maximum(energy, 0.0)
