"""Place: where a shape is from the sensor, in words."""

import numpy as np
from numpy.typing import ArrayLike

from hefting.shapes import Shape


def place_of(shape: Shape) -> tuple[str, ...]:
    """Where a shape reaches along the axes of the sensor, and where its COM is if its
    density is uniform; a line each."""
    low, high = 1e3 * shape.hull.min(axis=0), 1e3 * shape.hull.max(axis=0)
    reach = ", ".join(
        f"{axis} {_mm(a)} to {_mm(b)}"
        for axis, a, b in zip("xyz", low, high, strict=True)
    )
    center = 1e3 * shape.homogeneous.center_of_mass
    at = ", ".join(f"{axis} {_mm(c)}" for axis, c in zip("xyz", center, strict=True))
    return (f"reaches {reach} mm", f"COM of uniform density {at} mm")


def depth_of(shape: Shape, point: ArrayLike) -> float:
    """Depth [m] of a point (3,) [m] in the convex hull of a shape; negative outside."""
    return shape.margin(point) * (float(shape.extents.max()) or 1.0)


def _mm(value: float) -> str:
    return f"{np.round(value, 1) + 0.0:.1f}".replace("-", "−")
