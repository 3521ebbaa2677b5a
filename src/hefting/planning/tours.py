"""A plan of rests in a few poses, with all limits kept between them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from hefting.core.accuracy import Accuracy
from hefting.core.errors import InputError
from hefting.core.spatial import Array
from hefting.planning.check import Usage
from hefting.planning.constraints import CLEARANCE
from hefting.planning.information import features
from hefting.planning.poses import SHORTEST_REST, Tour, best_tour
from hefting.planning.problem import GRID, Problem
from hefting.planning.search import Found, Searcher

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
    """With moves so many times as long; None where no time is left to rest."""
    moves = factor * tour.moves
    rest = tour.rest - float((moves - tour.moves).sum()) / len(tour.poses)
    return Tour(tour.poses, moves, rest) if rest >= SHORTEST_REST else None


def _found(searcher: Searcher, problem: Problem, tour: Tour) -> Found:
    trajectory = tour.trajectory()
    usage = Usage.of(
        trajectory,
        problem.chain,
        problem.constraints,
        searcher.joints,
        searcher.solid,
    )
    motion = trajectory.sampled(GRID)
    still = np.zeros_like(motion.position)
    passed = problem.chain.forward(motion.position, still, still)
    x = features(passed.motion)
    after = problem.known + problem.information.gained(passed, x, problem.duration)
    value = problem.objective.value(after)[0]
    return Found(problem, trajectory, usage, value, after)
