"""Inertial parameters of a rigid body: conversions, frames, sums and consistency; and
coordinates of pseudo-inertias in an orthonormal basis of symmetric 4 x 4 matrices."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Self

import numpy as np
from numpy.typing import ArrayLike

from hefting.core.errors import InputError
from hefting.core.spatial import (
    Array,
    check_pose,
    frozen,
    rotation_by,
    skew,
    tensor_to_vector,
    vector_to_tensor,
)


@dataclass(frozen=True)
class Consistency:
    """Margins of the conditions of physical consistency; a body exists if and only if
    all are positive.

    The margins are dimensionless. The pseudo-inertia condition (Wensing et al. 2018)
    implies those before it; they are kept apart because they say what is wrong in
    words.

    Examples
    --------
    >>> import numpy as np
    >>> J = np.diag([3.0, 1.0, 1.0])
    >>> needle = hefting.InertialParameters.from_com(1.0, np.zeros(3), J)
    >>> needle.consistency().violated
    'triangle'
    """

    margins: dict[str, float]
    """``mass``: sign of the mass. ``inertia``: smallest principal moment at the COM
    over the largest. ``triangle``: slack of the triangle inequality, smallest of (J1 +
    J2 - J3) over the largest moment. ``pseudo_inertia``: smallest eigenvalue of the
    second-moment matrix at the COM over the largest, times the sign of the mass.
    ``hull``, where the shape is known: depth of the COM in its convex hull over its
    largest side."""

    @property
    def violated(self) -> str | None:
        """Name of the first condition that fails, or None."""
        return next(
            (name for name, margin in self.margins.items() if not margin >= -TOLERANCE),
            None,
        )

    @property
    def is_consistent(self) -> bool:
        """True when every condition holds (up to rounding: a flat or rod-like body sits
        on the boundary)."""
        return self.violated is None

    def __str__(self) -> str:
        name = self.violated
        if name is None:
            return "consistent"
        return f"{EXPLANATIONS[name]} (margin {self.margins[name]:.3g})"


TOLERANCE = 1e-9
"""Rounding allowed in a relative margin: bodies of coplanar or collinear points have
margins of exactly zero."""

EXPLANATIONS = {
    "mass": "the mass is not positive",
    "inertia": "the inertia tensor at the COM is not positive definite",
    "triangle": "the principal moments break the triangle inequality",
    "pseudo_inertia": "the pseudo-inertia is not positive definite",
    "hull": "the COM is outside the shape's convex hull",
}


@dataclass(frozen=True, eq=False)
class InertialParameters:
    """Mass, first moment and inertia tensor about a frame's origin, in that frame's
    axes.

    ``vector`` (10,) is [m, m c (3), Jxx, Jxy, Jxz, Jyy, Jyz, Jzz] in kg, kg m, kg m²
    (`spatial.PARAMETERS`). Nothing is assumed of the values: a least-squares result may
    be unphysical, which `consistency` shows.

    Examples
    --------
    >>> import numpy as np
    >>> J = 0.01 * np.eye(3)
    >>> body = hefting.InertialParameters.from_com(0.5, [0.0, 0.0, 0.1], J)
    >>> body.inertia_at_origin.diagonal().round(3).tolist()
    [0.015, 0.015, 0.01]
    >>> (body + body).mass
    1.0
    """

    vector: Array

    def __post_init__(self):
        object.__setattr__(self, "vector", frozen(self.vector))
        if self.vector.shape != (10,):
            raise InputError(
                f"inertial parameters are ten numbers, not an array of shape {self.vector.shape}"
            )

    # factories

    @classmethod
    def from_com(
        cls, mass: float, center_of_mass: ArrayLike, inertia_at_com: ArrayLike
    ) -> Self:
        """From mass [kg], COM (3,) [m] and the inertia tensor (3, 3) [kg m²] about the
        COM, in the frame's axes."""
        c = np.asarray(center_of_mass, dtype=float)
        J = np.asarray(inertia_at_com, dtype=float) - mass * skew(c) @ skew(c)
        return cls(np.concatenate(([mass], mass * c, tensor_to_vector(J))))

    @classmethod
    def from_origin(
        cls, mass: float, center_of_mass: ArrayLike, inertia_at_origin: ArrayLike
    ) -> Self:
        """From mass [kg], COM (3,) [m] and the inertia tensor (3, 3) [kg m²] about the
        frame's origin."""
        c = np.asarray(center_of_mass, dtype=float)
        return cls(
            np.concatenate(([mass], mass * c, tensor_to_vector(inertia_at_origin)))
        )

    @classmethod
    def from_pseudo_inertia(cls, matrix: ArrayLike) -> Self:
        """From the 4 x 4 pseudo-inertia [[Sigma, m c], [m c', m]], Sigma = ∫ p p' dm
        (Wensing et al. 2018)."""
        P = np.asarray(matrix, dtype=float)
        J = np.trace(P[:3, :3]) * np.eye(3) - P[:3, :3]
        return cls(np.concatenate(([P[3, 3]], P[:3, 3], tensor_to_vector(J))))

    @classmethod
    def from_points(cls, positions: ArrayLike, masses: ArrayLike) -> Self:
        """From point masses: positions (n, 3) [m] and masses (n,) [kg]."""
        p, m = np.asarray(positions, dtype=float), np.asarray(masses, dtype=float)
        P = np.empty((4, 4))
        P[:3, :3], P[:3, 3], P[3, 3] = (p.T * m) @ p, m @ p, m.sum()
        P[3, :3] = P[:3, 3]
        return cls.from_pseudo_inertia(P)

    # accessors

    @property
    def mass(self) -> float:
        """Mass [kg]."""
        return float(self.vector[0])

    @property
    def center_of_mass(self) -> Array:
        """COM (3,) [m] in the frame; NaN when the mass is zero."""
        mass, moment = self.mass, self.vector[1:4]
        if 0.0 < abs(mass) < np.inf:
            return moment / mass
        with np.errstate(invalid="ignore"):
            return moment / mass if mass else np.full(3, np.nan)

    @property
    def inertia_at_origin(self) -> Array:
        """Inertia tensor (3, 3) [kg m²] about the frame's origin."""
        return vector_to_tensor(self.vector[4:])

    @property
    def inertia_at_com(self) -> Array:
        """Inertia tensor (3, 3) [kg m²] about the COM, in the frame's axes."""
        C = skew(self.center_of_mass)
        return self.inertia_at_origin + self.mass * C @ C

    @property
    def pseudo_inertia(self) -> Array:
        """Pseudo-inertia (4, 4), see `from_pseudo_inertia`."""
        P = np.empty((4, 4))
        J = self.inertia_at_origin
        P[:3, :3] = 0.5 * np.trace(J) * np.eye(3) - J
        P[:3, 3] = P[3, :3] = self.vector[1:4]
        P[3, 3] = self.mass
        return P

    def principal(self) -> tuple[Array, Array]:
        """Principal moments (3,) [kg m²] at the COM in rising order, and the
        right-handed axes as columns (3, 3)."""
        moments, axes = np.linalg.eigh(self.inertia_at_com)
        axes[:, 2] *= np.sign(np.linalg.det(axes))
        return moments, axes

    def consistency(self, hull: float | None = None) -> Consistency:
        """Margins of every condition of physical consistency; `hull` is that of the COM
        in a known shape."""
        known = {} if hull is None else {"hull": hull}
        if not (self.vector[0] and np.isfinite(self.vector).all()):
            return Consistency(
                dict.fromkeys(
                    ("mass", "inertia", "triangle", "pseudo_inertia"), float("nan")
                )
                | known
            )
        sign = float(np.sign(self.mass))
        moments = np.linalg.eigvalsh(self.inertia_at_com)
        # eigenvalues of the second-moment matrix about the COM
        second = 0.5 * moments.sum() - moments
        # of a point far away rounding is all that remains
        floor = 1e-5 * float(np.abs(self.vector[4:]).max())
        largest = max(float(np.abs(moments).max()), floor) or 1.0
        return Consistency(
            {
                "mass": sign,
                "inertia": float(moments[0]) / largest,
                "triangle": float(moments[0] + moments[1] - moments[2]) / largest,
                "pseudo_inertia": sign
                * float(second.min())
                / (max(float(np.abs(second).max()), floor) or 1.0),
            }
            | known
        )

    # operations

    def moved(self, pose_old_in_new: ArrayLike) -> Self:
        """The same body in another frame; `pose_old_in_new` (4, 4) is this frame's pose
        in the new one."""
        pose = check_pose(pose_old_in_new)
        return type(self).from_pseudo_inertia(pose @ self.pseudo_inertia @ pose.T)

    def __add__(self, other: InertialParameters) -> InertialParameters:
        """Two bodies rigidly joined, both given in this frame."""
        return InertialParameters(self.vector + other.vector)

    def __sub__(self, other: InertialParameters) -> InertialParameters:
        """What remains when `other`, given in this frame, is taken away."""
        return InertialParameters(self.vector - other.vector)


