"""Conditioning: the order of operations, from a recording as it is to one that any estimator can take."""

from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike

from hefting.calibration import autocorrelation_time
from hefting.conditioning import outliers
from hefting.conditioning.conclusion import Settled, conclude
from hefting.conditioning.drift import Hats, candidates
from hefting.conditioning.fit import LARGEST_STEP, Fit, Problem, Start, begin, gauss_newton
from hefting.conditioning.offset import scan
from hefting.conditioning.outliers import Outliers
from hefting.conditioning.result import SIGNIFICANT, Conditioned
from hefting.conditioning.sifting import all_outliers, outliers_of, siftable, sifted
from hefting.conditioning.signals import Signal, signal_of, still
from hefting.conditioning.system import solve
from hefting.conditioning.uncertainty import uncertainty
from hefting.errors import InputError
from hefting.motion.measure import Source
from hefting.recording import Recording
from hefting.spatial import STANDARD_GRAVITY, Array, frozen

WORKING = 50_000
"""Samples worked on; of longer recordings only so many, but at `RATE` [Hz] or faster."""
RATE = 50.0
ROUGH = 6_000
"""Samples of the robust fit and of the choice of the drift."""
FEWEST = 12
"""Samples below which there is nothing to condition."""
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


def condition(
    recording: Recording,
    gravity: ArrayLike = STANDARD_GRAVITY,
    source: Source = "auto",
    *,
    clock: bool = True,
    tilt: bool = False,
) -> Conditioned:
    """Find what is wrong with a recording: clock offset, drifting bias, sign, bad samples and, if asked, gravity.

    Parameters
    ----------
    gravity : (3,) in world axes [m/s²]; its direction only a beginning with `tilt`.
    source : where the motion comes from, as for `hefting.motion.measure.measure`.
    clock : whether to look for an offset between wrench and motion.
    tilt : whether to look for gravity's direction. A sensor that is not perfect invents a few degrees.

    What cannot be found counts as absent, and `warnings` say so. Raises `InputError` where
    `hefting.motion.measure.measure` does.
    """
    g = frozen(gravity)
    if g.shape != (3,) or not np.isfinite(g).all() or not g.any():
        raise InputError(f"gravity must be three numbers [m/s²], not all zero; got {g.tolist()}")
    wrench = recording["wrench"]
    signal = signal_of(recording, source, g)
    moving = signal is not None
    if signal is None:
        signal = still(recording)
    inside = (wrench.time >= signal.first) & (wrench.time <= signal.last)
    enough = inside.sum() >= FEWEST
    knots = _knots(signal, wrench.time[inside], g) if enough else (1,)
    long = recording.static or (enough and bool(np.ptp(wrench.time[inside]) >= SHORTEST))
    free_tilt = tilt and long and not signal.gravity_measured
    raw = Problem(signal, wrench.time, wrench.values, clock and moving and long, free_tilt, knots)
    if not enough:
        return _plain(recording, raw, g, clock, tilt)
    problem = _working(raw)
    found = _settled(problem, g, *sifted(problem, _rough(problem, g)))
    late = None
    if problem.free_offset and not _offset_counts(problem, found):
        late = found.fit.offset, found.spread.offset_std
        problem, raw = replace(problem, free_offset=False), replace(raw, free_offset=False)
        # with an offset far off, what was found there may be wrong
        again = replace(begin(found.fit), offset=0.0) if abs(late[0]) < NEAR else _rough(problem, g)
        found = _settled(problem, g, *sifted(problem, again, found.bad if abs(late[0]) < NEAR else None))
    if problem.stride > 1:
        found = replace(found, bad=all_outliers(raw, problem, found.fit))
    return conclude(recording, raw, found, late, clock, tilt)


