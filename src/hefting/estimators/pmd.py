"""PMD: point mass discretization (Nadeau, Giamou & Kelly, ICRA 2022, problem 1)."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from functools import cached_property
from typing import ClassVar

import numpy as np

from hefting.core.errors import InputError
from hefting.core.estimate import Certificate, Estimate
from hefting.core.spatial import Array, own
from hefting.estimators.base import BiasModel, require_samples
from hefting.estimators.cone import ConeProblem, solve
from hefting.estimators.joint_state import State
from hefting.estimators.model_rows import ModelRows
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
            "help": "how much motion the full model takes over at; default 300, 1 with smoothed poses"
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
    """Equal masses (n,) that fit the wrench best in scale: where the solver starts."""
    predicted = problem.A.sum(axis=1)
    square = float(predicted @ predicted)
    mass = float(predicted @ problem.b) / square if square else 0.0
    least = 1e-3 * _norm(problem.b) / (math.sqrt(square) or 1.0)
    return (max(mass, least) or 1.0) * np.ones(problem.A.shape[1])


def _norm(x: Array) -> float:
    return math.sqrt(x.dot(x))