def com_jacobian(parameters: InertialParameters) -> Array:
    """Derivative (10, 10) of mass, COM and inertia at the COM (xx, xy, xz, yy, yz, zz)
    by the parameter vector."""
    m, c = parameters.mass, parameters.center_of_mass
    J = np.zeros((10, 10))
    J[0, 0] = 1.0
    J[1:4, 0], J[1:4, 1:4] = -c / m, np.eye(3) / m
    J[4:, 4:] = np.eye(6)
    # inertia at COM = inertia at origin + m [c]x[c]x = J_o + [mc]x[mc]x / m
    J[4:, 0] = -tensor_to_vector(skew(c) @ skew(c))
    for i, unit in enumerate(np.eye(3)):
        J[4:, 1 + i] = tensor_to_vector(skew(unit) @ skew(c) + skew(c) @ skew(unit))
    return J


ROWS, COLUMNS = np.triu_indices(4)
"""Entry of the matrix that each coordinate stands for."""


def _basis() -> Array:
    basis = np.zeros((10, 4, 4))
    for matrix, i, j in zip(basis, ROWS, COLUMNS, strict=True):
        matrix[i, j] = matrix[j, i] = 1.0 if i == j else math.sqrt(0.5)
    return basis


BASIS = _basis().reshape(10, 16)
"""(10, 16) orthonormal basis of the symmetric 4 x 4 matrices."""
DIAGONAL = np.ascontiguousarray(BASIS[:, ::5])
"""(10, 4) takes s to vec(diag(s))."""
IDENTITY = BASIS @ np.eye(4).ravel()
"""(10,) coordinates of the identity."""
PARAMETERS_OF = np.stack(
    [InertialParameters.from_pseudo_inertia(m.reshape(4, 4)).vector for m in BASIS],
    axis=1,
)
"""(10, 10) takes coordinates of a pseudo-inertia to the parameters of its body."""


