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
"""

import numpy as np

from hefting.core.sensor_accuracy import SensorAccuracy
from hefting.core.spatial import Array
from hefting.estimators.bayes.colour import TimeSamples
from hefting.estimators.bayes.likelihood import Equations, Samples
from hefting.estimators.bayes.sensor_errors import slow_variances


def constant_errors(
    samples: Samples,
    equations: Equations,
    whole: Array,
    accuracy: SensorAccuracy,
    free_bias: bool,
) -> Array:
    """(10, 10) part of the score's covariance by gain, cross-talk, and an offset that
    is constant or varies with the load.

    Parameters
    ----------
    samples : all samples, without their mean where a bias is free.
    equations : theirs, with the whitening of the wrench.
    whole : (10,) parameters of all that the sensor holds.
    accuracy : of the sensor.
    free_bias : whether a constant bias is free.
    """
    W = equations.whitening
    A = (W.T @ W) @ samples.A  # (22, 6, 10): S^-1 A
    w = samples.A @ whole  # (22, 6)
    by_entry = np.tensordot(w.T, A, 1).transpose(1, 0, 2)  # (6, 6, 10): of M[c, d]
    load = _load(samples, w, whole, accuracy, free_bias)
    stds = np.hypot(
        accuracy.channel_stds,
        np.outer(accuracy.offset_std, 1.0 / accuracy.scale) / (12.0**0.5 * load),
    )
    rows = (stds[:, :, None] * by_entry).reshape(36, 10)
    common = accuracy.common_std * np.einsum("cci->i", by_entry)
    V = rows.T @ rows + np.outer(common, common)
    if not free_bias:
        constant = accuracy.offset_std[:, None] * samples.K * (W.T @ W @ samples.A_mean)
        V += constant.T @ constant
    return V


def slow_offsets(
    time: TimeSamples, samples: Samples, equations: Equations, accuracy: SensorAccuracy
) -> Array:
    """(10, 10) part of the score's covariance by an offset that changes slowly."""
    W = equations.whitening
    B = accuracy.offset_std[:, None] * (W.T @ W)
    information = time.scales.information(B)
    rows = (B @ samples.A).reshape(-1, 10)
    rest = rows.T @ rows - information.sum(axis=0)
    variances = slow_variances(
        0.5**0.5,
        1.0,
        time.samples,
        len(time.scales.counts),
        time.free_bias,
    )
    return np.tensordot(variances[:-1], information, 1) + variances[-1] * rest


def _load(
    samples: Samples,
    w: Array,
    whole: Array,
    accuracy: SensorAccuracy,
    free_bias: bool,
) -> float:
    """Root mean square of the wrench w (22, 6), in newtons a channel, gravity included;
    never zero."""
    square = float(np.sum((w / accuracy.scale) ** 2)) / samples.K
    if free_bias:
        square += float(np.sum((samples.A_mean @ whole / accuracy.scale) ** 2))
    return max((square / 6.0) ** 0.5, 1e-12)
