"""HPS: homogeneous part segmentation (Nadeau, Giamou & Kelly, ICRA 2023)."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from hefting.core.errors import InputError, NotIdentifiableError
from hefting.core.estimate import Certificate, Estimate
from hefting.core.measurements import Measurements
from hefting.core.spatial import Array
from hefting.estimators.base import BiasModel
from hefting.estimators.joint_state import State
from hefting.estimators.point_estimator import PointEstimator
from hefting.estimators.possible_bodies import PossibleBodies
from hefting.estimators.quadratic import (
    RANK_TOLERANCE,
    Quadratic,
    WrenchNoise,
    nonnegative_least_squares,
)
from hefting.estimators.sample_state import SampleState
from hefting.shapes import Shape

REACH = 10.0
"""Ratio of masses up to which the lower bound holds."""


@dataclass(frozen=True, eq=False)
class HPS(PointEstimator):
    """One non-negative mass for each part of the object, each part homogeneous, from
    gravity alone:

        minimise  |S^-1/2 (Ã M m - b)|²   over m >= 0,   samples with |a| and |alpha| below their limits

    Column i of M holds the inertial parameters of part i with 1 kg. For stop-and-go
    motion; gravity does not determine the masses of more than four parts. The choice of
    samples depends on the sensor's origin and on units.

    Examples
    --------
    >>> import numpy as np
    >>> corners = np.indices((2, 2, 2)).reshape(3, 8).T * (0.1, 0.3, 0.1)
    >>> shape = hefting.Shape(corners, labels=np.arange(8) % 4 // 2)
    >>> hefting.HPS(shape).fit(measurements).physically_consistent
    True
    """

    rank = 40
    role = "shape"
    needs = "labelled parts"
    consistent = True
    source = "Nadeau, Giamou & Kelly, ICRA 2023"
    best_for = "stop-and-go motion of an object whose parts are known"
    invariances = frozenset(
        {"world frame", "sample order", "merging", "sensor rotation", "wrench scale"}
    )

    shape: Shape
    """Points with the label of each one's part, and its share of the volume."""
    bias: BiasModel = "none"
    """``"none"``: the wrench is unbiased; ``"estimate"``: find a constant bias with the
    masses."""
    noise: WrenchNoise = None
    """Known wrench noise S, levels or a covariance (6, 6). None: newtons weigh like
    newton-metres."""
    max_acceleration: float = 1.0
    """Samples count as static below it [m/s²]."""
    max_angular_acceleration: float = 1.0
    """Samples count as static below it [rad/s²]."""

    def __post_init__(self):
        super().__post_init__()
        if self.shape.labels is None:
            fix = "give a .ply file of points with a 'segmentation' property"
            raise InputError("HPS needs labelled parts", fix=fix)
        for name in ("max_acceleration", "max_angular_acceleration"):
            value = getattr(self, name)
            if not (isinstance(value, int | float) and value > 0.0):
                raise InputError(f"{name} must be positive, not {value}")

    @cached_property
    def _shares(self) -> Array:
        """(n, parts) mass of each point for 1 kg in each part."""
        _, part = np.unique(np.asarray(self.shape.labels), return_inverse=True)
        shares = np.zeros((self.shape.n, int(part.max()) + 1))
        shares[np.arange(self.shape.n), part] = self.shape.shares
        totals = shares.sum(axis=0)
        return shares[:, totals > 0.0] / totals[totals > 0.0]

    @cached_property
    def _matrix(self) -> Array:
        """M (10, parts)"""
        return self.shape.matrix @ self._shares

    @property
    def sampling(self) -> tuple[Any, ...]:
        """By the limits of the accelerations."""
        return "static", self.max_acceleration, self.max_angular_acceleration

    def update(self, state: SampleState, measurements: Measurements) -> SampleState:
        """The state with the near-static samples of `measurements` added.

        Its time record holds all samples: those that were chosen by measured
        accelerations have other errors of them than the rest.
        """
        a = np.linalg.norm(measurements.linear_acceleration, axis=1)
        alpha = np.linalg.norm(measurements.angular_acceleration, axis=1)
        chosen = (a < self.max_acceleration) & (alpha < self.max_angular_acceleration)
        if chosen.all():
            return state.fold(measurements, 0.0)
        record = state.fold(measurements, 0.0).record
        return replace(state.fold(measurements[chosen], 0.0), record=record)

    def estimate(self, state: State) -> Estimate:
        """The estimate from the near-static samples seen.

        Raises `NotIdentifiableError` when there are none, when they do not tell the
        mass from a bias, or when no mass at all explains the wrench best.
        """
        if state.samples == 0:
            what = "no near-static samples to estimate from"
            raise NotIdentifiableError(what, fix="stop and go, or use GEO or PMD")
        problem = Quadratic.of(state, self.noise, self.bias == "estimate")
        row = self.mass_row(state, problem.A)
        problem = problem.with_equation(row.equation)
        G, g = problem.A @ self._matrix, problem.b
        lengths = np.sqrt(
            (G * G).sum(axis=0)
            + ((problem.bias_rows[:, :, 6:16] @ self._matrix) ** 2).sum(axis=(0, 1))
        )
        lengths[lengths == 0.0] = 1.0
        U, S, V = np.linalg.svd(G / lengths, full_matrices=False)
        # what is less, a bias and rounding explain as well
        told = int((RANK_TOLERANCE < S).sum())
        if told == 0:
            what = "the poses do not tell the mass" + (
                " from a bias" if self.bias == "estimate" else ""
            )
            raise NotIdentifiableError(what, fix="record more orientations")
        masses = nonnegative_least_squares(
            (V * lengths)[:told] * S[:told, None], U[:, :told].T @ g
        )
        if not masses.any():
            fix = "check the object's pose and the signs of wrench and gravity"
            raise NotIdentifiableError(
                "the wrench is best explained by no mass at all", fix=fix
            )
        vector = self._matrix @ masses
        r = G @ masses - g
        return self.answer(
            vector,
            state,
            row,
            certificate=Certificate(float(r @ r), _bound(G, g, masses), iterations=1),
            bias=problem.bias(vector),
            point_masses=self._shares @ masses,
            warnings=_warnings(len(lengths), told),
        )

    def possible_bodies(self, center: Array) -> PossibleBodies:
        """Bodies of these parts, each homogeneous."""
        return self._of_parts.or_any(center)

    @cached_property
    def _of_parts(self) -> PossibleBodies:
        return PossibleBodies.of_parts(self.shape, self._shares)


def _warnings(parts: int, told: int) -> tuple[str, ...]:
    return (
        ()
        if told == parts
        else (
            f"gravity does not tell the masses of {parts} parts apart, only of {told}",
        )
    )


def _bound(G: Array, g: Array, masses: Array) -> float:
    """Lower bound of |G m - g|² over m >= 0, from the residual made orthogonal to the
    active columns."""
    U, S, _ = np.linalg.svd(G[:, masses > 0.0], full_matrices=False)
    U = U[:, 1e-12 * S.max(initial=0.0) < S]
    u = -(g - U @ (U.T @ g))
    slope = min(0.0, float((G.T @ u).min()))
    return max(
        0.0, -float(u @ u + 2.0 * (g @ u)) + 2.0 * REACH * float(masses.sum()) * slope
    )
