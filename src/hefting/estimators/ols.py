"""OLS: ordinary least squares on the full model (Atkeson, An & Hollerbach 1986)."""

from dataclasses import dataclass

import numpy as np

from hefting.errors import InputError
from hefting.estimate import Certificate, Estimate
from hefting.estimators.base import BiasModel, Estimator, require_bias_model, require_samples
from hefting.inertia import InertialParameters
from hefting.lapack import lapack
from hefting.measurements import Measurements, Noise
from hefting.moments import FULL_EQUATIONS, Moments
from hefting.spatial import PARAMETERS, WRENCH, Array, Indices

RANK_TOLERANCE = 1e-9
"""Singular values of the column-scaled regressor below this, relative to the largest, count as zero."""


@dataclass(frozen=True)
class OLS(Estimator[Moments]):
    """Ten parameters that minimise the squared wrench residual; unconstrained, so they may be unphysical.

    Directions the motion does not excite get the smallest parameters that fit and infinite variance.
    """

    bias: BiasModel = "none"
    """``"none"``: the wrench is unbiased; ``"estimate"``: find a constant bias with the parameters."""
    noise: Noise | None = None
    """Known wrench noise: force and torque rows are divided by its levels. None: newtons weigh like newton-metres,
    and the covariance comes from the residual."""

    def __post_init__(self):
        require_bias_model(self.bias)
        if self.noise is not None and not (self.noise.force > 0.0 and self.noise.torque > 0.0):
            raise InputError("known noise must be positive in force and torque", fix="or give noise=None")

    def start(self) -> Moments:
        """The state before any sample."""
        return Moments.empty()

    def update(self, state: Moments, measurements: Measurements) -> Moments:
        """The state with the samples of `measurements` added."""
        return state.fold(measurements)

    def merge(self, first: Moments, second: Moments) -> Moments:
        """The state of an estimator that has seen the samples of both."""
        return first.merge(second)

    def estimate(self, state: Moments) -> Estimate:
        """The estimate from the samples seen. Raises `NotIdentifiableError` when there are none."""
        require_samples(state.samples)
        fit = least_squares(state, self.bias == "estimate", self.noise)
        return Estimate(
            method=self.name,
            parameters=InertialParameters(fit.solution[:10]),
            samples=state.samples,
            duration=state.duration,
            covariance=fit.covariance[:10, :10],
            certificate=Certificate(fit.square, fit.bound, iterations=1),
            bias=fit.solution[10:] if self.bias == "estimate" else None,
            warnings=fit.warnings,
        )


@dataclass(frozen=True, eq=False)
class LeastSquares:
    """Least-squares fit of the full model: the ten parameters and, when it is free, the six of a constant bias."""

    solution: Array
    """(10,) or (16,)"""
    covariance: Array
    """(10, 10) or (16, 16), infinite where the data do not decide"""
    free: Indices
    """indices of the unknowns the data do not decide"""
    square: float
    """sum of squared (whitened) residuals"""
    bound: float
    """lower bound on its minimum, by the gradient that is left"""

    @property
    def warnings(self) -> tuple[str, ...]:
        """A sentence on what is undetermined, if anything is."""
        if not len(self.free):
            return ()
        names = ", ".join((PARAMETERS + BIAS_NAMES)[i] for i in self.free)
        return (f"the motion does not determine {names}: shown are the smallest values that fit",)


_PARAMETERS_THEN_BIAS = [*range(6, 16), *range(6), 16]
BIAS_NAMES = tuple(f"bias {name}" for name in WRENCH)


def least_squares(moments: Moments, free_bias: bool, noise: Noise | None) -> LeastSquares:
    """Minimise |S^-1/2 (A phi + beta - b)|² over phi (10,) and, if free, beta (6,); S from `noise`, or the identity.

    Without `noise` the covariance is scaled by the mean squared residual. Directions that no sample excites get
    the smallest solution (with columns scaled to one length) and infinite variance.
    """
    n = 16 if free_bias else 10
    equations = FULL_EQUATIONS[_PARAMETERS_THEN_BIAS] if free_bias else FULL_EQUATIONS[6:]
    if noise is not None:
        equations = equations / np.repeat((noise.force, noise.torque), 3)[:, None]
    R = moments.factor_of(equations)
    A, b = R[:, :n], R[:, n]
    norms = np.sqrt((A * A).sum(axis=0))
    scale = np.where(norms > 0.0, norms, 1.0)
    U, S, V, _ = lapack.dgesdd(A / scale, full_matrices=0)
    kept = RANK_TOLERANCE * S[0] < S
    half = V[kept].T / S[kept] / scale[:, None]
    solution = half @ (U[:, kept].T @ b)
    r = b - A @ solution
    square = float(r @ r)
    slack = U[:, kept].T @ r  # zero at the exact minimum
    covariance = half @ half.T
    free = np.flatnonzero(np.abs(V[~kept]).max(axis=0, initial=0.0) > 1e-6)
    if noise is None:
        covariance *= square / max(6 * moments.samples - int(kept.sum()), 1)
    covariance[free], covariance[:, free] = 0.0, 0.0
    covariance[free, free] = np.inf
    return LeastSquares(solution, covariance, free, square, max(0.0, square - float(slack @ slack)))
