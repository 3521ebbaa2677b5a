"""The paper's eight objects after 150 observations, their motion from noisy poses; see
`benchmarks.accuracy`."""

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from benchmarks.cramer_rao import Scale, bound
from hefting.core.estimate import Estimate
from hefting.core.measurements import NOISE_LEVELS, Measurements
from hefting.core.spatial import Array, tensor_to_vector
from hefting.estimators import PMD, Bayes
from hefting.ingest.free_fit import fit_freely
from hefting.motion import sample_weights
from hefting.motion.spline import fit_poses
from hefting.motion.state import Motion
from hefting.reproduction.experiment import (
    C1,
    DURATION,
    OBJECTS,
    RATE,
    Thing,
    thing,
    wielded,
)
from hefting.reproduction.filtered import Observed, causal_filter, windows
from hefting.simulation import WRENCH_NOISE

NOISE = "moderate"
"""Of the wrench."""
SPEEDS = (1.0, 1.5, 2.0)
"""Average angular speeds [rad/s]."""
SETTINGS = {
    "warm": "causal filter that has settled before the window",
    "smoothed": "window on its own, smoothed; the motion exact, its samples weighted, as `hefting identify` has it",
    "smoothed, std": "the same with the smoother's standard deviations and bandwidth, unweighted",
    "cold": "causal filter that begins with the window",
}
"""Where the motion comes from, and what Bayes is told of it."""


@dataclass(frozen=True, eq=False)
class Run:
    """What came of one window."""

    errors: Array
    """(3,) [%] of mass, COM and inertia about the sensor, by Bayes"""
    pmd: Array
    """the same by PMD"""
    held: Array
    """(10,) whether the 95 % intervals of mass, COM and inertia hold the truth"""
    known: Array
    """(3,) mean errors [%] at the Cramér-Rao bound where the motion is known"""
    claimed: Array
    """the same with the motion's noise, as the filter or smoother claims it"""


def runs(speed: float, seed: int, duration: float = DURATION) -> dict[str, list[Run]]:
    """Every window of every object at one speed with one realisation of the noise, by
    setting."""
    found: dict[str, list[Run]] = {name: [] for name in SETTINGS}
    for index, name in enumerate(OBJECTS):
        subject, exact = thing(name), wielded(name, speed, duration=duration)
        observed = Observed.of(
            exact, WRENCH_NOISE[NOISE], (seed, index, round(10 * speed))
        )
        for setting, window, z, motion in seen(observed):
            z = informed(setting, z, motion)
            bayes = Bayes(subject.shape)
            found[setting].append(
                compared(
                    subject,
                    bayes,
                    z,
                    least_errors(subject, exact.measurements[window], motion),
                )
            )
    return found


def seen(observed: Observed) -> Iterator[tuple[str, slice, Measurements, Motion]]:
    """Setting, window, and in it the measurements and where their motion is from."""
    live = causal_filter(observed)
    begun = replace(live, cold_start=True)
    _, followed = live.update(
        live.start(), observed.time, observed.position, observed.orientation
    )
    settled = observed.with_motion(followed)
    missing = len(observed.time) - len(settled)  # before it had settled
    for window in windows(len(observed.time) / RATE):
        part = observed[window]
        later = slice(window.start - missing, window.stop - missing)
        yield "warm", window, settled[later], followed[later]
        smooth = fit_poses(part.time, part.position, part.orientation).at(part.time)
        z = part.with_motion(smooth)
        yield "smoothed", window, replace(z, weights=_weights(z, smooth)), smooth
        yield "smoothed, std", window, z, smooth
        _, cold = begun.update(
            begun.start(), part.time, part.position, part.orientation
        )
        yield "cold", window, part.with_motion(cold), cold


def _weights(z: Measurements, motion: Motion) -> Array:
    """(K,) of samples, less where the motion is less certain."""
    fit = fit_freely(z, False)
    weights = sample_weights(fit.vector, motion, fit.noise.force, fit.noise.torque)
    return weights / weights.mean()


def informed(setting: str, z: Measurements, motion: Motion) -> Measurements:
    """The samples with what is known of their motion; the wrench's noise and its colour
    a state finds."""
    return z if setting == "smoothed" else replace(z, motion_noise=motion.noise)


def memory(motion: Motion) -> float:
    """Samples over which errors of a filter's or smoother's accelerations last
    (docs/bayes.md)."""
    return max(np.pi * RATE / motion.bandwidth, 1.0)


def _squares(motion: Motion) -> tuple[Array, Array]:
    """Claimed variances (K,) of linear and angular acceleration."""
    assert motion.linear_acceleration_std is not None
    return np.square(motion.linear_acceleration_std), np.square(
        motion.angular_acceleration_std
    )


def least_errors(
    subject: Thing, exact: Measurements, motion: Motion
) -> tuple[Array, Array]:
    """Mean errors (3,) [%] at the bound, the motion known, and with its noise as
    claimed."""
    held, level = subject.held, NOISE_LEVELS[NOISE]
    scale = Scale(held.parameters, held.extents, held.pose[:3, :3])
    wrench = np.repeat(np.square((level.force, level.torque)), 3)
    claimed = memory(motion) * np.repeat(np.column_stack(_squares(motion)), 3, axis=1)
    each = (
        bound(exact, held.parameters, wrench),
        bound(exact, held.parameters, wrench, claimed),
    )
    return scale.mean_errors(each[0]), scale.mean_errors(each[1])


def compared(
    subject: Thing, bayes: Bayes, z: Measurements, bounds: tuple[Array, Array]
) -> Run:
    """Bayes beside PMD, which sees no weights; `bounds` are those of `least_errors`."""
    estimate, truth = bayes.fit(z), subject.held.parameters
    pmd = PMD(subject.shape, c1=C1).fit(replace(z, weights=None))
    assert estimate.intervals is not None
    held = []
    for name in ("mass", "center_of_mass", "inertia_at_origin"):
        (low, high), true = estimate.intervals[name], getattr(truth, name)
        inside = np.atleast_1d((low <= true) & (true <= high))
        held.append(tensor_to_vector(inside) > 0.0 if inside.ndim == 2 else inside)
    return Run(
        _errors(subject, estimate), _errors(subject, pmd), np.concatenate(held), *bounds
    )


def _errors(subject: Thing, estimate: Estimate) -> Array:
    e = subject.errors(estimate)
    return np.array((e.mass, e.center_of_mass, e.inertia_at_origin))
