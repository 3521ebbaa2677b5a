"""LMI: least squares over bodies that can exist (Wensing, Kim & Slotine 2018)."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import ClassVar

import numpy as np

from hefting.core.estimate import Estimate
from hefting.core.inertia import PARAMETERS_OF, InertialParameters, congruence, vec
from hefting.core.spatial import Array, vector_to_tensor
from hefting.estimators.base import (
    INVARIANCES,
    BiasModel,
    require_samples,
    require_shape,
)
from hefting.estimators.joint_state import State
from hefting.estimators.point_estimator import PointEstimator
from hefting.estimators.possible_bodies import PossibleBodies, ball_factor
from hefting.estimators.quadratic import (
    Quadratic,
    WrenchNoise,
    require_information,
    warnings_of,
)
from hefting.estimators.semidefinite import solve
from hefting.shapes import Shape

TYPICAL_RADIUS = 0.1
"""Radius of gyration [m] of the object where the data do not determine it."""


@dataclass(frozen=True, eq=False)
class LMI(PointEstimator):
    """Parameters of a body that explain the wrench best; needs no shape:

        minimise  |S^-1/2 (A phi - b)|²   over bodies: P(phi) >= 0

    P is the 4 x 4 pseudo-inertia. Given a shape, the mass must also be able to lie in the
    ellipsoid around its bounding box: tr(P Q) >= 0. What the motion leaves open is shown
    as a compact body's.

    Examples
    --------
    >>> estimate = hefting.LMI().fit(measurements)
    >>> estimate.physically_consistent, estimate.certificate.converged
    (True, True)
    """

    rank = 50
    role = "free"
    takes_shape: ClassVar = {"ellipsoid": "a bounding box"}
    fills_in = "a compact body"
    consistent = True
    source = "Wensing, Kim & Slotine, IEEE RA-L 3(1), 2018"
    best_for = "an object of unknown shape"
    invariances = frozenset(INVARIANCES)
    variants: ClassVar = {"ellipsoid": {"ellipsoid": "shape"}}

    ellipsoid: Shape | None = None
    """If given, the ellipsoid around its bounding box must be able to hold the mass."""
    bias: BiasModel = "none"
    """``"none"``: the wrench is unbiased; ``"estimate"``: find a constant bias with the
    parameters."""
    noise: WrenchNoise = None
    """Known wrench noise S, levels or a covariance (6, 6). None: newtons weigh like
    newton-metres."""

    def __post_init__(self):
        super().__post_init__()
        if self.ellipsoid is not None:
            require_shape(self.ellipsoid)

    @property
    def name(self) -> str:
        """``LMI``, or ``LMI-ellipsoid``."""
        return "LMI" if self.ellipsoid is None else "LMI-ellipsoid"

    def estimate(self, state: State) -> Estimate:
        """The estimate from the samples seen; `NotIdentifiableError` without any."""
        require_samples(state.samples)
        problem = Quadratic.of(state, self.noise, self.bias == "estimate")
        require_information(problem)
        row = self.mass_row(state, problem.A)
        problem = problem.with_equation(row.equation)
        half_space = None
        if self.ellipsoid is None:
            G = _typical(problem)
        else:
            ellipsoid = bounding_ellipsoid(self.ellipsoid)
            G = _scaled(problem, _inside(ellipsoid))
            half_space = vec(G.T @ ellipsoid @ G)
            half_space /= np.sqrt(half_space @ half_space)
        T = PARAMETERS_OF @ congruence(G)
        solution = solve(problem.A @ T, problem.b, half_space=half_space)
        vector = T @ solution.q
        return self.answer(
            vector,
            state,
            row,
            certificate=solution.certificate,
            bias=problem.bias(vector),
            warnings=warnings_of(problem.svd.open, "those of a compact body"),
        )

    def possible_bodies(self, center: Array) -> PossibleBodies | None:
        """Any body; in the box of the ellipsoid, where one is given."""
        if self.ellipsoid is None:
            return super().possible_bodies(center)
        return self._in_box.or_any(center)

    @cached_property
    def _in_box(self) -> PossibleBodies:
        assert self.ellipsoid is not None
        return PossibleBodies.in_box(_box_filling(self.ellipsoid))


def _typical(problem: Quadratic) -> Array:
    """G (4, 4) with G G' the pseudo-inertia of a body like that of least squares, from
    which the solver starts."""
    vector = problem.least_squares()
    mass = float(vector[0])
    com, radius = np.zeros(3), TYPICAL_RADIUS
    if mass > 0.0:
        com = vector[1:4] / mass
        com *= min(1.0, 1.0 / max(float(np.linalg.norm(com)), 1e-300))
        second = abs(float(np.trace(vector_to_tensor(vector[4:])))) / (2.0 * mass)
        if second > 0.0:
            radius = float(np.clip(np.sqrt(second), 0.01, 1.0))
    return _scaled(problem, ball_factor(com, radius))


def _scaled(problem: Quadratic, G: Array) -> Array:
    """`G` scaled to the mass whose wrench is as large as the measured one."""
    wrench = problem.A @ (PARAMETERS_OF @ vec(G @ G.T))
    size = float(np.sqrt(wrench @ wrench))
    return G * np.sqrt(
        problem.size / size if problem.size > 0.0 and size > 0.0 else 1.0
    )


def _box_filling(shape: Shape) -> InertialParameters:
    """A homogeneous kilogram in the shape's bounding box, of sides of at least 1 mm."""
    R = shape.pose[:3, :3]
    local = shape.hull @ R
    low, high = local.min(axis=0), local.max(axis=0)
    second = np.maximum(high - low, 1e-3) ** 2 / 12.0
    J = R @ np.diag(second.sum() - second) @ R.T
    return InertialParameters.from_com(1.0, R @ (0.5 * (low + high)), J)


def bounding_ellipsoid(shape: Shape) -> Array:
    """Q (4, 4) with x'Q x >= 0, x = (point, 1), inside the least ellipsoid around the
    shape's bounding box, by volume.

    Bodies with all mass inside have tr(P Q) >= 0 (Wensing et al. 2018). Sides of no
    length count as 1 mm.
    """
    R = shape.pose[:3, :3]
    local = shape.hull @ R
    low, high = local.min(axis=0), local.max(axis=0)
    axes = np.sqrt(3.0) * np.maximum(0.5 * (high - low), 0.5e-3)
    centre = R @ (0.5 * (low + high))
    S = (R / axes**2) @ R.T
    Q = np.empty((4, 4))
    Q[:3, :3], Q[:3, 3], Q[3, :3] = -S, S @ centre, S @ centre
    Q[3, 3] = 1.0 - centre @ S @ centre
    return Q


def _inside(ellipsoid: Array) -> Array:
    """G (4, 4) with G G' the pseudo-inertia of 1 kg inside the ellipsoid: its second
    moment about the centre is 0.4² times the squared semi-axis along each axis, and 3 ·
    0.4² < 1."""
    centre = np.linalg.solve(ellipsoid[:3, :3], -ellipsoid[:3, 3])
    half = 0.4 * np.linalg.cholesky(np.linalg.inv(-ellipsoid[:3, :3]))
    G = np.eye(4)
    G[:3, :3], G[:3, 3] = half, centre
    return G
