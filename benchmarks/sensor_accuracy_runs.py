"""One recording of a sensor with errors of gain, cross-talk and offset, identified by
each method that is told how large they are."""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np
from scipy.signal import lfilter

from benchmarks.bodies import Body
from benchmarks.calibration_runs import LEVELS
from benchmarks.method_runs import MethodRun, judged, methods_for, recorded
from hefting.core.errors import NotIdentifiableError
from hefting.core.measurements import NOISE_LEVELS, Measurements
from hefting.core.sensor_accuracy import SensorAccuracy
from hefting.core.spatial import Array
from hefting.estimators import Bayes, Estimator

SLOW_SHARE = 0.25
"""Correlation time of the offset that varies, over the length of the recording."""


def identified(
    body: Body, accuracy: SensorAccuracy | None, seed: tuple[int, ...], others: bool
) -> list[MethodRun]:
    """Wield a body once more and identify it: by Bayes with the shape and without, and
    by the `others`.

    The sensor's errors have the size of `accuracy`, which every method is told; None:
    the size of the default, of which nothing is told. Every second recording has a bias
    that is found.
    """
    z, free_bias = measured(body, accuracy, seed)
    runs: list[MethodRun] = []
    for name, estimator in methods(body, others):
        told = replace(
            estimator,
            bias="estimate" if free_bias else "none",
            sensor_accuracy=accuracy,
        )
        try:
            run = judged(body, told.fit(z), free_bias)
        except NotIdentifiableError:
            continue
        runs.append(replace(run, method=name))
    return runs


def measured(
    body: Body, accuracy: SensorAccuracy | None, seed: tuple[int, ...]
) -> tuple[Measurements, bool]:
    """A body wielded once more, by a sensor of an accuracy as for `identified`, and
    whether there is a bias to be found."""
    rng = np.random.default_rng(seed)
    level = NOISE_LEVELS[LEVELS[rng.integers(len(LEVELS))]]
    z = recorded(body, "white", level, seed, rng)
    free_bias = bool(rng.integers(2))
    size = SensorAccuracy.parse("0.5%") if accuracy is None else accuracy
    z = with_sensor_errors(z, size, rng, constant=not free_bias)
    if free_bias:
        bias = rng.normal(size=6) * np.repeat((10.0, 0.3), 3)
        z = replace(z, force=z.force + bias[:3], torque=z.torque + bias[3:])
    return z, free_bias


def methods(body: Body, others: bool) -> Iterator[tuple[str, Estimator]]:
    """Bayes with the body's shape and without, and the `others`."""
    yield "Bayes, shape", Bayes(body.shape)
    yield "Bayes, no shape", Bayes()
    if others:
        for method in methods_for(body):
            yield method.name, method


def with_sensor_errors(
    z: Measurements,
    accuracy: SensorAccuracy,
    rng: np.random.Generator,
    *,
    constant: bool,
) -> Measurements:
    """The samples as a sensor of this accuracy would have measured them.

    How much of the gains' errors all channels share is unknown: it is drawn evenly. The
    offset varies slowly and with the load; where it is `constant` too, that part is as
    large as both together.
    """
    wrench, scale = z.wrench, accuracy.scale
    offset = accuracy.offset_std
    load = wrench / scale / np.sqrt(np.mean((wrench / scale) ** 2))
    varying = (load @ (rng.normal(size=(6, 6)) / 6.0**0.5)) + _slow(len(z), rng)
    wrong = wrench @ error_matrix(accuracy, rng).T + varying * offset / 2.0**0.5
    if constant:
        wrong = wrong + rng.normal(size=6) * offset
    return replace(z, force=z.force + wrong[:, :3], torque=z.torque + wrong[:, 3:])


def error_matrix(accuracy: SensorAccuracy, rng: np.random.Generator) -> Array:
    """M (6, 6): gains, of which a random share of the variance is common to all
    channels, and cross-talk."""
    common = rng.uniform()
    M = rng.normal(size=(6, 6)) * accuracy.channel_stds
    own = rng.normal(size=6) * (1.0 - common) ** 0.5
    np.fill_diagonal(M, accuracy.gain_std * (own + rng.normal() * common**0.5))
    return M


def _slow(samples: int, rng: np.random.Generator) -> Array:
    """(K, 6) first-order processes of variance 1."""
    rho = np.exp(-1.0 / (SLOW_SHARE * samples))
    new = rng.normal(size=(samples, 6)) * np.sqrt(1.0 - rho**2)
    new[0] /= np.sqrt(1.0 - rho**2)
    return np.asarray(lfilter([1.0], [1.0, -rho], new, axis=0))
