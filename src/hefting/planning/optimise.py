"""Optimisation of a motion, from random initial ones: Fourier series at rest at both
ends.

The augmented Lagrangian is minimised by L-BFGS: constraints g <= 0 add
mean(max(0, lambda + mu g)² - lambda²) / 2 mu over the instants to the objective; after
each round lambda becomes max(0, lambda + mu g) (Nocedal & Wright, *Numerical
Optimization*, sec. 17.4).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import field, replace

import numpy as np
from scipy.optimize import minimize

from hefting.core.spatial import Array, immutable
from hefting.planning.problem import Basis, Cuts, Look, Problem
from hefting.planning.space import Space

HIGHEST = 1.2
"""[Hz] Highest frequency of a random motion's terms."""
FILLED = 0.004
"""Largest share of the nearest limit that is left unused when a motion is scaled."""
MOST_SHRINKS = 25
"""Largest number of steps of this scaling."""
SMALLEST = 1e-6
"""Least scale that is tried."""


def random_ways(
    rng: np.random.Generator, time: Array, joints: int, terms: int, decay: float
) -> Array:
    """(K, n) random displacements of joints, without unit, with zero velocity and
    acceleration at both ends: sum_k a_k (cos k w t - 1) + b_k sin k w t, w one turn over
    the whole time, with amplitudes in proportion to k^-`decay`."""
    k = np.arange(1, terms + 1)
    a, b = rng.normal(size=(2, terms, joints)) * (k**-decay)[:, None]
    a -= np.outer(k**2, k**2 @ a) / float(k**2 @ k**2)
    b -= np.outer(k, k @ b) / float(k @ k)
    angle = 2.0 * np.pi / time[-1] * np.outer(time, k)
    return (np.cos(angle) - 1.0) @ a + np.sin(angle) @ b


def random_motion(problem: Problem, rng: np.random.Generator) -> Array:
    """Free control points (P, n) of a random motion just within limits on the grid."""
    most = max(int(HIGHEST * problem.duration), 3)
    terms, decay = int(rng.integers(3, most + 1)), rng.uniform(0.0, 1.5)
    time = np.linspace(0.0, problem.duration, problem.basis.values.shape[1])
    ways = random_ways(rng, time, len(problem.start), terms, decay)
    ways *= np.exp(rng.normal(size=len(problem.start)))
    return filled(problem, fitted(problem.basis, ways))


def fitted(basis: Basis, ways: Array) -> Array:
    """Free control points (P, n) of the spline nearest to displacements (K, n)."""
    return np.linalg.lstsq(basis.values[0], ways, rcond=None)[0]


def filled(problem: Problem, x: Array) -> Array:
    """The motion, scaled so that it just keeps the limits on the grid."""
    x = x / max(float(np.abs(x).max()), 1e-12)
    return fill_share(lambda scale: largest_share(problem, scale * x)) * x


def fill_share(used: Callable[[float], float], first: float = 0.3) -> float:
    """Largest scale of a motion that keeps its limits, where `used` is the largest share
    of a limit at a scale, nearly proportional to it; zero if none was found."""
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
    """Largest share of a limit on the grid, for free control points (P, n)."""
    excesses = problem.look(x).excesses()
    return 1.0 + max(float(g.max()) for g in excesses.values())


AIM = 0.015
"""Share of each limit that is left unused on the grid, as shares are larger between its
instants, and a round exceeds limits slightly."""
FIRST_WEIGHT, GROWTH, LARGEST_WEIGHT = 5.0, 3.0, 600.0
"""mu of the first round, its growth per round, and its largest value, tuned on motions
of 4 and 10 s of three arms."""
STRIDE = 1.0
"""[rad] Farthest that a control point moves in the first round beside solids or walls, as
their clearances are linear nearby only; in proportion to mu^-0.5 later."""


@immutable
class Search:
    """State of the optimisation between two rounds."""

    problem: Problem
    x: Array
    """(P, n) free control points"""
    space: Space | None
    multipliers: dict[str, Array] = field(default_factory=dict[str, Array])
    """lambda of each limit at each instant"""
    weight: float = FIRST_WEIGHT
    """mu"""
    aims: dict[str, float] = field(default_factory=dict[str, float])
    """share of each limit that is left unused, if not `AIM`"""

    def next(self, steps: int) -> Search:
        """The state after one more round of `steps` of L-BFGS."""
        problem, shape = self.problem, self.problem.size
        if self.space is not None:
            position = problem.basis.states(problem.start, self.x).position
            problem = replace(problem, cuts=Cuts.of(self.space, position))
        flat = self.x.ravel()
        near = STRIDE * (FIRST_WEIGHT / self.weight) ** 0.5
        reach = np.inf if self.space is None else near
        before = self.multipliers
        result = minimize(
            lambda flat: lagrangian(
                problem.look(flat.reshape(shape)), before, self.weight, self.aims
            ),
            flat,
            jac=True,
            method="L-BFGS-B",
            bounds=np.column_stack((flat - reach, flat + reach)),
            options={"maxiter": steps, "maxcor": 20, "ftol": 1e-7},
        )
        x = result.x.reshape(shape)
        after = {
            name: np.maximum(
                0.0,
                before.get(name, 0.0) + self.weight * (g + self.aims.get(name, AIM)),
            )
            for name, g in problem.look(x).excesses().items()
        }
        weight = min(GROWTH * self.weight, LARGEST_WEIGHT)
        return replace(self, problem=problem, x=x, multipliers=after, weight=weight)

    def rounds(self, number: int, steps: int) -> Search:
        """The state after a `number` of rounds."""
        search = self
        for _ in range(number):
            search = search.next(steps)
        return search

    def freer(self, more: dict[str, float]) -> Search:
        """The state with `more` of some limits left unused."""
        raised = {name: self.aims.get(name, AIM) + add for name, add in more.items()}
        return replace(self, aims=self.aims | raised)

    @property
    def value(self) -> float:
        """Objective, the logarithm of a deviation."""
        return self.problem.objective.value(self.problem.look(self.x).after)[0]


def lagrangian(
    look: Look, multipliers: dict[str, Array], weight: float, aims: dict[str, float]
) -> tuple[float, Array]:
    """The augmented Lagrangian and its gradient, flat."""
    value, by_after = look.problem.objective.value(look.after)
    by: dict[str, Array] = {}
    instants = look.features.shape[1]
    for name, g in look.excesses().items():
        before = multipliers.get(name, 0.0)
        after = np.maximum(0.0, before + weight * (g + aims.get(name, AIM)))
        value += float(np.sum(after**2 - before**2)) / (2.0 * weight * instants)
        by[name] = after / instants
    return value, look.gradient(by_after, by).ravel()
