"""Convergence: estimates up to several instants of a recording, or up to one."""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from hefting.core.errors import NotIdentifiableError
from hefting.core.estimate import Estimate
from hefting.core.inertia import InertialParameters
from hefting.core.spatial import Array, immutable, tensor_to_vector
from hefting.estimators import Estimator
from hefting.estimators.joint_state import State
from hefting.estimators.sample_state import SampleState
from hefting.identification.checks import with_diagnostics
from hefting.identification.estimator import taken
from hefting.ingest.free_fit import free_fit
from hefting.ingest.ingested import Ingested
from hefting.shapes import Shape

INSTANTS = 20
"""Number of instants of a recording."""


@immutable
class Convergence:
    """Estimates from the samples up to each of n instants, by one method.

    Clock, bias drift, sign and outliers are those found from the whole recording.
    """

    rows: np.ndarray
    """(n,) number of measurements seen, increasing; the last is all of them"""
    values: Array
    """(n, 10) mass [kg], COM [m] and inertia there [kg m²], xx, xy, xz, yy, yz, zz"""
    low: Array | None
    """(n, 10) lower ends of their 95 % intervals, minus infinity where open; None where
    the method has none"""
    high: Array | None
    """(n, 10) upper ends"""


def convergence(estimator: Estimator, found: Ingested, final: Estimate) -> Convergence:
    """Estimates along a recording.

    Parameters
    ----------
    estimator : the estimator of `final`.
    found : the used part of the recording, or of several in turn.
    final : the estimate from all of it, which is the last one.
    """
    seen, estimates = [], []
    last: Estimate | None = None
    for rows, state in _states(estimator, found):
        try:
            last, _ = estimator.continued(state, last)
        except NotIdentifiableError:
            continue
        seen.append(rows)
        estimates.append(last)
    seen.append(len(found.measurements))
    estimates.append(final)
    values = np.array([ten_of(each.parameters) for each in estimates])
    low = high = None
    if all(each.intervals is not None for each in estimates):
        ends = np.array([ten_ends(each.intervals) for each in estimates])
        low, high = ends[:, 0], ends[:, 1]
    return Convergence(np.array(seen), values, low, high)


def ten_of(body: InertialParameters) -> Array:
    """(10,) mass [kg], COM [m] and inertia at the COM [kg m²] of a body."""
    inertia = tensor_to_vector(body.inertia_at_com)
    return np.concatenate(([body.mass], body.center_of_mass, inertia))


def ten_ends(intervals: dict[str, Array]) -> tuple[Array, Array]:
    """(10,) lower and upper ends of `Estimate.intervals`, as `ten_of` has them."""
    low, high = (
        np.concatenate(
            (
                [intervals["mass"][end]],
                intervals["center_of_mass"][end],
                tensor_to_vector(intervals["inertia_at_com"][end]),
            )
        )
        for end in (0, 1)
    )
    return low, high


def _states(estimator: Estimator, found: Ingested) -> Iterator[tuple[int, State]]:
    """Measurements seen, and the estimator's state, at all instants but the last."""
    total = len(found.measurements)
    instants = np.unique(np.linspace(0, total, INSTANTS + 1).astype(int))[1:-1]
    before, begin = estimator.start(), 0
    for part in found.recordings:
        z = taken(estimator, part)
        state, seen = estimator.start(), 0
        for rows in instants[(instants > begin) & (instants <= begin + len(z))]:
            until = int(rows) - begin
            state, seen = estimator.update(state, z[seen:until]), until
            yield int(rows), estimator.merge(before, state)
        state = estimator.update(state, z[seen:])
        before, begin = estimator.merge(before, state), begin + len(z)


def estimate_until(
    found: Ingested, estimator: Estimator, shape: Shape | None, instant: float
) -> Estimate:
    """The estimate from the samples of one recording up to an instant [s], on the clock
    of ``found.measurements``; of static poses their index.

    The recording is understood as a whole: clock offset, sign, bias model and drift,
    gravity, outliers, noise, the weights of the samples and the errors that they share
    are those of all of it; nothing else of later samples is used. At the end of the
    recording the estimate is that of `hefting.identify`. The estimator is that of
    `estimator_for` for the whole recording; it does not stop at an accuracy (`until`).

    Raises `NotIdentifiableError` if there is no sample up to the instant, or they do not
    determine a positive mass.
    """
    used = int(np.searchsorted(found.measurements.time, instant, side="right"))
    samples = taken(estimator, found)[:used]
    estimate = estimator.estimate(estimator.update(estimator.start(), samples))
    return with_diagnostics(estimate, estimator, _first_samples(found, used), shape)


def _first_samples(found: Ingested, used: int) -> Ingested:
    """A recording with its first samples only, conditioned as the whole, and least squares
    of these samples."""
    if used >= len(found.measurements):
        return found
    z = found.measurements[:used]
    free_bias = found.bias == "estimate"
    fit = free_fit(SampleState.of(z), free_bias, found.conditioned.inflation)
    if found.tool is not None and found.tool.covariance is not None:
        fit = fit.less(np.zeros(10), found.tool.covariance)
    counts = found.counts[:used]
    return replace(found, measurements=z, counts=counts, kept=None, fit=fit)
