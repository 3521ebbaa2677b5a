"""The one robust fit of a recording: clock offset, bias, sign and bad samples together.

Coarse offset by a scan, a robust fit with the most freely drifting bias, outliers left out and the rest fitted anew
until both agree, as few bias knots as the data ask for, and the offset sharpened by generalised least squares. Every
step goes on from where the last one ended.
"""

from dataclasses import dataclass, replace

import numpy as np

from hefting.core.spatial import Array
from hefting.ingest import outliers
from hefting.ingest.blocks import Blocks, medians
from hefting.ingest.conditioned import SIGNIFICANT
from hefting.ingest.drift import HatFunctions
from hefting.ingest.fit import LARGEST_OFFSET_STEP, Fit, Problem, Start, gauss_newton, solve
from hefting.ingest.offset import scan
from hefting.ingest.outliers import Outliers, no_outliers
from hefting.ingest.uncertainty import Uncertainty, uncertainty

MOST_BLOCKS_OF_FIRST_FIT = 6_000
"""Largest number of blocks in the first robust fit and in the choice of the number of bias knots."""
FEWEST_SAMPLES_FOR_OUTLIERS = 40
"""Number of samples below which no sample is rejected."""
FEWEST_POSES_FOR_OUTLIERS = 12
"""Number of static poses below which no pose is rejected."""
SAMPLES_AT_A_TIME = 200_000
"""Number of samples of a long recording in which outliers are found together; it bounds the memory."""
OUTLIER_ITERATIONS = 8
"""Largest number of alternations between finding outliers and fitting the inliers."""
NEGLIGIBLE_MASK_CHANGE = 1e-3
"""Share of samples by which two outlier masks may differ and still count as the same."""
OFFSET_REFINEMENTS = 2
"""Largest number of refinements of the clock offset by generalised least squares."""
RIGID_MOTION_FREQUENCY = 15.0
"""[Hz] Frequencies above it are not used for the clock offset: arms and sensors ring there, each with its own delay."""
OFFSET_WITHOUT_EFFECT_ON_OUTLIERS = 5e-3
"""[s] Removing a smaller clock offset keeps the outliers that were found with it."""
SMALLEST_EXPLAINED_SHARE_WITH_OFFSET = 0.8
"""Share of the wrench's variance that a fit must explain for its clock offset to be believed."""
SMALLEST_OFFSET = 1e-5
"""[s] Smaller clock offsets are not corrected."""


@dataclass(frozen=True, eq=False)
class Samples:
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
        return len(self.time) >= (FEWEST_POSES_FOR_OUTLIERS if self.static else FEWEST_SAMPLES_FOR_OUTLIERS)


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


def from_scratch(samples: Samples, problem: Problem, gravity: Array) -> tuple[Problem, Fit, Outliers]:
    """A fit to the samples that are not outliers, and the outliers, with nothing known beforehand.

    Contacts are found in the medians of the blocks, where there are any, so that few passes look at every sample.
    """
    fit = _rough(samples, problem, gravity)
    if problem.blocks.starts is not None:
        typical = medians(samples.wrench, problem.blocks.starts)
        coarse = Samples(problem.time, typical, samples.static, smooth=False)
        fit = sift(coarse, replace(problem, blocks=coarse.blocks()), fit)[1]
    return sift(samples, problem, fit)


def _rough(samples: Samples, problem: Problem, gravity: Array) -> Fit:
    """A robust fit of the blocks' medians, with the most freely drifting bias, from scratch."""
    knots = problem.knots[-1]
    typical = replace(problem.blocks, wrench=medians(samples.wrench, problem.blocks.starts))
    robust = replace(problem, blocks=typical).every(MOST_BLOCKS_OF_FIRST_FIT)
    return gauss_newton(robust, scan(robust, gravity, min(knots, 9)), knots, robust=True)


def sift(samples: Samples, problem: Problem, start: Fit) -> tuple[Problem, Fit, Outliers]:
    """A fit to the samples that are not outliers, with the most freely drifting bias, and the outliers."""
    knots = problem.knots[-1]
    none = no_outliers(len(samples.time))
    if not samples.enough:
        return problem, gauss_newton(problem, start.start, knots, steps=5), none
    fit = start
    if len(start.weights) != len(problem.blocks) or (start.model.layout.offset is None and problem.free_offset):
        fit = gauss_newton(problem, start.start, knots, robust=True, steps=2)
    before = none
    for k in range(OUTLIER_ITERATIONS):
        bad = outliers_of(samples, problem, fit)
        if k and not _differ(bad, before):
            break
        if k > OUTLIER_ITERATIONS // 2:  # it wavers
            bad = bad.union(before)
        problem = _keeping(samples, problem, bad)
        fit, before = gauss_newton(problem, fit.start, knots, steps=5), bad
    return problem, fit, before


def _differ(one: Outliers, other: Outliers) -> bool:
    """Whether what is left out differs by more than does not matter."""
    return float(np.mean(one.rejected != other.rejected)) > NEGLIGIBLE_MASK_CHANGE


def _keeping(samples: Samples, problem: Problem, bad: Outliers) -> Problem:
    """The problem without the outliers."""
    return replace(problem, blocks=samples.blocks(bad))


