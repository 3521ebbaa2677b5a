"""Gauss-Newton fit of parameters, bias, clock offset and gravity's direction: robust,
or plain on chosen samples.

The robust fit is iteratively reweighted least squares with the weights of the
multivariate Student t distribution of a sample's six residuals (Lange, Little & Taylor,
J. American Statistical Association 84, 1989). The model is that of
`hefting.ingest.model`.
"""

from functools import cached_property

import numpy as np

from hefting.core.spatial import (
    Array,
    Mask,
    immutable,
    interpolated,
    median,
    squared_lengths,
)
from hefting.ingest.drift import HatFunctions
from hefting.ingest.model import Layout, Model, Problem, Solution, solve, tilt_gravity
from hefting.ingest.path import Reading
from hefting.motion.state import effect_of_acceleration_errors, samples_per_error

STUDENT_DEGREES_OF_FREEDOM = 3.0
"""Degrees of freedom of the Student t distribution assumed for a sample's residual in a
robust fit."""
LARGEST_OFFSET_STEP = 0.02
"""[s] Largest change of the clock offset in one Gauss-Newton step."""
LARGEST_OFFSET_CHANGE = 0.1
"""[s] Largest change of the clock offset between the start and the end of one fit."""
LARGEST_TILT_STEP = 3.0
"""[m/s²] Largest change of gravity along each tangent in one Gauss-Newton step."""
NEGLIGIBLE_PREDICTION_CHANGE = 1e-3
"""Change of the predicted wrench by the parameters, and by the clock offset, as a share of
the residual scale, at which a robust fit counts as converged. A plain fit must change by a
tenth of it."""


@immutable
class Fit:
    """A solution and its residuals."""

    phi: Array
    """(10,) parameters with the sign of the recorded wrench: a negative mass for the
    other sign convention"""
    hats: HatFunctions
    """functions of time that compose the bias"""
    bias: Array
    """(n, 6) at the knots [N, N m]"""
    scale: Array
    """(2,) scale of force [N] and torque [N m] residuals: root mean square, or that of
    the Student t distribution"""
    weights: Array
    """(B,) of the blocks, by their counts and the motion's errors; zero if rejected or
    without known motion"""
    spread: Array
    """(B,) widening of a block's residual by the motion's errors, 1 in the median"""
    residual: Array
    """(B, 6) measured less predicted wrench [N, N m]"""
    solution: Solution
    model: Model

    @property
    def offset(self) -> float:
        """[s] by which the wrench is late"""
        return self.model.offset

    @property
    def gravity(self) -> Array:
        """(3,) in world axes [m/s²]"""
        return self.model.gravity

    @property
    def known(self) -> Mask:
        """(B,) blocks at which the motion is known"""
        return self.model.reading.known

    @cached_property
    def bias_now(self) -> Array:
        """(B, 6) bias at the blocks [N, N m]"""
        return self.hats.combine(self.bias)

    @cached_property
    def columns(self) -> Array:
        """(B, 6, core) columns of the design matrix"""
        return self.model.columns(self.phi)

    @property
    def start(self) -> "Start":
        """This fit as the start of another."""
        return Start(
            self.phi,
            self.offset,
            self.gravity,
            self.scale,
            self.hats.knots,
            self.bias,
            self.model.reading,
        )


@immutable
class Start:
    """Initial values of a fit."""

    phi: Array
    """(10,) parameters"""
    offset: float
    """[s]"""
    gravity: Array
    """(3,) in world axes [m/s²]"""
    scale: Array
    """(2,) of force [N] and torque [N m] residuals"""
    knots: Array
    """(n,) [s] of the bias"""
    bias: Array
    """(n, 6) at the knots [N, N m]"""
    reading: Reading | None = None
    """of the motion at or near the same times, to save time"""


def gauss_newton(
    problem: Problem,
    start: Start,
    knots: int,
    *,
    robust: bool = False,
    steps: int = 12,
    hold_offset: bool = False,
    final: bool = True,
) -> Fit:
    """Fit the model by Gauss-Newton steps.

    Parameters
    ----------
    problem : samples, motion and free unknowns.
    start : initial values.
    knots : number of knots of the bias.
    robust : whether to weight the blocks by their residuals, as the Student t
        distribution does.
    steps : largest number of steps.
    hold_offset : whether to fix the clock offset, which is still an unknown of the final
        normal equations.
    final : whether the motion of the solution is as accurate as an answer needs; a
        comparison needs less.
    """
    hats = HatFunctions.over(problem.time, knots)
    phi, scale = start.phi, start.scale
    bias = interpolated(problem.time, start.knots, start.bias)
    bounds = start.offset - LARGEST_OFFSET_CHANGE, start.offset + LARGEST_OFFSET_CHANGE
    model = Model.at(problem, start.offset, start.gravity, start.reading, final=False)
    for step in range(steps):
        residual = problem.wrench - model.predict(phi) - bias
        weights, scale, _ = weight_blocks(
            problem, model.reading, phi, residual, scale, robust=robust
        )
        linear = (
            model.with_fixed_offset if hold_offset and problem.free_offset else model
        )
        found = solve(linear, phi, weights, scale, hats)
        prediction_change = _size(model.predict(found.core[:10] - phi))
        phi, bias = found.core[:10], hats.combine(found.bias)
        offset_step = _offset_step(model.offset, found, linear.layout, bounds)
        gravity = _stepped_gravity(model.gravity, found, linear.layout)

        tolerance = (
            (1.0 if robust else 0.1) * NEGLIGIBLE_PREDICTION_CHANGE * float(scale.max())
        )
        reweighted = step > 0 or not robust
        done = (
            reweighted
            and prediction_change < tolerance
            and (
                not offset_step
                or _size(offset_step * model.predict_rate(phi)) < tolerance
            )
        )
        last = done or step == steps - 1
        if offset_step or linear.layout.tilt is not None or last:
            model = Model.at(
                problem,
                model.offset + offset_step,
                gravity,
                model.reading,
                final=last and final,
            )
        if done:
            break
    residual = problem.wrench - model.predict(phi) - bias
    weights, scale, spread = weight_blocks(
        problem, model.reading, phi, residual, scale, robust=robust
    )
    solution = solve(model, phi, weights, scale, hats)
    return Fit(phi, hats, found.bias, scale, weights, spread, residual, solution, model)


