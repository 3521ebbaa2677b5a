"""Robust fit of a recording: clock offset, bias, sign and outliers together.

It scans for a coarse clock offset, fits the blocks' medians robustly with the most
freely drifting bias, alternates between rejecting outliers and fitting the inliers,
reduces the bias to as few knots as the data support, and refines the offset by
generalised least squares. Each step starts from the result of the one before.
"""

from dataclasses import replace

import numpy as np

from hefting.core.spatial import STANDARD_GRAVITY, Array, immutable, median
from hefting.ingest.conditioned import LEAST_MASS, SIGNIFICANT
from hefting.ingest.drift import HatFunctions
from hefting.ingest.fit import LARGEST_OFFSET_STEP, Fit, Start, gauss_newton
from hefting.ingest.free_fit import SMALLEST_GRAVITY_CHANGE
from hefting.ingest.model import Problem, solve
from hefting.ingest.offset import scan_offsets
from hefting.ingest.outliers import Outliers, no_outliers
from hefting.ingest.samples import Samples, find_odd_pose, find_outliers_of_fit
from hefting.ingest.uncertainty import Uncertainty, estimate_uncertainty

MOST_BLOCKS_OF_FIRST_FIT = 6_000
"""Largest number of blocks in the first robust fit and in the choice of the number of
bias knots."""
CLEARLY_SMALLER_SCALES = 0.99
"""Ratio of the product of force and torque scales below which reversed gravity is
accepted: with the other sign of the wrench, only accelerations distinguish it."""
MOST_KNOTS_OF_SCAN = 9
"""Largest number of bias knots in the scan for a coarse clock offset."""
OUTLIER_ITERATIONS = 8
"""Largest number of alternations between finding outliers and fitting inliers."""
NEGLIGIBLE_MASK_CHANGE = 1e-3
"""Share of samples by which two outlier masks may differ and count as equal."""
OFFSET_REFINEMENTS = 2
"""Largest number of refinements of the clock offset by generalised least squares."""
RIGID_MOTION_FREQUENCY = 15.0
"""[Hz] Higher frequencies are not used for the clock offset: arms and sensors ring
there, with different delays."""
OFFSET_WITHOUT_EFFECT_ON_OUTLIERS = 5e-3
"""[s] Clock offset up to which, when it is removed, outliers are found from those found
with it; else they are found from scratch."""
SMALLEST_EXPLAINED_SHARE_WITH_OFFSET = 0.8
"""Share of the wrench's variance that a fit must explain for a clock offset of more
than `COMMON_OFFSET` to be accepted."""
SMALLEST_EXPLAINED_SHARE_WITH_COMMON_OFFSET = 0.5
"""The same for a smaller clock offset. In parts of recordings of a drifting sensor,
with 0.69 to 0.76 explained, the offset was found to 3 ms."""
COMMON_OFFSET = 0.05
"""[s] Clock offset that the drivers of robots and sensors commonly leave."""
SMALLEST_OFFSET = 1e-5
"""[s] Smaller clock offsets are not corrected."""


@immutable
class InlierFit:
    """A fit to the samples that are not outliers."""

    problem: Problem
    """with blocks of the inliers"""
    fit: Fit
    outliers: Outliers


@immutable
class RobustFit(InlierFit):
    """A fit to the inliers with its uncertainty."""

    uncertainty: Uncertainty

    @property
    def biased(self) -> bool:
        """Whether a bias was estimated."""
        return bool(self.fit.hats.functions.any())

    @property
    def mass_is_open(self) -> bool:
        """Whether the mass is undetermined, or within three deviations of zero."""
        return not abs(self.fit.phi[0]) >= SIGNIFICANT * self.uncertainty.mass_std

    @property
    def holds_nothing(self) -> bool:
        """Whether the mass is some grams at most, although gravity turned."""
        most = abs(float(self.fit.phi[0])) + SIGNIFICANT * self.uncertainty.mass_std
        if not most < LEAST_MASS:
            return False
        per_kilogram = self.fit.model.predict(np.eye(10)[0])[self.fit.known, :3]
        turned = float(np.linalg.norm(np.std(per_kilogram, axis=0)))
        gravity = float(np.linalg.norm(STANDARD_GRAVITY))
        return turned >= SMALLEST_GRAVITY_CHANGE * gravity

    @property
    def explained(self) -> float:
        """Share of the wrench's weighted variance that motion and bias explain."""
        fit, unit = self.fit, np.repeat(1.0 / self.fit.scale, 3)
        wrench = self.problem.wrench * unit
        mean = fit.weights @ wrench / max(fit.weights.sum(), 1e-300)
        total = fit.weights @ (wrench - mean) ** 2
        left = fit.weights @ (fit.residual * unit) ** 2
        return float(1.0 - left.sum() / max(total.sum(), 1e-300))


