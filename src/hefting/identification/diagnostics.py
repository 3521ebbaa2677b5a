"""Diagnostics: an estimate with all errors that its method leaves out, with what is open
of it, and with what gives doubt."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from hefting.core.errors import NotIdentifiableError
from hefting.core.estimate import Estimate
from hefting.core.spatial import Array
from hefting.core.undetermined import Undetermined
from hefting.estimators import (
    Estimator,
)
from hefting.identification.checks import Checked, warnings_of
from hefting.ingest.free_fit import TYPICAL_SIZE, inflated
from hefting.ingest.ingested import Ingested
from hefting.ingest.plausibility import named_instead
from hefting.shapes import Shape

LARGEST_HALF_WIDTH = 0.5
"""Half-width of an interval over the mass, or over the largest moment of inertia, up to
which a number is known whatever least squares says of it: then its size is."""


def with_diagnostics(
    estimate: Estimate, estimator: Estimator, found: Ingested, shape: Shape | None
) -> Estimate:
    """The estimate with its residual, with what was assumed and what gives doubt.

    Raises `NotIdentifiableError` when its mass is not positive.
    """
    negative = (
        estimate.intervals is not None and not estimate.intervals["mass"][1] > 0.0
    )
    if negative or not estimate.parameters.mass > 0.0:
        if shape is None or not estimator.rests_on_shape:
            what = "no positive mass explains the wrench"
            fix = "check `sign` and `gravity`"
        else:
            doubts = f" ({'; '.join(shape.warnings)})" if shape.warnings else ""
            what = f"no mass inside the shape explains the wrench{doubts}"
            fix = "check the shape's pose and unit"
        refusal = NotIdentifiableError(what, where=found.log, fix=fix)
        raise named_instead(refusal, found)
    rms = found.residual(estimate.sensed_vector, estimate.bias)
    provenance = found.provenance | estimator.provenance | estimate.provenance
    own: Shape | None = getattr(estimator, "shape", None)
    if own is not None and own.known != "reach":
        provenance["points"] = own.n
    estimate = replace(
        estimate,
        samples=round(found.samples),
        duration=found.duration,
        covariance=widened_covariance(estimate, estimator, found),
        hull_margin=_margin(estimate, shape),
        residual=rms,
        provenance=provenance,
    )
    estimate = replace(
        estimate, undetermined=undetermined_by(estimate, estimator, found, shape)
    )
    checked = Checked(estimate, rms, estimator, found, shape)
    return replace(estimate, warnings=warnings_of(checked))


def _margin(estimate: Estimate, shape: Shape | None) -> float | None:
    """Depth of the COM in the hull; where the shape is uncertain the method knows
    better where that is."""
    if shape is None or estimate.hull_margin is not None:
        return estimate.hull_margin
    return shape.margin(estimate.parameters.center_of_mass)


def undetermined_by(
    estimate: Estimate, estimator: Estimator, found: Ingested, shape: Shape | None
) -> Undetermined:
    """What is open of an estimate.

    Open is what unconstrained least squares leaves open (`FreeFit.open_parameters`) and
    the method does not take from the object's shape; a box around the object is no
    shape. What the method knows by its interval is not open.
    """
    if shape is not None and estimator.rests_on_shape and shape.known == "object":
        return Undetermined()
    size = TYPICAL_SIZE
    if shape is not None and estimator.rests_on_shape:
        size = float(np.linalg.norm(shape.extents))
    names = found.fit.open_parameters(size)
    open_ = Undetermined.of_parameters(names, estimator.fills_in)
    return _less_what_is_known(open_, estimate, size)


def _less_what_is_known(
    open_: Undetermined, estimate: Estimate, size: float
) -> Undetermined:
    """Without the numbers whose intervals are narrow."""
    if not open_:
        return open_
    mass, moments = estimate.parameters.mass, estimate.parameters.inertia_at_com
    half = estimate.half_widths
    largest = LARGEST_HALF_WIDTH * float(np.abs(moments.diagonal()).max())
    left = Undetermined(
        open_.mass and not half["mass"] <= LARGEST_HALF_WIDTH * mass,
        open_.center_of_mass & ~(half["center_of_mass"] <= 0.5 * size),
        open_.inertia_at_com & ~(half["inertia_at_com"] <= largest),
        open_.filled_from,
    )
    return left if left else Undetermined()


def widened_covariance(
    estimate: Estimate, estimator: Estimator, found: Ingested
) -> Array | None:
    """The method's own covariance; one of white noise alone is widened for coloured
    residuals, and by the errors of gravity's size and of the tool; with a scale's
    reading it is that of the intervals.

    With gravity found as well it is that of the fit which found it: gravity's error is
    the larger part.
    """
    white = estimator.covariance_of_white_noise
    weighed = "sensor_gain" in estimate.provenance
    if estimate.covariance is None or not white or weighed:
        return estimate.covariance
    covariance = inflated(estimate.covariance, found.fit.inflation)
    if found.covariance_with_gravity is not None:
        covariance = found.covariance_with_gravity
    tool, error = found.tool, found.gravity_error
    if error is not None:
        covariance = covariance + np.outer(error, error)
    return (
        covariance
        if tool is None or tool.covariance is None
        else covariance + tool.covariance
    )
