"""Search for the best motion: the best of random motions are optimised, and the best of
these that keeps every limit is chosen."""

from collections import Counter
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from hefting.core.errors import InputError
from hefting.core.progress import report
from hefting.core.spatial import Array, immutable
from hefting.planning.check import Usage
from hefting.planning.kinematics import Trajectory
from hefting.planning.limits import CLEARANCE
from hefting.planning.optimise import Search, fill_share, random_motion
from hefting.planning.problem import Problem
from hefting.planning.solids import OBJECT
from hefting.planning.space import Space

MOST_REPAIRS = 5
"""Rounds by which a motion that exceeds its limits on the fine grid is repaired."""
MOST_REPAIRED = 2
"""Number of optimised motions that are repaired, or else of random ones."""
MORE = 0.003
"""Share of a limit that a repair leaves unused, in addition to the excess."""
LEAST_SHARE = 1e-3
"""Least scale to which a motion is reduced to keep its limits."""
STARTS_A_START = 4
"""Random motions from each random start."""
DRAWS = 400
"""Number of random configurations that are tried as starts at once."""
MOST_DRAWN = 25
"""Times that this is done until one is clear: in narrow cells one of 2,000 is."""
LOOKED_AT = 100
"""Number of them for which an error counts obstacles, if none is clear."""
ELBOW_ROOM = 0.03
"""[m] Clearance of random starts from which on all are alike."""


class Found(NamedTuple):
    """A motion with the limits that it uses."""

    problem: Problem
    trajectory: Trajectory
    usage: Usage
    value: float
    """objective"""
    after: Array
    """(10, 10) information after the motion"""


ANOTHER = "give another `start`"
"""Advice against an impossible start."""


@immutable
class Effort:
    """Lengths of the search in steps, so that a seed gives one plan on all machines."""

    candidates: int
    """random motions"""
    starts: int
    """best of these, which are optimised"""
    rounds: int
    """of the augmented Lagrangian, for each of them"""
    steps: int
    """of L-BFGS in each round"""
    polish: int
    """more rounds for the best"""


EFFORTS = {
    "full": Effort(60, 4, 6, 60, 4),
    "next": Effort(30, 2, 6, 50, 2),
    "quick": Effort(20, 1, 6, 40, 0),
}
"""Full: some 2,000 evaluations; next, from an estimate: a third; quick, while a robot
waits: a tenth."""


