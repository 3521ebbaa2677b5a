"""Working box: the axes in which a solid's bounding box is tight and rays meet few of
its triangles."""

from dataclasses import dataclass

import numpy as np

from hefting.core.spatial import Array
from hefting.shapes.solid import Solid


@dataclass(frozen=True)
class WorkingBox:
    """The solid in its working frame."""

    axes: Array
    """(3, 3), columns are the working axes in the axes of the file"""
    low: Array
    """(3,) [m] lower corner"""
    sides: Array
    """(3,) [m]"""
    triangles: Array
    """(F, 3, 3) [m]"""
    centroid: Array
    """(3,) [m]"""
    whitening: Array
    """(3, 3) W with W second_moment W' = I"""

    @property
    def outward(self) -> Array:
        """The triangles (F, 3, 3), oriented outward here too where the working axes are
        left-handed."""
        right_handed = np.linalg.det(self.axes) > 0.0
        return self.triangles if right_handed else self.triangles[:, ::-1]


def working_box(solid: Solid) -> WorkingBox:
    """The axes of the file, or the principal axes if their box is smaller by a tenth;
    rays along the last."""
    _, principal = np.linalg.eigh(solid.second_moment)
    principal = principal * np.sign(
        principal[np.abs(principal).argmax(axis=0), np.arange(3)]
    )
    turned = np.ptp(solid.vertices @ principal, axis=0)
    axes = principal if np.prod(turned) < 0.9 * np.prod(solid.extents) else np.eye(3)
    triangles = (solid.vertices @ axes)[solid.faces]
    # the best rays meet the fewest triangles: smallest sum of projected boxes
    spans = np.ptp(triangles, axis=1)
    last = int(np.argmin([(spans[:, i - 2] * spans[:, i - 1]).sum() for i in range(3)]))
    axes = np.roll(axes, 2 - last, axis=1)
    vertices = solid.vertices @ axes
    low, sides = vertices.min(axis=0), np.ptp(vertices, axis=0)
    whitening = np.asarray(
        np.linalg.inv(np.linalg.cholesky(axes.T @ solid.second_moment @ axes)), float
    )
    return WorkingBox(
        axes, low, sides, vertices[solid.faces], solid.centroid @ axes, whitening
    )
