"""Conditioning: the one robust fit of a recording: clock offset, bias, sign, gravity, noise and bad samples together.

Coarse offset by a scan, a robust fit with the most freely drifting bias, outliers left out and the rest fitted anew
until both agree, as few bias knots as the data ask for, and the offset sharpened by generalised least squares. Every
step goes on from where the last one ended.
"""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike

from hefting.errors import InputError
from hefting.ingest import outliers
from hefting.ingest.blocks import Blocks, medians, within_blocks
from hefting.ingest.conditioned import SIGNIFICANT, Conditioned, Tilted, WrenchSign, mass_over_std
from hefting.ingest.drift import Drift, HatFunctions, candidates
from hefting.ingest.findings import findings_of, warnings_of
from hefting.ingest.fit import LARGEST_STEP, Fit, Problem, Start, gauss_newton, solve
from hefting.ingest.offset import scan
from hefting.ingest.outliers import Outliers, no_outliers
from hefting.ingest.path import Path, path_of, static_path
from hefting.ingest.uncertainty import Uncertainty, uncertainty
from hefting.measurements import Noise
from hefting.motion import smooth_poses
from hefting.motion.measure import Source
from hefting.motion.weighting import effect_of_acceleration_errors
from hefting.recording import Recording
from hefting.spatial import STANDARD_GRAVITY, Array, frozen

MOST_SAMPLES = 100_000
"""Samples that are looked at one by one; of longer recordings blocks stand for them until the fit is done."""
MOST_BLOCKS = 20_000
"""Blocks worked on; of longer recordings only so many, evenly chosen."""
ROUGH = 6_000
"""Blocks of the first robust fit and of the choice of the drift."""
FEWEST = 12
"""Samples below which there is nothing to condition."""
FEWEST_SIFTED, FEWEST_POSES = 40, 12
"""Samples, and static poses, below which none is an outlier."""
STRETCH = 200_000
"""Samples of a long recording looked at together."""
PASSES = 8
"""of finding outliers and fitting the rest"""
TURNS, APART = 2000, 3.0
"""Instants gravity is looked at; knots of a bias are so many times as far apart as its direction is correlated."""
REFINEMENTS = 2
"""of the offset by generalised least squares"""
FASTEST = 15.0
"""Hz: beyond, arms and sensors ring, each with a delay of its own"""
NEAR = 5e-3
"""s: so small an offset changes nothing about what is an outlier"""
EXPLAINED = 0.8
"""Share of the wrench's changes below which it is something else than an offset that is wrong."""
SHORTEST = 1.0
"""s: in less there is no telling offset, bias and gravity apart"""
SMALLEST_OFFSET = 1e-5
"""s: not worth a correction"""
POOR = 0.1
"""Residual over the force's changes, or share left out, that makes one wonder about gravity. Tilted by 15° they are
0.2 to 0.3 and 0.1 to 0.3; Panda's are 0.08."""
THIN = 5_000
"""Blocks that suffice to find gravity's direction."""


@dataclass(frozen=True, eq=False)
class _Samples:
    """Wrench samples as they are looked at one by one."""

    time: Array
    """(K,) [s]"""
    wrench: Array
    """(K, 6)"""
    static: bool
    smooth: bool
    """whether they may be averaged"""

    def blocks(self, bad: Outliers | None = None) -> Blocks:
        """Of all of them, or of those that are not outliers."""
        return Blocks.of(self.time, self.wrench, None if bad is None else ~bad.rejected, self.smooth)

    @property
    def enough(self) -> bool:
        """Whether there are enough to tell which are outliers."""
        return len(self.time) >= (FEWEST_POSES if self.static else FEWEST_SIFTED)


