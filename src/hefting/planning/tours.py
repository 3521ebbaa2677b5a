"""Stop and go: rests in a few poses, for mass and COM alone.

At rest only gravity's direction in the sensor's axes tells anything (Atkeson et al.
1986): the more it changes from pose to pose, and the longer the arm rests, the better.
"""

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from hefting.core.accuracy import Accuracy
from hefting.core.errors import InputError
from hefting.core.immutable import immutable
from hefting.core.spatial import Array, frozen
from hefting.planning.information import features
from hefting.planning.kinematics import AT_REST, DEGREE, Trajectory
from hefting.planning.limits import CLEARANCE
from hefting.planning.problem import GRID, Problem
from hefting.planning.search import Found, Searcher

COUNTS = (4, 5, 6)
"""Poses that are tried. Mass, COM and a free bias need three at least."""
STEPS = 600
"""Of the search for the poses of each count."""
FIRST_STEP = 0.5
"""[rad] by which poses are moved in the first step, one standard deviation."""
GROWTH, SHRINKAGE = 1.4, 0.92
"""Of that after a better and after a worse try, so that a fifth succeeds."""
ALONG = 8
"""Instants of each move that are looked at."""
SHORTEST_REST = 0.3
"""[s] in each pose: what shakes has settled."""
PEAKS = 15.0 / 8.0, 10.0 / 3.0**0.5, 60.0
"""Largest speed, acceleration and jerk of a minimum-jerk move of 1 rad in 1 s (Flash &
Hogan 1985)."""
SLACK = 1.02
"""Factor of a move's time over the least, for what happens between instants."""


@immutable
class Tour:
    """Rests in N poses of n joints, minimum-jerk moves between."""

    poses: Array
    """(N, n) [rad]"""
    moves: Array
    """(N - 1,) [s]"""
    rest: float
    """[s] in each pose"""

    def trajectory(self) -> Trajectory:
        """The motion: a spline of degree five with three equal control points for each
        knot, which is at rest there."""
        spans = np.full(2 * len(self.poses) - 1, self.rest)
        spans[1::2] = self.moves
        inner = np.concatenate(([0.0], np.cumsum(spans)))
        repeats = np.full(len(inner), AT_REST)
        repeats[[0, -1]] = DEGREE + 1
        stays = np.repeat(self.poses, 2 * AT_REST, axis=0)
        return Trajectory(np.repeat(inner, repeats), stays)


def best_tour(
    problem: Problem,
    rng: np.random.Generator,
    is_free: Callable[[Array], bool],
    steps: int = STEPS,
) -> Tour | None:
    """The tour from the problem's start, of its duration, that leaves the least
    uncertainty by its objective; None where none was found.

    `is_free` tells of joint positions (K, n) whether they touch nothing.
    """
    found = [_search(problem, rng, is_free, count, steps) for count in COUNTS]
    known = [each for each in found if each is not None]
    return min(known, key=lambda each: each[0])[1] if known else None


def minimum_jerk(share: Array) -> tuple[Array, Array, Array]:
    """Way, speed and acceleration at shares of the time of a move of 1 in 1 s."""
    u = share
    way = u**3 * (10.0 - 15.0 * u + 6.0 * u**2)
    speed = 30.0 * u**2 * (1.0 - u) ** 2
    return way, speed, 60.0 * u * (1.0 - u) * (1.0 - 2.0 * u)


def _search(
    problem: Problem,
    rng: np.random.Generator,
    is_free: Callable[[Array], bool],
    count: int,
    steps: int,
) -> tuple[float, Tour] | None:
    """The best of a random walk that goes only where it is better: its value and
    tour."""
    best: tuple[float, Tour] | None = None
    poses = np.repeat(problem.start[None], count, axis=0)
    step = FIRST_STEP
    for _ in range(steps):
        tried = poses + step * rng.normal(size=poses.shape)
        tried = np.clip(tried, *problem.constraints.limits.position.T)
        tried[0] = problem.start
        tour = timed(problem, tried)
        value = np.inf if tour is None else _value(problem, tour)
        is_better = best is None or value < best[0]
        if tour is None or not (is_better and is_free(_along(tried)[0])):
            step *= SHRINKAGE
            continue
        best, poses = (value, tour), tried
        step *= GROWTH
    return best


