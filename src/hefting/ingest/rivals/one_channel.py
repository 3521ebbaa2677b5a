"""One channel of the wrench is wrong by itself: in another unit, of another gain, at the
wire of another one, or dead.

The other five tell the body, and so what it should have measured. What it did measure is
found as any linear function of the motion, in their place.
"""

import numpy as np

from hefting.core.spatial import WRENCH
from hefting.ingest.model import FEATURES, REGRESSOR_BY_FEATURE
from hefting.ingest.rivals.case import Case
from hefting.ingest.rivals.evidence import Rows, fit_freely
from hefting.ingest.rivals.explanation import Explanation, newton_euler, over_offsets
from hefting.ingest.robust_rows import RobustRows
from hefting.logs.units import UNITS

CODE = "channel-wrong"
SMALLEST_FACTOR = 1.2
"""Gain, or its inverse, up to which it is the calibration matrix that is off."""
RARITY = 5.0
"""See `Explanation.rarity`: of some 36 pairs of channels, and a gain."""
ALIKE = 0.8
"""Share of what another channel explains that its own must, or it is the other's."""
DEAD = 0.5
"""Share that some channel must explain, by more than the noise, or it is noise."""
NEAR = 0.06
"""Deviation of a gain's logarithm from a unit's, as a share of it, up to which it may be
that."""


def explain(case: Case) -> Explanation | None:
    """The likeliest channel, as many times what itself or another should measure."""
    rows = newton_euler(case, case.motion_late(case.likely_offsets))
    c, of, gain = _measured(fit_freely(case, rows.known, rows.used), rows)
    if of == c and 1.0 / SMALLEST_FACTOR < abs(gain) < SMALLEST_FACTOR:
        return None
    fitted, _ = over_offsets(
        case, lambda motion: _with(newton_euler(case, motion), c, of, gain)
    )
    return Explanation(
        CODE,
        f"the channel {WRENCH[c]} seems to {_told(c, of, gain)}",
        "check its wire, unit and gain, and correct it where the log is written",
        fitted,
        1,
        rarity=RARITY,
        is_grave=True,
    )


def _with(rows: Rows, c: int, of: int, gain: float) -> Rows:
    """Rows in which channel c is a gain times what another, or itself, should measure."""
    maps = rows.maps.copy()
    maps[:FEATURES, c] = gain * rows.maps[:FEATURES, of]
    return Rows(rows.known, maps, rows.used)


def _measured(free: RobustRows, rows: Rows) -> tuple[int, int, float]:
    """The channel without which the others agree best, the one that it measures, and how
    many times, or zero where that is noise; from free functions of the motion."""
    best = free.best
    known = np.sqrt(free.weights[best])[:, None] * rows.known[best]
    # of the features that part which no bias has
    biases = known.shape[1] - FEATURES
    R = np.linalg.qr(np.roll(known, -FEATURES, axis=1)).R[biases:, biases:]
    model = np.tensordot(R, REGRESSOR_BY_FEATURE, 1)
    found = R @ free.solution[best].reshape(-1, 6)[:FEATURES]
    scale = np.repeat(free.scale[best], 3)
    left, bodies = np.zeros(6), np.zeros((6, 10))
    for c in range(6):
        A = np.delete(model / scale[:, None], c, axis=1).reshape(-1, 10)
        b = np.delete(found / scale, c, axis=1).ravel()
        bodies[c] = np.linalg.lstsq(A, b)[0]
        left[c] = np.square(b - A @ bodies[c]).sum()
    c = int(np.argmin(left))
    expected, found = model @ bodies[c], found[:, c]
    square = np.maximum(np.square(expected).sum(axis=0), 1e-300)
    gains = found @ expected / square
    share = gains**2 * square / max(float(found @ found), 1e-300)
    of = int(np.argmax(share))
    if share[c] > ALIKE * share[of]:
        of = c
    # in noise alone any function of the motion may be the likeliest
    noise = scale[c] ** 2 * float(free.weights[best].sum())
    heard = share[of] > DEAD and gains[of] ** 2 * square[of] > noise
    return c, of, float(gains[of]) if heard else 0.0


def _told(c: int, of: int, gain: float) -> str:
    """What a channel seems to do."""
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
