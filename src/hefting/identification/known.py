"""What hyperparameters of an estimator may follow from: the recording and the shape."""

from hefting.estimators.base import Known
from hefting.ingest.ingested import Ingested
from hefting.shapes import Shape


def known_of(found: Ingested, shape: Shape | None) -> Known:
    """What hyperparameters may follow from."""
    return Known(
        bias=found.bias,
        noise=found.fit.noise,
        motion_noise=None if found.source == "columns" else found.motion_noise,
        smoothed=found.source in ("smooth", "inertial"),
        systematic=found.common_errors,
        carried=None if found.tool is None else found.tool.parameters.vector,
        shape=shape,
    )
