"""Box: the solid between two corners."""

import numpy as np
from numpy.typing import ArrayLike

from hefting.core.errors import InputError
from hefting.shapes.solid import Solid, solid_from_mesh

LARGEST_DISTANCE = 1e3
"""[m] No part of a box is further from the sensor."""
BOX_FACES = (
    *((0, 1, 3), (0, 3, 2), (4, 6, 7), (4, 7, 5), (0, 4, 5), (0, 5, 1)),
    *((2, 3, 7), (2, 7, 6), (0, 2, 6), (0, 6, 4), (1, 5, 7), (1, 7, 3)),
)
"""Triangles of a box whose corner 4 i + 2 j + k is at its i-th x, j-th y and k-th z."""


def box_solid(lower: ArrayLike, upper: ArrayLike) -> Solid:
    """The box between two corners (3,) [m], its sides along the axes of their frame.

    Raises `InputError` for corners that are not finite, not in order, or far away.
    """
    low, high = np.asarray(lower, dtype=float), np.asarray(upper, dtype=float)
    if not (np.isfinite((low, high)).all() and (low < high).all()):
        raise InputError(
            "a box needs x0 < x1, y0 < y1, z0 < z1",
            "box",
            "give X0,X1,Y0,Y1,Z0,Z1 in metres",
        )
    if max(-low.min(), high.max()) > LARGEST_DISTANCE:
        raise InputError(
            "a box is at most a kilometre from the sensor",
            "box",
            "give its sides in metres",
        )
    corners = np.where(np.indices((2, 2, 2)).reshape(3, 8).T == 1, high, low)
    return solid_from_mesh(corners, BOX_FACES, "box")
