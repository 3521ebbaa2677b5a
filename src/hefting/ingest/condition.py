"""Conditioning: clock offset, bias, sign and outliers of a recording by a robust fit, and
gravity's direction."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike

from hefting.core.measurements import Noise
from hefting.core.progress import report
from hefting.core.recording import Recording
from hefting.core.spatial import (
    STANDARD_GRAVITY,
    Array,
    check_gravity,
    immutable,
    squared_lengths,
)
from hefting.estimators.timescales import autocorrelation_time
from hefting.ingest.blocks import Blocks, medians, within_blocks
from hefting.ingest.changes.find import find_changes
from hefting.ingest.conditioned import (
    Conditioned,
    GravityEstimate,
    WrenchSign,
    mass_over_std,
)
from hefting.ingest.drift import Drift, candidates
from hefting.ingest.findings import RejectedOffset, findings_of, warnings_of
from hefting.ingest.fit import Fit, gauss_newton
from hefting.ingest.model import Problem
from hefting.ingest.offset_profile import OffsetProfile, profile_of
from hefting.ingest.outliers import Outliers
from hefting.ingest.path import WORLD_AXES_COLUMNS, Path, path_of, static_path
from hefting.ingest.response import felt_path
from hefting.ingest.robust_fit import (
    RobustFit,
    fastest_frequency,
    fit_few_samples,
    fit_robustly,
    offset_is_significant,
    remove_offset,
)
from hefting.ingest.samples import (
    Samples,
    find_outliers_of_fit,
    find_outliers_piecewise,
)
from hefting.ingest.uncertainty import estimate_uncertainty
from hefting.ingest.weights import may_be_acceleration
from hefting.motion import smooth_poses
from hefting.motion.measure import Source
from hefting.motion.state import effect_of_acceleration_errors

MOST_FITTED_SAMPLES = 100_000
"""Largest number of samples that are fitted directly; of longer recordings block
medians are fitted."""
MOST_FITTED_BLOCKS = 10_000
"""Largest number of block medians that are fitted; of more, evenly chosen ones."""
FEWEST_CONDITIONED_SAMPLES = 12
"""Number of samples below which a recording is not conditioned."""
GRAVITY_INSTANTS = 2000
"""Number of instants of gravity's direction from which its autocorrelation is found."""
KNOT_SPACING_IN_CORRELATION_TIMES = 3.0
"""Smallest distance between bias knots, in autocorrelation times of gravity's direction
in sensor axes."""
SHORTEST_CONDITIONED_RECORDING = 1.0
"""[s] In shorter recordings offset, bias and gravity cannot be distinguished, and no
offset or gravity is estimated."""
BLOCKS_FOR_GRAVITY = 5_000
"""Number of blocks used for finding gravity's direction."""


@immutable
class _Found:
    """The robust fit of a recording, and what was found beside it."""

    fit: RobustFit
    rejected_offset: RejectedOffset | None = None
    gravity: GravityEstimate | None = None
    few_samples: bool = False
    """whether there were too few samples to condition"""
    another_lag: float = 0.0
    """[s] a longer lag of the wrench with about the same residuals, less the one found"""


def condition(
    recording: Recording,
    gravity: ArrayLike = STANDARD_GRAVITY,
    source: Source = "auto",
    *,
    clock: bool = True,
    tilt: bool = False,
    hint: bool = False,
    changes: bool = True,
) -> Conditioned:
    """Find clock offset, drifting bias, sign and outliers of a recording and, if asked
    for, gravity's direction.

    Parameters
    ----------
    recording : the recording, with a wrench and orientations.
    gravity : (3,) in world axes [m/s²]; with `tilt` its direction is only the start of
        the search.
    source : where the motion comes from, as for `hefting.motion.measure.measure`.
    clock : whether to look for an offset between wrench and motion.
    tilt : whether to estimate gravity's direction. The errors of a sensor change it by
        a few degrees.
    hint : whether to estimate, for information, gravity's direction even where it is
        given.
    changes : whether to look for changes of the object. The rest of the result is that
        of one body in all of the recording, whatever is found.

    What cannot be found counts as absent, with a warning. Raises `InputError` where
    `hefting.motion.measure.measure` does.

    Examples
    --------
    >>> found = hefting.condition(hefting.read_log("demo/log.csv"))
    >>> found.sign.name
    'on-object'
    """
    g = check_gravity(gravity)
    wrench = recording["wrench"]
    report("smoothing the motion")
    path = path_of(recording, source, g)
    moving = path is not None
    if path is None:
        path = static_path(recording)
    samples = Samples(wrench.time, wrench.values, path.kind == "static", path.smooth)
    time = samples.time[(samples.time >= path.first) & (samples.time <= path.last)]
    if len(time) < FEWEST_CONDITIONED_SAMPLES:
        problem = Problem(path, samples.blocks(), False, False, (1,))
        found = _Found(fit_few_samples(samples, problem, g), few_samples=True)
        return _conclude(recording, samples, found, clock=clock, tilt=tilt)
    long = recording.static or bool(np.ptp(time) >= SHORTEST_CONDITIONED_RECORDING)
    working = _thinned(samples)
    free_gravity = tilt and long and not path.gravity_measured
    knots = _numbers_of_knots(path, time, g)
    problem = Problem(
        path, working.blocks(), clock and moving and long, free_gravity, knots
    )
    report("finding sign, delay, bias and outliers")
    found = _fit(working, problem, g)
    fit = found.fit
    asked = hint and long and not samples.static
    if asked and not (free_gravity or path.gravity_measured):
        found = replace(found, gravity=_estimate_gravity(working, fit))
    if working is not samples:
        outliers = find_outliers_piecewise(samples, fit.problem, fit.fit)
        found = replace(found, fit=replace(fit, outliers=outliers))
    result = _conclude(recording, samples, found, clock=clock, tilt=tilt)
    if not changes or may_be_acceleration(recording, result):
        return result
    report("looking for changes of the object")
    return replace(result, changes=find_changes(working, fit, recording.start))


