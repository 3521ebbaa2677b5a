"""The sensor does not answer in proportion to the load: its gain depends on the load, as
near the end of an amplifier's range, or with a calibration for one load; or each channel
follows only after the load has moved by some share of its range, by hysteresis or play.

A channel that reads x has an error in proportion to x |x| or x³, with x counted from no
load or from zero, where its gain is right. The factor is common to the forces and to
the torques, as if all gauges had the same range.
"""

import numpy as np

from hefting.core.spatial import Array, distinct
from hefting.ingest.model import REGRESSOR_BY_FEATURE
from hefting.ingest.rivals.case import Case
from hefting.ingest.rivals.evidence import (
    Fitted,
    beside_body,
    fit_rows,
    is_hopeless,
    with_bias,
)
from hefting.ingest.rivals.explanation import (
    Explanation,
    fit_as_given,
    newton_euler,
    of_each_wrench,
)

HYSTERESIS = "hysteresis"
SHARES = np.array((0.005, 0.01, 0.02, 0.03, 0.05, 0.1))
"""Play over the range of each channel that is tried."""
PLAY_PASSES = 2
"""Number of times that the play is found, from improved predictions of the load."""


def explain_hysteresis(case: Case) -> Explanation | None:
    """The likeliest play."""
    if not case.path.moves:
        return None
    given, late = fit_as_given(case)
    # play looks like a delay, which the recording as given may have taken it for
    offsets = distinct((0.0, 0.5 * late, late))
    rows = newton_euler(case, case.motion_late(offsets))
    fitted = fit_rows(case, rows)
    load = case.wrench - fitted.residual[fitted.best]
    for _ in range(PLAY_PASSES):
        wrenches = case.wrench - _lags(load, SHARES)
        fitted = of_each_wrench(case, rows, wrenches)
        if is_hopeless(case, fitted, given):
            return None
        index = fitted.best // len(offsets)
        load = wrenches[index] - fitted.residual[fitted.best]
    what = (
        f"the sensor seems to follow the load with some {100.0 * SHARES[index]:.2g} % of "
        "play or hysteresis"
    )
    fix = "check how it is mounted, and its cable"
    # intervals allow for as much as the sensor may have
    effect = 0.0 if SHARES[index] <= case.sensor_errors else None
    return Explanation(
        HYSTERESIS,
        what,
        fix,
        fitted,
        1,
        rarity=2.0,
        of_many_laws=True,
        effect=effect,
    )


def _lags(load: Array, shares: Array) -> Array:
    """(S, K, 6) readings of followers with play of each of the shares (S,), less their
    load (K, 6)."""
    half = 0.5 * shares[:, None] * np.ptp(load, axis=0)
    shown = np.empty((len(load), *half.shape))
    shown[0] = load[0]
    low, high = load[:, None] - half, load[:, None] + half
    for k in range(1, len(load)):
        np.minimum(np.maximum(shown[k - 1], low[k]), high[k], out=shown[k])
    return np.swapaxes(shown - load[:, None], 0, 1)


CODE = "gain-by-load"
PASSES = 2
"""Number of times that the reading without noise is predicted, with improved laws."""
SMALLEST_CHANGE = 0.01
"""Change of the gain within a recording from which on it is reported; data sheets allow
half."""
LARGEST_CHANGE = 1.0
"""Change of the gain beyond which it is another error."""
UNKNOWNS = 2
ERRORS = np.eye(6)[:, :, None] * np.repeat(np.eye(2), 3, axis=0)[:, None]
"""(6, 6, 2) columns of the errors of force and torque, per unit of each channel's."""
RARITY = 15.0
"""See `Explanation.rarity`. Different gains are far more common, and sensors follow
such a law slightly: in recordings of three real ones it explains a fifth of what is
unexplained, with an evidence of up to 3."""


def explain(case: Case) -> Explanation | None:
    """The likeliest law, at the clock offset of the recording as given."""
    if not case.path.moves:
        return None
    fitted, loads = _fit_laws(case)
    law = fitted.best
    load = np.abs(loads[law % 2]).reshape(-1, 2, 3)
    # (2,) each, of force and torque
    largest, varies = load.max(axis=(0, 2)), np.ptp(load, axis=0).max(axis=1)
    powers = largest if law < 2 else largest**2
    changes = powers * fitted.solution[law, 10:12]
    of = int(np.argmax(np.abs(changes) * largest / fitted.scale[law]))
    change = abs(changes[of])
    seen = change * varies[of] / max(largest[of], 1e-300)
    if not (seen > SMALLEST_CHANGE and change < LARGEST_CHANGE):
        return None
    name, unit = (("force", "N"), ("torque", "N m"))[of]
    what = (
        f"the sensor's gain seems to change with the load, the {name}'s "
        f"by {100.0 * changes[of]:+.2g} % at {largest[of]:.2g} {unit}"
    )
    fix = "zero it first, check its calibration, or use one of a larger range"
    return Explanation(CODE, what, fix, fitted, UNKNOWNS, rarity=RARITY)


def _fit_laws(case: Case) -> tuple[Fitted, Array]:
    """Fit of four laws, and the loads (2, K, 6) [N, N m] without noise, counted from no
    load and from zero: x |x| of each of these loads, then x³ of each."""
    fitted, offset = fit_as_given(case)
    motion = case.motion_late(offset)
    features = case.features(motion)
    loads = np.empty((2, *case.wrench.shape))
    for _ in range(PASSES):
        body = REGRESSOR_BY_FEATURE @ fitted.solution[fitted.best, :10]
        reading = case.wrench - fitted.residual[fitted.best]
        loads = np.stack((features[0] @ body, reading))
        laws = np.concatenate([loads * np.abs(loads), loads**3])
        each = np.broadcast_to(features, (len(laws), *features.shape[1:]))
        used = np.broadcast_to(motion.known, laws.shape[:2])
        known = np.concatenate((each, laws), axis=2)
        fitted = fit_rows(case, with_bias(case, known, beside_body(ERRORS), used))
    return fitted, loads
