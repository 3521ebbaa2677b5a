"""How uncertain one will be, as one number to make small."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Self

import numpy as np

from hefting.core.accuracy import Accuracy
from hefting.core.estimate import com_jacobian
from hefting.core.inertia import InertialParameters
from hefting.core.spatial import Array, frozen

NORM_QUANTILE = 1.75
"""95 % quantile of the length of a random vector over the root of its mean square:
1.96 where one axis alone is uncertain, 1.61 where three are alike."""
SHARPNESS = 12.0
"""Power of the mean that stands for the largest of the shares."""
DOUBLE = np.array((1.0, 2.0, 2.0, 1.0, 2.0, 1.0)) ** 0.5
"""Weights of a tensor's entries in its Frobenius norm."""


@dataclass(frozen=True, eq=False)
class Objective:
    """With the covariance C of the parameters after the motion: the largest of
    deviation over tolerance, or the volume of their ellipsoid."""

    rows: tuple[Array, ...]
    """(k, 10) each: deviations of a quantity, over its tolerance, by those of the
    parameters"""
    floors: Array
    """of each quantity, squares that no motion lessens"""
    volume: bool
    """whether the volume counts, not the largest"""

    @classmethod
    def of(
        cls, body: InertialParameters, asked: Accuracy | None, gain: float = 0.0
    ) -> Self:
        """For a body of about these parameters; `gain` is the standard deviation of the
        sensor's gain, an error that the mass keeps."""
        rows, floors = [], []
        for name, own in quantities(body).items():
            limit = getattr(asked, name) if asked else None
            if limit is not None and np.isfinite(limit):
                factor = 1.96 if name == "mass" else NORM_QUANTILE
                rows.append(frozen(factor / limit * own))
                floors.append((factor * gain / limit) ** 2 if name == "mass" else 0.0)
        return cls(tuple(rows), frozen(floors), not rows)

    def value(self, information: Array) -> tuple[float, Array]:
        """Logarithm of the deviation to make least, and its derivative (10, 10) by the
        information (10, 10)."""
        scale = 1.0 / np.sqrt(information.diagonal())
        L = np.linalg.cholesky(scale[:, None] * information * scale)
        half = np.linalg.solve(L, np.diag(scale))
        C = half.T @ half
        if self.volume:
            log = np.log(L.diagonal()).sum() - np.log(scale).sum()
            return -float(log) / 10.0, -C / 20.0
        images = [rows @ C for rows in self.rows]
        squares = np.array(
            [np.sum(i * rows) for i, rows in zip(images, self.rows, strict=True)]
        )
        squares = squares + self.floors
        powers = (squares / squares.max()) ** (0.5 * SHARPNESS)
        shares = powers / powers.sum()
        value = 0.5 * np.log(squares.max()) + np.log(powers.sum()) / SHARPNESS
        slope = sum(
            -0.5 * s / q * (i.T @ i)
            for s, q, i in zip(shares, squares, images, strict=True)
        )
        return float(value), np.asarray(slope)


def quantities(body: InertialParameters) -> dict[str, Array]:
    """Deviations of mass (1, 10) as a share, COM (3, 10) [m] and inertia about the COM
    (6, 10) as a share of its norm, by those of the parameters."""
    J = com_jacobian(body)
    size = float(np.linalg.norm(body.inertia_at_com)) or 1e-12
    return {
        "mass": J[:1] / body.mass,
        "center_of_mass": J[1:4],
        "inertia": DOUBLE[:, None] * J[4:] / size,
    }