def _thinned(samples: Samples) -> Samples:
    """The samples, or medians of some blocks of a long recording."""
    if len(samples.time) <= MOST_FITTED_SAMPLES:
        return samples
    blocks = samples.blocks()
    nth = blocks.step_of(MOST_FITTED_BLOCKS)
    typical = medians(samples.wrench, blocks.starts, nth)
    return Samples(blocks.time[::nth], typical, samples.static, smooth=False)


def _fit(samples: Samples, problem: Problem, gravity: Array) -> _Found:
    """The robust fit, with the clock offset if it is free and accepted, and with a
    filtered motion if that is clearly better."""
    first, found = fit_robustly(samples, problem, gravity)
    if (felt := felt_path(samples, found)) is not None:
        first, found = fit_robustly(samples, replace(problem, path=felt), gravity)
    profile = None
    if not first.problem.free_offset:
        return _Found(found)
    if offset_is_significant(found):
        profile = profile_of(found)
        if profile is None or profile.doubt() is None:
            return _Found(found, another_lag=_another_lag(profile))
    rejected = RejectedOffset(found.fit.offset, found.uncertainty.offset_std, profile)
    return _Found(remove_offset(samples, gravity, first, found), rejected)


def _another_lag(profile: OffsetProfile | None) -> float:
    if profile is None or not profile.has_rival:
        return 0.0
    return profile.rival[0] - profile.offset


def _numbers_of_knots(path: Path, time: Array, gravity: Array) -> tuple[int, ...]:
    """Numbers of bias knots to choose from; a bias that varies as fast as gravity would
    fit the object's weight."""
    duration = float(time[-1] - time[0])
    numbers = (1,) if path.kind == "static" else candidates(duration, 0.0)
    if max(numbers) <= 2:  # these are the same however fast gravity varies
        return numbers
    times = np.linspace(time[0], time[-1], GRAVITY_INSTANTS)
    reading = path.at(times, spread=False)
    if not reading.known.any():
        return (1,)
    in_sensor_axes = reading.value[:, WORLD_AXES_COLUMNS].reshape(-1, 3, 3) @ gravity
    correlation_time = autocorrelation_time(in_sensor_axes[reading.known]) * (
        times[1] - times[0]
    )
    return candidates(duration, KNOT_SPACING_IN_CORRELATION_TIMES * correlation_time)


def _estimate_gravity(samples: Samples, found: RobustFit) -> GravityEstimate | None:
    """Gravity by a fit with its direction free, which starts from that with gravity as
    given; None where the direction is undetermined."""
    knots = found.fit.hats.n
    typical = samples.blocks().with_medians(samples.wrench)
    problem = replace(found.problem, blocks=typical, free_gravity=True).every(
        BLOCKS_FOR_GRAVITY
    )
    fit = gauss_newton(problem, found.fit.start, knots, robust=True, steps=8)
    time, wrench = problem.time, problem.wrench
    chosen = Samples(time, wrench, static=False, smooth=False)
    blocks = Blocks(time, np.zeros(len(time)), np.ones(len(time)), wrench)
    problem = replace(problem, blocks=blocks)
    for _ in range(2):
        outliers = find_outliers_of_fit(chosen, problem, fit)
        problem = replace(
            problem, blocks=replace(blocks, count=(~outliers.rejected).astype(float))
        )
        fit = gauss_newton(problem, fit.start, knots, steps=8)
    uncertainty = estimate_uncertainty(fit, fastest_frequency(problem))
    std = uncertainty.tilt_std / float(np.linalg.norm(fit.gravity))
    if not np.isfinite(std):
        return None
    return GravityEstimate(fit.gravity, std)


