"""Late: the motion as a wrench feels it that passes a low-pass filter, where the residuals
show one.

A filter's tail looks like a drifting bias or like contacts, and what is then taken out is
a part of the object's weight. So it is looked for before these are.
"""

from dataclasses import replace
from functools import partial

import numpy as np

from hefting.core.spatial import Array, Mask, interpolated
from hefting.ingest.blocks import medians
from hefting.ingest.filtering import Ahead
from hefting.ingest.fit import Start, gauss_newton
from hefting.ingest.model import Problem
from hefting.ingest.path import Path, Read
from hefting.ingest.robust_fit import InlierFit
from hefting.ingest.samples import Samples

SHORTEST = 0.05
"""[s] Lag from which on a filter is looked for here: a shorter one leaves nothing that
drifts."""
LONGEST = 1.2
"""[s] The longest filter's: a longer lag is that of a clock."""
CONSTANTS = (0.6, 1.0, 1.4, 1.8)
"""Time constants that are tried, over the lag that was found for a delay: from the rise
or the end of a move alone that is found too short."""
CLEARLY_LESS = 0.8
"""Size of the residuals over that beside a delay, for force and torque together, from
which on there is a filter. In parts of 9 s of a recording through a filter of 0.6 s it is
0.4 to 0.9."""
MOST_BLOCKS = 2000
"""Blocks that are compared."""
INSTANTS_PER_LAG, FEWEST_PER_LAG, MOST_INSTANTS = 20, 4, 50_000
"""Instants at which the motion is filtered."""


def felt_path(samples: Samples, found: InlierFit) -> Path | None:
    """The motion through the filter that explains the wrench clearly better than a delay
    does, ahead by the lag of that filter; None where there is none.

    The bias is constant in both, and no sample is left out but by its weight.
    """
    problem, lag = found.problem, found.fit.offset
    if not problem.free_offset or lag < SHORTEST:
        return None
    if (grid := instants(problem.path, lag)) is None:
        return None
    whole = samples.blocks()
    typical = replace(whole, wrench=medians(samples.wrench, whole.starts))
    delayed = replace(problem, blocks=typical, free_gravity=False).every(MOST_BLOCKS)
    start = replace(found.fit.start, reading=None)
    least, best = CLEARLY_LESS * _left(delayed, start), None
    constants = [lag * share for share in CONSTANTS if lag * share < LONGEST]
    ahead = Ahead.of(grid, problem.path.read(grid, False)[0], LONGEST)
    for constant in constants:
        read = partial(_read_felt, problem.path.read, grid, ahead.through(constant))
        path = replace(problem.path, read=read, plain=problem.path)
        left = _left(replace(delayed, path=path), start)
        if left < least:
            least, best = left, path
    return best


def _left(problem: Problem, start: Start) -> float:
    """Size of what robust least squares leaves of force and torque together."""
    fit = gauss_newton(problem, start, 1, robust=True, steps=6, final=False)
    return float(np.sqrt(fit.scale.prod()))


def instants(path: Path, lag: float) -> Array | None:
    """(n,) [s] even instants at which a motion is filtered that is felt so late [s];
    None of one that is too long for so short a lag."""
    lags = (path.last - path.first) / lag
    if lags * FEWEST_PER_LAG > MOST_INSTANTS:
        return None
    count = int(min(lags * INSTANTS_PER_LAG, MOST_INSTANTS)) + 2
    return np.linspace(path.first, path.last, count)


def _read_felt(
    read: Read, grid: Array, value: Array, time: Array, spread: bool
) -> tuple[Array, Array, Mask]:
    return interpolated(time, grid, value), *read(time, spread)[1:]
