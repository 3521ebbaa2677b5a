"""Unconstrained least squares: the parameters from the data alone, without a prior.

All fits here (with or without a bias, with gravity reversed, without a tool) are
computed from one triangular factor of the samples' moments.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from hefting.core.measurements import Measurements, Noise
from hefting.core.moments import Moments
from hefting.core.regressor import GRAVITY, ONE, WRENCH, predict_wrench
from hefting.core.spatial import PARAMETERS, Array, immutable, skew
from hefting.estimators.joint_state import (
    State,
    as_one,
    full_without_bias,
    states_by_bias,
)
from hefting.estimators.quadratic import LeastSquares, least_squares
from hefting.estimators.sample_state import SampleState
from hefting.ingest.conditioned import (
    SIGNIFICANT,
    WrenchSign,
    mass_over_std,
    mean_inflation,
)

SMALLEST_GRAVITY_CHANGE = 0.03
"""Root-mean-square change of gravity in sensor axes, relative to its size, below which
the distance of the COM is undetermined beside a free bias."""
TYPICAL_SIZE = 0.2
"""[m] Size of a held object by which parameters count as open without a shape."""


@immutable
class FreeFit:
    """Result of unconstrained least squares, weighted by its own residuals."""

    vector: Array
    """(10,) Parameters about the sensor origin, of the recorded wrench's sign."""
    bias: Array | None
    """(6,) [N, N m] Constant bias, or (n, 6) of n recordings; None if not free."""
    covariance: Array
    """(10, 10), or (16, 16) with a bias of one recording, for autocorrelated residuals;
    infinite where undetermined."""
    noise: Noise
    """Noise of the wrench: root-mean-square residual of a sample of unit weight."""
    inflation: Array
    """(16,) Ratio of the variance of each parameter and component of the bias to that
    for white residuals, at least 1; included in `covariance`."""

    @property
    def autocorrelation(self) -> float:
        """Mean `inflation` of the determined parameters."""
        return mean_inflation(self.inflation, self.covariance)

    @property
    def mass(self) -> float:
        """[kg]"""
        return float(self.vector[0])

    @property
    def mass_std(self) -> float:
        """[kg] standard deviation of `mass`"""
        return float(np.sqrt(self.covariance[0, 0]))

    @property
    def mass_t(self) -> float:
        """Mass over its standard deviation; 0 when undetermined."""
        return mass_over_std(self.mass, self.mass_std)

    @property
    def mass_is_open(self) -> bool:
        """Whether the mass is undetermined, or within three deviations of zero."""
        return not abs(self.mass_t) >= SIGNIFICANT

    def open_parameters(self, size: float) -> tuple[str, ...]:
        """Names of the parameters that the data do not determine for an object of
        `size` [m].

        The standard deviation of these exceeds a third of the mass, for the COM half of
        the size, or for an inertia m size² / 12.
        """
        std = np.sqrt(self.covariance.diagonal()[:10])
        mass = abs(float(self.vector[0]))
        limits = np.concatenate(
            (
                [mass / SIGNIFICANT],
                np.full(3, mass * size / 2),
                np.full(6, mass * size**2 / 12),
            )
        )
        return tuple(PARAMETERS[i] for i in np.flatnonzero(~(std <= limits)))

    @property
    def bias_t(self) -> Array:
        """(6,) the bias over its standard deviations; 0 where undetermined."""
        if self.bias is None:
            return np.zeros(6)
        std = np.sqrt(self.covariance.diagonal()[10:])
        return self.bias / np.maximum(std, 1e-300)

    @property
    def bias_is_significant(self) -> bool:
        """Whether a component of the bias is more than three standard deviations from
        zero.

        False if the motion does not separate the bias from the object's weight.
        """
        known = not self.mass_is_open and np.isfinite(self.covariance[10:, 10:]).all()
        return bool(known and (np.abs(self.bias_t) > SIGNIFICANT).any())

    def flipped(self) -> "FreeFit":
        """The fit to the wrench with the opposite sign."""
        return replace(
            self, vector=-self.vector, bias=None if self.bias is None else -self.bias
        )

    def less(self, vector: Array, covariance: Array | None) -> "FreeFit":
        """The fit of the object alone, after subtracting a tool.

        `vector` (10,) are the tool's parameters; `covariance` (10, 10) is added.
        """
        own = self.covariance.copy()
        if covariance is not None:
            own[:10, :10] += covariance
        return replace(self, vector=self.vector - vector, covariance=own)