def timed(problem: Problem, poses: Array) -> Tour | None:
    """The tour through poses (N, n) with moves as quick as the limits allow; None where
    no time is left to rest."""
    limits = problem.constraints.limits
    way = np.abs(np.diff(poses, axis=0))
    speed, acceleration, jerk = PEAKS
    moves = np.maximum.reduce(
        [
            (speed * way / limits.speed).max(axis=1),
            np.sqrt(acceleration * way / limits.acceleration).max(axis=1),
            np.cbrt(jerk * way / limits.jerk).max(axis=1),
            _corner_times(problem, poses),
        ]
    )
    moves = np.maximum(SLACK * moves, 1e-2)
    rest = (problem.duration - moves.sum()) / len(poses)
    return Tour(frozen(poses), frozen(moves), rest) if rest >= SHORTEST_REST else None


def _corner_times(problem: Problem, poses: Array) -> Array:
    """Least times (N - 1,) [s] of the moves that keep the speed of the corners."""
    q, dq = _along(poses)
    own = problem.constraints
    tip = problem.chain.forward(q, dq, np.zeros_like(q)).motion
    velocities = own.corner_velocities(tip)
    speeds = np.linalg.norm(velocities, axis=1).max(axis=0)
    return speeds.reshape(len(poses) - 1, -1).max(axis=1) / own.limits.corner_speed


def _along(poses: Array) -> tuple[Array, Array]:
    """Joint positions and speeds ((N - 1) m, n) on moves of one second each."""
    way, speed, _ = minimum_jerk(np.linspace(0.0, 1.0, 2 * ALONG + 1)[1:])
    first, step = poses[:-1, None], np.diff(poses, axis=0)[:, None]
    n = poses.shape[1]
    q = first + way[:, None] * step
    return q.reshape(-1, n), (speed[:, None] * step).reshape(-1, n)


def _value(problem: Problem, tour: Tour) -> float:
    """What the rests leave of the uncertainty."""
    still = np.zeros_like(tour.poses)
    passed = problem.chain.forward(tour.poses, still, still)
    resting = tour.rest * len(tour.poses)
    gained = problem.information.gained(passed, features(passed.motion), resting)
    return problem.objective.value(problem.known + gained)[0]


USUAL = Accuracy(mass=0.01, center_of_mass=0.002)
"""Whose worst is made least, where nothing is asked."""
MOST_SLOWED = 4
"""Times that the moves are made slower."""


def asked_of_tour(asked: Accuracy | None) -> Accuracy:
    """What rests are planned for; `InputError` where that is an inertia."""
    if asked is not None and asked.inertia is not None:
        what = "rests do not tell an inertia"
        raise InputError(what, fix="ask for mass and com alone, or plan a motion")
    return asked or USUAL


def planned_tour(searcher: Searcher, problem: Problem, start: Array) -> Found:
    """The best rests from a place to start from (n,). `InputError` where no move keeps
    the limits."""
    problem = replace(problem, start=start)
    tour = best_tour(problem, searcher.rng, lambda q: _is_free(searcher, q))
    for _ in range(MOST_SLOWED):
        if tour is None:
            break
        found = _found(searcher, problem, tour)
        if found.usage.largest <= 1.0:
            return found
        tour = _slower(tour, 1.01 * min(found.usage.largest, 1.5))
    what = f"no poses with rests are within reach in {problem.duration:g} s"
    raise InputError(what, fix="plan for longer, or relax the limits")


def _is_free(searcher: Searcher, q: Array) -> bool:
    solid = searcher.solid
    return solid is None or bool(solid.clearance(q).min() > 2.0 * CLEARANCE)


def _slower(tour: Tour, factor: float) -> Tour | None:
    """A tour with moves so many times as long; None where no time is left to rest."""
    moves = factor * tour.moves
    rest = tour.rest - float((moves - tour.moves).sum()) / len(tour.poses)
    return Tour(tour.poses, moves, rest) if rest >= SHORTEST_REST else None


def _found(searcher: Searcher, problem: Problem, tour: Tour) -> Found:
    trajectory = tour.trajectory()
    motion = trajectory.sampled(GRID)
    still = np.zeros_like(motion.position)
    passed = problem.chain.forward(motion.position, still, still)
    x = features(passed.motion)
    after = problem.known + problem.information.gained(passed, x, problem.duration)
    return searcher.measured(problem, trajectory, after)
