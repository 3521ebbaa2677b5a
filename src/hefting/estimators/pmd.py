"""PMD: point mass discretization (Nadeau, Giamou & Kelly, ICRA 2022, problem 1)."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import ClassVar

import numpy as np

from hefting.core.errors import InputError
from hefting.core.estimate import Certificate, Estimate
from hefting.core.inertia import InertialParameters
from hefting.core.moments import FULL_EQUATIONS, REDUCED_EQUATIONS, Moments, triangular
from hefting.core.spatial import Array
from hefting.estimators.base import BiasModel, require_samples
from hefting.estimators.cone import ConeProblem, solve
from hefting.estimators.joint_state import State, states_by_bias
from hefting.estimators.point_estimator import PointEstimator
from hefting.estimators.possible_bodies import PossibleBodies
from hefting.estimators.quadratic import with_equation
from hefting.estimators.sample_state import SMOOTHED_C1, Model
from hefting.estimators.whitened_state import WhitenedState
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
            "help": "how much motion the full model takes over at; default 300, 1 with smoothed poses"
        },
    )
    """Dynamism at which the full model takes over: 300 in the paper's simulations, 5e3
    and 25e3 on its robot."""
    regularization: float = field(
        default=0.1,
        metadata={"help": "pull to equal masses; default 0.1", "metavar": "LAMBDA"},
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

    @cached_property
    def _basis(self) -> tuple[Array, Array]:
        """T (10, p) and V (p, n) with M = T V and orthonormal rows of V; p is the rank
        of M."""
        M = self.shape.matrix
        U, S, V = np.linalg.svd(M, full_matrices=False)
        rank = int(np.sum(1e-12 * S[0] < S))
        return U[:, :rank] * S[:rank], np.ascontiguousarray(V[:rank])

    def estimate(self, state: State, start: Estimate | None = None) -> Estimate:
        """The estimate from the samples seen; `start`, an earlier estimate over the
        same shape, saves time.

        Raises `NotIdentifiableError` when there are no samples.
        """
        require_samples(state.samples)
        rows = _Rows.of(state, self.bias == "estimate")
        row = self.mass_row(state, rows.A)
        if row.equation is not None:
            rows = _Rows.of(state, self.bias == "estimate", row.equation)
        T, V = self._basis
        problem = ConeProblem(
            rows.A @ T, rows.b, rows.K, V, self.regularization, rows.size
        )
        masses = start.point_masses if start is not None else None
        if masses is not None and len(masses) != self.shape.n:
            raise InputError(
                f"the start has {len(masses)} masses, the shape {self.shape.n} points"
            )
        if masses is None or not masses @ masses > 0.0:
            masses = _homogeneous(problem)
        solution = solve(problem, masses)
        vector = self.shape.matrix @ solution.masses
        bias = rows.bias(vector, solution.scales) if self.bias == "estimate" else None
        objective = rows.objective(vector, bias) + self.regularization * _norm(
            solution.masses
        )
        scale = max(objective, 1e-6 * rows.size)
        found = Estimate(
            method=self.name,
            parameters=InertialParameters(vector),
            samples=state.samples,
            duration=state.duration,
            certificate=Certificate(
                objective=objective,
                bound=solution.bound,
                iterations=solution.iterations,
                converged=objective - solution.bound <= ACCURACY * scale,
            ),
            bias=bias,
            point_masses=solution.masses,
        )
        return self.with_intervals(found, state, row)

    def possible_bodies(self, center: Array) -> PossibleBodies:
        """Bodies of any density in the shape."""
        return self._in_shape.or_any(center)

    @cached_property
    def _in_shape(self) -> PossibleBodies:
        return PossibleBodies.in_shape(self.shape)


def _homogeneous(problem: ConeProblem) -> Array:
    """Equal masses (n,) that fit the wrench best in scale: where the solver starts."""
    n: int = problem.M.shape[1]
    predicted = problem.A @ problem.M.sum(axis=1)
    square = float(predicted @ predicted)
    mass = float(predicted @ problem.b) / square if square else 0.0
    least = 1e-3 * _norm(problem.b) / (math.sqrt(square) or 1.0)
    return np.full(n, max(mass, least) or 1.0)


def _norm(x: Array) -> float:
    return math.sqrt(x @ x)


@dataclass(frozen=True, eq=False)
class _Rows:
    """Both models' equations in triangular form, and the same with the bias taken out.

    The rows [bias columns | A | b] of each model are reduced to a triangular factor; as
    the bias columns are one multiple of the identity for each sample, they stay so: c
    I6 in the first six rows, c² the sum of squared weights. A dual point must be
    orthogonal to them, (c0 u0 + c1 u1) = 0 in those rows, which one unknown in place of
    two satisfies: u0 = c1/c t, u1 = -c0/c t, c² = c0² + c1². Each recording has a bias,
    and six such rows, of its own.
    """

    reduced: tuple[Array, ...]
    """(5 or 11, 5 or 11) factor of [bias columns | m, mc | b] of each bias"""
    full: tuple[Array, ...]
    """(11 or 17, 11 or 17) factor of [bias columns | ten parameters | b] of each"""
    A: Array
    b: Array
    K: Array
    size: float
    """|b| of both models together, before the biases were taken out"""

    @classmethod
    def of(cls, state: State, free_bias: bool, equation: Array | None = None) -> _Rows:
        """Of all samples: first the rows that each bias couples, then those of the
        reduced and of the full model. An `equation` (11,) more of the parameters belongs
        to the model that has more of the samples."""
        if isinstance(state, WhitenedState):
            return cls._of_equations(state, equation)
        states = states_by_bias(state, free_bias)
        reduced, full = [s.reduced for s in states], [s.full for s in states]
        of_reduced = of_full = None
        if equation is not None:
            if _weight(full) >= _weight(reduced):
                of_full = equation
            else:
                of_reduced = equation[[0, 1, 2, 3, 10]]
        reduced = _factors(reduced, REDUCED_EQUATIONS, free_bias, of_reduced)
        full = _factors(full, FULL_EQUATIONS, free_bias, of_full)
        size = _norm(np.concatenate([R[:, -1] for R in (*reduced, *full)]))
        n = 6 if free_bias else 0
        parts = [_coupled(*both) for both in zip(reduced, full, strict=True) if n]
        for share, factors in (((1.0, 0.0), reduced), ((0.0, 1.0), full)):
            rows = factors[0][n:, n:]
            if len(states) > 1:
                rows = triangular(np.concatenate([R[n:, n:] for R in factors]))
            parts.append((rows, share))
        shares = np.array([share for _, share in parts]).T
        K = np.repeat(shares, [len(rows) for rows, _ in parts], axis=1)
        rows = np.concatenate([_with_inertia(rows) for rows, _ in parts])
        return cls(tuple(reduced), tuple(full), rows[:, :10], rows[:, 10], K, size)

    @classmethod
    def _of_equations(cls, state: WhitenedState, equation: Array | None) -> _Rows:
        """Of equations of the full model without a bias, in their own unit."""
        full = triangular(with_equation(state.noise * state.factor, equation))
        K = np.tile((0.0, 1.0), (len(full), 1)).T
        none = np.zeros((5, 5))
        return cls((none,), (full,), full[:, :10], full[:, 10], K, _norm(full[:, 10]))

    def bias(self, vector: Array, scales: Array) -> Array:
        """(6,) bias that minimises the sum of both norms, given parameters (10,) and
        the norms' optimal values (2,); (n, 6) those of n recordings."""
        found = np.empty((len(self.full), 6))
        for i, (reduced, full) in enumerate(zip(self.reduced, self.full, strict=True)):
            g0 = reduced[:6, 6:-1] @ vector[:4] - reduced[:6, -1]
            g1 = full[:6, 6:-1] @ vector - full[:6, -1]
            c0, c1 = float(reduced[0, 0]), float(full[0, 0])
            weight0, weight1 = c0 / scales[0], c1 / scales[1]
            found[i] = -(weight0 * g0 + weight1 * g1) / (
                weight0 * c0 + weight1 * c1 or 1.0
            )
        return found[0] if len(found) == 1 else found

    def objective(self, vector: Array, bias: Array | None) -> float:
        """Sum of both residual norms, from the factors themselves."""
        norms: list[float] = []
        for factors, x in ((self.reduced, vector[:4]), (self.full, vector)):
            left = [R[:, -1 - len(x) : -1] @ x - R[:, -1] for R in factors]
            if bias is not None:
                for r, R, own in zip(left, factors, np.atleast_2d(bias), strict=True):
                    r += R[:, :6] @ own
            norms.append(_norm(np.concatenate(left)))
        return sum(norms)


