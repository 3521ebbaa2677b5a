"""Optimisation of a motion: an augmented Lagrangian, minimised by L-BFGS.

Limits g <= 0 join the objective as mean(max(0, lambda + mu g)² - lambda²) / 2 mu over
the instants; after each round lambda becomes max(0, lambda + mu g) (Nocedal & Wright,
*Numerical Optimization*, sec. 17.4).
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np
from scipy.optimize import minimize

from hefting.core.spatial import Array
from hefting.planning.cuts import Clear, Cuts
from hefting.planning.problem import Look, Problem

AIM = 0.015
"""Share of each limit that is left free on the optimisation's grid, as the motion goes a
little further between its instants, and a round leaves a little beyond."""
FIRST_WEIGHT, GROWTH, LARGEST_WEIGHT = 5.0, 3.0, 600.0
"""mu of the first round, its growth from round to round, and its largest value. Found on
motions of 4 and 10 s of three arms."""


@dataclass(frozen=True, eq=False)
class Search:
    """A motion on its way to the best, between two rounds."""

    problem: Problem
    x: Array
    """(P, n) free control points"""
    space: Clear | None
    """what must not be touched"""
    multipliers: dict[str, Array] = field(default_factory=dict[str, Array])
    """lambda of each limit at each instant"""
    weight: float = FIRST_WEIGHT
    """mu"""
    aim: float = AIM

    def next(self, steps: int) -> Search:
        """After one more round of so many steps of L-BFGS."""
        problem, shape = self.problem, self.problem.size
        if self.space is not None:
            position = problem.basis.states(problem.start, self.x).position
            problem = replace(problem, cuts=Cuts.of(self.space, position))
        multipliers = self.multipliers or {
            name: np.zeros_like(g)
            for name, g in problem.look(self.x).excesses().items()
        }
        found = minimize(
            lambda flat: lagrangian(
                problem.look(flat.reshape(shape)), multipliers, self.weight, self.aim
            ),
            self.x.ravel(),
            jac=True,
            method="L-BFGS-B",
            options={"maxiter": steps, "maxcor": 20, "ftol": 1e-7},
        )
        x = found.x.reshape(shape)
        after = {
            name: np.maximum(0.0, multipliers[name] + self.weight * (g + self.aim))
            for name, g in problem.look(x).excesses().items()
        }
        weight = min(GROWTH * self.weight, LARGEST_WEIGHT)
        return replace(self, problem=problem, x=x, multipliers=after, weight=weight)

    def rounds(self, number: int, steps: int) -> Search:
        """After so many more rounds."""
        own = self
        for _ in range(number):
            own = own.next(steps)
        return own

    @property
    def value(self) -> float:
        """Logarithm of the deviation that is made least."""
        return self.problem.objective.value(self.problem.look(self.x).after)[0]


def lagrangian(
    look: Look, multipliers: dict[str, Array], weight: float, aim: float
) -> tuple[float, Array]:
    """The augmented Lagrangian and its gradient, flat."""
    value, by_after = look.problem.objective.value(look.after)
    by: dict[str, Array] = {}
    instants = look.features.shape[1]
    for name, g in look.excesses().items():
        own = multipliers[name]
        push = np.maximum(0.0, own + weight * (g + aim))
        value += float(np.sum(push**2 - own**2)) / (2.0 * weight * instants)
        by[name] = push / instants
    return value, look.gradient(by_after, by).ravel()
