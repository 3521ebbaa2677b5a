"""PMD: point mass discretization (Nadeau, Giamou & Kelly, ICRA 2022, problem 1).

Both models' equations are in triangular form, with the biases taken out: the rows [bias
columns | A | b] of each model are reduced to a triangular factor. As the bias columns
are one multiple of the identity for each sample, they stay so: c I6 in the first six
rows, c² the sum of squared weights. Each recording has a bias, and six such rows, of
its own.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import ClassVar, Self

import numpy as np

from hefting.core.errors import InputError
from hefting.core.estimate import Certificate, Estimate
from hefting.core.moments import FULL_EQUATIONS, REDUCED_EQUATIONS, triangular
from hefting.core.spatial import Array, immutable, own
from hefting.estimators.base import BiasModel, require_samples
from hefting.estimators.cone import ConeProblem, solve
from hefting.estimators.joint_state import (
    State,
    WhitenedState,
    states_by_bias,
    states_of,
)
from hefting.estimators.point_estimator import PointEstimator
from hefting.estimators.possible_bodies import PossibleBodies
from hefting.estimators.sample_state import SMOOTHED_C1, Model
from hefting.shapes import Shape

ACCURACY = 1e-6
"""Gap up to which a solution counts as converged, relative to the objective (or to 1e-6
|b| where it is smaller)."""


@dataclass(frozen=True, eq=False)
class PMD(PointEstimator):
    """Non-negative masses at the shape's points that best explain the wrench:

        minimise  |D(1-w) (Ã M m - b)| + |D(w) (A M m - b)| + lambda |m|   over m >= 0

    with the reduced (gravity-only) regressor Ã, the full one A, and each sample's
    weight w = tanh(3 nu / c1) of its dynamism nu. With ``bias="estimate"`` one constant
    wrench is added to both models and is free.

    Examples
    --------
    >>> pmd = hefting.PMD(hefting.load_shape("box:-0.1,0.1,-0.3,0.3,0,0.3"))
    >>> estimate = pmd.fit(measurements)
    >>> bool(estimate.point_masses.min() >= 0.0)
    True
    """

    rank = 20
    role = "shape"
    needs = "a shape"
    assumes = "the shape and equal masses"
    consistent = True
    depends_on_count = True
    source = "Nadeau, Giamou & Kelly, ICRA 2022"
    best_for = "a few seconds of slow, noisy motion of a known shape"
    invariances = frozenset(
        {"world frame", "sample order", "merging", "sensor rotation", "wrench scale"}
    )
    variants: ClassVar = {"full": {"model": "full"}, "reduced": {"model": "reduced"}}
    when_smoothed: ClassVar = {"c1": SMOOTHED_C1}

    shape: Shape
    """The points, in the sensor frame."""
    c1: float = field(
        default=300.0,
        metadata={
            "help": "amount of motion at which the full model takes over; default 300, 1 with smoothed poses"
        },
    )
    """Dynamism at which the full model takes over: 300 in the paper's simulations, 5e3
    and 25e3 on its robot."""
    regularization: float = field(
        default=0.1,
        metadata={
            "help": "pull towards equal masses; default 0.1",
            "metavar": "LAMBDA",
        },
    )
    """lambda [N/kg]: pull towards equal masses."""
    bias: BiasModel = "none"
    """``"none"``: the wrench is unbiased; ``"estimate"``: find a constant bias with the
    masses."""
    model: Model = "blended"
    """``"blended"``, as published; ``"full"`` or ``"reduced"`` throughout."""

    def __post_init__(self):
        super().__post_init__()
        if not (
            isinstance(self.regularization, int | float)
            and 0.0 <= self.regularization < math.inf
        ):
            raise InputError(
                f"the regularization must be finite and not negative, but is {self.regularization}"
            )

    def estimate(self, state: State, start: Estimate | None = None) -> Estimate:
        """The estimate from the samples seen; `start`, an earlier estimate over the
        same shape, saves time.

        Raises `NotIdentifiableError` when there are no samples.
        """
        require_samples(state.samples)
        rows = ModelRows.of(state, free_bias=self.bias == "estimate")
        row = self.mass_row(state, rows.A)
        if row.equation is not None:
            rows = rows.with_equation(row.equation, state)
        M = self.shape.matrix
        problem = ConeProblem(
            rows.A.dot(M), rows.b, rows.K, self.regularization, rows.size
        )
        masses = start.point_masses if start is not None else None
        if masses is not None and len(masses) != self.shape.n:
            raise InputError(
                f"the start has {len(masses)} masses, the shape {self.shape.n} points"
            )
        if masses is None or not masses.dot(masses) > 0.0:
            masses = _homogeneous(problem)
        solution = solve(problem, masses)
        vector = M.dot(solution.masses)
        bias = rows.bias(vector, solution.scales)
        norms = rows.norms(vector, bias).tolist()
        objective = sum(norms) + self.regularization * _norm(solution.masses)
        scale = max(objective, 1e-6 * rows.size)
        return self.answer(
            own(vector),
            state,
            row,
            certificate=Certificate(
                objective=objective,
                bound=solution.bound,
                iterations=solution.iterations,
                converged=objective - solution.bound <= ACCURACY * scale,
            ),
            bias=bias,
            point_masses=own(solution.masses),
        )

    def possible_bodies(self, center: Array) -> PossibleBodies:
        """Bodies of any density in the shape."""
        return self._in_shape.or_any(center)

    @cached_property
    def _in_shape(self) -> PossibleBodies:
        return PossibleBodies.in_shape(self.shape)


def _homogeneous(problem: ConeProblem) -> Array:
    """Equal masses (n,) that fit the wrench best, from which the solver starts."""
    predicted = problem.A.sum(axis=1)
    square = float(predicted @ predicted)
    mass = float(predicted @ problem.b) / square if square else 0.0
    least = 1e-3 * _norm(problem.b) / (math.sqrt(square) or 1.0)
    return (max(mass, least) or 1.0) * np.ones(problem.A.shape[1])


def _norm(x: Array) -> float:
    return math.sqrt(x.dot(x))


SHARES = np.repeat(np.eye(2), (5, 11), axis=1)
"""(2, 16) shares in both norms of the rows without a bias: five of the reduced model,
eleven of the full one."""
WITH_INERTIA = np.eye(11)[[0, 1, 2, 3, 10]]
"""(5, 11) selects [m, mc | b] of [ten parameters | b]."""


@immutable
class BiasRows:
    """The six equations c beta + A phi = b of both models that contain the bias beta of
    a recording."""

    c: Array
    """(2,) of the reduced and of the full model; not negative"""
    rows: Array
    """(2, 6, 11) [A | b] of both"""

    @classmethod
    def of(cls, reduced: Array, full: Array) -> Self:
        """From the factors (11, 11) and (17, 17) of the models."""
        both = [_with_positive_diagonal(R[:6]) for R in (reduced, full)]
        rows = both[0][:, 6:].dot(WITH_INERTIA), both[1][:, 6:]
        return cls(np.array([R[0, 0] for R in both]), np.array(rows))

    @property
    def eliminated(self) -> tuple[Array, Array]:
        """Six rows [A | b] without the bias, and their shares (2, 6) in both norms.

        A dual point must be orthogonal to the bias columns, c0 u0 + c1 u1 = 0, which
        one unknown in place of two satisfies: u0 = c1/c t, u1 = -c0/c t, c² = c0² + c1².
        """
        c0, c1 = self.c / (_norm(self.c) or 1.0)
        shares = np.repeat(((c1 * c1,), (c0 * c0,)), 6, axis=1)
        return c1 * self.rows[0] - c0 * self.rows[1], shares

    def bias(self, vector: Array, scales: Array) -> Array:
        """(6,) bias that minimises the sum of both norms, given parameters (10,) and
        the norms' optimal values (2,)."""
        weights = self.c / scales
        residuals = weights @ self._without_bias(vector)
        return -residuals / (float(weights @ self.c) or 1.0)

    def squares(self, vector: Array, bias: Array) -> Array:
        """(2,) squared residuals of both models."""
        r = self._without_bias(vector) + np.outer(self.c, bias)
        return (r * r).sum(axis=1)

    def _without_bias(self, vector: Array) -> Array:
        """(2, 6) residuals A phi - b of both models."""
        return self.rows @ np.append(vector, -1.0)


