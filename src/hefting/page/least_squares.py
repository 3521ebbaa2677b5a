"""Least squares: what the motion of a recording tells by itself."""

from hefting.core.errors import HeftingError
from hefting.core.estimate import Estimate
from hefting.estimators import OLS, Estimator
from hefting.identification.identify import estimator_for, with_diagnostics
from hefting.identification.run import run
from hefting.ingest.ingested import Ingested


def least_squares(found: Ingested) -> tuple[Estimate, Estimator] | None:
    """What least squares finds, with what it leaves open; None where the recording
    determines nothing."""
    try:
        estimator = estimator_for(OLS, found, None, {})
        estimate, used = run(estimator, found)
    except HeftingError:
        return None
    return with_diagnostics(estimate, estimator, used, None), estimator