@dataclass(frozen=True, eq=False)
class Settled:
    """A fit, how far it may be off, and what it leaves out."""

    problem: Problem
    fit: Fit
    spread: Uncertainty
    bad: Outliers

    @property
    def biased(self) -> bool:
        """Whether a bias was found beside the object."""
        return bool(self.fit.hats.functions.any())

    @property
    def mass_is_open(self) -> bool:
        """Whether the mass is within three standard deviations of zero, or not determined at all."""
        return not abs(self.fit.phi[0]) >= SIGNIFICANT * self.spread.mass_std

    @property
    def explained(self) -> float:
        """Share of the wrench's changes that the motion and the bias explain."""
        fit, unit = self.fit, np.repeat(1.0 / self.fit.scale, 3)
        wrench = self.problem.wrench * unit
        total = fit.weights @ (wrench - fit.weights @ wrench / max(fit.weights.sum(), 1e-300)) ** 2
        left = fit.weights @ (fit.residual * unit) ** 2
        return float(1.0 - left.sum() / max(total.sum(), 1e-300))


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
    g = frozen(gravity)
    if g.shape != (3,) or not np.isfinite(g).all() or not g.any():
        raise InputError(f"gravity must be three numbers [m/s²], not all zero; got {g.tolist()}")
    wrench = recording["wrench"]
    path = path_of(recording, source, g)
    moving = path is not None
    if path is None:
        path = static_path(recording)
    raw = _Samples(wrench.time, wrench.values, path.kind == "static", path.smooth)
    inside = (raw.time >= path.first) & (raw.time <= path.last)
    enough = bool(inside.sum() >= FEWEST)
    knots = _knots(path, raw.time[inside], g) if enough else (1,)
    long = recording.static or (enough and bool(np.ptp(raw.time[inside]) >= SHORTEST))
    free_offset, free_gravity = clock and moving and long, tilt and long and not path.gravity_measured
    if not enough:
        few = Problem(path, raw.blocks(), False, False, knots)
        return _conclude(recording, raw, _plain(few, g), None, clock, tilt, few=True)
    working = raw
    if len(raw.time) > MOST_SAMPLES:
        blocks = raw.blocks()
        chosen = replace(blocks, wrench=medians(raw.wrench, blocks.starts)).every(MOST_BLOCKS)
        working = _Samples(chosen.time, chosen.wrench, raw.static, smooth=False)
    problem = Problem(path, working.blocks(), free_offset, free_gravity, knots)
    found = _settle(working, g, *_from_scratch(working, problem, g))
    late = None
    if problem.free_offset and not _offset_counts(found):
        late = found.fit.offset, found.spread.offset_std
        found = _without_offset(working, problem, found, g)
    tilted = None
    if not free_gravity and long and not path.gravity_measured and not raw.static:
        poor = _is_poor(working, found)
        tilted = _tilted(working, found, poor) if hint or poor else None
    if working is not raw:
        found = replace(found, bad=_all_outliers(raw, found))
    return _conclude(recording, raw, found, late, clock, tilt, tilted=tilted)


def _knots(path: Path, time: Array, gravity: Array) -> tuple[int, ...]:
    """Numbers of bias knots to choose from: a bias that turns with gravity would eat the weight."""
    if path.kind == "static" or candidates(float(time[-1] - time[0]), 0.0) == (1,):
        return (1,)
    times = np.linspace(time[0], time[-1], TURNS)
    turning = path.at(times, spread=False)
    if not turning.known.any():
        return (1,)
    along = turning.value[:, 12:].reshape(-1, 3, 3) @ gravity
    correlated = autocorrelation_time(along[turning.known]) * (times[1] - times[0])
    return candidates(float(time[-1] - time[0]), APART * correlated)


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


def _from_scratch(samples: _Samples, problem: Problem, gravity: Array) -> tuple[Problem, Fit, Outliers]:
    """A fit to the samples that are not outliers, and the outliers, with nothing known beforehand.

    Contacts are found in the medians of the blocks, where there are any, so that few passes look at every sample.
    """
    fit = _rough(samples, problem, gravity)
    if problem.blocks.starts is not None:
        typical = medians(samples.wrench, problem.blocks.starts)
        coarse = _Samples(problem.time, typical, samples.static, smooth=False)
        fit = _sift(coarse, replace(problem, blocks=coarse.blocks()), fit)[1]
    return _sift(samples, problem, fit)


