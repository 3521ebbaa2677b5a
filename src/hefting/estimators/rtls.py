"""RTLS: recursive total least squares (Kubus, Kröger & Wahl 2008)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from hefting.core.errors import InputError, NotIdentifiableError
from hefting.core.estimate import Certificate, Estimate
from hefting.core.measurements import Noise
from hefting.core.spatial import Array
from hefting.estimators.base import BiasModel, Known, require_samples
from hefting.estimators.joint_state import State
from hefting.estimators.point_estimator import PointEstimator
from hefting.estimators.quadratic import (
    RANK_TOLERANCE,
    Quadratic,
    ScaledSVD,
    warnings_of,
)


@dataclass(frozen=True, eq=False)
class RTLS(PointEstimator):
    """Ten parameters of total least squares: the smallest change of regressor and
    wrench that makes them agree.

        minimise  |[dA D^-1, db]|_F   such that  (A + dA) phi = b + db

    Unconstrained, so they may be those of no body. Without known noise every column of
    [A | b] is taken to carry as much of it as every other (D = I), as published, and
    the answer depends on units and axes: turned, products of inertia become moments,
    and a tensor holds those twice and these once. With known noise it depends on
    neither, and its mean error vanishes as samples grow in number. It always depends on
    the sensor's origin: elsewhere noise of the force is in the torque, too. The columns of a constant
    bias are exact.

    Examples
    --------
    >>> hefting.RTLS().fit(measurements).method
    'RTLS'
    """

    rank = 70
    source = "Kubus, Kröger & Wahl, IROS 2008"
    fills_in = "the smallest values that fit"
    best_for = "long, fast, clean recordings with known noise of the accelerations"
    invariances = frozenset(
        {"world frame", "sample order", "merging", "sensor rotation", "units"}
    )

    bias: BiasModel = "none"
    """``"none"``: the wrench is unbiased; ``"estimate"``: find a constant bias with the
    parameters."""
    noise: Noise | None = None
    """Known noise: rows are divided by the wrench's levels, and D holds the
    root-mean-square error that those of the accelerations make in each column. Where
    these are zero, so is the column's: that of ordinary least squares."""

    def __post_init__(self):
        if self.noise is not None and not isinstance(self.noise, Noise):
            what = "RTLS wants the noise as levels of wrench and accelerations"
            raise InputError(what, fix="give a Noise, or None")
        super().__post_init__()
        if self.noise is None:
            return
        for level in (self.noise.linear_acceleration, self.noise.angular_acceleration):
            if not 0.0 <= level < np.inf:
                raise InputError(
                    f"known noise of the accelerations must be zero or positive, not {level}"
                )

    @classmethod
    def settings(cls, known: Known, model: str | None = None) -> dict[str, Any]:
        """As of every method, with the noise of wrench and accelerations; unknown where
        the latter's is."""
        noise, motion = known.noise, known.motion_noise
        both = (
            None
            if motion is None
            else Noise(noise.force, noise.torque, motion.linear, motion.angular)
        )
        return super().settings(known, model) | {"noise": both}

    def estimate(self, state: State) -> Estimate:
        """The estimate from the samples seen.

        Raises `NotIdentifiableError` when there are none, or when no finite parameters
        are best.
        """
        require_samples(state.samples)
        problem = Quadratic.of(state, self.noise, self.bias == "estimate")
        row = self.mass_row(state, problem.A)
        problem = problem.with_equation(row.equation)
        levels = np.ones(10) if self.noise is None else column_levels(self.noise)
        exact, noisy = np.flatnonzero(levels == 0.0), np.flatnonzero(levels > 0.0)
        levels = levels[noisy]
        E, A, b = problem.A[:, exact], problem.A[:, noisy] / levels, problem.b
        svd = ScaledSVD.of(E) if len(exact) else None
        U = np.empty((len(b), 0)) if svd is None else svd.U
        lengths = np.sqrt((A * A).sum(axis=0))
        lengths[lengths == 0.0] = 1.0
        y, square, bound = _total_least_squares(
            A - U @ (U.T @ A), b - U @ (U.T @ b), lengths
        )
        vector = np.empty(10)
        vector[noisy] = y / levels
        if svd is not None:
            vector[exact] = svd.solve(b - A @ y)
        return self.answer(
            vector,
            state,
            row,
            certificate=Certificate(square, bound, iterations=1),
            bias=problem.bias(vector),
            warnings=warnings_of(problem.svd.open, "the smallest values that fit"),
        )


def column_levels(noise: Noise) -> Array:
    """Root-mean-square error (10,) of the whitened regressor's columns by noise of the
    accelerations."""
    a, alpha = noise.linear_acceleration**2, noise.angular_acceleration**2
    f, t = noise.force**2, noise.torque**2
    first, second, product = 2.0 * (alpha / f + a / t), alpha / t, 2.0 * alpha / t
    squares = (
        3.0 * a / f,
        first,
        first,
        first,
        second,
        product,
        product,
        second,
        product,
        second,
    )
    return np.sqrt(np.array(squares) / 6.0)


def _total_least_squares(
    A: Array, b: Array, lengths: Array
) -> tuple[Array, float, float]:
    """x (k,) from the smallest right singular vector of [A | b], its squared singular
    value, and a lower bound of that. Directions that A does not see, with columns
    relative to `lengths` (k,), get the smallest solution."""
    basis = np.eye(A.shape[1])
    if A.shape[1]:
        _, S, V = np.linalg.svd(A / lengths)
        if S[-1] <= RANK_TOLERANCE:
            basis = np.linalg.qr((V[RANK_TOLERANCE < S] * lengths).T)[0]
    C = np.column_stack((A @ basis, b))
    _, S, V = np.linalg.svd(C)
    v = V[-1]
    if abs(v[-1]) < 1e-10:
        raise NotIdentifiableError(
            "total least squares has no finite solution here", fix="use another method"
        )
    x = basis @ (-v[:-1] / v[-1])
    r = A @ x - b
    square = float(r @ r) / (1.0 + float(x @ x))
    return (
        x,
        square,
        max(0.0, float(S[-1]) - 16.0 * float(np.finfo(float).eps * S[0])) ** 2,
    )