@immutable
class ModelRows:
    """Equations of both models: six that each bias couples, then the others."""

    biases: tuple[BiasRows, ...]
    """of each recording; empty without a free bias"""
    A: Array
    """(r, 10)"""
    b: Array
    """(r,)"""
    K: Array
    """(2, r) share of each row in both norms"""
    size: float
    """|b| of both models before the biases were eliminated"""

    @classmethod
    def of(cls, state: State, *, free_bias: bool) -> Self:
        """From all samples; or from equations of the full model, in their own unit."""
        if isinstance(state, WhitenedState):
            return cls._of((), np.zeros((5, 5)), state.noise * state.factor)
        first = 0 if free_bias else 6
        states = states_by_bias(state, free_bias)
        reduced = [s.reduced.factor_of(REDUCED_EQUATIONS[first:]) for s in states]
        full = [s.full.factor_of(FULL_EQUATIONS[first:]) for s in states]
        if not free_bias:
            return cls._of((), *reduced, *full)
        biases = tuple(map(BiasRows.of, reduced, full))
        return cls._of(biases, _uncoupled(reduced), _uncoupled(full))

    @classmethod
    def _of(cls, biases: Sequence[BiasRows], reduced: Array, full: Array) -> Self:
        """From rows [m, mc | b] (5, 5) and [ten parameters | b] (11, 11), no bias."""
        rows, K = np.concatenate((reduced.dot(WITH_INERTIA), full)), SHARES
        for each in reversed(biases):
            coupled, shares = each.eliminated
            rows = np.concatenate((coupled, rows))
            K = np.concatenate((shares, K), axis=1)
        right = (
            rows[-SHARES.shape[1] :, 10],
            *(r.rows[:, :, 10].ravel() for r in biases),
        )
        size = math.hypot(*map(_norm, right))
        return cls(tuple(biases), rows[:, :10], rows[:, 10], K, size)

    def with_equation(self, equation: Array, state: State) -> Self:
        """With one more equation (11,) of the parameters, in the model that has more of
        the samples of `state`."""
        return replace(
            self,
            A=np.vstack((self.A, equation[:10])),
            b=np.append(self.b, equation[10]),
            K=np.column_stack((self.K, _share_of_most(state))),
            size=math.hypot(self.size, equation[10]),
        )

    def bias(self, vector: Array, scales: Array) -> Array | None:
        """(6,) bias beside parameters (10,), as of `BiasRows`; (n, 6) those of n
        recordings; None where none is free."""
        if not self.biases:
            return None
        found = [each.bias(vector, scales) for each in self.biases]
        return found[0] if len(found) == 1 else np.array(found)

    def norms(self, vector: Array, bias: Array | None) -> Array:
        """(2,) both residual norms, of the equations with their biases."""
        first = 6 * len(self.biases)
        r = (self.A.dot(vector) - self.b)[first:]
        squares = self.K[:, first:].dot(r * r)
        if bias is not None:
            for rows, beta in zip(self.biases, np.atleast_2d(bias), strict=True):
                squares += rows.squares(vector, beta)
        return np.sqrt(squares)


def _uncoupled(factors: Sequence[Array]) -> Array:
    """Triangular factor of the rows of all factors that hold no bias."""
    rows = [R[6:, 6:] for R in factors]
    return rows[0] if len(rows) == 1 else triangular(np.concatenate(rows))


def _with_positive_diagonal(R: Array) -> Array:
    return np.copysign(1.0, R.diagonal())[:, None] * R


def _share_of_most(state: State) -> tuple[float, float]:
    """Share in both norms of a row of the model with more of the samples."""
    if isinstance(state, WhitenedState):
        return 0.0, 1.0
    each = [(_norm(s.reduced.ones), _norm(s.full.ones)) for s in states_of(state)]
    reduced, full = np.square(each).sum(axis=0)
    return (0.0, 1.0) if full >= reduced else (1.0, 0.0)