def _coupled(reduced: Array, full: Array) -> tuple[Array, tuple[float, float]]:
    """The six rows [A | b] that a bias couples, and their shares in both norms."""
    c0, c1 = float(reduced[0, 0]), float(full[0, 0])
    c = math.hypot(c0, c1) or 1.0
    rows = -c0 / c * full[:6, 6:] + c1 / c * _with_inertia(reduced[:6, 6:])
    return rows, ((c1 / c) ** 2, (c0 / c) ** 2)


def _with_inertia(rows: Array) -> Array:
    """Rows (r, 11) of [ten parameters | b], of the reduced model's (r, 5) too."""
    if rows.shape[1] == 11:
        return rows
    whole = np.zeros((len(rows), 11))
    whole[:, :4], whole[:, 10] = rows[:, :4], rows[:, 4]
    return whole


def _weight(moments: Sequence[Moments]) -> float:
    """Root of the sum of the samples' squared weights."""
    return _norm(np.concatenate([each.ones for each in moments]))


def _factors(
    moments: Sequence[Moments],
    equations: Array,
    free_bias: bool,
    equation: Array | None,
) -> list[Array]:
    """`_factor` of each; the one `equation` more is in the first."""
    return [
        _factor(each, equations, free_bias, None if i else equation)
        for i, each in enumerate(moments)
    ]


def _factor(
    moments: Moments, equations: Array, free_bias: bool, equation: Array | None
) -> Array:
    """Triangular factor of [bias columns | regressor | wrench] over all samples, and of
    one `equation` more; without bias columns if not free."""
    factor = moments.factor_of(equations if free_bias else equations[6:])
    if equation is not None:
        factor = triangular(with_equation(factor, equation))
    if free_bias:
        factor[:6] *= np.where(factor.diagonal()[:6] < 0.0, -1.0, 1.0)[:, None]
    return factor
