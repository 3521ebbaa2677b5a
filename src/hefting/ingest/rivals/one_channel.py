"""One channel of the wrench is wrong: in another unit, of another gain, on the wire of
another channel, or dead.

The other five channels determine the body, and so what the channel should have measured.
What it did measure is fitted as any linear function of the motion, and compared.
"""

import numpy as np

from hefting.core.spatial import WRENCH, Array
from hefting.ingest.model import FEATURES, REGRESSOR_BY_FEATURE
from hefting.ingest.rivals.case import Case
from hefting.ingest.rivals.evidence import Rows, fit_free_channels
from hefting.ingest.rivals.explanation import Explanation, newton_euler, over_offsets
from hefting.ingest.robust_rows import RobustRows
from hefting.logs.units import UNITS

CODE = "channel-wrong"
SMALLEST_FACTOR = 1.2
"""Gain, or its inverse, up to which the error is left to `calibration_matrix`."""
RARITY = 5.0
"""See `Explanation.rarity`: there are some 36 pairs of channels, each with a gain."""
ALIKE = 0.8
"""A channel counts as measuring what it should, rather than another, if that explains
more than this share of what the other explains."""
DEAD = 0.5
"""A channel is dead unless what some channel should measure explains more than this share
of it, and more than the noise."""
NEAR = 0.06
"""Largest relative difference of the logarithms of a gain and of a unit that is named."""


def explain(case: Case) -> Explanation | None:
    """The faulty channel, as a gain times what it or another channel should measure."""
    rows = newton_euler(case, case.motion_late(case.likely_offsets))
    c, of, gain = _measured(fit_free_channels(case, rows.known, rows.used), rows)
    if of == c and 1.0 / SMALLEST_FACTOR < abs(gain) < SMALLEST_FACTOR:
        return None
    fitted, _ = over_offsets(
        case, lambda motion: _with(newton_euler(case, motion), c, of, gain)
    )
    return Explanation(
        CODE,
        f"the channel {WRENCH[c]} seems to {_description(c, of, gain)}",
        "check its wire, unit and gain, and correct it where the log is written",
        fitted,
        1,
        rarity=RARITY,
        is_grave=True,
    )


def _with(rows: Rows, c: int, of: int, gain: float) -> Rows:
    """Rows in which channel `c` is `gain` times what channel `of` should measure."""
    maps = rows.maps.copy()
    maps[:FEATURES, c] = gain * rows.maps[:FEATURES, of]
    return Rows(rows.known, maps, rows.used)


def _measured(free: RobustRows, rows: Rows) -> tuple[int, int, float]:
    """The faulty channel c, the channel `of` whose wrench it measures, and the gain, zero
    if it measures noise; from a fit of free channels."""
    best = free.best
    known = np.sqrt(free.weights[best])[:, None] * rows.known[best]
    # 12 virtual samples of the features, from which any bias is eliminated
    biases = known.shape[1] - FEATURES
    R = np.linalg.qr(np.roll(known, -FEATURES, axis=1)).R[biases:, biases:]
    model = np.tensordot(R, REGRESSOR_BY_FEATURE, 1)
    wrench = R @ free.solution[best].reshape(-1, 6)[:FEATURES]
    scale = np.repeat(free.scale[best], 3)
    c, body = _odd_channel(model / scale[:, None], wrench / scale)
    expected, measured = model @ body, wrench[:, c]
    square = np.maximum(np.square(expected).sum(axis=0), 1e-300)
    gains = measured @ expected / square
    share = gains**2 * square / max(float(measured @ measured), 1e-300)
    of = int(np.argmax(share))
    if share[c] > ALIKE * share[of]:
        of = c
    # any function of the motion may be the likeliest in noise alone
    noise = scale[c] ** 2 * float(free.weights[best].sum())
    alive = share[of] > DEAD and gains[of] ** 2 * square[of] > noise
    return c, of, float(gains[of]) if alive else 0.0


def _odd_channel(model: Array, wrench: Array) -> tuple[int, Array]:
    """The channel without which one body (10,) explains the others best, and that body,
    from regressors (n, 6, 10) and wrenches (n, 6) over their noise."""
    left, bodies = np.zeros(6), np.zeros((6, 10))
    for c in range(6):
        A = np.delete(model, c, axis=1).reshape(-1, 10)
        b = np.delete(wrench, c, axis=1).ravel()
        bodies[c] = np.linalg.lstsq(A, b)[0]
        left[c] = np.square(b - A @ bodies[c]).sum()
    c = int(np.argmin(left))
    return c, bodies[c]


def _description(c: int, of: int, gain: float) -> str:
    """What channel `c` seems to do, as a verb phrase."""
    if gain == 0.0:
        return "measure nothing but noise"
    if of != c:
        return f"measure what {WRENCH[of]} should"
    said = f"be {gain:.3g} times what the other channels tell"
    for unit in UNITS["force" if c < 3 else "torque"].values():
        ratio = abs(gain) * float(unit.to_si(np.ones(1))[0])
        if abs(np.log(ratio)) < NEAR * abs(np.log(abs(gain))):
            return f"{said}, as if in {unit.name}"
    return said
