"""Quantities: the ten numbers of a body in the units a person reads, in groups of one
unit."""

from dataclasses import dataclass

import numpy as np

from hefting.core.estimate import Estimate
from hefting.core.inertia import InertialParameters
from hefting.core.spatial import TENSOR_COLUMNS, TENSOR_ROWS, Array, tensor_to_vector
from hefting.identification.convergence import ten_ends, ten_of
from hefting.scene.ellipsoid import half_widths

AXES = "xyz"
NAMES = (
    "mass",
    *(f"COM {axis}" for axis in AXES),
    *(f"J{AXES[i]}{AXES[j]}" for i, j in zip(TENSOR_ROWS, TENSOR_COLUMNS, strict=True)),
)
"""Of the ten numbers, in this order; J about the COM."""
SCALE = np.array((1.0, *[1e3] * 3, *[1e3] * 6))
"""From SI units to those shown."""


@dataclass(frozen=True)
class Group:
    """Numbers of one unit."""

    title: str
    unit: str
    rows: tuple[int, ...]
    """of the ten"""


GROUPS = (
    Group("Mass", "kg", (0,)),
    Group("Centre of mass, from the sensor's origin", "mm", (1, 2, 3)),
    Group("Moments of inertia about the centre of mass", "g m²", (4, 7, 9)),
    Group("Products of inertia about the centre of mass", "g m²", (5, 6, 8)),
)


def ten(body: InertialParameters) -> Array:
    """(10,) numbers of a body, in the units shown."""
    return SCALE * ten_of(body)


def ends_of(estimate: Estimate) -> tuple[Array, Array]:
    """(10,) lower and upper ends of the 95 % intervals of an estimate, in the units
    shown; infinite where it is open, NaN where the method has none."""
    if estimate.intervals is not None:
        low, high = ends_of_intervals(estimate.intervals)
    else:
        half, values = _half_widths(estimate), ten(estimate.parameters)
        low, high = values - half, values + half
    open_ = open_of(estimate)
    return np.where(open_, -np.inf, low), np.where(open_, np.inf, high)


def ends_of_intervals(intervals: dict[str, Array]) -> tuple[Array, Array]:
    """The same of `Estimate.intervals`."""
    low, high = ten_ends(intervals)
    return SCALE * low, SCALE * high


def open_of(estimate: Estimate) -> np.ndarray:
    """(10,) whether neither the recording nor a shape determines a number."""
    o = estimate.undetermined
    inertia = tensor_to_vector(o.inertia_at_com)
    return np.array([o.mass, *o.center_of_mass, *inertia], dtype=bool)


def _half_widths(estimate: Estimate) -> Array:
    """(10,) in the units shown, NaN where the method has none."""
    p = estimate.parameters
    parts = [
        half_widths(estimate, name, getattr(p, name))
        for name in ("mass", "center_of_mass", "inertia_at_com")
    ]
    if any(part is None for part in parts):
        return np.full(10, np.nan)
    mass, com, inertia = (np.asarray(part) for part in parts)
    return SCALE * np.concatenate(([mass], com, inertia[TENSOR_ROWS, TENSOR_COLUMNS]))