def fit_from_scratch(samples: Samples, problem: Problem, gravity: Array) -> InlierFit:
    """A fit to the inliers without any initial values but gravity (3,) [m/s²].

    Where there are blocks, outliers are first found among the blocks' medians, which
    takes fewer passes over all samples.
    """
    fit = _fit_block_medians(samples, problem, gravity)
    if problem.blocks.starts is not None:
        typical = problem.blocks.with_medians(samples.wrench).wrench
        coarse = Samples(problem.time, typical, samples.static, smooth=False)
        fit = fit_without_outliers(
            coarse, replace(problem, blocks=coarse.blocks()), fit
        ).fit
    return fit_without_outliers(samples, problem, fit)


def _fit_block_medians(samples: Samples, problem: Problem, gravity: Array) -> Fit:
    """A robust fit to the blocks' medians, with the most freely drifting bias, from a
    scan of clock offsets."""
    knots = problem.knots[-1]
    typical = problem.blocks.with_medians(samples.wrench)
    chosen = replace(problem, blocks=typical).every(MOST_BLOCKS_OF_FIRST_FIT)
    start = scan_offsets(chosen, gravity, min(knots, MOST_KNOTS_OF_SCAN))
    fit = gauss_newton(chosen, start, knots, robust=True)
    if not problem.free_gravity:
        return fit
    opposite = gauss_newton(
        chosen, replace(fit.start, gravity=-fit.gravity), knots, robust=True
    )
    better = opposite.scale.prod() < CLEARLY_SMALLER_SCALES * fit.scale.prod()
    return opposite if better else fit


def fit_without_outliers(samples: Samples, problem: Problem, start: Fit) -> InlierFit:
    """Alternate between finding outliers and fitting the inliers, with the most freely
    drifting bias, until they agree. `start` is a fit to the same or other blocks."""
    knots = problem.knots[-1]
    outliers = no_outliers(len(samples.time))
    if not samples.enough:
        return InlierFit(
            problem, gauss_newton(problem, start.start, knots, steps=5), outliers
        )
    fit = start
    offset_was_held = start.model.layout.offset is None and problem.free_offset
    if len(start.weights) != len(problem.blocks) or offset_was_held:
        fit = gauss_newton(problem, start.start, knots, robust=True, steps=2)
    for iteration in range(OUTLIER_ITERATIONS):
        found = find_outliers_of_fit(samples, problem, fit)
        if iteration and not _differ(found, outliers):
            break
        # the masks may alternate: reject what either of them does
        if iteration > OUTLIER_ITERATIONS // 2:
            found = found.union(outliers)
        problem = _with_inliers(samples, problem, found)
        fit, outliers = gauss_newton(problem, fit.start, knots, steps=5), found
    return InlierFit(problem, fit, outliers)


def _differ(one: Outliers, other: Outliers) -> bool:
    """Whether two outlier masks differ in more than a negligible share of samples."""
    return float(np.mean(one.rejected != other.rejected)) > NEGLIGIBLE_MASK_CHANGE


def _with_inliers(samples: Samples, problem: Problem, outliers: Outliers) -> Problem:
    return replace(problem, blocks=samples.blocks(outliers))


def choose_bias_and_refine_offset(
    samples: Samples, gravity: Array, found: InlierFit
) -> RobustFit:
    """The fit with as many bias knots as the data support and the clock offset of
    generalised least squares.

    Where the mass cannot be distinguished from a bias it is the fit without any bias,
    with `gravity` (3,) [m/s²] as given, provided that this determines the mass; not where
    the mass is known to be none.
    """
    refined = _refine_offset(samples, _choose_bias(found), middle=found.fit.offset)
    if refined.holds_nothing or not refined.mass_is_open:
        return refined
    without = _without_bias(samples, gravity, refined)
    return refined if without.mass_is_open else without