def free_fit(state: State, free_bias: bool, inflation: Array | None = None) -> FreeFit:
    """Ten parameters, and a constant bias if it is free, by iterated least squares.

    The residuals of an unweighted fit weight the next ones. The noise is the residual
    of the full model, so it includes the effect of the motion's errors. The covariance
    is that for white residuals, times the `inflation` (16,) where that exceeds 1.
    """
    parts = [part.full for part in states_by_bias(state, free_bias)]
    rows = float(max(sum(part.samples for part in parts), 1))
    square = sum(float(np.sum(part.wrench**2)) for part in parts)
    size = (square / (6.0 * rows)) ** 0.5 or 1.0
    fit, noise = least_squares(state, free_bias, None), Noise()
    for _ in range(2):
        r = _left(parts, fit)
        unknowns = 10 + (0 if fit.bias is None else fit.bias.size) - len(fit.free)
        spent = max(1.0 - unknowns / (6.0 * rows), 1.0 / (6.0 * rows))
        levels = np.sqrt(
            np.sum(r.reshape(-1, 2, 3) ** 2, axis=(0, 2)) / (3.0 * rows * spent)
        )
        noise = Noise(*(max(float(level), 1e-9 * size) for level in levels))
        fit = least_squares(state, free_bias, noise)
    ratio = np.ones(16) if inflation is None else np.maximum(inflation, 1.0)
    return FreeFit(
        fit.solution[:10], fit.bias, inflated(fit.covariance, ratio), noise, ratio
    )


def _left(parts: Sequence[Moments], fit: LeastSquares) -> Array:
    """Residuals (r, 6) of the virtual samples' wrench."""
    none = np.zeros((len(parts), 6))
    biases = none if fit.bias is None else np.atleast_2d(fit.bias)
    return np.concatenate(
        [
            part.wrench - part.full @ fit.solution[:10] - part.ones[:, None] * bias
            for part, bias in zip(parts, biases, strict=True)
        ]
    )


def inflated(covariance: Array, ratio: Array) -> Array:
    """A covariance (q, q) with variances multiplied by the first q of `ratio`."""
    root = np.sqrt(ratio[: len(covariance)])
    return covariance * root * root[:, None]


def fit_freely(
    measurements: Measurements, free_bias: bool, inflation: Array | None = None
) -> FreeFit:
    """`free_fit` of `measurements`."""
    return free_fit(SampleState.of(measurements), free_bias, inflation)


def wrench_sign(with_bias: FreeFit | None, without: FreeFit) -> WrenchSign:
    """Sign convention of the wrench by the sign of the mass.

    `with_bias` is the fit with a constant bias, None if there is no bias. If that
    leaves the mass undetermined, as in a single orientation, the sign is that of the
    mass
    without a bias, and t is 0: not certain.
    """
    if with_bias is None:
        return WrenchSign(without.mass >= 0.0, without.mass_t)
    if not with_bias.mass_is_open:
        return WrenchSign(with_bias.mass >= 0.0, with_bias.mass_t)
    return WrenchSign(without.mass >= 0.0, 0.0)


def lever(state: State, free_bias: bool) -> float:
    """Least distance [m] of the COM from the sensor origin.

    It is the ratio of the first moment by the torque to the mass by the force, both
    from gravity alone. As the two are estimated separately, a wrong unit of the torque
    shows. What gravity leaves of the wrench, as accelerations do, counts as in step with
    it: the moment may be smaller by that, and the mass larger.
    0 if undetermined: with a free bias, where gravity in sensor axes turns by less than
        `SMALLEST_GRAVITY_CHANGE`.
    """
    factor = as_one(state).full.factor
    weight = max(float(factor[:, ONE] @ factor[:, ONE]), 1e-300)
    size = float(np.sqrt(np.sum(factor[:, GRAVITY] ** 2) / weight))
    if free_bias:
        factor = full_without_bias(state).factor
    gravity, wrench = factor[:, GRAVITY], factor[:, WRENCH]
    turns = np.sqrt(np.sum(gravity**2, axis=0) / weight).max()
    if free_bias and turns < SMALLEST_GRAVITY_CHANGE * size:
        return 0.0
    least = []
    for sign, A, b in (
        (1.0, -gravity.reshape(-1, 1), wrench[:, :3].ravel()),
        (-1.0, skew(gravity).reshape(-1, 3), wrench[:, 3:].ravel()),
    ):
        found = np.linalg.lstsq(A, b, rcond=1e-3)[0]
        left = np.linalg.norm(b - A @ found) / max(np.linalg.norm(gravity), 1e-300)
        least.append(float(np.linalg.norm(found) + sign * left))
    mass, moment = least
    return max(moment, 0.0) / mass if mass > 0.0 else 0.0


def residuals(measurements: Measurements, vector: Array, bias: Array | None) -> Array:
    """Measured minus predicted wrench (K, 6) for ten parameters and a bias (6,)."""
    r = measurements.wrench - predict_wrench(measurements, vector)
    return r if bias is None else r - bias
