"""Which numbers of an estimate neither the recording nor a shape determines."""

import numpy as np

from hefting.core.estimate import Estimate
from hefting.core.undetermined import Undetermined
from hefting.estimators import Estimator
from hefting.ingest.free_fit import TYPICAL_SIZE
from hefting.ingest.ingested import Ingested
from hefting.shapes import Shape

LARGEST_HALF_WIDTH = 0.5
"""Half-width of an interval over the mass, or over the largest moment of inertia, up to
which a number is known whatever least squares says of it: then its size is."""


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
