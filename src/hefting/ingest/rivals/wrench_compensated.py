"""The controller subtracts the weight of a payload from the wrench: all of the object's
weight, a part of it, or more, as of a heavier object before it. Or it adds the weight,
with the wrong sign.

The model has a mass and first moment on which gravity acts, beside those on which
acceleration acts.
"""

from collections.abc import Iterator
from dataclasses import replace
from functools import partial

import numpy as np

from hefting.core.spatial import Array
from hefting.ingest.model import REGRESSOR_BY_FEATURE
from hefting.ingest.rivals.case import Case, Motion
from hefting.ingest.rivals.evidence import (
    Fitted,
    Rows,
    beside_body,
    linear_step,
    with_bias,
)
from hefting.ingest.rivals.explanation import (
    Explanation,
    Undone,
    explains_nothing,
    over_offsets,
)

CODE = "wrench-compensated"
FIX = "set its payload to zero before recording"
SMALLEST_SHARE = 0.005
"""Smallest share of the object's weight that is reported."""
SMALL_SHARE = 0.05
"""Share below which the missing mass itself must be significant. Soft grips and liquids
were taken for a share of up to 0.02."""
LARGEST_SHARE = 100.0
"""Largest share of the object's weight that a controller subtracts: that of a tool of
3 kg, for an object of 30 g. A share of 2 is gravity reversed, which has no unknowns and is
reported instead."""
ADDED = 0.25, 5.0
"""Smallest and largest share of the object's weight that a controller is said to add: a
filter of 18 Hz and averages of 40 ms weaken what a trembling hand does as 0.17 does."""
ALIKE = 0.1
"""Difference of the shares of first moment and mass that time leaves alike, over the
smaller of what is missing and what is left."""
OR_HEAVIER = ", or the controller to subtract a payload heavier than the object"
"""What is said beside a mistake that may be one."""


def explain(case: Case) -> Explanation | None:
    """The share of the object's weight that is missing, or that was added."""
    if not _is_observable(case):
        return None
    build = partial(freed, case)
    if explains_nothing(case, build):
        return None
    fitted, _ = over_offsets(case, build)
    solution = fitted.solution[fitted.best]
    mass, weighed = float(solution[0]), float(solution[10])
    if not mass:
        return None
    share = 1.0 - weighed / mass
    if not (SMALLEST_SHARE <= share <= LARGEST_SHARE or ADDED[0] < -share < ADDED[1]):
        return None
    part = f"{100.0 * abs(share):.0f} % of the object's weight"
    if share > 1.0:
        part = f"{abs(mass - weighed):.2g} kg, more than the object's,"
    seem, does = ("missing", "subtracts") if share > 0.0 else ("added", "adds")
    what = (
        f"some {part} seem to be {seem} in the wrench, as if the controller {does} a "
        "payload"
    )
    fix = FIX
    if abs(share) > SMALL_SHARE and _is_alike(solution, share):
        ratio = (1.0 - share) ** -0.5
        said = (
            f"{ratio:.3g} times too fast"
            if ratio > 1.0
            else f"{1.0 / ratio:.3g} times too slow"
        )
        what += f", or time runs {said}"
        fix += ", or give time at the rate at which samples were taken"
    effect = _effect(fitted) if abs(share) < SMALL_SHARE else None
    return Explanation(CODE, what, fix, fitted, 4, effect=effect)


def _is_alike(solution: Array, share: float) -> bool:
    """Whether the same `share` of the first moment as of the mass is missing, as where
    time runs too fast."""
    missing = solution[1:4] - solution[11:14]
    apart = np.linalg.norm(missing - share * solution[1:4])
    least = min(abs(share), 1.0 - share)
    return bool(apart < ALIKE * least * np.linalg.norm(solution[1:4]))


def undone(case: Case) -> Iterator[Undone]:
    """All of the weight subtracted: as if there were no gravity."""
    if _is_observable(case) and not case.path.gravity_measured:
        what = "all of the object's weight seems to be missing in the wrench, as if the controller subtracts it"
        other = case.with_gravity(np.zeros(3))
        yield Undone(CODE, what, FIX, other, is_linear=True)


def _is_observable(case: Case) -> bool:
    """Whether both gravity and accelerations act on the object."""
    moves = case.path.moves and case.path.kind != "orientation"
    return moves and bool(case.gravity.any())


def freed(case: Case, motion: Motion) -> Rows:
    """Rows of a body on which gravity acts with another mass and first moment."""
    gravity = -(motion.axes @ case.gravity)
    a = motion.a if not case.path.gravity_measured else motion.a - gravity
    known = np.concatenate((a, motion.rest, gravity), axis=2)
    maps = beside_body(REGRESSOR_BY_FEATURE[:3, :, :4])
    return with_bias(case, known, maps, motion.known)


def _effect(fitted: Fitted) -> float:
    """The missing mass over its standard deviation.

    Every payload has a mass; an object that only sags has another first moment by gravity
    than by acceleration, and the same mass.
    """
    found = fitted.of_best()
    rows = found.rows
    missing = found.solution[0, 10] - found.solution[0, 0]
    # of one body, on which gravity and acceleration act alike, and of what gravity acts
    # on besides: the covariance of the latter is that of the missing mass and moment
    weighed = rows.maps[:, :, 10:14]
    maps = np.delete(rows.maps, range(10, 14), axis=2)
    maps[:, :, :4] += weighed
    one_body = replace(found, rows=replace(rows, maps=maps))
    columns = np.einsum("kz,zcp->kcp", rows.known[0], weighed)
    variance = linear_step(one_body, columns).covariance[0, 0]
    return float(abs(missing) / np.sqrt(max(variance, 1e-300)))