def fit_robustly(
    samples: Samples, problem: Problem, gravity: Array
) -> tuple[InlierFit, RobustFit]:
    """The fit to the inliers without any initial values but gravity (3,) [m/s²], and
    that with bias and clock offset chosen."""
    first = fit_from_scratch(samples, problem, gravity)
    return first, choose_bias_and_refine_offset(samples, gravity, first)


def _choose_bias(found: InlierFit) -> RobustFit:
    problem, fit = found.problem, found.fit
    fastest = fastest_frequency(problem)
    uncertainty = estimate_uncertainty(fit, fastest)
    knots = _number_of_bias_knots(problem, fit, uncertainty.slow)
    if knots != fit.hats.n:
        fit = gauss_newton(problem, fit.start, knots, steps=5)
        uncertainty = estimate_uncertainty(fit, fastest)
    return RobustFit(problem, fit, found.outliers, uncertainty)


def _refine_offset(samples: Samples, found: RobustFit, middle: float) -> RobustFit:
    """The fit with the clock offset of generalised least squares, at most
    `LARGEST_OFFSET_STEP` from `middle` [s]."""
    problem = found.problem
    fit = found.fit
    outliers = found.outliers
    uncertainty = found.uncertainty
    fastest, knots = fastest_frequency(problem), fit.hats.n
    lowest, highest = middle - LARGEST_OFFSET_STEP, middle + LARGEST_OFFSET_STEP
    for _ in range(OFFSET_REFINEMENTS if problem.free_offset else 0):
        step = uncertainty.offset_step
        offset = float(np.clip(fit.offset + step, lowest, highest))
        fit = gauss_newton(
            problem, replace(fit.start, offset=offset), knots, steps=3, hold_offset=True
        )
        if samples.enough:  # the motion may now be known at other samples of the ends
            again = find_outliers_of_fit(samples, problem, fit)
            if _differ(again, outliers):
                outliers, problem = again, _with_inliers(samples, problem, again)
                fit = gauss_newton(problem, fit.start, knots, steps=3, hold_offset=True)
        uncertainty = estimate_uncertainty(fit, fastest)
        if abs(step) < 0.1 * uncertainty.offset_std:
            break
    return RobustFit(problem, fit, outliers, uncertainty)


def _fit_other_inliers(samples: Samples, found: InlierFit, knots: int) -> InlierFit:
    """The fit, with `knots` of the bias, to the inliers of a fit whose unknowns differ
    from that by which its outliers were found."""
    fit = found.fit
    outliers = find_outliers_of_fit(samples, found.problem, fit)
    problem = _with_inliers(samples, found.problem, outliers)
    fit = gauss_newton(problem, fit.start, knots, steps=5)
    return InlierFit(problem, fit, outliers)


def _without_bias(samples: Samples, gravity: Array, found: RobustFit) -> RobustFit:
    """The fit without bias and clock offset, with gravity (3,) [m/s²] as given."""
    problem = replace(found.problem, free_offset=False, free_gravity=False)
    start = replace(
        found.fit.start, offset=0.0, gravity=gravity, bias=np.zeros_like(found.fit.bias)
    )
    fit = gauss_newton(problem, start, 0, steps=5)
    without = InlierFit(problem, fit, found.outliers)
    if samples.enough and found.outliers.rejected.any():
        without = _fit_other_inliers(samples, without, 0)
    problem, fit = without.problem, without.fit
    uncertainty = estimate_uncertainty(fit, fastest_frequency(problem))
    return RobustFit(problem, fit, without.outliers, uncertainty)


def remove_offset(
    samples: Samples, gravity: Array, first: InlierFit, found: RobustFit
) -> RobustFit:
    """The fit without clock offset, if that `found` after `first` is not used."""
    problem = replace(first.problem, free_offset=False)
    if abs(found.fit.offset) >= OFFSET_WITHOUT_EFFECT_ON_OUTLIERS:
        everything = replace(problem, blocks=samples.blocks())
        return fit_robustly(samples, everything, gravity)[1]
    start, knots = replace(found.fit.start, offset=0.0), problem.knots[-1]
    fit = gauss_newton(problem, start, knots)
    without = InlierFit(problem, fit, first.outliers)
    if samples.enough:
        without = _fit_other_inliers(samples, without, knots)
    return choose_bias_and_refine_offset(samples, gravity, without)


