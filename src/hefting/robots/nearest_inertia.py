"""The nearest inertia tensor that a body can have.

To a tensor J about the COM belong the second moments S = ∫ p p' dm = tr(J) / 2 I - J.
A body of mass m > 0 exists if and only if S is positive definite, which is the
pseudo-inertia condition with the mass and the COM held fixed (Wensing, Kim and Slotine
2018, https://arxiv.org/abs/1701.04395). The nearest is

    minimise |S' - S|_F  over  S' - t I positive semidefinite,

the projection on a cone, whose solution keeps the eigenvectors and raises every
eigenvalue to at least t (Higham 1988, https://doi.org/10.1016/0024-3795(88)90223-6).
"""

import numpy as np

from hefting.core.spatial import Array

THINNEST_SHARE = 1e-6
"""Least second moment of what is found, as a share of the sum of those that can be: a
thickness of a thousandth of the body's size, as in exports. On the boundary rounding
alone makes simulators refuse a body (MuJoCo wants A + B >= C exactly)."""

THINNEST_LENGTH = 1e-4
"""Least radius of gyration of what is found along any axis [m]: a tensor of zero has
no size, and no link is thinner."""

LEAST_MOMENT = 1e-14
"""Least second moment of what is found [kg m²]: MuJoCo refuses moments of inertia below
1e-15."""

DIGITS = 13
"""Decimal places that are kept below the largest entry: a millionth of the least second
moment, so that what is written can still exist, and zeros stay zeros."""


def second_moments(inertia: Array) -> Array:
    """Second moments (3, 3) [kg m²] of a tensor (3, 3), both about the COM."""
    return 0.5 * np.trace(inertia) * np.eye(3) - inertia


def least_second_moment(mass: float, inertia: Array) -> float:
    """The least second moment t [kg m²] of what is found for a mass [kg] and a tensor
    (3, 3)."""
    possible = np.maximum(np.linalg.eigvalsh(second_moments(inertia)), 0.0)
    return max(
        THINNEST_SHARE * float(possible.sum()),
        THINNEST_LENGTH**2 * mass,
        LEAST_MOMENT,
    )


def nearest_inertia(mass: float, inertia: Array) -> Array:
    """The nearest tensor (3, 3) [kg m²] about the COM of a body that can exist.

    Parameters
    ----------
    mass : positive [kg]; it and the COM stay.
    inertia : (3, 3) symmetric [kg m²] about the COM, in any axes. In other axes the
        answer is the same tensor, turned.
    """
    moments, axes = np.linalg.eigh(second_moments(inertia))
    raised = np.maximum(moments, least_second_moment(mass, inertia))
    second = (axes * raised) @ axes.T
    return _rounded(np.trace(second) * np.eye(3) - 0.5 * (second + second.T), inertia)


def _rounded(tensor: Array, before: Array) -> Array:
    """`tensor` with `DIGITS`, and the entries of `before` where it is the same."""
    places = DIGITS - int(np.ceil(np.log10(np.abs(tensor).max())))
    same = np.abs(tensor - before) <= 10.0**-places
    rounded = np.vectorize(lambda value: round(float(value), places))(tensor)
    return np.where(same, before, rounded)


def distance(inertia: Array, other: Array) -> float:
    """Frobenius distance [kg m²] of the second moments of two tensors (3, 3)."""
    return float(np.linalg.norm(second_moments(inertia) - second_moments(other)))
