"""Instant: what a recording tells of its object up to an instant of it."""

from dataclasses import replace

import numpy as np

from hefting.core.estimate import Estimate
from hefting.core.measurements import Measurements
from hefting.core.spatial import Array
from hefting.estimators import Estimator
from hefting.estimators.sample_state import SampleState
from hefting.identification.identify import with_diagnostics
from hefting.identification.seen import taken
from hefting.ingest.free_fit import FreeFit, free_fit
from hefting.ingest.ingested import Ingested
from hefting.shapes import Shape


def estimate_until(
    found: Ingested, estimator: Estimator, shape: Shape | None, instant: float
) -> Estimate:
    """The estimate from the samples of a recording up to an instant.

    The recording is understood as a whole: clock offset, sign, bias model and drift,
    gravity, outliers, noise, the weights of the samples and the errors that they share
    are those of all of it. Of the samples so put right those with a time up to `instant`
    are used, and nothing else of later ones. At the end of the recording the estimate is
    that of `hefting.identify`.

    Parameters
    ----------
    found : Ingested
        One recording, as read and conditioned.
    estimator : Estimator
        With its hyperparameters, as `estimator_for` makes it of the whole recording; it
        does not stop at an accuracy (`until`).
    shape : Shape, optional
        Shape of the object in the sensor frame.
    instant : float
        Time of the last sample to use [s], on the clock of ``found.measurements``; of
        static poses their index.

    Returns
    -------
    Estimate

    Raises
    ------
    NotIdentifiableError
        If there is no sample up to the instant, or they do not determine a positive
        mass.
    """
    used = int(np.searchsorted(found.measurements.time, instant, side="right"))
    samples = taken(estimator, found)[:used]
    state = estimator.update(estimator.start(), samples)
    estimate = estimator.estimate(state)
    return with_diagnostics(estimate, estimator, first_samples(found, used), shape)


def first_samples(found: Ingested, used: int) -> Ingested:
    """A recording with no more than its first samples, and what least squares finds of
    these; conditioned as the whole."""
    if used >= len(found.measurements):
        return found
    z = found.measurements[:used]
    return replace(
        found,
        measurements=z,
        counts=found.counts[:used],
        kept=None,
        fit=_fit_of(found, z),
    )


def _fit_of(found: Ingested, z: Measurements) -> FreeFit:
    """Least squares of some samples, from which the tool is subtracted."""
    free_bias = found.bias == "estimate"
    fit = free_fit(SampleState.of(z), free_bias, found.conditioned.inflation)
    tool: Array | None = None if found.tool is None else found.tool.covariance
    return fit if tool is None else fit.less(np.zeros(10), tool)
