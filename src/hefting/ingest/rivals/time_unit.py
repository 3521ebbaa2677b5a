"""Time in another unit, or of samples at another rate than assumed.

Accelerations from poses go with the inverse square of the unit of time, and gravity does
not: the object seems to have another mass where it is accelerated than where it is
weighed.
"""

from dataclasses import replace

import numpy as np

from hefting.ingest.rivals.case import Case
from hefting.ingest.rivals.evidence import fit_rows
from hefting.ingest.rivals.explanation import (
    Build,
    Explanation,
    newton_euler,
    over_offsets,
)

CODE = "time-unit"
MILLISECONDS = 1e-3
"""[s]"""
RATIOS = (2.0, 2.5, 4.0, 5.0, 8.0, 10.0)
"""Of the rates at which arms and sensors are usually sampled: 50, 100, 125, 200, 250,
400, 500 and 1000 Hz. Smaller ones are like a payload that the controller takes away."""


def explain(case: Case) -> Explanation | None:
    """The likeliest unit [s] of the recorded time."""
    if not case.path.moves or case.path.kind != "smooth" or case.path.gravity_measured:
        return None
    units = (MILLISECONDS, *RATIOS, *(1.0 / ratio for ratio in RATIOS))
    offsets = np.unique((0.0, case.offset))
    motion = case.motion_at(case.time - offsets[:, None])
    found = [fit_rows(case, _builder(case, unit)(motion)).likelihood for unit in units]
    unit = units[int(np.argmax(np.max(found, axis=1)))]
    fitted, _ = over_offsets(case, _builder(case, unit))
    what = "time seems to be in milliseconds"
    if unit != MILLISECONDS:
        size, way = max(unit, 1.0 / unit), "fast" if unit < 1.0 else "slow"
        what = f"time seems to run {size:g} times too {way}"
    return Explanation(
        CODE,
        what,
        "give it in seconds, of samples at the rate at which they were taken",
        fitted,
        0,
        rarity=1.0,
        is_grave=True,
    )


def _builder(case: Case, unit: float) -> Build:
    factor = unit**-2.0
    return lambda motion: newton_euler(
        case, replace(motion, a=factor * motion.a, rest=factor * motion.rest)
    )
