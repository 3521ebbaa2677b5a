"""GEO: least squares pulled towards a homogeneous body, along the manifold of bodies
(Lee, Wensing & Park 2020)."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any, ClassVar, Literal

import numpy as np

from hefting.core.errors import InputError
from hefting.core.estimate import Estimate
from hefting.core.inertia import IDENTITY, PARAMETERS_OF, InertialParameters, congruence
from hefting.core.spatial import Array
from hefting.estimators.base import INVARIANCES, BiasModel, require_samples
from hefting.estimators.joint_state import State
from hefting.estimators.point_estimator import PointEstimator
from hefting.estimators.possible_bodies import PossibleBodies, ball_factor, body_factor
from hefting.estimators.quadratic import Quadratic, WrenchNoise, require_information
from hefting.estimators.sample_state import (
    SMOOTHED_C1,
    Model,
    require_one_of,
    require_positive,
)
from hefting.estimators.semidefinite import solve
from hefting.shapes import Shape

Distance = Literal["entropic", "pullback", "euclidean"]
DISTANCES: dict[str, str] = {
    "entropic": "tr(P0^-1 P) - log det(P0^-1 P) - 4",
    "pullback": "½ tr((P0^-1 (P - P0))²)",
    "euclidean": "|phi - phi0|²",
}
GAMMA = 30.0
"""Default weight of the prior with whitened residuals: ten dimensions over it is the
expected distance D of bodies, about 1/3. On twelve tools, with 150 and 1,000 samples of
moderate noise, values from 10 to 100 were alike; the rule below grows with the data and
then biases inhomogeneous bodies."""
KAPPA = 1e-5
"""Default weight with plain residuals, relative to tr(A'A), see `weight_by_rule`."""
COMPACT = 0.1
"""Radius of gyration [m] of a compact body."""
THINNEST = 1e-3
"""Least thickness of a prior body over its largest side, as a flat P0 is singular."""


@dataclass(frozen=True, eq=False)
class GEO(PointEstimator):
    """Parameters that explain the wrench and stay near those of a homogeneous body:

        minimise  |S^-1/2 (A phi - b)|² + gamma D(phi, phi0)   over bodies: P(phi) >= 0

    P is the 4 x 4 pseudo-inertia; phi0 is the prior. The larger gamma, the more depends
    on the prior's shape and pose. The sensor's origin and units do not matter where the
    noise is given; nor does the wrench's scale where gamma is scaled by its square, and
    a given prior by it. The Euclidean distance depends on axes, origin and units.

    Examples
    --------
    >>> shape = hefting.load_shape("box:-0.1,0.1,-0.3,0.3,0,0.3")
    >>> hefting.GEO(shape).fit(measurements).physically_consistent
    True
    """

    rank = 30
    role = "prior"
    needs = "a bounding box"
    instead_of_shape = ("prior",)
    consistent = True
    source = "Lee, Wensing & Park, IEEE T-RO 36(2), 2020"
    best_for = "any motion, if the shape or its bounding box is about right"
    invariances = frozenset(INVARIANCES)
    variants: ClassVar = {
        "blended": {"model": "blended"},
        "reduced": {"model": "reduced"},
    }
    when_smoothed: ClassVar = {"c1": SMOOTHED_C1}

    shape: Shape | None = None
    """Shape (a box will do): a homogeneous prior, as heavy as least squares says."""
    prior: InertialParameters | None = None
    """The prior body, in place of a shape."""
    distance: Distance = "entropic"
    """D, see `DISTANCES`."""
    gamma: float | None = field(
        default=None, metadata={"help": "weight of the homogeneous prior; default 30"}
    )
    """Weight of the prior, in units of the squared (whitened) wrench; None: `GAMMA`
    where the noise is known, and else `KAPPA` tr(A'A), the rule of the authors' later
    code. The Euclidean distance has units, and always that rule."""
    bias: BiasModel = "none"
    """``"none"``: the wrench is unbiased; ``"estimate"``: find a constant bias with the
    parameters."""
    noise: WrenchNoise = None
    """Known wrench noise S, levels or a covariance (6, 6). None: newtons weigh like
    newton-metres."""
    model: Model = "full"
    """``"full"``, ``"reduced"`` or ``"blended"``, see
    `hefting.estimators.sample_state.MODELS`."""
    c1: float = 300.0
    """Of the blend: dynamism at which the full model takes over."""

    def __post_init__(self):
        super().__post_init__()
        if (self.shape is None) == (self.prior is None):
            what = "GEO needs a shape or a prior body, and not both"
            raise InputError(what, fix="a bounding box will do")
        if self.prior is not None and not isinstance(self.prior, InertialParameters):
            raise InputError("the prior must be InertialParameters")
        if self.prior is not None and not self.prior.consistency().is_consistent:
            raise InputError(f"the prior is not a body: {self.prior.consistency()}")
        require_one_of("distance", self.distance, DISTANCES)
        if self.gamma is not None:
            require_positive("gamma", self.gamma)

    @property
    def provenance(self) -> dict[str, Any]:
        """As of every method, with the weight of the prior that is used."""
        usual = self.gamma is None and self.distance != "euclidean"
        return super().provenance | ({"gamma": GAMMA} if usual else {})

    def estimate(self, state: State) -> Estimate:
        """The estimate from the samples seen; `NotIdentifiableError` without any."""
        require_samples(state.samples)
        problem = Quadratic.of(state, self.noise, self.bias == "estimate")
        require_information(problem)
        gamma = self._gamma(problem)
        row = self.mass_row(state, problem.A)
        problem = problem.with_equation(row.equation)
        prior, T = self._unit
        if self.prior is None:
            mass = problem.measured_mass(prior.vector)
            prior, T = InertialParameters(mass * prior.vector), mass * T
        A, b = problem.A @ T, problem.b
        if self.distance == "entropic":
            solution = solve(A, b, gamma)
        elif self.distance == "pullback":
            pull = math.sqrt(0.5 * gamma)
            solution = solve(
                np.vstack((A, pull * np.eye(10))), np.concatenate((b, pull * IDENTITY))
            )
        else:
            pull = math.sqrt(gamma)
            solution = solve(
                np.vstack((A, pull * T)), np.concatenate((b, pull * prior.vector))
            )
        vector = T @ solution.q
        return self.answer(
            vector,
            state,
            row,
            certificate=solution.certificate,
            bias=problem.bias(vector),
        )

    @cached_property
    def _unit(self) -> tuple[InertialParameters, Array]:
        """The prior, for 1 kg if a shape gives it, and T (10, 10) with phi = T q such
        that Q = I is that prior; for the Euclidean distance, which does not depend on
        the prior's shape, Q = I is a compact body."""
        if self.prior is not None:
            prior = self.prior
        else:
            assert self.shape is not None
            prior = self.shape.homogeneous
        prior = thickened(prior)
        G = body_factor(prior)
        if self.distance == "euclidean":
            G = ball_factor(prior.center_of_mass, COMPACT)
        return prior, prior.mass * (PARAMETERS_OF @ congruence(G))

    def possible_bodies(self, center: Array) -> PossibleBodies:
        """Bodies near the prior's, homogeneous one."""
        return self._near_prior.or_any(center)

    @cached_property
    def _near_prior(self) -> PossibleBodies:
        prior = self.shape.homogeneous if self.shape is not None else self.prior
        assert prior is not None
        return PossibleBodies.near(thickened(prior))

    def _gamma(self, problem: Quadratic) -> float:
        if self.gamma is not None:
            return self.gamma
        if self.noise is not None and self.distance != "euclidean":
            return GAMMA
        return max(weight_by_rule(problem.A), 1e-300)


def weight_by_rule(A: Array) -> float:
    """gamma = `KAPPA` tr(A'A) for a regressor A (r, 10), as in the later code of the
    method's authors. Each product of inertia counts half, so that the result does not
    depend on the sensor's axes."""
    return KAPPA * float(
        (A * A).sum(axis=0) @ (1.0, 1.0, 1.0, 1.0, 1.0, 0.5, 0.5, 1.0, 0.5, 1.0)
    )


def thickened(parameters: InertialParameters) -> InertialParameters:
    """The body with at least `THINNEST` of its largest side in every direction (0.1 mm
    for a point)."""
    m, c = parameters.mass, parameters.center_of_mass
    P = parameters.pseudo_inertia[:3, :3] / m - np.outer(c, c)
    values, axes = np.linalg.eigh(P)
    floor = max(THINNEST**2 * float(values[2]), 1e-8 / 12.0)
    if values[0] >= floor:
        return parameters
    second = (axes * np.maximum(values, floor)) @ axes.T
    return InertialParameters.from_com(
        m, c, m * (np.trace(second) * np.eye(3) - second)
    )
