"""Whether an accuracy is expected to be reached, and when."""

from __future__ import annotations

import numpy as np

from hefting.core.accuracy import NAMES, Accuracy
from hefting.core.errors import InputError
from hefting.core.inertia import InertialParameters
from hefting.planning.objective import NORM_QUANTILE, quantities
from hefting.planning.result import Forecast
from hefting.planning.search import Found


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


def require_in_reach(best: Found, forecast: Forecast, asked: Accuracy) -> None:
    """`InputError` where what is asked is not expected to be reached by the end, which
    says how long it would take.

    Deviations by noise fall with the root of the duration; what the estimator is not
    sure of beside them, the sensor's own accuracy, stays.
    """
    last = forecast.accuracy[-1]
    if asked.met_by(last):
        return
    duration = float(forecast.time[-1])
    factor = 1.0
    noisy = _by_noise(best)
    for name in NAMES.values():
        limit, got = getattr(asked, name), getattr(last, name)
        if limit is None or got is None or got <= limit:
            continue
        stays = (
            np.sqrt(max(got**2 - noisy[name] ** 2, 0.0)) if np.isfinite(got) else 0.0
        )
        if stays >= limit:
            what = f"{asked.shortfall(last)} after {duration:g} s, nor by any longer motion"
            fix = "ask for less: the rest is the sensor's own accuracy"
            raise InputError(what, fix=fix)
        factor = max(factor, (got**2 - stays**2) / (limit**2 - stays**2))
    long = duration * factor
    shown = f"{long:.2g} s" if np.isfinite(long) else "longer than can be told"
    what = f"out of reach within {duration:g} s: {asked.shortfall(last)}"
    raise InputError(what, fix=f"plan for about {shown}, or ask for less")


def _by_noise(best: Found) -> dict[str, float]:
    """What errors do not exceed with 95 % probability by noise alone, as `Accuracy` has
    them."""
    C = np.linalg.inv(best.after)
    body = InertialParameters(best.problem.constraints.body)
    return {
        name: NORM_QUANTILE * float(np.sqrt(np.trace(rows @ C @ rows.T)))
        for name, rows in quantities(body).items()
    }


def _share(asked: Accuracy, got: Accuracy) -> float:
    """Largest of what is known over what is asked."""
    shares = [0.0]
    for name in NAMES.values():
        limit, own = getattr(asked, name), getattr(got, name)
        if limit is not None and np.isfinite(limit):
            shares.append(np.inf if own is None else own / limit)
    return float(max(shares))
