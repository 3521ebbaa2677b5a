"""Stop and go: rests in a few poses, for mass and COM alone.

At rest only gravity's direction in sensor axes gives information (Atkeson et al. 1986),
the more, the more it differs between poses and the longer the arm rests.
"""

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from hefting.core.accuracy import Accuracy
from hefting.core.errors import InputError
from hefting.core.spatial import Array, frozen, immutable
from hefting.planning.information import features
from hefting.planning.kinematics import AT_REST, DEGREE, Trajectory
from hefting.planning.limits import CLEARANCE
from hefting.planning.problem import GRID, Problem
from hefting.planning.search import Found, Searcher

COUNTS = (4, 5, 6)
"""Numbers of poses that are tried. Mass, COM and a free bias need at least three."""
STEPS = 600
"""Number of steps of the search for each number of poses."""
FIRST_STEP = 0.5
"""[rad] Standard deviation of the first step."""
GROWTH, SHRINKAGE = 1.4, 0.92
"""Factors of it after a success and after a failure, for one success in five steps."""
ALONG = 8
"""Half the number of instants at which each move is checked."""
SHORTEST_REST = 0.3
"""[s] in each pose, for vibrations to settle."""
PEAKS = 15.0 / 8.0, 10.0 / 3.0**0.5, 60.0
"""Largest speed, acceleration and jerk of a minimum-jerk move of 1 rad in 1 s (Flash &
Hogan 1985)."""
SLACK = 1.02
"""Factor of a move's time over the least, as speeds are larger between instants."""


@immutable
class Tour:
    """Rests in N poses of n joints, with minimum-jerk moves between."""

    poses: Array
    """(N, n) [rad]"""
    moves: Array
    """(N - 1,) [s]"""
    rest: float
    """[s] in each pose"""

    def trajectory(self) -> Trajectory:
        """The motion as a spline of degree five, whose equal control points give rests
        and minimum-jerk moves exactly."""
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
    """The tour from the problem's start, of its duration, with the least objective; None
    if none was found.

    `is_free` is whether joint positions (K, n) are clear of everything.
    """
    tried = [_search(problem, rng, is_free, count, steps) for count in COUNTS]
    found = [each for each in tried if each is not None]
    return min(found, key=lambda each: each[0])[1] if found else None


def minimum_jerk(u: Array) -> tuple[Array, Array]:
    """Displacement and speed at times `u` of a move of 1 in 1 s."""
    way = u**3 * (10.0 - 15.0 * u + 6.0 * u**2)
    return way, 30.0 * u**2 * (1.0 - u) ** 2


def _search(
    problem: Problem,
    rng: np.random.Generator,
    is_free: Callable[[Array], bool],
    count: int,
    steps: int,
) -> tuple[float, Tour] | None:
    """Value and tour of the best poses by a random search that accepts improvements."""
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
    """The tour through poses (N, n) with the fastest moves within limits; None if rests
    are shorter than `SHORTEST_REST`."""
    limits = problem.constraints.limits
    distance = np.abs(np.diff(poses, axis=0))
    speed, acceleration, jerk = PEAKS
    moves = np.maximum.reduce(
        [
            (speed * distance / limits.speed).max(axis=1),
            np.sqrt(acceleration * distance / limits.acceleration).max(axis=1),
            np.cbrt(jerk * distance / limits.jerk).max(axis=1),
            _corner_times(problem, poses),
        ]
    )
    moves = np.maximum(SLACK * moves, 1e-2)
    rest = (problem.duration - moves.sum()) / len(poses)
    return Tour(frozen(poses), frozen(moves), rest) if rest >= SHORTEST_REST else None


def _corner_times(problem: Problem, poses: Array) -> Array:
    """Least times (N - 1,) [s] of the moves by the limit of the corners' speed."""
    q, dq = _along(poses)
    constraints = problem.constraints
    tip = problem.chain.forward(q, dq, np.zeros_like(q)).motion
    velocities = constraints.corner_velocities(tip)
    speeds = np.linalg.norm(velocities, axis=1).max(axis=0)
    fastest = speeds.reshape(len(poses) - 1, -1).max(axis=1)
    return fastest / constraints.limits.corner_speed


def _along(poses: Array) -> tuple[Array, Array]:
    """Joint positions and speeds ((N - 1) 2 `ALONG`, n) on moves of one second each."""
    way, speed = minimum_jerk(np.linspace(0.0, 1.0, 2 * ALONG + 1)[1:])
    first, step = poses[:-1, None], np.diff(poses, axis=0)[:, None]
    n = poses.shape[1]
    q = first + way[:, None] * step
    return q.reshape(-1, n), (speed[:, None] * step).reshape(-1, n)


def _value(problem: Problem, tour: Tour) -> float:
    """The objective after the rests."""
    zeros = np.zeros_like(tour.poses)
    passed = problem.chain.forward(tour.poses, zeros, zeros)
    resting = tour.rest * len(tour.poses)
    gained = problem.information.gained(passed, features(passed.motion), resting)
    return problem.objective.value(problem.known + gained)[0]


USUAL = Accuracy(mass=0.01, center_of_mass=0.002)
"""Default accuracy that rests are planned for."""
MOST_SLOWED = 4
"""Number of times that moves are slowed down to keep limits."""


def asked_of_tour(asked: Accuracy | None) -> Accuracy:
    """The accuracy that rests are planned for; `InputError` if it has an inertia."""
    if asked is not None and asked.inertia is not None:
        what = "rests do not show an inertia"
        raise InputError(what, fix="ask for mass and com alone, or plan a motion")
    return asked or USUAL


def planned_tour(searcher: Searcher, problem: Problem, start: Array) -> Found:
    """The best tour from positions `start` (n,); `InputError` if none keeps limits."""
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
    """A tour with moves `factor` times as long; None if rests become too short."""
    moves = factor * tour.moves
    rest = tour.rest - float((moves - tour.moves).sum()) / len(tour.poses)
    return Tour(tour.poses, moves, rest) if rest >= SHORTEST_REST else None


def _found(searcher: Searcher, problem: Problem, tour: Tour) -> Found:
    trajectory = tour.trajectory()
    motion = trajectory.sampled(GRID)
    zeros = np.zeros_like(motion.position)
    passed = problem.chain.forward(motion.position, zeros, zeros)
    x = features(passed.motion)
    after = problem.known + problem.information.gained(passed, x, problem.duration)
    return searcher.measured(problem, trajectory, after)
