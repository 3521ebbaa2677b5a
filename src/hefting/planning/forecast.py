"""How sure one will be, and whether and when that is what was asked."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from hefting.core.accuracy import NAMES, Accuracy
from hefting.core.errors import InputError
from hefting.core.estimate import NORMAL_95, com_jacobian
from hefting.core.inertia import InertialParameters
from hefting.core.spatial import Array, frozen, vector_to_tensor
from hefting.estimators import Bayes
from hefting.planning.held import Held
from hefting.planning.result import Forecast

INSTANTS = {"full": 10, "next": 6, "quick": 2}
"""At which is told how sure one is expected to be, besides before the motion."""
SHORTEST = 1.0
"""[s] of a recording from which something is expected."""
DRAWS = 1000
LEVEL = 0.95


def forecast_by(
    after: Callable[[float, Array | None], Array | None],
    held: Held,
    duration: float,
    instants: int,
) -> Forecast:
    """Before a motion of `duration` [s], and at so many instants of it.

    `after` gives the covariance (10, 10) after so long a part of the motion [s], from
    that before it; None stands for next to nothing.
    """
    times = np.linspace(min(SHORTEST, 0.5 * duration), duration, instants)
    if instants <= 2:
        times = times[-1:]
    before = _before(held)
    known = [before, *(after(t, before) for t in times)]
    accuracies = [_accuracy(C, held.body) for C in known]
    widths = [NORMAL_95 * _deviations(C, held.body) for C in known]
    return Forecast(
        frozen([0.0, *times]),
        frozen([own[0] for own in widths]),
        frozen([own[1:4] for own in widths]),
        frozen([vector_to_tensor(own[4:]) for own in widths]),
        tuple(accuracies),
    )


def _before(held: Held) -> Array | None:
    """(10, 10) covariance of what is known now; None where next to nothing is."""
    if held.estimate is not None:
        return np.asarray(held.estimate.covariance)
    if held.shape is None:
        return None
    return Bayes(held.shape).prior_covariance(held.body.mass)


def _deviations(C: Array | None, body: InertialParameters) -> Array:
    """(10,) standard deviations of mass, COM and inertia about it; infinite where
    nothing is known."""
    if C is None:
        return np.full(10, np.inf)
    finite = np.where(np.isfinite(C), C, 0.0)
    J = com_jacobian(body)
    variances = np.einsum("ip,pq,iq->i", J, finite, J)
    open_ones = (J**2) @ np.where(np.isfinite(C.diagonal()), 0.0, 1.0) > 0.0
    return np.where(open_ones, np.inf, np.sqrt(np.maximum(variances, 0.0)))


def _accuracy(C: Array | None, body: InertialParameters) -> Accuracy:
    """What errors do not exceed with probability `LEVEL`."""
    if C is None or not np.isfinite(C).all():
        return Accuracy(np.inf, np.inf, np.inf)
    values, vectors = np.linalg.eigh(C)
    half = vectors * np.sqrt(np.maximum(values, 0.0))
    normal = np.random.default_rng(0).standard_normal((DRAWS, 10))
    return Accuracy.of_draws(body.vector + normal @ half.T, body, LEVEL)


LONGER = 4.0
"""Times the duration of the motion that tells how deviations fall with it."""


def time_needed(forecast: Forecast, asked: Accuracy) -> float | None:
    """[s] after which what is asked is expected to be reached, linear between the
    instants of the forecast; None where it is not."""
    shares = [_share(asked, each) for each in forecast.accuracy]
    if shares[0] <= 1.0:
        return 0.0
    for i in range(1, len(shares)):
        if shares[i] <= 1.0:
            before, after = (min(shares[k], 1e3) for k in (i - 1, i))
            part = (before - 1.0) / max(before - after, 1e-12)
            low, high = forecast.time[i - 1 : i + 1]
            return float(low + part * (high - low))
    return None


def out_of_reach(asked: Accuracy, forecast: Forecast, longer: Forecast) -> InputError:
    """The error of an accuracy that is not expected by the end, which says how long it
    would take, by what a longer motion would reach.

    Variances are taken to fall as n / T + f: f is what the estimator is not sure of
    however long the recording, as the sensor's own accuracy.
    """
    last, then = forecast.accuracy[-1], longer.accuracy[-1]
    T, longer_T = float(forecast.time[-1]), float(longer.time[-1])
    what = f"out of reach within {T:g} s: {asked.shortfall(last)}"
    needed = T
    for name in NAMES.values():
        limit, got, later = (getattr(own, name) for own in (asked, last, then))
        if limit is None or got is None or later is None or got <= limit:
            continue
        n = max(got**2 - later**2, 0.0) / (1.0 / T - 1.0 / longer_T)
        f = max(later**2 - n / longer_T, 0.0)
        needed = max(needed, n / (limit**2 - f) if limit**2 > f else np.inf)
    if not np.isfinite(needed):
        fix = "ask for less: what stays is the sensor's own accuracy"
        return InputError(f"{what}, nor by any longer motion", fix=fix)
    return InputError(what, fix=f"plan for about {needed:.2g} s, or ask for less")


def _share(asked: Accuracy, got: Accuracy) -> float:
    """Largest of what is known over what is asked."""
    shares = [0.0]
    for name in NAMES.values():
        limit, own = getattr(asked, name), getattr(got, name)
        if limit is not None and np.isfinite(limit):
            shares.append(np.inf if own is None else own / limit)
    return float(max(shares))
