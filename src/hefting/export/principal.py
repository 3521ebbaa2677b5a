"""Principal moments and axes of an inertia tensor, and how finely they are worth being
written."""

import itertools

import numpy as np

from hefting.core.quantity import rounded
from hefting.core.spatial import Array, skew

THINNEST = 1e-6
"""Least second moment of mass along any axis, as a share of the sum over the three
principal axes: a thickness of a thousandth of the body's size. A flat or rod-like body
is on the boundary of what can exist, and rounding alone makes simulators refuse it
(MuJoCo wants A + B >= C and positive moments, exactly)."""

ALIKE = 3.0
"""Moments that differ by no more than so many rounding steps count as equal: each of
the two may be off by one and a half."""

SIGNED_PERMUTATIONS = np.array(
    [
        np.diag(signs)[:, order]
        for order in itertools.permutations(range(3))
        for signs in itertools.product((1.0, -1.0), repeat=3)
    ]
)
RENAMINGS = SIGNED_PERMUTATIONS[np.linalg.det(SIGNED_PERMUTATIONS) > 0]
"""The 24 right-handed ways (24, 3, 3) to rename and reverse three axes."""


def principal(inertia: Array, step: float) -> tuple[Array, Array]:
    """Principal moments (3,) [kg m²] and right-handed principal axes as columns (3, 3).

    Each axis is called x, y or z after the frame's axis it is nearest to: of the 24
    right-handed ways to name them, the one least turned from the frame. Axes of moments
    that are equal to within `ALIKE` times `step` [kg m²] are arbitrary: they are laid
    along the frame's, as far as they can be.
    """
    moments, axes = np.linalg.eigh(inertia)
    alike = np.diff(moments) <= ALIKE * step
    if alike.all():
        return np.full(3, moments.mean()), np.eye(3)
    if alike.any():
        pair, single = ([0, 1], 2) if alike[0] else ([1, 2], 0)
        moments[pair] = moments[pair].mean()
        axes[:, pair] = _across(axes[:, single])
    axes[:, 2] *= np.sign(np.linalg.det(axes))
    renaming = RENAMINGS[np.einsum("ij,kji->k", axes, RENAMINGS).argmax()]
    return np.abs(renaming.T) @ moments, axes @ renaming


def _across(axis: Array) -> Array:
    """Two orthonormal columns (3, 2) perpendicular to a unit vector (3,), the first as
    near to an axis of the frame as one can be."""
    nearest = np.eye(3)[np.abs(axis).argmin()]
    first = nearest - axis * float(nearest @ axis)
    first = first / float(np.linalg.norm(first))
    return np.column_stack((first, skew(axis) @ first))


def angle_decimals(moments: Array, step: float) -> int:
    """Decimal places of an angle [deg] that turns the axes of these moments: a turn
    changes the tensor by the difference of two moments."""
    spread = float(np.ptp(moments))
    if spread == 0.0:
        return 0
    degrees = np.degrees(step / spread)
    return int(np.clip(-np.floor(np.log10(degrees)), 0, 9))


def with_thickness(inertia: Array) -> tuple[Array, bool]:
    """Inertia tensor (3, 3) whose every second moment is at least `THINNEST`, and
    whether that changed it."""
    second, axes = np.linalg.eigh(0.5 * np.trace(inertia) * np.eye(3) - inertia)
    raised = np.maximum(second, THINNEST * second.sum())
    if np.array_equal(raised, second):
        return inertia, False
    tensor = inertia + (axes * ((raised - second).sum() - (raised - second))) @ axes.T
    return 0.5 * (tensor + tensor.T), True


def rounded_inertia(inertia: Array, places: np.ndarray) -> tuple[Array, int]:
    """An inertia tensor (3, 3) with its entries rounded to decimal `places` (3, 3), or
    to as many more as it takes that a body can still have it; and the most places of an
    entry."""
    for more in range(16):
        found = rounded(inertia, places + more)
        second = np.linalg.eigvalsh(0.5 * np.trace(found) * np.eye(3) - found)
        if second[0] >= 0.5 * THINNEST * second.sum() > 0.0:
            return found, int(places.max()) + more
    return inertia, int(places.max()) + 16
