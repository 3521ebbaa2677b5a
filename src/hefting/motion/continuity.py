"""Continuity of poses: which samples no moving body can have passed.

Samples out of reach of the others are glitches. A value that is repeated exactly, from
which the next step is a jump, is not that of a body at rest but of a stream that
stalled, or had not begun.
"""

from dataclasses import dataclass

import numpy as np

from hefting.core.spatial import Array, Indices, Mask
from hefting.motion.pose_steps import FEWEST_HELD_ROWS, Limits, Runs, Steps
from hefting.motion.reachable import Chain

HELD_TIMING_ERRORS = 2.0
"""Errors of time stamps that a stall of the stream lasts longer than. Shorter ones are
part of every log: in recordings at a nominal 1 kHz some last 3 to 8 ms."""


@dataclass(frozen=True, eq=False)
class Discontinuities:
    """Samples of a pose stream that no body can have passed, and jumps."""

    glitch: Mask
    """(K,) samples out of reach of the others"""
    frozen: Mask
    """(K,) samples repeated while the body moved on"""
    ends: Mask
    """(K,) values held before the motion begins with a jump, or after it ends with
    one"""
    jumps: Indices
    """(J,) first samples of parts that are out of reach of the part before, and are
    kept nevertheless"""

    @property
    def left_out(self) -> Mask:
        """(K,) any of the masks."""
        return self.glitch | self.frozen | self.ends


def find_discontinuities(
    time: Array, values: Array, limits: Limits
) -> Discontinuities | None:
    """Samples of a stream of positions or orientations that cannot be reached from the
    others; None where there are none.

    Parameters
    ----------
    time : (K,) [s], increasing.
    values : (K, 3) positions [m], or (K, 4) unit quaternions, of either sign.
    limits : bounds on the motion.
    """
    if len(time) < FEWEST_HELD_ROWS:
        return None
    runs = Runs.of(time, values)
    if len(runs.first) < FEWEST_HELD_ROWS:
        return None
    steps = Steps.of(runs, limits)
    broken = steps.broken()
    reached, jumps = np.ones(len(runs.first), dtype=bool), np.zeros(0, dtype=int)
    if broken.any():
        chain = Chain(steps, runs, broken)
        reached, jumps = chain.reached, chain.jumps
    out = ~reached[runs.of_row]
    frozen = np.zeros(len(time), dtype=bool)
    kept = np.flatnonzero(~out)
    if runs.any_long and len(kept) >= FEWEST_HELD_ROWS:
        if out.any():
            runs_left = Runs.of(time[kept], values[kept])
            frozen[kept] = _frozen(runs_left, Steps.of(runs_left, limits))
        else:
            frozen = _frozen(runs, steps)
    if not (out.any() or frozen.any() or len(jumps)):
        return None
    ends = (out | frozen) & runs.at_ends
    return Discontinuities(
        out & ~ends, frozen & ~ends, ends, runs.first[jumps].astype(int)
    )


def _frozen(runs: Runs, steps: Steps) -> Mask:
    """(K,) samples of runs of equal rows that are longer than usual, and than errors of
    time stamps, and begin or end with a jump.

    The first sample of such a run, at which the stream stalled, is not among them,
    unless it is the first of all: the stream had not begun.
    """
    held = runs.long & (runs.end - runs.time > HELD_TIMING_ERRORS * steps.timing_error)
    if not held.any() or len(runs.first) < FEWEST_HELD_ROWS:
        return np.zeros(len(runs.of_row), dtype=bool)
    length = np.linalg.norm(steps.steps, axis=1)
    jumps = length > steps.starts_from_rest(steps.interval)
    frozen = np.zeros(len(held), dtype=bool)
    frozen[:-1] = held[:-1] & jumps
    # a jump between two held values is the end of the first one's stall
    frozen[1:] |= held[1:] & jumps & ~held[:-1]
    repeated = np.ones(len(runs.of_row), dtype=bool)
    repeated[runs.first[1:]] = False
    return repeated & frozen[runs.of_row]