def _number_of_bias_knots(problem: Problem, fit: Fit, slow: float) -> int:
    """Number of knots with the least Bayesian information criterion.

    `slow` is the spectrum of the whitened residuals at low frequencies. Squared
    residuals and the number of samples are divided by it where it is more than 1, as
    the residuals are correlated.
    """
    if len(problem.knots) == 1:
        return problem.knots[0]
    rows = slice(None, None, -(-len(problem.time) // MOST_BLOCKS_OF_FIRST_FIT))
    unit, weights = np.repeat(fit.scale, 3), fit.weights[rows]
    model = replace(
        fit.model, features=fit.model.features[rows], known=fit.model.known[rows]
    )
    correlation = max(slow, 1.0)
    independent = max(6.0 * float(np.sum(weights > 0.0)) / correlation, 2.0)
    offset_and_tilt, scores = model.columns(fit.phi)[:, :, 10:], {}
    for n in problem.knots:
        hats = HatFunctions.over(problem.time[rows], n)
        found = solve(model, fit.phi, weights, fit.scale, hats)
        residual = problem.wrench[rows] - model.predict(found.core[:10])
        residual = (
            residual - offset_and_tilt @ found.core[10:] - hats.combine(found.bias)
        )
        square = float(np.sum(weights[:, None] * (residual / unit) ** 2))
        scores[n] = square / correlation + 6.0 * n * np.log(independent)
    return min(scores, key=lambda n: scores[n])


def offset_is_significant(found: RobustFit) -> bool:
    """Whether the clock offset is significantly different from zero and improves the
    fit significantly."""
    problem, fit, uncertainty = found.problem, found.fit, found.uncertainty
    share = (
        SMALLEST_EXPLAINED_SHARE_WITH_OFFSET
        if abs(fit.offset) > COMMON_OFFSET
        else SMALLEST_EXPLAINED_SHARE_WITH_COMMON_OFFSET
    )
    if not found.biased or found.mass_is_open or found.explained < share:
        return False
    if not abs(fit.offset) > max(SIGNIFICANT * uncertainty.offset_std, SMALLEST_OFFSET):
        return False
    fixed = replace(problem, free_offset=False)
    at_zero = replace(fit.start, offset=0.0)
    zero = gauss_newton(fixed, at_zero, fit.hats.n, steps=4, final=False)
    weights = (fit.weights * (zero.known & fit.known))[:, None]
    unit = np.repeat(fit.scale, 3)
    square_zero, square = (
        float(np.sum(weights * (f.residual / unit) ** 2)) for f in (zero, fit)
    )
    # accelerations are not modelled and resemble an offset
    if problem.path.kind == "orientation":
        return square_zero > 2.0 * square
    return square_zero - square > SIGNIFICANT**2 * max(uncertainty.slow, 1e-3)


def fastest_frequency(problem: Problem) -> float:
    """Largest frequency [1/block] at which the motion counts as of a rigid body."""
    if problem.path.gravity_measured or problem.path.kind == "static":
        return 0.5
    if len(problem.time) < 2:
        return 0.5
    return min(RIGID_MOTION_FREQUENCY * median(np.diff(problem.time)), 0.5)


def fit_few_samples(samples: Samples, problem: Problem, gravity: Array) -> RobustFit:
    """A plain fit of too few samples, without offset and outliers, except an odd pose;
    gravity (3,) [m/s²] as given."""
    time = problem.time
    start = Start(
        np.zeros(10),
        0.0,
        gravity,
        np.maximum(problem.floor, 1e-12),
        time[:1],
        np.zeros((1, 6)),
    )
    fit = gauss_newton(problem, start, 1, steps=4)
    outliers = find_odd_pose(samples, fit)
    if outliers.rejected.any():
        problem = _with_inliers(samples, problem, outliers)
        fit = gauss_newton(problem, start, 1, steps=4)
    return RobustFit(problem, fit, outliers, estimate_uncertainty(fit))
