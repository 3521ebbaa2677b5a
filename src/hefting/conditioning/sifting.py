"""Fitting and leaving out what the fit does not explain, in turns."""

import numpy as np

from hefting.conditioning import outliers
from hefting.conditioning.fit import Fit, Problem, Start, begin, gauss_newton
from hefting.conditioning.outliers import Outliers
from hefting.spatial import Array

FEWEST_SIFTED, FEWEST_POSES = 40, 12
"""Samples, and static poses, below which none is an outlier."""
STRETCH = 200_000
"""Samples of a long recording looked at together."""
PASSES = 8
"""of finding outliers and fitting the rest"""


def sifted(problem: Problem, start: Start, bad: Outliers | None = None) -> tuple[Fit, Outliers]:
    """A fit to the samples that are not outliers, with the most freely drifting bias, and the outliers."""
    knots = problem.knots[-1]
    none = outliers.nothing(len(problem.time))
    if not siftable(problem):
        return gauss_newton(problem, start, knots, ~none.rejected, steps=5), none
    fit = gauss_newton(problem, start, knots, None if bad is None else ~bad.rejected, steps=2)
    before = none
    for k in range(PASSES):
        bad = outliers_of(problem, fit)
        if k and np.array_equal(bad.rejected, before.rejected):
            break
        if k > PASSES // 2:  # it wavers
            bad = bad.joined(before)
        fit, before = gauss_newton(problem, begin(fit), knots, ~bad.rejected, steps=5), bad
    return fit, before


def siftable(problem: Problem) -> bool:
    """Whether there are samples enough to tell which are outliers."""
    return len(problem.time) >= (FEWEST_POSES if problem.signal.kind == "static" else FEWEST_SIFTED)


def outliers_of(problem: Problem, fit: Fit) -> Outliers:
    """What a fit does not explain of the samples it was made from."""
    if problem.signal.kind == "static":
        return outliers.among_poses(problem.wrench, problem.wrench - fit.residual, _changes(problem))
    return outliers.among(
        problem.time, problem.wrench, problem.wrench - fit.residual, fit.spread, fit.known, fit.scale, _changes(problem)
    )


def all_outliers(raw: Problem, problem: Problem, fit: Fit) -> Outliers:
    """What a fit to some samples does not explain of all, stretch by stretch."""
    predicted = problem.wrench - fit.residual
    found = []
    for begins in range(0, len(raw.time), STRETCH):
        part = slice(begins, begins + STRETCH)
        time = raw.time[part]
        at, spread, known = (
            np.column_stack([np.interp(time, problem.time, column) for column in values.T])
            for values in (predicted, fit.spread[:, None], fit.known[:, None].astype(float))
        )
        known = (known[:, 0] > 1.0 - 1e-9) & (time >= problem.time[0]) & (time <= problem.time[-1])
        found.append(outliers.among(time, raw.wrench[part], at, spread[:, 0], known, fit.scale, _changes(problem)))
    return Outliers(*(np.concatenate([getattr(f, name) for f in found]) for name in ("contact", "spike", "saturation")))


def _changes(problem: Problem) -> Array:
    """(2,) how much force and torque change."""
    spread = np.std(problem.wrench - np.median(problem.wrench, axis=0), axis=0)
    return np.linalg.norm(spread.reshape(2, 3), axis=1)
