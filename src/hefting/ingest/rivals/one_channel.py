"""One channel of the wrench is wrong by itself: in another unit, of another gain, at the
wire of another one, or dead.

The other five tell the body, and so what it should have measured. What it did measure is
found as any linear function of the motion, in their place.
"""

import numpy as np

from hefting.core.spatial import WRENCH
from hefting.ingest.model import FEATURES, REGRESSOR_BY_FEATURE
from hefting.ingest.rivals.case import Case
from hefting.ingest.rivals.evidence import (
    Fitted,
    LinearPart,
    Rows,
    fit_rows,
    is_hopeless,
)
from hefting.ingest.rivals.explanation import (
    Explanation,
    fit_as_given,
    newton_euler,
    over_offsets,
)
from hefting.logs.units import UNITS

CODE = "channel-wrong"
SMALLEST_FACTOR = 1.2
"""Gain, or its inverse, up to which it is the calibration matrix that is off."""
ALIKE = 0.8
"""Share of the variance that another channel explains which what a channel should measure
must explain, or it is the other's."""
DEAD = 0.5
"""Share of the variance that some channel must explain, or what is found is noise."""
SMALLEST_GAIN = 5e-3
"""Gain up to which it is cross-talk or chance."""
NEAR = 0.06
"""Deviation of a gain's logarithm from a unit's, as a share of it, up to which it may be
that: far from one nothing else is likely, and a small channel is told to some percent."""
RARITY = 5.0
"""Of which channel it is, and of the other that it may measure."""


def explain(case: Case) -> Explanation | None:
    """The likeliest channel, as many times what itself or another should measure."""
    given = fit_as_given(case)[0]
    c = _likeliest(given.of_best())
    rows = newton_euler(case, case.motion_late(case.likely_offsets))
    freed = fit_rows(case, _freed(rows, c)).of_best()
    if is_hopeless(case, freed, given):
        return None
    of, gain = _measured(freed, c)
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


def _likeliest(given: Fitted) -> int:
    """The channel that leaves least beside any function of the motion in its place, to
    first order."""
    known = given.rows.known[0, :, :FEATURES]
    columns = np.einsum("kx,cd->kcdx", known, np.eye(6)).reshape(len(known), 6, -1)
    S, g = LinearPart.of(given, 0).beside(columns)
    parts = [slice(first, first + FEATURES) for first in range(0, len(g), FEATURES)]
    steps = [np.linalg.lstsq(S[p, p], g[p], rcond=1e-9)[0] for p in parts]
    return int(np.argmax([g[p] @ step for p, step in zip(parts, steps, strict=True)]))


def _freed(rows: Rows, c: int) -> Rows:
    """Rows in which channel c is any linear function of the motion."""
    maps = np.pad(rows.maps, ((0, 0), (0, 0), (0, FEATURES)))
    maps[:FEATURES, c] = 0.0
    maps[:FEATURES, c, -FEATURES:] = np.eye(FEATURES)
    return Rows(rows.known, maps, rows.used)


def _with(rows: Rows, c: int, of: int, gain: float) -> Rows:
    """Rows in which channel c is a gain times what another, or itself, should measure."""
    maps = rows.maps.copy()
    maps[:FEATURES, c] = gain * rows.maps[:FEATURES, of]
    return Rows(rows.known, maps, rows.used)


def _measured(fitted: Fitted, c: int) -> tuple[int, float]:
    """The channel that channel c measures, and how many times, by the fit with it free;
    zero where that is noise."""
    known = fitted.rows.known[0, fitted.weights[0] > 0.0, :FEATURES]
    known = known - known.mean(axis=0)
    expected = known @ (REGRESSOR_BY_FEATURE @ fitted.solution[0, :10])
    found = known @ fitted.solution[0, -FEATURES:]
    square = np.maximum(np.square(expected).sum(axis=0), 1e-300)
    gains = found @ expected / square
    share = gains**2 * square / max(float(found @ found), 1e-300)
    of = int(np.argmax(share))
    if share[c] > ALIKE * share[of]:
        of = c
    live = share[of] > DEAD and abs(gains[of]) > SMALLEST_GAIN
    return of, float(gains[of]) if live else 0.0


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
