"""Time in another unit, or samples at another rate than assumed.

Accelerations from poses are proportional to the inverse square of the unit of time, and
gravity is not: the object seems to have another mass by its acceleration than by its
weight. If it seems heavier by acceleration, a payload that the controller subtracts
does the same: time is named beside it, or alone if samples are unusually far apart.
"""

from collections.abc import Iterator
from dataclasses import replace
from functools import partial

import numpy as np

from hefting.core.spatial import median
from hefting.ingest.rivals import wrench_compensated
from hefting.ingest.rivals.case import Case
from hefting.ingest.rivals.evidence import fit_rows
from hefting.ingest.rivals.explanation import (
    Build,
    Explanation,
    Undone,
    explains_nothing,
    newton_euler,
    over_offsets,
)

CODE = "time-unit"
MILLISECONDS = 1e-3
"""[s]"""
RATIOS = (2.0, 2.5, 3.0, 4.0, 5.0, 8.0, 10.0)
"""Ratios of the rates at which arms and sensors are usually sampled: 50, 100, 125, 200,
250, 400, 500 and 1000 Hz. Smaller ones are like a payload that the controller
subtracts."""
COMMON = frozenset((2.0, 5.0, 10.0, 0.5, MILLISECONDS))
"""[s] Units that are first mistakes of a pair."""
SHORTEST_INTERVALS = {MILLISECONDS: 0.2, 0.5: 0.0}
"""[s] Least recorded interval between samples for a unit of less than a second to be
tried; for the others it is `RARE_INTERVAL`."""
LARGEST_INERTIAL = 4.0
"""Ratio above which the object has less than 1/16 of its mass by acceleration, as one
lighter than the payload that is subtracted."""
RARE_INTERVAL = 0.05
"""[s] Interval that samples rarely exceed."""


def explain(case: Case) -> Explanation | None:
    """The likeliest unit [s] of the recorded time."""
    if not _is_from_poses(case) or explains_nothing(
        case, partial(wrench_compensated.freed, case)
    ):
        return None
    units = _units(case)
    motion = case.motion_late(case.likely_offsets)
    found = [fit_rows(case, _builder(case, unit)(motion)).likelihood for unit in units]
    unit = units[int(np.argmax(np.max(found, axis=1)))]
    fitted, _ = over_offsets(case, _builder(case, unit))
    return Explanation(
        CODE,
        f"time seems to {_what(unit)}",
        _fix(unit),
        fitted,
        0,
        rarity=1.0,
        alternative=None if unit < 1.0 else lambda: wrench_compensated.explain(case),
        is_grave=True,
    )


def undone(case: Case) -> Iterator[Undone]:
    """Each unit."""
    if not _is_from_poses(case):
        return
    for unit in COMMON.intersection(_units(case)):
        other = case.with_accelerations(unit**-2.0, unit**-2.0)
        yield Undone(
            CODE,
            f"time seems to {_what(unit)}",
            _fix(unit),
            other,
            rarity=1.0,
            is_grave=True,
            is_linear=True,
        )


def _is_from_poses(case: Case) -> bool:
    """Whether all accelerations are derivatives of poses."""
    return case.path.kind == "smooth" and not case.path.gravity_measured


def _units(case: Case) -> list[float]:
    """Units [s] in which time may be, given the intervals between samples."""
    interval = median(np.diff(case.recording["wrench"].time))
    faster = (MILLISECONDS, *(1.0 / ratio for ratio in RATIOS))
    return [
        *RATIOS,
        *(u for u in faster if interval >= SHORTEST_INTERVALS.get(u, RARE_INTERVAL)),
    ]


def _what(unit: float) -> str:
    """Clause that time is in a unit [s]."""
    if unit == MILLISECONDS:
        return "be in milliseconds"
    size, way = max(unit, 1.0 / unit), "fast" if unit < 1.0 else "slow"
    what = f"run {size:g} times too {way}"
    if unit < 1.0:
        share = 100.0 * (1.0 - unit**2)
        return f"{what}, or the controller to subtract {share:.0f} % of the object's weight"
    return what + wrench_compensated.OR_HEAVIER if unit > LARGEST_INERTIAL else what


def _fix(unit: float) -> str:
    """Advice for time in a unit [s]."""
    if unit == MILLISECONDS:
        return 'give time in seconds, or unit = "ms" of it in a column map'
    return "give time in seconds, of samples at the rate at which they were taken"


def _builder(case: Case, unit: float) -> Build:
    factor = unit**-2.0
    return lambda motion: newton_euler(
        case, replace(motion, a=factor * motion.a, rest=factor * motion.rest)
    )
