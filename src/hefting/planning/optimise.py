"""Optimisation of a motion: an augmented Lagrangian, minimised by L-BFGS.

Limits g <= 0 join the objective as mean(max(0, lambda + mu g)² - lambda²) / 2 mu over
the instants; after each round lambda becomes max(0, lambda + mu g) (Nocedal & Wright,
*Numerical Optimization*, sec. 17.4). What is left beyond a limit is scaled away
afterwards (`hefting.planning.feasible`).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.optimize import minimize

from hefting.core.spatial import Array
from hefting.planning.problem import Look, Problem

AIM = 0.015
"""Share of each limit that is left free on the optimisation's grid, as the motion goes a
little further between its instants."""
FIRST_WEIGHT, GROWTH, LARGEST_WEIGHT = 5.0, 3.0, 600.0
"""mu of the first round, its growth from round to round, and its largest value. Found on
motions of 4 and 10 s of three arms."""


@dataclass(frozen=True)
class Effort:
    """How long is searched; numbers of steps, so that the same seed gives the same
    plan on any machine."""

    candidates: int
    """random motions that are looked at first"""
    starts: int
    """best of these that are optimised"""
    rounds: int
    """of the multipliers, each of the starts"""
    steps: int
    """of L-BFGS in each round"""


EFFORTS = {
    "full": Effort(60, 3, 6, 60),
    "quick": Effort(16, 1, 4, 40),
}
"""Full: some 2,000 evaluations; quick: a tenth, for use while a robot waits."""


def optimised(problem: Problem, x: Array, effort: Effort) -> Array:
    """Free control points (P, n) of a better motion, near `x`; it may be a little
    beyond its limits."""
    shape, weight = problem.size, FIRST_WEIGHT
    multipliers = {
        name: np.zeros_like(g) for name, g in problem.look(x).excesses().items()
    }
    for _ in range(effort.rounds):
        found = minimize(
            lambda flat, w=weight, m=multipliers: _value(
                problem.look(flat.reshape(shape)), m, w
            ),
            x.ravel(),
            jac=True,
            method="L-BFGS-B",
            options={"maxiter": effort.steps, "maxcor": 20, "ftol": 1e-7},
        )
        x = found.x.reshape(shape)
        excesses = problem.look(x).excesses()
        multipliers = {
            name: np.maximum(0.0, multipliers[name] + weight * (g + AIM))
            for name, g in excesses.items()
        }
        weight = min(GROWTH * weight, LARGEST_WEIGHT)
    return x


def _value(
    look: Look, multipliers: dict[str, Array], weight: float
) -> tuple[float, Array]:
    """The augmented Lagrangian and its gradient, flat."""
    value, by_after = look.problem.objective.value(look.after)
    by: dict[str, Array] = {}
    instants = look.features.shape[1]
    for name, g in look.excesses().items():
        own = multipliers[name]
        push = np.maximum(0.0, own + weight * (g + AIM))
        value += float(np.sum(push**2 - own**2)) / (2.0 * weight * instants)
        by[name] = push / instants
    return value, look.gradient(by_after, by).ravel()