def _rough(samples: _Samples, problem: Problem, gravity: Array) -> Fit:
    """A robust fit of the blocks' medians, with the most freely drifting bias, from scratch."""
    knots = problem.knots[-1]
    typical = replace(problem.blocks, wrench=medians(samples.wrench, problem.blocks.starts))
    robust = replace(problem, blocks=typical).every(ROUGH)
    return gauss_newton(robust, scan(robust, gravity, min(knots, 9)), knots, robust=True)


def _sift(
    samples: _Samples, problem: Problem, start: Fit, bad: Outliers | None = None
) -> tuple[Problem, Fit, Outliers]:
    """A fit to the samples that are not outliers, with the most freely drifting bias, and the outliers."""
    knots = problem.knots[-1]
    none = no_outliers(len(samples.time))
    if not samples.enough:
        return problem, gauss_newton(problem, start.start, knots, steps=5), none
    fit = start
    if bad is not None:
        problem = _keeping(samples, problem, bad)
        fit = gauss_newton(problem, start.start, knots, steps=5)
    elif len(start.weights) != len(problem.blocks) or (start.model.layout.offset is None and problem.free_offset):
        fit = gauss_newton(problem, start.start, knots, robust=True, steps=2)
    before = none
    for k in range(PASSES):
        bad = _outliers(samples, problem, fit)
        if k and np.array_equal(bad.rejected, before.rejected):
            break
        if k > PASSES // 2:  # it wavers
            bad = bad.union(before)
        problem = _keeping(samples, problem, bad)
        fit, before = gauss_newton(problem, fit.start, knots, steps=5), bad
    return problem, fit, before


def _keeping(samples: _Samples, problem: Problem, bad: Outliers) -> Problem:
    """The problem without the outliers."""
    return replace(problem, blocks=samples.blocks(bad))


def _settle(samples: _Samples, gravity: Array, problem: Problem, fit: Fit, bad: Outliers) -> Settled:
    """The fit with as free a bias as the data ask for, its offset by generalised least squares."""
    fastest = _fastest(problem)
    spread = uncertainty(fit, fastest)
    n = _bias_knots(problem, fit, spread.slow)
    middle = fit.offset
    if n != fit.hats.n:
        fit = gauss_newton(problem, fit.start, n, steps=5)
        spread = uncertainty(fit, fastest)
    for _ in range(REFINEMENTS if problem.free_offset else 0):
        step = spread.offset_step
        sharper = float(np.clip(fit.offset + step, middle - LARGEST_STEP, middle + LARGEST_STEP))
        fit = gauss_newton(problem, replace(fit.start, offset=sharper), n, steps=3, hold=True)
        if samples.enough:  # the ends may now be known
            again = _outliers(samples, problem, fit)
            if not np.array_equal(again.rejected, bad.rejected):
                bad, problem = again, _keeping(samples, problem, again)
                fit = gauss_newton(problem, fit.start, n, steps=3, hold=True)
        spread = uncertainty(fit, fastest)
        if abs(step) < 0.1 * spread.offset_std:
            break
    found = Settled(problem, fit, spread, bad)
    if not found.mass_is_open:
        return found
    without = _without_bias(samples, gravity, found)
    return found if without.mass_is_open else without


def _without_bias(samples: _Samples, gravity: Array, found: Settled) -> Settled:
    """The fit where the mass cannot be told from a bias: with none."""
    bare, bad = replace(found.problem, free_offset=False, free_gravity=False), found.bad
    start = replace(found.fit.start, offset=0.0, gravity=gravity, bias=np.zeros_like(found.fit.bias))
    alone = gauss_newton(bare, start, 0, steps=5)
    if samples.enough and bad.rejected.any():
        bad = _outliers(samples, bare, alone)
        bare = _keeping(samples, bare, bad)
        alone = gauss_newton(bare, alone.start, 0, steps=5)
    return Settled(bare, alone, uncertainty(alone, _fastest(bare)), bad)


def _without_offset(samples: _Samples, problem: Problem, found: Settled, gravity: Array) -> Settled:
    """The fit without the clock offset that was found but does not count."""
    near = abs(found.fit.offset) < NEAR
    problem = replace(problem, free_offset=False)
    if not near:  # what was found there may be wrong
        return _settle(samples, gravity, *_from_scratch(samples, problem, gravity))
    fit = gauss_newton(
        replace(found.problem, free_offset=False), replace(found.fit.start, offset=0.0), found.fit.hats.n
    )
    return _settle(samples, gravity, *_sift(samples, problem, fit, found.bad))