def settle(samples: Samples, gravity: Array, problem: Problem, fit: Fit, bad: Outliers) -> Settled:
    """The fit with as free a bias as the data ask for, its offset by generalised least squares."""
    fastest = fastest_frequency(problem)
    spread = uncertainty(fit, fastest)
    n = _bias_knots(problem, fit, spread.slow)
    middle = fit.offset
    if n != fit.hats.n:
        fit = gauss_newton(problem, fit.start, n, steps=5)
        spread = uncertainty(fit, fastest)
    for _ in range(OFFSET_REFINEMENTS if problem.free_offset else 0):
        step = spread.offset_step
        sharper = float(np.clip(fit.offset + step, middle - LARGEST_OFFSET_STEP, middle + LARGEST_OFFSET_STEP))
        fit = gauss_newton(problem, replace(fit.start, offset=sharper), n, steps=3, hold=True)
        if samples.enough:  # the ends may now be known
            again = outliers_of(samples, problem, fit)
            if _differ(again, bad):
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


def _without_bias(samples: Samples, gravity: Array, found: Settled) -> Settled:
    """The fit where the mass cannot be told from a bias: with none."""
    bare, bad = replace(found.problem, free_offset=False, free_gravity=False), found.bad
    start = replace(found.fit.start, offset=0.0, gravity=gravity, bias=np.zeros_like(found.fit.bias))
    alone = gauss_newton(bare, start, 0, steps=5)
    if samples.enough and bad.rejected.any():
        bad = outliers_of(samples, bare, alone)
        bare = _keeping(samples, bare, bad)
        alone = gauss_newton(bare, alone.start, 0, steps=5)
    return Settled(bare, alone, uncertainty(alone, fastest_frequency(bare)), bad)


def without_offset(samples: Samples, gravity: Array, first: tuple[Problem, Fit, Outliers], found: Settled) -> Settled:
    """The fit without the clock offset that was `found`, after a `first` fit from scratch, but does not count."""
    problem = replace(first[0], free_offset=False)
    if abs(found.fit.offset) >= OFFSET_WITHOUT_EFFECT_ON_OUTLIERS:  # what was left out there may be wrong
        everything = replace(problem, blocks=samples.blocks())
        return settle(samples, gravity, *from_scratch(samples, everything, gravity))
    bad, knots = first[2], problem.knots[-1]
    fit = gauss_newton(problem, replace(found.fit.start, offset=0.0), knots)
    if samples.enough:
        bad = outliers_of(samples, problem, fit)
        problem = _keeping(samples, problem, bad)
        fit = gauss_newton(problem, fit.start, knots, steps=5)
    return settle(samples, gravity, problem, fit, bad)


def _bias_knots(problem: Problem, fit: Fit, slow: float) -> int:
    """Number of knots by the Bayesian information criterion, slow residuals counting as what they are."""
    if len(problem.knots) == 1:
        return problem.knots[0]
    rows = slice(None, None, -(-len(problem.time) // MOST_BLOCKS_OF_FIRST_FIT))
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


def offset_counts(found: Settled) -> bool:
    """Whether the offset found is one: away from zero, and explaining what zero does not."""
    problem, fit, spread = found.problem, found.fit, found.spread
    if not found.biased or found.mass_is_open or found.explained < SMALLEST_EXPLAINED_SHARE_WITH_OFFSET:
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


def fastest_frequency(problem: Problem) -> float:
    """Frequency [1/block] up to which the motion is that of a rigid body."""
    if problem.path.gravity_measured or problem.path.kind == "static":
        return 0.5
    return min(RIGID_MOTION_FREQUENCY * float(np.median(np.diff(problem.time))), 0.5)


def plain_fit(samples: Samples, problem: Problem, gravity: Array) -> Settled:
    """Of too few samples: nothing is conditioned."""
    time = problem.time
    start = Start(np.zeros(10), 0.0, gravity, np.maximum(problem.floor, 1e-12), time[:1], np.zeros((1, 6)))
    fit = gauss_newton(problem, start, 1, steps=4)
    return Settled(problem, fit, uncertainty(fit), no_outliers(len(samples.time)))


def outliers_of(samples: Samples, problem: Problem, fit: Fit) -> Outliers:
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


def _outliers_between(samples: Samples, problem: Problem, fit: Fit, changes: Array) -> Outliers:
    """Outliers of samples that lie between the blocks of a fit: its prediction is interpolated."""
    predicted = problem.wrench - fit.residual
    columns = np.column_stack((predicted, fit.spread, fit.known))
    at = np.column_stack([np.interp(samples.time, problem.time, column) for column in columns.T])
    half = 0.5 * float(np.median(np.diff(problem.time)))
    covered = (samples.time >= problem.time[0] - half) & (samples.time <= problem.time[-1] + half)
    known = (at[:, 7] > 1.0 - 1e-9) & covered
    scale = fit.scale * problem.blocks.mean_count**0.5
    return outliers.find_outliers(samples.time, samples.wrench, at[:, :6], at[:, 6], known, scale, changes)


def all_outliers(raw: Samples, found: Settled) -> Outliers:
    """What a fit to some blocks does not explain of all samples, stretch by stretch."""
    changes, parts = _changes(found.problem), []
    for begins in range(0, len(raw.time), SAMPLES_AT_A_TIME):
        part = slice(begins, begins + SAMPLES_AT_A_TIME)
        piece = Samples(raw.time[part], raw.wrench[part], raw.static, raw.smooth)
        parts.append(_outliers_between(piece, found.problem, found.fit, changes))
    return Outliers(*(np.concatenate([getattr(f, name) for f in parts]) for name in ("contact", "spike", "saturation")))


def _changes(problem: Problem) -> Array:
    """(2,) how much force and torque change."""
    spread = np.std(problem.wrench - np.median(problem.wrench, axis=0), axis=0)
    return np.linalg.norm(spread.reshape(2, 3), axis=1)
