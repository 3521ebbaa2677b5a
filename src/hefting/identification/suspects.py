"""Suspects: which of many recordings differ most from the rest, without identifying the
rest again for each.

With A_i phi = b_i the equations of recording i beside its bias, G = sum A_i'A_i and phi
the least squares of all, that of all but i is in closed form

    phi_i = phi + (G - A_i'A_i)^-1 A_i'(A_i phi - b_i).

Its interval is taken to be that of all. So this ranks recordings, and no more.
"""

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from hefting.core.estimate import Estimate
from hefting.core.inertia import InertialParameters
from hefting.core.spatial import Array
from hefting.estimators import OLS
from hefting.estimators.quadratic import Quadratic
from hefting.identification.agreement import Agreement
from hefting.identification.known import known_of
from hefting.identification.seen import state_of
from hefting.ingest.ingested import Ingested
from hefting.ingest.joint import together

SHIFTED = ("mass", "center_of_mass")
"""Intervals by which estimates are compared."""


def least_squares_of(found: Ingested) -> Estimate:
    """Unconstrained least squares with the intervals of all errors that are allowed
    for."""
    estimator = OLS(**OLS.settings(known_of(found, None)))
    states = [state_of(estimator, part) for part in found.recordings]
    state = estimator.merge_all(states)
    estimate = replace(estimator, intervals=False).estimate(state)
    intervals, covariance = estimator.uncertainty(estimate.parameters, state)
    return replace(estimate, intervals=intervals, covariance=covariance)


def deviations_from_rest(
    parts: Mapping[str, Ingested], alone: Mapping[str, Estimate]
) -> dict[str, float]:
    """About how many standard deviations each recording is from all others, largest
    first; `alone` is the least squares of each."""
    found = together(list(parts.values()), list(parts))
    whole = least_squares_of(found)
    phi, free_bias = whole.parameters.vector, found.bias == "estimate"
    each = {
        name: Quadratic.of(part.state, found.fit.noise, free_bias)
        for name, part in parts.items()
    }
    G = np.sum([own.A.T @ own.A for own in each.values()], axis=0)
    apart: dict[str, float] = {}
    for name, own in each.items():
        gradient = own.A.T @ (own.A @ phi - own.b)
        moved = phi + _solved(G - own.A.T @ own.A, gradient)
        rest = _moved(whole, InertialParameters(moved))
        agreement = Agreement.of({"own": alone[name], "rest": rest})
        apart[name] = agreement.largest.deviations
    return dict(sorted(apart.items(), key=lambda item: -item[1]))


def _solved(G: Array, gradient: Array) -> Array:
    """G^-1 gradient (10,); the shortest such, in scaled unknowns, where G (10, 10) is
    singular."""
    scale = np.sqrt(np.maximum(G.diagonal(), 1e-300))
    scaled = G / np.outer(scale, scale)
    return np.linalg.lstsq(scaled, gradient / scale, rcond=1e-12)[0] / scale


def _moved(estimate: Estimate, body: InertialParameters) -> Estimate:
    """The estimate of another body, with intervals as wide."""
    assert estimate.intervals is not None
    shifts = {
        name: np.asarray(getattr(body, name)) - getattr(estimate.parameters, name)
        for name in SHIFTED
    }
    intervals = {
        name: ends + shifts[name] if name in shifts else ends
        for name, ends in estimate.intervals.items()
    }
    return replace(estimate, parameters=body, intervals=intervals)
