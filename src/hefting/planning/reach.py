"""Whether an accuracy is expected to be reached, and when."""

from __future__ import annotations

import numpy as np

from hefting.core.accuracy import NAMES, Accuracy
from hefting.core.errors import InputError
from hefting.planning.result import Forecast

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
