"""Widened covariance: that of an estimate with the errors which its method leaves
out."""

import numpy as np

from hefting.core.estimate import Estimate
from hefting.core.spatial import Array
from hefting.estimators import Estimator
from hefting.ingest.free_fit import inflated
from hefting.ingest.ingested import Ingested


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
