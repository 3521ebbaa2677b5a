"""Conditioning: what is wrong with a recording, by the one robust fit, and gravity's direction."""

from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike

from hefting.core.measurements import Noise
from hefting.core.recording import Recording
from hefting.core.spatial import STANDARD_GRAVITY, Array, check_gravity
from hefting.ingest.blocks import Blocks, medians, within_blocks
from hefting.ingest.conditioned import Conditioned, Tilted, WrenchSign, mass_over_std
from hefting.ingest.drift import Drift, candidates
from hefting.ingest.findings import findings_of, warnings_of
from hefting.ingest.fit import Fit, Problem, gauss_newton
from hefting.ingest.outliers import Outliers
from hefting.ingest.path import Path, path_of, static_path
from hefting.ingest.robust_fit import (
    Samples,
    Settled,
    all_outliers,
    fastest_frequency,
    from_scratch,
    offset_counts,
    outliers_of,
    plain_fit,
    settle,
    without_offset,
)
from hefting.ingest.uncertainty import uncertainty
from hefting.motion import smooth_poses
from hefting.motion.measure import Source
from hefting.motion.weighting import effect_of_acceleration_errors

MOST_FITTED_SAMPLES = 100_000
"""Largest number of samples that are fitted directly. Of longer recordings block medians are fitted."""
MOST_FITTED_BLOCKS = 10_000
"""Largest number of block medians that are fitted; of longer recordings evenly chosen ones."""
FEWEST_CONDITIONED_SAMPLES = 12
"""Number of samples below which a recording is not conditioned."""
GRAVITY_INSTANTS = 2000
"""Number of instants at which gravity's direction is evaluated to find its autocorrelation time."""
KNOT_SPACING_IN_CORRELATION_TIMES = 3.0
"""Smallest distance between bias knots, in autocorrelation times of gravity's direction in sensor axes."""
SHORTEST_CONDITIONED_RECORDING = 1.0
"""[s] In shorter recordings offset, bias and gravity cannot be distinguished, and no offset or gravity is estimated."""
POORLY_EXPLAINED_SHARE = 0.1
"""Ratio of force residual to the force's changes, or share of rejected samples, above which gravity's direction is
checked. With a base tilted by 15° these are 0.2 to 0.3 and 0.1 to 0.3; on the Panda recordings 0.08."""
BLOCKS_FOR_GRAVITY = 5_000
"""Number of blocks used for finding gravity's direction."""


def condition(
    recording: Recording,
    gravity: ArrayLike = STANDARD_GRAVITY,
    source: Source = "auto",
    *,
    clock: bool = True,
    tilt: bool = False,
    hint: bool = False,
) -> Conditioned:
    """Find what is wrong with a recording: clock offset, drifting bias, sign, bad samples and, if asked, gravity.

    Parameters
    ----------
    gravity : (3,) in world axes [m/s²]; its direction only a beginning with `tilt`.
    source : where the motion comes from, as for `hefting.motion.measure.measure`.
    clock : whether to look for an offset between wrench and motion.
    tilt : whether to look for gravity's direction. A sensor that is not perfect invents a few degrees.
    hint : whether to say where the data would have gravity even where it was given and explains the wrench well.

    What cannot be found counts as absent, and `warnings` say so. Raises `InputError` where
    `hefting.motion.measure.measure` does.
    """
    g = check_gravity(gravity)
    wrench = recording["wrench"]
    path = path_of(recording, source, g)
    moving = path is not None
    if path is None:
        path = static_path(recording)
    raw = Samples(wrench.time, wrench.values, path.kind == "static", path.smooth)
    inside = (raw.time >= path.first) & (raw.time <= path.last)
    enough = bool(inside.sum() >= FEWEST_CONDITIONED_SAMPLES)
    knots = _knots(path, raw.time[inside], g) if enough else (1,)
    long = recording.static or (enough and bool(np.ptp(raw.time[inside]) >= SHORTEST_CONDITIONED_RECORDING))
    free_offset, free_gravity = clock and moving and long, tilt and long and not path.gravity_measured
    if not enough:
        few = Problem(path, raw.blocks(), False, False, knots)
        return _conclude(recording, raw, plain_fit(raw, few, g), None, clock, tilt, few=True)
    working = raw
    if len(raw.time) > MOST_FITTED_SAMPLES:
        blocks = raw.blocks()
        chosen = replace(blocks, wrench=medians(raw.wrench, blocks.starts)).every(MOST_FITTED_BLOCKS)
        working = Samples(chosen.time, chosen.wrench, raw.static, smooth=False)
    problem = Problem(path, working.blocks(), free_offset, free_gravity, knots)
    first = from_scratch(working, problem, g)
    found = settle(working, g, *first)
    late = None
    if problem.free_offset and not offset_counts(found):
        late = found.fit.offset, found.spread.offset_std
        found = without_offset(working, g, first, found)
    tilted = None
    if not free_gravity and long and not path.gravity_measured and not raw.static:
        poor = _is_poor(working, found)
        tilted = _tilted(working, found, poor) if hint or poor else None
    if working is not raw:
        found = replace(found, bad=all_outliers(raw, found))
    return _conclude(recording, raw, found, late, clock, tilt, tilted=tilted)