def _bias_knots(problem: Problem, fit: Fit, slow: float) -> int:
    """Number of knots by the Bayesian information criterion, slow residuals counting as what they are."""
    if len(problem.knots) == 1:
        return problem.knots[0]
    rows = slice(None, None, -(-len(problem.time) // ROUGH))
    unit, weights = np.repeat(fit.scale, 3), fit.weights[rows]
    model = replace(fit.model, features=fit.model.features[rows], known=fit.model.known[rows])
    independent = max(6.0 * float(np.sum(weights > 0.0)) / max(slow, 1.0), 2.0)
    change, scores = model.columns(fit.phi)[:, :, 10:], {}
    for n in problem.knots:
        hats = HatFunctions.over(problem.time[rows], n)
        found = solve(model, fit.phi, weights, fit.scale, hats)
        r = problem.wrench[rows] - model.predict(found.core[:10]) - change @ found.core[10:] - hats.combine(found.bias)
        square = float(np.sum(weights[:, None] * (r / unit) ** 2))
        scores[n] = square / max(slow, 1.0) + 6.0 * n * np.log(independent)
    return min(scores, key=lambda n: scores[n])


def _offset_counts(found: Settled) -> bool:
    """Whether the offset found is one: away from zero, and explaining what zero does not."""
    problem, fit, spread = found.problem, found.fit, found.spread
    if not found.biased or found.mass_is_open or found.explained < EXPLAINED:
        return False
    if not abs(fit.offset) > max(SIGNIFICANT * spread.offset_std, SMALLEST_OFFSET):
        return False
    at_zero = replace(problem, free_offset=False)
    zero = gauss_newton(at_zero, replace(fit.start, offset=0.0), fit.hats.n, steps=4)
    weights = (fit.weights * (zero.known & fit.known))[:, None]
    squares = [float(np.sum(weights * (f.residual / np.repeat(fit.scale, 3)) ** 2)) for f in (zero, fit)]
    if problem.path.kind == "orientation":  # accelerations, not modelled, look like an offset, too
        return squares[0] > 2.0 * squares[1]
    return squares[0] - squares[1] > SIGNIFICANT**2 * max(spread.slow, 1e-3)


def _fastest(problem: Problem) -> float:
    """Frequency [1/block] up to which the motion is that of a rigid body."""
    if problem.path.gravity_measured or problem.path.kind == "static":
        return 0.5
    return min(FASTEST * float(np.median(np.diff(problem.time))), 0.5)


def _plain(problem: Problem, gravity: Array) -> Settled:
    """Of too few samples: nothing is conditioned."""
    time = problem.time
    start = Start(np.zeros(10), 0.0, gravity, np.maximum(problem.floor, 1e-12), time[:1], np.zeros((1, 6)))
    fit = gauss_newton(problem, start, 1, steps=4)
    return Settled(problem, fit, uncertainty(fit), no_outliers(len(time)))


def _outliers(samples: _Samples, problem: Problem, fit: Fit) -> Outliers:
    """What a fit does not explain of the samples."""
    changes = _changes(problem)
    predicted = problem.wrench - fit.residual
    if samples.static:
        return outliers.find_odd_poses(samples.wrench, predicted, changes)
    if problem.blocks.starts is None:
        return outliers.find_outliers(
            samples.time, samples.wrench, predicted, fit.spread, fit.known, fit.scale, changes
        )
    return _outliers_between(samples, problem, fit, changes)


def _outliers_between(samples: _Samples, problem: Problem, fit: Fit, changes: Array) -> Outliers:
    """Outliers of samples that lie between the blocks of a fit: its prediction is interpolated."""
    predicted = problem.wrench - fit.residual
    columns = np.column_stack((predicted, fit.spread, fit.known))
    at = np.column_stack([np.interp(samples.time, problem.time, column) for column in columns.T])
    half = 0.5 * float(np.median(np.diff(problem.time)))
    covered = (samples.time >= problem.time[0] - half) & (samples.time <= problem.time[-1] + half)
    known = (at[:, 7] > 1.0 - 1e-9) & covered
    scale = fit.scale * problem.blocks.mean_count**0.5
    return outliers.find_outliers(samples.time, samples.wrench, at[:, :6], at[:, 6], known, scale, changes)


def _all_outliers(raw: _Samples, found: Settled) -> Outliers:
    """What a fit to some blocks does not explain of all samples, stretch by stretch."""
    changes, parts = _changes(found.problem), []
    for begins in range(0, len(raw.time), STRETCH):
        part = slice(begins, begins + STRETCH)
        piece = _Samples(raw.time[part], raw.wrench[part], raw.static, raw.smooth)
        parts.append(_outliers_between(piece, found.problem, found.fit, changes))
    return Outliers(*(np.concatenate([getattr(f, name) for f in parts]) for name in ("contact", "spike", "saturation")))


def _changes(problem: Problem) -> Array:
    """(2,) how much force and torque change."""
    spread = np.std(problem.wrench - np.median(problem.wrench, axis=0), axis=0)
    return np.linalg.norm(spread.reshape(2, 3), axis=1)


def _is_poor(samples: _Samples, found: Settled) -> bool:
    """Whether so little of the wrench is explained that gravity may be to blame."""
    changes = float(np.sqrt(np.mean(np.var(samples.wrench[:, :3], axis=0))))
    return float(found.fit.scale[0]) > POOR * changes or float(found.bad.rejected.mean()) > POOR


def _tilted(samples: _Samples, found: Settled, suspected: bool) -> Tilted | None:
    """Where the data would have gravity, and what that leaves of the force; None where they do not tell."""
    blocks = samples.blocks()
    typical = replace(blocks, wrench=medians(samples.wrench, blocks.starts))
    problem = replace(found.problem, blocks=typical, free_gravity=True).every(THIN)
    fit = gauss_newton(problem, replace(found.fit.start, reading=None), found.fit.hats.n, robust=True, steps=20)
    thin = _Samples(problem.time, problem.wrench, static=False, smooth=False)
    blocks = Blocks(problem.time, np.zeros(len(problem.time)), np.ones(len(problem.time)), problem.wrench)
    problem = replace(problem, blocks=blocks)
    for _ in range(2):
        bad = _outliers(thin, problem, fit)
        problem = replace(problem, blocks=replace(blocks, count=(~bad.rejected).astype(float)))
        fit = gauss_newton(problem, fit.start, found.fit.hats.n, steps=8)
    spread = uncertainty(fit, _fastest(problem))
    std = spread.tilt_std / float(np.linalg.norm(fit.gravity))
    if not np.isfinite(std):
        return None
    ratio = float(fit.scale[0]) / max(float(found.fit.scale[0]), 1e-300)
    return Tilted(fit.gravity, std, ratio, suspected)


def _conclude(
    recording: Recording,
    raw: _Samples,
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


def _noise(raw: _Samples, problem: Problem, fit: Fit, bad: Outliers) -> Noise:
    """Of one sample of the wrench, what the residuals hold beside the motion's errors; of the accelerations, those."""
    used = fit.weights > 0.0
    spent = used.sum() / max(used.sum() - len(fit.phi) / 6.0 - fit.hats.n, 1.0)
    count = np.where(used, problem.blocks.count, 0.0)
    square = count @ np.sum(fit.residual.reshape(-1, 2, 3) ** 2, axis=2) / max(3.0 * count.sum(), 1e-300)
    square = np.maximum(square, problem.floor**2) * spent
    if problem.blocks.starts is not None and len(raw.time) == len(bad.rejected):
        square = square + within_blocks(problem.blocks, raw.wrench, ~bad.rejected)
    variances = fit.model.reading.variances[:, used].mean(axis=1) if used.any() else np.zeros(2)
    effect = effect_of_acceleration_errors(fit.phi) @ variances / 3.0
    force, torque = np.sqrt(np.maximum(square - effect, 0.01 * square))
    return Noise(float(force), float(torque), float(variances[0] ** 0.5), float(variances[1] ** 0.5))
