"""Continuity of poses: samples that no moving body can have passed.

Samples that cannot be reached from the others are glitches. A value that is repeated
exactly and from which the next step is a jump is not that of a body at rest: the stream
stalled, or had not begun.
"""

import numpy as np

from hefting.core.spatial import Array, Indices, Mask, immutable, lengths
from hefting.motion.pose_steps import (
    FEWEST_HELD_ROWS,
    STEPS_OF_VELOCITY,
    Limits,
    Runs,
    Steps,
)

HELD_TIMING_ERRORS = 2.0
"""Shortest stall of a stream, in errors of time stamps. Shorter ones are part of every
log: in recordings at a nominal 1 kHz some last 3 to 8 ms."""

PIECES_LOOKED_BACK = 40
"""Number of earlier pieces from which a piece may be reached."""
JUMP_COST = 1.0
"""[s] Duration of the poses that a jump costs: two parts of a recording that cannot be
reached from each other are both kept if each lasts longer."""


@immutable
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
    time stamps, and begin or end with a jump. The first sample of a run, at which the
    stream stalled, is not included, unless it is the first of all: the stream had not
    begun."""
    held = runs.long & (runs.end - runs.time > HELD_TIMING_ERRORS * steps.timing_error)
    if not held.any() or len(runs.first) < FEWEST_HELD_ROWS:
        return np.zeros(len(runs.of_row), dtype=bool)
    length = lengths(steps.steps)
    jumps = length > steps.starts_from_rest(steps.interval)
    frozen = np.zeros(len(held), dtype=bool)
    frozen[:-1] = held[:-1] & jumps
    # a jump between two held values is the end of the first one's stall
    frozen[1:] |= held[1:] & jumps & ~held[:-1]
    repeated = np.ones(len(runs.of_row), dtype=bool)
    repeated[runs.first[1:]] = False
    return repeated & frozen[runs.of_row]


class Chain:
    """The longest chain of pieces of a stream, each of which can be reached from the
    one before.

    A piece is what is between two breaks. It is not reached from the piece just before
    it unless that ends with a held value, as the body may have moved meanwhile, or one
    of the two samples at the break may be the only fault. A jump between two pieces
    costs the samples of `JUMP_COST`.
    """

    reached: Mask
    """(U,) the samples of the chain"""
    jumps: Indices
    """first samples of those of its pieces that follow a jump"""

    def __init__(self, steps: Steps, runs: Runs, broken: Mask):
        """Of steps between U runs of equal samples, of which some (U - 1,) are
        `broken`."""
        breaks = np.flatnonzero(broken)
        self._steps = steps
        self._first = np.concatenate(([0], breaks + 1))
        self._last = np.concatenate((breaks, [len(broken)]))
        self._samples = np.add.reduceat(runs.length, self._first).astype(float)
        self._held = runs.long[self._last]
        duration = float(runs.end[-1] - runs.time[0])
        self._cost = JUMP_COST * float(self._samples.sum()) / duration
        # no jump leads to a value that is only held, however long it lasts
        single = self._first == self._last
        most = np.where(single, 0.5 * self._cost, np.inf)
        self._samples = np.minimum(self._samples, most)
        self._link()
        self._follow()

    def _link(self) -> None:
        """Find for each piece the one from which it is best reached (dynamic
        programming)."""
        score = self._samples.copy()
        self._before = np.full(len(score), -1)
        self._jumped = np.zeros(len(score), dtype=bool)
        self._trimmed = np.zeros(len(score), dtype=bool)
        for p in range(1, len(score)):
            best = int(np.argmax(score[:p]))
            if score[best] > self._cost:
                score[p] += score[best] - self._cost
                self._before[p], self._jumped[p] = best, True
            near = self._reached_from(p)
            if not len(near) and self._reached_when_trimmed(p):
                near, self._trimmed[p] = np.array([p - 1]), True
            source = int(near[np.argmax(score[near])]) if len(near) else -1
            if source >= 0 and self._samples[p] + score[source] > score[p]:
                score[p] = self._samples[p] + score[source]
                self._before[p], self._jumped[p] = source, False
        self._score = score

    def _reached_from(self, p: int) -> Indices:
        """The earlier pieces from which piece `p` is reached."""
        stalled = self._held[p - 1] and self._last[p] > self._first[p]
        earlier = np.arange(max(p - PIECES_LOOKED_BACK, 0), p - 1 + stalled)
        begin, end = self._first[earlier], self._last[earlier]
        return earlier[
            self._steps.reaches(begin, end, int(self._first[p]), int(self._last[p]))
        ]

    def _reached_when_trimmed(self, p: int) -> bool:
        """Whether a piece is reached from the one before if both samples at the break
        are left out."""
        length = (self._last - self._first)[p - 1 : p + 1]
        if (length < STEPS_OF_VELOCITY).any():
            return False
        begin, end = self._first[p - 1 : p], self._last[p - 1 : p] - 1
        first, last = int(self._first[p]) + 1, int(self._last[p])
        return bool(self._steps.reaches(begin, end, first, last)[0])

    def _follow(self) -> None:
        """Collect the chain of largest score from its end."""
        self.reached = np.zeros(int(self._last[-1]) + 1, dtype=bool)
        p, jumps, trimmed = int(np.argmax(self._score)), [], []
        while p >= 0:
            self.reached[self._first[p] : self._last[p] + 1] = True
            if self._jumped[p]:
                jumps.append(int(self._first[p]))
            elif self._trimmed[p]:
                trimmed += [int(self._first[p]) - 1, int(self._first[p])]
            p = int(self._before[p])
        self.reached[trimmed] = False
        self.jumps = np.array(jumps[::-1], dtype=int)