@immutable
class Searcher:
    """Search for a motion of named joints in a space."""

    joints: tuple[str, ...]
    space: Space
    effort: Effort
    rng: np.random.Generator

    @property
    def solid(self) -> Space | None:
        """The space; None if it has no half-spaces and no pairs of solids."""
        space = self.space
        return space if space.half_spaces or space.contacts else None

    def best(self, problem: Problem, starts: Array) -> Found:
        """The best motion from one of `starts` (s, n) [rad]; `InputError` if none keeps
        the limits."""
        drafts = self._drafts(problem, starts)
        if not drafts:
            raise self._infeasible(problem, starts)
        report("planning", 0.1)
        searches: list[Search] = []
        for i, draft in enumerate(drafts[: self.effort.starts]):
            searches.append(draft.rounds(self.effort.rounds, self.effort.steps))
            report("planning", 0.1 + 0.6 * (i + 1) / self.effort.starts)
        searches.sort(key=lambda search: search.value)
        searches[0] = searches[0].rounds(self.effort.polish, 2 * self.effort.steps)
        for mended in (
            map(self._repaired, searches[:MOST_REPAIRED]),
            map(self._shrunk, drafts[:MOST_REPAIRED]),
        ):
            kept = [found for found in mended if found]
            if kept:
                return min(kept, key=lambda found: found.value)
        raise self._infeasible(problem, starts)

    def _drafts(self, problem: Problem, starts: Array) -> list[Search]:
        """Random motions to optimise, those without contact first, then by value."""
        drafts = []
        for i in range(self.effort.candidates):
            start = starts[i // STARTS_A_START % len(starts)]
            own = replace(problem, start=start)
            x = random_motion(own, self.rng)
            if np.abs(x).max() > 0.0:
                drafts.append(Search(own, x, self.solid))

        def touches(draft: Search) -> bool:
            q = draft.problem.basis.states(draft.problem.start, draft.x).position
            return draft.space is not None and draft.space.clearance(q).min() < 0.0

        return sorted(drafts, key=lambda draft: (touches(draft), draft.value))

    def _repaired(self, search: Search) -> Found | None:
        """The motion, optimised further until it keeps all limits on the fine grid, or
        else made smaller."""
        for _ in range(MOST_REPAIRS):
            found = self.found(search.problem, search.x)
            if found.usage.largest <= 1.0:
                return found
            more = {name: g + MORE for name, g in found.usage.beyond.items()}
            search = search.freer(more).next(self.effort.steps)
        found = self.found(search.problem, search.x)
        return found if found.usage.largest <= 1.0 else self._shrunk(search)

    def _shrunk(self, search: Search) -> Found | None:
        """The motion, scaled down until it keeps all limits; None below `LEAST_SHARE`."""

        def scaled(share: float) -> Found:
            return self.found(search.problem, share * search.x)

        share = fill_share(lambda share: scaled(share).usage.largest, 1.0)
        return None if share < LEAST_SHARE else scaled(share)

    def found(self, problem: Problem, x: Array) -> Found:
        """The motion of free control points (P, n), with its usage of limits."""
        trajectory = problem.basis.trajectory(problem.start, x)
        return self.measured(problem, trajectory, problem.look(x).after)

    def measured(self, problem: Problem, trajectory: Trajectory, after: Array) -> Found:
        """A motion with its usage of limits and the information `after` it (10, 10)."""
        usage = Usage.of(
            trajectory, problem.chain, problem.constraints, self.joints, self.solid
        )
        return Found(
            problem, trajectory, usage, problem.objective.value(after)[0], after
        )

    def free_starts(self, problem: Problem, number: int) -> Array:
        """Random starts (s, n) [rad] within all limits and in contact with nothing, at
        most `number`; `InputError` if none is found."""
        ends = problem.constraints.limits.position
        near = np.clip(0.0, *ends.T)[:, None]
        ends = np.clip(ends, near - np.pi, near + np.pi)
        middle, half = ends.mean(axis=1), 0.35 * (ends[:, 1] - ends[:, 0])
        draws, room = middle[None], np.full(DRAWS, np.inf)
        for _ in range(MOST_DRAWN):
            draws = middle + half * self.rng.uniform(-1.0, 1.0, (DRAWS, len(ends)))
            if self.solid is not None:
                room = self.solid.clearance(draws)
            if room.max() >= CLEARANCE:
                break
        starts: list[Array] = []
        for k in np.argsort(-np.minimum(room, ELBOW_ROOM), kind="stable"):
            if room[k] < CLEARANCE or len(starts) == number:
                break
            if self._is_within(problem, draws[k]):
                starts.append(draws[k])
        if not starts and room.max() >= CLEARANCE:
            raise self._infeasible(problem, draws[[int(np.argmax(room))]])
        if not starts:
            raise _nowhere_clear(self.space, draws)
        return np.array(starts)

    def require_free(self, problem: Problem, start: Array) -> None:
        """`InputError` for a start (n,) that exceeds a limit or is in collision."""
        limits = problem.constraints.limits
        for name, q, (low, high) in zip(
            self.joints, start, limits.position, strict=True
        ):
            if not low <= q <= high:
                what = f"joint '{name}' starts at {q:.4g} rad, outside {low:.4g} to {high:.4g} rad"
                degrees = np.abs(start).max() > 2.0 * np.pi
                fix = "give `start` in radians, not degrees" if degrees else ANOTHER
                raise InputError(what, fix=fix)
        if self.solid is not None:
            clear, names = self.solid.nearest(start[None])
            if clear < 0.0:
                what = f"the start is in collision by {-1e3 * clear:.0f} mm: {names}"
                raise InputError(what, fix=ANOTHER)
        rest = self.found(replace(problem, start=start), np.zeros(problem.size))
        if rest.usage.largest > 1.0:
            what = f"{rest.usage.worst} is beyond its limit at the start already"
            raise InputError(what, fix="give another `start`, or relax that limit")

    def _is_within(self, problem: Problem, start: Array) -> bool:
        """Whether a start (n,) is within all limits."""
        own = replace(problem, start=start)
        excesses = own.look(np.zeros(own.size)).excesses()
        return max(float(g.max()) for g in excesses.values()) < 0.0

    def _infeasible(self, problem: Problem, starts: Array) -> InputError:
        own = replace(problem, start=starts[0])
        rest = self.found(own, np.zeros(own.size))
        what = f"no motion keeps all limits; the tightest is {rest.usage.worst}"
        return InputError(what, fix="relax it, or start elsewhere (`start`)")


def _nowhere_clear(space: Space, draws: Array) -> InputError:
    """The error if no random configuration (d, n) is clear: the most frequent obstacle,
    and advice on it."""
    near = Counter(space.nearest(q)[1] for q in draws[:LOOKED_AT])
    [(names, count)] = near.most_common(1)
    what = (
        f"none of {MOST_DRAWN * DRAWS:,} random places to start from is clear of everything: most "
        f"often ({100 * count / len(draws[:LOOKED_AT]):.0f} %) it is {names}"
    )
    fix = "`srdf`, if these cannot touch"
    if any(names.endswith(half.text) for half in space.half_spaces):
        fix = "relax `keep`"
    elif OBJECT in names:
        fix = "the object's own `shape`, or its box"
    return InputError(what, fix=f"give `start`, or {fix}")


def effort_named(name: str) -> Effort:
    """One of `EFFORTS`; `InputError` for another name."""
    if name not in EFFORTS:
        raise InputError(f"effort is '{name}'", fix=f"use {' or '.join(EFFORTS)}")
    return EFFORTS[name]