def _knots(path: Path, time: Array, gravity: Array) -> tuple[int, ...]:
    """Numbers of bias knots to choose from: a bias that turns with gravity would eat the weight."""
    if path.kind == "static" or candidates(float(time[-1] - time[0]), 0.0) == (1,):
        return (1,)
    times = np.linspace(time[0], time[-1], GRAVITY_INSTANTS)
    turning = path.at(times, spread=False)
    if not turning.known.any():
        return (1,)
    along = turning.value[:, 12:].reshape(-1, 3, 3) @ gravity
    correlated = autocorrelation_time(along[turning.known]) * (times[1] - times[0])
    return candidates(float(time[-1] - time[0]), KNOT_SPACING_IN_CORRELATION_TIMES * correlated)


def autocorrelation_time(series: Array) -> float:
    """Integrated autocorrelation time of the columns of `series` (K, d), averaged; 1 for white noise, never less."""
    x = series - series.mean(axis=0)
    n = len(x)
    if n < 8 or not x.any():
        return 1.0
    size = 1 << (2 * n - 1).bit_length()
    covariance = np.fft.irfft(np.abs(np.fft.rfft(x, size, axis=0)) ** 2, size, axis=0)[: n // 2]
    times = []
    for column in covariance.T[covariance[0] > 0.0]:
        rho = column / column[0]
        below = np.flatnonzero(rho < 0.05)
        times.append(1.0 + 2.0 * float(rho[1 : below[0] if len(below) else len(rho)].sum()))
    return max(1.0, float(np.mean(times))) if times else 1.0


def _is_poor(samples: Samples, found: Settled) -> bool:
    """Whether so little of the wrench is explained that gravity may be to blame."""
    changes = float(np.sqrt(np.mean(np.var(samples.wrench[:, :3], axis=0))))
    return (
        float(found.fit.scale[0]) > POORLY_EXPLAINED_SHARE * changes
        or float(found.bad.rejected.mean()) > POORLY_EXPLAINED_SHARE
    )


def _tilted(samples: Samples, found: Settled, suspected: bool) -> Tilted | None:
    """Where the data would have gravity, and what that leaves of the force; None where they do not tell."""
    blocks = samples.blocks()
    typical = replace(blocks, wrench=medians(samples.wrench, blocks.starts))
    problem = replace(found.problem, blocks=typical, free_gravity=True).every(BLOCKS_FOR_GRAVITY)
    fit = gauss_newton(problem, found.fit.start, found.fit.hats.n, robust=True, steps=8)
    thin = Samples(problem.time, problem.wrench, static=False, smooth=False)
    blocks = Blocks(problem.time, np.zeros(len(problem.time)), np.ones(len(problem.time)), problem.wrench)
    problem = replace(problem, blocks=blocks)
    for _ in range(2):
        bad = outliers_of(thin, problem, fit)
        problem = replace(problem, blocks=replace(blocks, count=(~bad.rejected).astype(float)))
        fit = gauss_newton(problem, fit.start, found.fit.hats.n, steps=8)
    spread = uncertainty(fit, fastest_frequency(problem))
    std = spread.tilt_std / float(np.linalg.norm(fit.gravity))
    if not np.isfinite(std):
        return None
    ratio = float(fit.scale[0]) / max(float(found.fit.scale[0]), 1e-300)
    return Tilted(fit.gravity, std, ratio, suspected)


def _conclude(
    recording: Recording,
    raw: Samples,
    found: Settled,
    late: tuple[float, float] | None,
    clock: bool,
    tilt: bool,
    few: bool = False,
    tilted: Tilted | None = None,
) -> Conditioned:
    """The result, in the project's sign.

    `late` is an offset that was not significant, and its deviation; `few`: there were too few samples to condition.
    """
    problem, fit, spread, bad = found.problem, found.fit, found.spread, found.bad
    path, no_bias = problem.path, not found.biased
    doubtful = found.mass_is_open or no_bias
    sign = WrenchSign(bool(fit.phi[0] >= 0.0), 0.0 if doubtful else mass_over_std(float(fit.phi[0]), spread.mass_std))
    offset_std: float | None = None
    if clock and path.moves:
        offset_std = late[1] if late else spread.offset_std
    tilt_std = None
    if tilt and not path.gravity_measured:
        tilt_std = spread.tilt_std / float(np.linalg.norm(fit.gravity))
    used = (fit.weights > 0.0) * problem.blocks.count
    mean = used @ fit.bias_now / max(used.sum(), 1.0)
    curves = path.curves
    if tilt_std is not None and np.isfinite(tilt_std) and curves is not None:
        curves = smooth_poses(recording, fit.gravity, curves.alone)  # an accelerometer beside them feels gravity
    result = Conditioned(
        parameters=fit.phi if sign.on_object else -fit.phi,
        covariance=spread.covariance[:10, :10],
        offset=fit.offset if problem.free_offset else 0.0,
        offset_std=offset_std,
        sign=sign,
        bias=Drift(fit.hats.knots, fit.bias, np.where(no_bias, np.inf, spread.bias), mean),
        biased=not no_bias,
        gravity=fit.gravity,
        tilt_std=tilt_std,
        tilted=tilted,
        noise=_noise(raw, problem, fit, bad),
        rejected=bad.rejected,
        reasons={name: int(getattr(bad, name).sum()) for name in ("contact", "spike", "saturation")},
        inflation=spread.inflation,
        findings=(),
        curves=curves,
    )
    findings = findings_of(result, recording, bad, late)
    warnings = warnings_of(result, path, found.explained, late, clock, tilt, few)
    return replace(result, findings=findings, warnings=warnings)


def _noise(raw: Samples, problem: Problem, fit: Fit, bad: Outliers) -> Noise:
    """Of one sample of the wrench, what the residuals hold beside the motion's errors; of the accelerations, those."""
    used = fit.weights > 0.0
    spent = used.sum() / max(used.sum() - len(fit.phi) / 6.0 - fit.hats.n, 1.0)
    count, residual = np.where(used, problem.blocks.count, 0.0), fit.residual
    averaged = problem.blocks.starts is not None
    if not averaged and len(raw.time) > len(problem.time):  # medians stood for the samples: of those beside them
        beside = np.minimum(np.searchsorted(raw.time, problem.time), len(raw.time) - 1)
        residual = raw.wrench[beside] - (problem.wrench - fit.residual)
        count = np.where(bad.rejected[beside], 0.0, count)
    square = count @ np.sum(residual.reshape(-1, 2, 3) ** 2, axis=2) / max(3.0 * count.sum(), 1e-300)
    square = np.maximum(square, problem.floor**2) * spent
    if averaged:
        within = within_blocks(problem.blocks, raw.time, raw.wrench, ~bad.rejected)
        square = square + within.diagonal().reshape(2, 3).mean(axis=1)
    variances = fit.model.reading.variances[:, used].mean(axis=1) if used.any() else np.zeros(2)
    effect = effect_of_acceleration_errors(fit.phi) @ variances / 3.0
    force, torque = np.sqrt(np.maximum(square - effect, 0.01 * square))
    return Noise(float(force), float(torque), float(variances[0] ** 0.5), float(variances[1] ** 0.5))