def _conclude(
    recording: Recording, samples: Samples, found: _Found, *, clock: bool, tilt: bool
) -> Conditioned:
    """The result, with the sign convention of `hefting.core.spatial`; `clock` and
    `tilt` as for `condition`."""
    problem, fit, uncertainty = found.fit.problem, found.fit.fit, found.fit.uncertainty
    outliers, path, rejected = found.fit.outliers, problem.path, found.rejected_offset
    sign = _sign(found.fit)
    has_clock = clock and path.moves
    offset_std, offset_left = uncertainty.offset_std, 0.5 * found.another_lag
    if rejected is not None:
        offset_std = rejected.std
        offset_left = rejected.left if rejected.contradictory else 0.0
    tilt_std, curves = None, path.curves
    if tilt and not path.gravity_measured:
        tilt_std = uncertainty.tilt_std / float(np.linalg.norm(fit.gravity))
    if tilt_std is not None and np.isfinite(tilt_std) and curves is not None:
        # curves that use an accelerometer depend on gravity
        curves = smooth_poses(recording, fit.gravity, curves.alone)
    result = Conditioned(
        parameters=fit.phi if sign.on_object else -fit.phi,
        covariance=uncertainty.covariance[:10, :10],
        offset=fit.offset if problem.free_offset else 0.0,
        offset_std=offset_std if has_clock else None,
        sign=sign,
        bias=_drift(found.fit),
        biased=found.fit.biased,
        gravity=fit.gravity,
        tilt_std=tilt_std,
        tilted=found.gravity,
        noise=_estimate_noise(samples, problem, fit, outliers),
        rejected=outliers.rejected,
        reasons={cause: int(mask.sum()) for cause, mask in vars(outliers).items()},
        inflation=uncertainty.inflation,
        findings=(),
        offset_left=offset_left if has_clock else 0.0,
        path=path,
        curves=curves,
        outliers=outliers,
    )
    return replace(
        result,
        findings=findings_of(result, recording, outliers, rejected),
        warnings=warnings_of(result, rejected, tilt=tilt, enough=not found.few_samples),
    )


def _drift(found: RobustFit) -> Drift:
    """The bias as recorded, with infinite deviations where it is undetermined."""
    fit, uncertainty = found.fit, found.uncertainty
    used = (fit.weights > 0.0) * found.problem.blocks.count
    mean = used @ fit.bias_now / max(used.sum(), 1.0)
    std, rise = uncertainty.bias, uncertainty.rise
    if not found.biased:
        std, rise = np.full_like(fit.bias, np.inf), None
    return Drift(fit.hats.knots, fit.bias, std, mean, rise)


def _sign(found: RobustFit) -> WrenchSign:
    """The sign convention by the sign of the mass; t is 0 where the mass is undetermined
    or no bias was determined beside it."""
    mass = float(found.fit.phi[0])
    doubtful = found.mass_is_open or not found.biased
    return WrenchSign(
        bool(mass >= 0.0),
        0.0 if doubtful else mass_over_std(mass, found.uncertainty.mass_std),
    )


def _estimate_noise(
    samples: Samples, problem: Problem, fit: Fit, outliers: Outliers
) -> Noise:
    """Noise of a sample of the wrench, less the effect of the motion's errors on its
    residual, and noise of the accelerations."""
    used = fit.weights > 0.0
    unknowns = len(fit.phi) / 6.0 + fit.hats.n
    correction = used.sum() / max(used.sum() - unknowns, 1.0)
    square = _mean_squared_residual(samples, problem, fit, outliers)
    square = np.maximum(square, problem.floor**2) * correction
    within = within_blocks(
        problem.blocks, samples.time, samples.wrench, ~outliers.rejected
    )
    square = square + within.diagonal().reshape(2, 3).mean(axis=1)
    variances = (
        fit.model.reading.variances[:, used].mean(axis=1) if used.any() else np.zeros(2)
    )
    effect = effect_of_acceleration_errors(fit.phi) @ variances / 3.0
    force, torque = np.sqrt(np.maximum(square - effect, 0.01 * square))
    return Noise(
        float(force),
        float(torque),
        float(variances[0] ** 0.5),
        float(variances[1] ** 0.5),
    )


def _mean_squared_residual(
    samples: Samples, problem: Problem, fit: Fit, outliers: Outliers
) -> Array:
    """(2,) mean squared residual of one axis of the force [N²] and of the torque
    [N² m²], without blocks of weight zero and samples that are outliers."""
    count = np.where(fit.weights > 0.0, problem.blocks.count, 0.0)
    residual = fit.residual
    medians_were_fitted = problem.blocks.starts is None and len(samples.time) > len(
        problem.time
    )
    if medians_were_fitted:  # a median has less noise than the sample next to it
        next_sample = np.minimum(
            np.searchsorted(samples.time, problem.time), len(samples.time) - 1
        )
        fitted_wrench = problem.wrench - fit.residual
        residual = samples.wrench[next_sample] - fitted_wrench
        count = np.where(outliers.rejected[next_sample], 0.0, count)
    return count @ squared_lengths(residual) / max(3.0 * count.sum(), 1e-300)