def _size(wrench: Array) -> float:
    """Root mean square of wrenches (B, 6) [N, N m]."""
    return float(np.sqrt(np.mean(wrench**2)))


def _offset_step(
    offset: float, found: Solution, layout: Layout, bounds: tuple[float, float]
) -> float:
    """Change of the clock offset [s], limited in size and to `bounds`; zero if the
    offset is not free."""
    if layout.offset is None:
        return 0.0
    step = float(
        np.clip(found.core[layout.offset], -LARGEST_OFFSET_STEP, LARGEST_OFFSET_STEP)
    )
    return float(np.clip(offset + step, *bounds)) - offset


def _stepped_gravity(gravity: Array, found: Solution, layout: Layout) -> Array:
    """Gravity (3,) after the step; unchanged if its direction is not free."""
    if layout.tilt is None:
        return gravity
    return tilt_gravity(
        gravity, np.clip(found.core[layout.tilt], -LARGEST_TILT_STEP, LARGEST_TILT_STEP)
    )


def weight_blocks(
    problem: Problem,
    reading: Reading,
    phi: Array,
    residual: Array,
    scale: Array,
    *,
    robust: bool,
) -> tuple[Array, Array, Array]:
    """Weights (B,) of the blocks by their counts and the motion's errors and, if
    `robust`, by their residuals; the scales (2,) of force [N] and torque [N m]
    residuals that go with them; and the factor (B,) by which the motion's errors widen
    a block's residual, 1 in the median.

    Parameters
    ----------
    problem : with B blocks.
    reading : of the motion at the blocks.
    phi : (10,) parameters, which determine the effect of the motion's errors.
    residual : (B, 6) [N, N m].
    scale : (2,) of force [N] and torque [N m] residuals so far.
    robust : whether to weight by the residuals, as the Student t distribution does.
    """
    blocks = problem.blocks
    trust, spread = motion_weights(
        phi, reading, problem.path.bandwidth, blocks.time, scale
    )
    weights = np.where(reading.known, trust * blocks.count / blocks.mean_count, 0.0)
    square = squared_lengths(residual)
    if not robust:
        scale = np.sqrt(weights @ square / max(3.0 * weights.sum(), 1e-300))
        return weights, np.maximum(scale, problem.floor), spread
    student = weights
    used = max(int((weights > 0.0).sum()), 1)
    for _ in range(2):
        distance = weights * (square @ scale**-2.0)
        student = weights * (
            (STUDENT_DEGREES_OF_FREEDOM + 6.0) / (STUDENT_DEGREES_OF_FREEDOM + distance)
        )
        scale = np.maximum(np.sqrt(student @ square / (3.0 * used)), problem.floor)
    return student, scale, spread


def motion_weights(
    phi: Array, reading: Reading, bandwidth: float, time: Array, scale: Array
) -> tuple[Array, Array]:
    """Weights (B,) by the motion's errors, 1 on average, and the factor (B,) by which
    these widen a residual.

    The weights are those of `hefting.motion.sample_weights`; the factor is 1 in the
    median.

    Parameters
    ----------
    phi : (10,) parameters.
    reading : of the motion at B blocks, with the variances of the accelerations.
    bandwidth : of the motion's errors [rad/s]; infinite where the motion is exact.
    time : (B,) [s].
    scale : (2,) of force [N] and torque [N m] residuals.
    """
    known = reading.known
    if not np.isfinite(bandwidth) or len(time) < 2 or not known.any():
        return np.ones(len(time)), np.ones(len(time))
    share = scale**-2.0 @ effect_of_acceleration_errors(phi) / 6.0
    excess = share @ reading.variances
    weights = 1.0 / (1.0 + samples_per_error(time, bandwidth) * excess)
    variance = 1.0 + excess
    return weights / weights[known].mean(), np.sqrt(variance / median(variance[known]))
