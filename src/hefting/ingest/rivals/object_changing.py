"""The object changes gradually: it leaks or is filled, or creeps in the gripper.

Mass and first moment are those at the start, the middle and the end of the recording,
and linear in time between; the inertia is one.
"""

import numpy as np

from hefting.core.spatial import Array
from hefting.ingest.drift import HatFunctions
from hefting.ingest.model import FEATURES, REGRESSOR_BY_FEATURE
from hefting.ingest.rivals.case import Case, Motion
from hefting.ingest.rivals.evidence import Fitted, Rows, missing, with_bias
from hefting.ingest.rivals.explanation import (
    Explanation,
    at_offset,
    fit_as_given,
    over_offsets,
)

CODE = "object-changing"
KNOTS = 3
"""Instants between which mass and first moment are linear in time."""
LARGEST_LEFT = 0.8
"""Share of what noise does not explain that a change may leave at the clock offset of the
recording as given; it is then looked for at others. Half of it is told."""
SMALLEST_MASS_CHANGE = 0.02
"""Change of the mass, as a share of it, that is told: gains of sensors drift by less."""
SMALLEST_MOVE = 0.002
"""[m] Movement of the COM that is told."""


def explain(case: Case) -> Explanation | None:
    """The likeliest change."""
    if not case.path.moves:
        return None
    given, offset = fit_as_given(case)
    quick = at_offset(case, lambda motion: _rows(case, motion), offset)
    if missing(case, quick) > LARGEST_LEFT * missing(case, given):
        return None
    fitted, offset = over_offsets(case, lambda motion: _rows(case, motion))
    drifting = at_offset(case, lambda motion: _with_drift(case, motion), offset)
    if drifting.likelihood[0] >= fitted.likelihood.max():
        return None
    return _told(fitted)


def _told(fitted: Fitted) -> Explanation | None:
    """What changes, of mass and COM that which the wrench shows more of; None for a
    change that is too small."""
    inertia, rest = np.split(fitted.solution[fitted.best], [6])
    bodies = rest[: 4 * KNOTS].reshape(KNOTS, 4)
    if bodies[:, 0].min() <= 0.0 <= bodies[:, 0].max():
        return None
    mass, com = np.abs(bodies[:, 0]), bodies[:, 1:] / bodies[:, :1]
    moved = float(np.linalg.norm(com - com[0], axis=1).max())
    scale = fitted.scale[fitted.best]
    if np.ptp(mass) / scale[0] > mass.max() * moved / scale[1]:
        if np.ptp(mass) < SMALLEST_MASS_CHANGE * mass.max():
            return None
        start, middle, end = mass
        fix = "close it"
        what = (
            f"the object seems to be {start:.3g} kg at the start of the recording, "
            f"{middle:.3g} kg in its middle and {end:.3g} kg at its end, as one that "
            "leaks or is filled, or by a sensor whose gain drifts"
        )
    elif moved < SMALLEST_MOVE:
        return None
    else:
        fix = "grip it tighter"
        what = (
            f"the object seems to move by {1e3 * moved:.0f} mm in the gripper, little by "
            "little"
        )
    return Explanation(
        CODE,
        what,
        f"{fix} and record again, or give a part in which it is as you want it with "
        "`start` and `duration`",
        fitted,
        4 * (KNOTS - 1),
        argument="start",
        parameters=np.concatenate((bodies[-1], inertia)),
        is_change=True,
    )


def _rows(case: Case, motion: Motion) -> Rows:
    """Rows of an inertia, of mass and first moment at each knot, and of a bias."""
    features = motion.features(case.modelled_gravity)
    hats = HatFunctions.over(case.time, KNOTS).values.T
    at_knots = [hat[:, None] * features for hat in hats]
    known = np.concatenate(at_knots, axis=2)
    return with_bias(case, known, _maps(), motion.known)


def _with_drift(case: Case, motion: Motion) -> Rows:
    """Rows of one body, and of a bias that is linear between the same knots."""
    hats = HatFunctions.over(case.time, KNOTS).values
    features = motion.features(case.modelled_gravity)
    return with_bias(case, features, REGRESSOR_BY_FEATURE, motion.known, functions=hats)


def _maps() -> Array:
    """Columns of the inertia, then of mass and first moment at each knot."""
    maps = np.zeros((KNOTS, FEATURES, 6, 6 + 4 * KNOTS))
    maps[..., :6] = REGRESSOR_BY_FEATURE[:, :, 4:]  # the hats add up to one
    for i in range(KNOTS):
        maps[i, :, :, 6 + 4 * i : 10 + 4 * i] = REGRESSOR_BY_FEATURE[:, :, :4]
    return maps.reshape(-1, 6, 6 + 4 * KNOTS)
