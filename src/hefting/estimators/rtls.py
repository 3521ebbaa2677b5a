"""RTLS: recursive total least squares (Kubus, Kröger & Wahl 2008)."""

from dataclasses import dataclass

import numpy as np

from hefting.errors import NotIdentifiableError
from hefting.estimate import Certificate, Estimate
from hefting.estimators.base import BiasModel, Estimator, require_bias_model, require_samples
from hefting.estimators.blend import Blend
from hefting.estimators.quadratic import ScaledSVD, stacked_factor, whitening
from hefting.inertia import InertialParameters
from hefting.measurements import Noise
from hefting.moments import triangular
from hefting.spatial import PARAMETERS, Array


@dataclass(frozen=True, eq=False)
class RTLS(Estimator):
    """Ten parameters of total least squares: the smallest change of regressor and wrench that makes them agree.

        minimise  |[dA D^-1, db]|_F   such that  (A + dA) phi = b + db

    Unconstrained, so they may be those of no body. Without known noise every column of [A | b] is taken to carry as
    much of it as every other (D = I), as published; the columns of a constant bias are exact. As sensor axes turn, so
    do products of inertia into moments, of which one counts twice in the sum and the other once: the answer depends
    on the axes, and on units and origin.
    """

    source = "Kubus, Kröger & Wahl, IROS 2008"
    invariances = frozenset({"world frame", "sample order", "merging"})

    bias: BiasModel = "none"
    """``"none"``: the wrench is unbiased; ``"estimate"``: find a constant bias with the parameters."""
    noise: Noise | None = None
    """Known noise: rows are divided by the wrench's levels, and D holds the root-mean-square error that those of the
    accelerations make in each column. Where these are zero, so is the column's: that of ordinary least squares."""

    def __post_init__(self):
        require_bias_model(self.bias)
        whitening(self.noise)

    def estimate(self, state: Blend) -> Estimate:
        """The estimate from the samples seen.

        Raises `NotIdentifiableError` when there are none, or when no finite parameters are best.
        """
        require_samples(state.samples)
        R = stacked_factor(state, self.noise)
        first = 0 if self.bias == "estimate" else 6
        if first:
            R = triangular(R[:, 6:])
        levels = np.ones(10) if self.noise is None else column_levels(self.noise)
        exact = [*range(6 - first), *(6 - first + np.flatnonzero(levels == 0.0))]
        noisy = 6 - first + np.flatnonzero(levels > 0.0)
        n, k = len(exact), len(noisy)
        scale = np.concatenate((np.ones(n), levels[levels > 0.0], (1.0,)))
        C = triangular(R[:, [*exact, *noisy, len(R) - 1]] * scale)
        y, square, bound = _total_least_squares(C[n:, n : n + k], C[n:, -1])
        x = ScaledSVD.of(C[:n, :n]).solve(C[:n, -1] - C[:n, n : n + k] @ y) if n else np.zeros(0)
        solution = np.empty(16 - first)
        solution[exact], solution[noisy] = x, y * levels[levels > 0.0]
        vector = solution[6 - first :]
        open_ = ScaledSVD.of(R[:, :-1]).open
        warnings = ()
        if (open_ >= 6 - first).any():
            names = ", ".join(PARAMETERS[i - 6 + first] for i in open_ if i >= 6 - first)
            warnings = (f"the motion does not determine {names}: shown are the smallest values that fit",)
        return Estimate(
            method=self.name,
            parameters=InertialParameters(vector),
            samples=state.samples,
            duration=state.duration,
            certificate=Certificate(square, bound, iterations=1),
            bias=None if first else solution[:6],
            warnings=warnings,
        )


def column_levels(noise: Noise) -> Array:
    """Root-mean-square error (10,) that noise of the accelerations makes in the whitened regressor's columns."""
    a, alpha = noise.linear_acceleration**2, noise.angular_acceleration**2
    f, t = noise.force**2, noise.torque**2
    first, second, product = 2.0 * (alpha / f + a / t), alpha / t, 2.0 * alpha / t
    squares = (3.0 * a / f, first, first, first, second, product, product, second, product, second)
    return np.sqrt(np.array(squares) / 6.0)


def _total_least_squares(A: Array, b: Array) -> tuple[Array, float, float]:
    """x (k,) by the smallest right singular vector of [A | b], its squared singular value, and a bound below that.

    Directions that A does not see are left out: of these the smallest solution.
    """
    svd = ScaledSVD.of(A) if A.shape[1] else None
    basis = np.eye(A.shape[1])
    if svd is not None and len(svd.kernel):
        basis = np.linalg.qr((svd.V * svd.scale).T)[0]
    C = np.column_stack((A @ basis, b))
    _, S, V = np.linalg.svd(C)
    v = V[-1]
    if abs(v[-1]) < 1e-10:
        raise NotIdentifiableError("total least squares has no finite solution here", fix="use another method")
    x = basis @ (-v[:-1] / v[-1])
    r = A @ x - b
    square = float(r @ r) / (1.0 + float(x @ x))
    return x, square, max(0.0, float(S[-1]) - 16.0 * np.finfo(float).eps * float(S[0])) ** 2