def mat(q: Array) -> Array:
    """Symmetric matrix (4, 4) of coordinates (10,)."""
    return (q @ BASIS).reshape(4, 4)


def vec(Q: Array) -> Array:
    """Coordinates (10,) of a symmetric matrix (4, 4)."""
    return BASIS @ Q.ravel()


_PAIRS = [
    4 * i[:, None] + j
    for i, j in ((ROWS, ROWS), (COLUMNS, COLUMNS), (ROWS, COLUMNS), (COLUMNS, ROWS))
]
_LENGTHS = np.where(ROWS == COLUMNS, math.sqrt(0.5), 1.0)
_SCALE = np.outer(_LENGTHS, _LENGTHS)


def congruence(G: Array) -> Array:
    """(10, 10) takes vec(X) to vec(G X G')."""
    g = G.ravel()
    first, second, third, fourth = (g.take(pair) for pair in _PAIRS)
    return _SCALE * (first * second + third * fourth)


def moving(pose_old_in_new: Array) -> Array:
    """(10, 10) takes parameters to those in a frame in which the old one has this pose
    (4, 4)."""
    units = map(InertialParameters, np.eye(10))
    return np.column_stack([unit.moved(pose_old_in_new).vector for unit in units])


def misplaced(vector: Array, pose_std: Sequence[float]) -> Array:
    """Covariance (10, 10) of parameters (10,) by errors of the frame's pose [m, rad],
    along and about each axis."""
    errors = np.tile(np.eye(4), (6, 1, 1))
    errors[:3, :3, 3] = pose_std[0] * np.eye(3)
    errors[3:, :3, :3] = [rotation_by(pose_std[1] * axis) for axis in np.eye(3)]
    body = InertialParameters(vector)
    changes = np.array([body.moved(error).vector - vector for error in errors])
    return changes.T @ changes
