"""The held object, as known before the motion."""

from typing import Self

import numpy as np

from hefting.core.errors import InputError
from hefting.core.estimate import Estimate, doubts_of
from hefting.core.estimate_json import subtracted_tool
from hefting.core.inertia import InertialParameters
from hefting.core.messages import Message, note
from hefting.core.spatial import Array, frozen, immutable
from hefting.core.undetermined import Covariance
from hefting.estimators import Bayes
from hefting.shapes import Shape
from hefting.shapes.solid import corners_between

UNKNOWN_MASS = 1.0
"""[kg] Assumed mass of an unknown object."""
UNKNOWN_BOX = ((-0.05, -0.05, 0.0), (0.05, 0.05, 0.2))
"""[m] Opposite corners, in the sensor frame, of the box around an unknown object: a hand
tool in a gripper."""

BOX_ASSUMED = "plan-box-assumed"
"""Code of the message that a box stands for the object's shape."""


@immutable
class Held:
    """The body to plan for, its box, and the prior information about it."""

    body: InertialParameters
    """likely parameters, in the sensor frame"""
    corners: Array
    """(8, 3) [m] of its box, in the sensor frame"""
    information: Array
    """(10, 10) inverse covariance of its parameters"""
    shape: Shape | None
    estimate: Estimate | None
    notes: tuple[Message, ...]
    """assumptions, and doubts about the estimate"""

    @property
    def tool(self) -> Array:
        """(10,) parameters of the tool that the estimate excludes; zeros without."""
        provenance = None if self.estimate is None else self.estimate.provenance
        tool = None if provenance is None else subtracted_tool(provenance)
        return np.zeros(10) if tool is None else tool

    @classmethod
    def of(cls, estimate: Estimate | None, shape: Shape | None) -> Self:
        """The object by an earlier estimate, a shape, both or neither.

        An estimate is assumed to include the information of the shape. Raises
        `InputError` for an estimate without mass or covariance.
        """
        notes: list[Message] = []
        if estimate is None:
            body = _body(shape)
            covariance = Bayes(shape or Shape.unknown()).prior_covariance(body.mass)
            information = np.linalg.inv(covariance)
            notes.append(_body_assumed(body, shape))
        else:
            body, information = _known(estimate)
            notes += doubts_of(estimate)
        if shape is None:
            corners = _unknown_corners(estimate)
            notes.append(_box_assumed(corners, estimate))
        else:
            corners = box_corners(shape)
        return cls(
            body, frozen(corners), frozen(information), shape, estimate, tuple(notes)
        )


def _body_assumed(body: InertialParameters, shape: Shape | None) -> Message:
    where = "box" if shape is None else "shape"
    what = (
        f"planned for a body of {body.mass:g} kg that is evenly spread in the {where}"
    )
    return note("plan-body-assumed", what, "estimate")


def _box_assumed(corners: Array, estimate: Estimate | None) -> Message:
    """A note on a box by its corners (8, 3) [m], the lowest first and the highest last,
    that stands for the shape; the `estimate` may have been made with one."""
    low, high = 1e3 * corners[0], 1e3 * corners[-1]
    x, y, z = 0.5 * (low + high)
    box = " x ".join(f"{side:.0f}" for side in high - low)
    made_with = None if estimate is None else estimate.provenance.get("shape")
    remedy = f": give {made_with}, as for the estimate" if made_with else ""
    what = (
        f"no shape given: the speed limit holds within a box of {box} mm about "
        f"({x:.0f}, {y:.0f}, {z:.0f}) mm in the tip's axes, and a part of the "
        f"object outside it may be faster{remedy}"
    )
    return note(BOX_ASSUMED, what, "shape")


def box_corners(shape: Shape) -> Array:
    """Corners (8, 3) [m] of the bounding box of a shape along its own axes, in the
    sensor frame."""
    axes = shape.pose[:3, :3]
    own = np.vstack((shape.hull, shape.positions)) @ axes
    return corners_between(own.min(axis=0), own.max(axis=0)) @ axes.T


def _unknown_corners(estimate: Estimate | None) -> Array:
    """Corners of `UNKNOWN_BOX`, extended by the same box about the estimated COM."""
    low, high = np.array(UNKNOWN_BOX)
    if estimate is not None:
        half, c = 0.5 * (high - low), estimate.center_of_mass
        low, high = np.minimum(low, c - half), np.maximum(high, c + half)
    return corners_between(low, high)


def _body(shape: Shape | None) -> InertialParameters:
    """A homogeneous body of `UNKNOWN_MASS` in the shape, or in `UNKNOWN_BOX`."""
    if shape is not None:
        own = shape.homogeneous
        return InertialParameters(UNKNOWN_MASS / own.mass * own.vector)
    low, high = np.array(UNKNOWN_BOX)
    squares = (high - low) ** 2
    J = UNKNOWN_MASS / 12.0 * np.diag(squares.sum() - squares)
    return InertialParameters.from_com(UNKNOWN_MASS, 0.5 * (low + high), J)


def _known(estimate: Estimate) -> tuple[InertialParameters, Array]:
    """Body and information of an estimate, with a weak prior for infinite variance."""
    body, C = estimate.parameters, estimate.covariance
    if not body.mass > 0.0:
        what = "the estimate has no mass to plan for"
        raise InputError(what, fix="identify again, or leave it out")
    if C is None:
        what = f"the estimate by {estimate.method} has no covariance to plan from"
        raise InputError(what, fix="identify with Bayes")
    own = Covariance.of(C)
    information = own.information
    if own.open.any():  # as large as anything that a gripper holds
        information += np.linalg.inv(Bayes().prior_covariance(body.mass))
    return body, information
