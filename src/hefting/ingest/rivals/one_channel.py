"""One channel of the wrench is wrong by itself: in another unit, of another gain, at the
wire of another one, or dead.

The other five tell the body, and so what it should have measured. That is regressed on
any linear function of the motion in its place.
"""

import numpy as np

from hefting.core.spatial import WRENCH
from hefting.ingest.model import FEATURES, REGRESSOR_BY_FEATURE
from hefting.ingest.rivals.case import Case
from hefting.ingest.rivals.evidence import Fitted, Rows, fit_rows, linear_step
from hefting.ingest.rivals.explanation import Explanation, newton_euler, over_offsets
from hefting.logs.units import UNITS

CODE = "channel-wrong"
SMALLEST_FACTOR = 1.2
"""Gain, or its inverse, up to which it is the calibration matrix that is off."""
OWN = 0.5
"""Share of what a channel measures that is its own, from which on it is no other's."""
CERTAIN = 5.0
"""Standard deviations of the gain from which on a channel measures something, and
within which it is that of a unit."""
STEPS = 3
"""Gauss-Newton steps of the gain."""
RARITY = 5.0
"""Of which channel it is, and of the other that it may measure."""


def explain(case: Case) -> Explanation | None:
    """The likeliest channel with its gain."""
    rows = newton_euler(case, case.motion_late(case.likely_offsets))
    each = [fit_rows(case, _freed(rows, c)).of_best() for c in range(6)]
    c = int(np.argmax([fitted.likelihood[0] for fitted in each]))
    of, gain = _gain(each[c], c)
    std = 0.0
    rows = rows.part(slice(each[c].best, each[c].best + 1))
    for _ in range(STEPS):
        fitted = fit_rows(case, _measuring(rows, c, of, gain))
        column = np.zeros((len(case.time), 6, 1))
        column[:, c, 0] = rows.predict(fitted.solution[0, :10])[0, :, of]
        step = linear_step(fitted, 0, column)
        gain += float(step.change[0])
        std = float(step.covariance[0, 0]) ** 0.5
    if of == c and 1.0 / SMALLEST_FACTOR < abs(gain) < SMALLEST_FACTOR:
        return None
    what, gain = _told(c, of, gain, std)
    fitted, _ = over_offsets(
        case, lambda motion: _measuring(newton_euler(case, motion), c, of, gain)
    )
    return Explanation(
        CODE,
        what,
        "check its wire, unit and gain, and correct it where the log is written",
        fitted,
        1,
        rarity=RARITY,
        is_grave=True,
    )


def _freed(rows: Rows, c: int) -> Rows:
    """Rows in which channel c is any linear function of the motion."""
    maps = np.pad(rows.maps, ((0, 0), (0, 0), (0, FEATURES)))
    maps[:FEATURES, c] = 0.0
    maps[:FEATURES, c, -FEATURES:] = np.eye(FEATURES)
    return Rows(rows.known, maps, rows.used)


def _measuring(rows: Rows, c: int, of: int, gain: float) -> Rows:
    """Rows in which channel c measures another one, or itself, so many times."""
    maps = rows.maps.copy()
    maps[:FEATURES, c] = gain * rows.maps[:FEATURES, of]
    return Rows(rows.known, maps, rows.used)


def _gain(fitted: Fitted, c: int) -> tuple[int, float]:
    """The channel that channel c measures, and how many times, by the fit with it
    free."""
    known = fitted.rows.known[0, fitted.weights[0] > 0.0, :FEATURES]
    known = known - known.mean(axis=0)
    expected = known @ (REGRESSOR_BY_FEATURE @ fitted.solution[0, :10])
    found = known @ fitted.solution[0, -FEATURES:]
    square = np.maximum(np.square(expected).sum(axis=0), 1e-300)
    along = found @ expected
    share = along**2 / square / max(float(found @ found), 1e-300)
    of = c if share[c] > OWN else int(np.argmax(share))
    if share[of] < OWN:
        of = c
    return of, float(along[of] / square[of])


def _told(c: int, of: int, gain: float, std: float) -> tuple[str, float]:
    """What channel c seems to measure, and how many times."""
    name = WRENCH[c]
    if of != c:
        return f"{name} seems to measure what {WRENCH[of]} should", gain
    if abs(gain) < CERTAIN * std:
        return f"the channel {name} does not seem to measure anything", 0.0
    times = f"{gain:.3g} times what the other channels tell"
    for unit in UNITS["force" if c < 3 else "torque"].values():
        there = gain * float(unit.to_si(np.ones(1))[0])
        if abs(there - 1.0) < min(max(CERTAIN * std / abs(gain), 0.02), 0.15):
            return f"{name} seems to be in {unit.name}, as it is {times}", gain
    return f"{name} seems to be {times}", gain
