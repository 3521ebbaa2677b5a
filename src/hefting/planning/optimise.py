"""Optimisation of a motion, from random ones to start from: Fourier series at rest at
both ends.

The augmented Lagrangian is minimised by L-BFGS: limits g <= 0 join the objective as
mean(max(0, lambda + mu g)² - lambda²) / 2 mu over the instants; after each round lambda
becomes max(0, lambda + mu g) (Nocedal & Wright, *Numerical Optimization*, sec. 17.4).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import field, replace

import numpy as np
from scipy.optimize import minimize

from hefting.core.immutable import immutable
from hefting.core.spatial import Array
from hefting.planning.problem import Basis, Cuts, Look, Problem
from hefting.planning.space import Space

HIGHEST = 1.2
"""[Hz] of a random motion's terms at most."""
FILLED = 0.004
"""Share of the nearest limit that a motion may leave."""
MOST_SHRINKS = 25
"""Times that a motion is shrunk or grown towards its limits."""
SMALLEST = 1e-6
"""Share of a motion below which nothing is left of it."""


def random_ways(
    rng: np.random.Generator, time: Array, joints: int, terms: int, decay: float
) -> Array:
    """(K, n) ways of the joints from the start, of no unit: sum_k a_k (cos k w t - 1) +
    b_k sin k w t, with w one turn over the whole time, velocity and acceleration zero at
    both ends, and amplitudes falling with k to the power of `decay`."""
    k = np.arange(1, terms + 1)
    a, b = rng.normal(size=(2, terms, joints)) * (k**-decay)[:, None]
    a -= np.outer(k**2, k**2 @ a) / float(k**2 @ k**2)
    b -= np.outer(k, k @ b) / float(k @ k)
    angle = 2.0 * np.pi / time[-1] * np.outer(time, k)
    return (np.cos(angle) - 1.0) @ a + np.sin(angle) @ b


def random_motion(problem: Problem, rng: np.random.Generator) -> Array:
    """Free control points (P, n) of a random motion that fills its limits, on the
    optimisation's grid."""
    most = max(int(HIGHEST * problem.duration), 3)
    terms, decay = int(rng.integers(3, most + 1)), rng.uniform(0.0, 1.5)
    time = np.linspace(0.0, problem.duration, problem.basis.values.shape[1])
    ways = random_ways(rng, time, len(problem.start), terms, decay)
    ways *= np.exp(rng.normal(size=len(problem.start)))
    return filled(problem, fitted(problem.basis, ways))


def fitted(basis: Basis, ways: Array) -> Array:
    """Free control points (P, n) of the spline nearest to ways (K, n) on the grid."""
    return np.linalg.lstsq(basis.values[0], ways, rcond=None)[0]


def filled(problem: Problem, x: Array) -> Array:
    """The motion with all its ways multiplied by one number, so that it just keeps the
    limits on the grid."""
    x = x / max(float(np.abs(x).max()), 1e-12)
    return fill_share(lambda scale: largest_share(problem, scale * x)) * x


def fill_share(used: Callable[[float], float], first: float = 0.3) -> float:
    """Largest number found by which a motion may be multiplied, if `used` is the
    largest share of a limit then; that is nearly proportional to it."""
    low, high, scale = 0.0, np.inf, first
    for _ in range(MOST_SHRINKS):
        share = used(scale)
        if share <= 1.0:
            low = scale
        else:
            high = scale
        if (low and share > 1.0 - FILLED) or high < SMALLEST:
            break
        guess = scale * (1.0 - 0.5 * FILLED) / max(share, 0.2)
        scale = guess if low < guess < high else 0.5 * (low + high)
    return low


def largest_share(problem: Problem, x: Array) -> float:
    """Largest share of any limit that a motion uses on the grid."""
    excesses = problem.look(x).excesses()
    return 1.0 + max(float(g.max()) for g in excesses.values())


AIM = 0.015
"""Share of each limit that is left free on the optimisation's grid, as the motion goes a
little further between its instants, and a round leaves a little beyond."""
FIRST_WEIGHT, GROWTH, LARGEST_WEIGHT = 5.0, 3.0, 600.0
"""mu of the first round, its growth from round to round, and its largest value. Found
on motions of 4 and 10 s of three arms."""


@immutable
class Search:
    """A motion on its way to the best, between two rounds."""

    problem: Problem
    x: Array
    """(P, n) free control points"""
    space: Space | None
    multipliers: dict[str, Array] = field(default_factory=dict[str, Array])
    """lambda of each limit at each instant"""
    weight: float = FIRST_WEIGHT
    """mu"""
    aims: dict[str, float] = field(default_factory=dict[str, float])
    """share of each limit that is left free, where it is not `AIM`"""

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
                problem.look(flat.reshape(shape)), multipliers, self.weight, self.aims
            ),
            self.x.ravel(),
            jac=True,
            method="L-BFGS-B",
            options={"maxiter": steps, "maxcor": 20, "ftol": 1e-7},
        )
        x = found.x.reshape(shape)
        after = {
            name: np.maximum(
                0.0, multipliers[name] + self.weight * (g + self.aims.get(name, AIM))
            )
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

    def freer(self, more: dict[str, float]) -> Search:
        """A search with more of some limits left free."""
        raised = {name: self.aims.get(name, AIM) + own for name, own in more.items()}
        return replace(self, aims=self.aims | raised)

    @property
    def value(self) -> float:
        """Logarithm of the deviation that is made least."""
        return self.problem.objective.value(self.problem.look(self.x).after)[0]


def lagrangian(
    look: Look, multipliers: dict[str, Array], weight: float, aims: dict[str, float]
) -> tuple[float, Array]:
    """The augmented Lagrangian and its gradient, flat."""
    value, by_after = look.problem.objective.value(look.after)
    by: dict[str, Array] = {}
    instants = look.features.shape[1]
    for name, g in look.excesses().items():
        own = multipliers[name]
        push = np.maximum(0.0, own + weight * (g + aims.get(name, AIM)))
        value += float(np.sum(push**2 - own**2)) / (2.0 * weight * instants)
        by[name] = push / instants
    return value, look.gradient(by_after, by).ravel()
