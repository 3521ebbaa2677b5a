"""OLS: least squares on the full model, plain or weighted by known noise (Atkeson, An &
Hollerbach 1986)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from hefting.core.estimate import Certificate, Estimate
from hefting.estimators.base import INVARIANCES, BiasModel, require_samples
from hefting.estimators.joint_state import State
from hefting.estimators.point_estimator import PointEstimator
from hefting.estimators.quadratic import Quadratic, WrenchNoise, least_squares
from hefting.estimators.sample_state import SMOOTHED_C1, Model


@dataclass(frozen=True, eq=False)
class OLS(PointEstimator):
    """Least squares: ten unconstrained parameters, so they may be those of no body.

    Directions the motion does not excite get the smallest parameters that fit and
    infinite variance. The covariance is that of white noise without `intervals`, else
    theirs. The sensor's origin and units do not matter where the noise is given.

    Examples
    --------
    >>> ols = hefting.OLS()
    >>> first = ols.update(ols.start(), measurements[:500])
    >>> second = ols.update(ols.start(), measurements[500:])
    >>> ols.estimate(ols.merge(first, second)).samples
    1000
    """

    rank = 60
    role = "free"
    source = "Atkeson, An & Hollerbach, IJRR 5(3), 1986"
    fills_in = "the smallest values that fit"
    best_for = "fast motion; an uncertainty for every parameter"
    invariances = frozenset(INVARIANCES)
    variants: ClassVar = {
        "blended": {"model": "blended"},
        "reduced": {"model": "reduced"},
    }
    when_smoothed: ClassVar = {"c1": SMOOTHED_C1}

    bias: BiasModel = "none"
    """``"none"``: the wrench is unbiased; ``"estimate"``: find a constant bias with the
    parameters."""
    noise: WrenchNoise = None
    """Known wrench noise, levels or a covariance (6, 6): residuals are weighed by it.
    None: newtons weigh like newton-metres, and without intervals the covariance comes
    from the residual."""
    model: Model = "full"
    """``"full"``, ``"reduced"`` or ``"blended"``, see
    `hefting.estimators.sample_state.MODELS`."""
    c1: float = 300.0
    """Of the blend: dynamism at which the full model takes over."""

    def estimate(self, state: State) -> Estimate:
        """The estimate from the samples seen; `NotIdentifiableError` without any."""
        require_samples(state.samples)
        free_bias = self.bias == "estimate"
        row = self.mass_row(state, Quadratic.of(state, self.noise, free_bias).A)
        fit = least_squares(state, free_bias, self.noise, row.equation)
        return self.answer(
            fit.solution[:10],
            state,
            row,
            covariance=fit.covariance[:10, :10],
            certificate=Certificate(fit.square, fit.bound, iterations=1),
            bias=fit.bias,
            warnings=fit.warnings,
        )