def _working(problem: Problem) -> Problem:
    """The samples to work on."""
    if len(problem.time) <= WORKING:
        return problem
    rate = 1.0 / float(np.median(np.diff(problem.time)))
    return problem.every(max(-(-len(problem.time) // max(int(rate / RATE), 1)), WORKING))


def _knots(signal: Signal, time: Array, gravity: Array) -> tuple[int, ...]:
    """Numbers of bias knots to choose from: a bias that turns with gravity would eat the weight."""
    if signal.kind == "static":
        return (1,)
    times = np.linspace(time[0], time[-1], TURNS)
    turning = signal.at(times)
    if not turning.known.any():
        return (1,)
    correlated = autocorrelation_time((turning.world @ gravity)[turning.known]) * (times[1] - times[0])
    return candidates(float(time[-1] - time[0]), APART * correlated)


def _rough(problem: Problem, gravity: Array) -> Start:
    """Where a robust fit ends, with the most freely drifting bias, from scratch."""
    knots = problem.knots[-1]
    start = scan(problem, gravity, min(knots, 9))
    return begin(gauss_newton(problem.every(ROUGH), start, knots))


def _settled(problem: Problem, gravity: Array, fit: Fit, bad: Outliers) -> Settled:
    """The fit with as free a bias as the data ask for, its offset by generalised least squares."""
    fastest = _fastest(problem)
    n = _bias_knots(problem, fit, uncertainty(fit, fastest).slow)
    middle = fit.offset
    fit = gauss_newton(problem, begin(fit), n, ~bad.rejected, steps=5)
    spread = uncertainty(fit, fastest)
    for _ in range(REFINEMENTS if problem.free_offset else 0):
        sharper = float(np.clip(fit.offset + spread.step[10], middle - LARGEST_STEP, middle + LARGEST_STEP))
        fit = gauss_newton(problem, replace(begin(fit), offset=sharper), n, ~bad.rejected, steps=3, hold=True)
        if problem.free_offset and siftable(problem):  # the ends may now be known
            bad = outliers_of(problem, fit)
        spread = uncertainty(fit, fastest)
    found = Settled(fit, spread, bad)
    if not found.mass_is_open:
        return found
    bare = replace(problem, free_offset=False, free_gravity=False)
    alone = gauss_newton(bare, replace(begin(fit), offset=0.0, gravity=gravity), 0, ~bad.rejected, steps=5)
    if siftable(problem) and bad.rejected.any():
        bad = outliers_of(bare, alone)
        alone = gauss_newton(bare, begin(alone), 0, ~bad.rejected, steps=5)
    without = Settled(alone, uncertainty(alone, fastest), bad)
    return found if without.mass_is_open else without


def _bias_knots(problem: Problem, fit: Fit, slow: float) -> int:
    """Number of knots by the Bayesian information criterion, slow residuals counting as what they are."""
    rows = slice(None, None, -(-len(problem.time) // ROUGH))
    scale = np.repeat(fit.scale, 3)
    columns, wrench, weights = fit.columns[rows], problem.wrench[rows], fit.weights[rows]
    independent = max(6.0 * float(np.sum(weights > 0.0)) / max(slow, 1.0), 2.0)
    scores = {}
    for n in problem.knots:
        hats = Hats.over(problem.time[rows], n)
        solved = solve(columns, wrench, weights, scale, hats)
        r = wrench - columns @ solved.solution - hats.combine(solved.bias)
        square = float(np.sum(weights[:, None] * (r / scale) ** 2))
        scores[n] = square / max(slow, 1.0) + 6.0 * n * np.log(independent)
    return min(scores, key=lambda n: scores[n])


def _offset_counts(problem: Problem, found: Settled) -> bool:
    """Whether the offset found is one: away from zero, and explaining what zero does not."""
    fit, spread = found.fit, found.spread
    if not found.biased or found.mass_is_open or found.explained < EXPLAINED:
        return False
    if not abs(fit.offset) > max(SIGNIFICANT * spread.offset_std, SMALLEST_OFFSET):
        return False
    at_zero = replace(problem, free_offset=False)
    zero = gauss_newton(at_zero, replace(begin(fit), offset=0.0), fit.hats.n, fit.weights > 0.0, steps=4)
    weights = (fit.weights * (zero.known & fit.known))[:, None]
    squares = [float(np.sum(weights * (f.residual / np.repeat(fit.scale, 3)) ** 2)) for f in (zero, fit)]
    if problem.signal.kind == "orientation":  # accelerations, not modelled, look like an offset, too
        return squares[0] > 2.0 * squares[1]
    return squares[0] - squares[1] > SIGNIFICANT**2 * max(spread.slow, 1e-3)


def _fastest(problem: Problem) -> float:
    """Frequency [1/sample] up to which the motion is that of a rigid body."""
    if problem.signal.gravity_measured or problem.signal.kind == "static":
        return 0.5
    return min(FASTEST * float(np.median(np.diff(problem.time))), 0.5)


def _plain(recording: Recording, problem: Problem, gravity: Array, clock: bool, tilt: bool) -> Conditioned:
    """Of too few samples: nothing is conditioned."""
    fixed = replace(problem, free_offset=False, free_gravity=False)
    start = Start(np.zeros(10), 0.0, gravity, np.maximum(problem.floor, 1e-12), problem.time[:1], np.zeros((1, 6)))
    bad = outliers.nothing(len(problem.time))
    fit = gauss_newton(fixed, start, 1, ~bad.rejected, steps=4)
    found = Settled(fit, uncertainty(fit), bad)
    return conclude(recording, fixed, found, None, clock, tilt, few=True)
