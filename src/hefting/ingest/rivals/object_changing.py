"""The object changes gradually: it leaks or is filled, or creeps in the gripper.

Mass and first moment are piecewise linear in time, with knots at the start, the middle
and the end of the recording; the inertia is constant. In static poses, which are seldom
many, mass and first moment change once, at one of the poses.
"""

import numpy as np

from hefting.core.spatial import Array
from hefting.ingest.drift import HatFunctions
from hefting.ingest.model import FEATURES, REGRESSOR_BY_FEATURE
from hefting.ingest.rivals.case import Case, Motion
from hefting.ingest.rivals.evidence import Fitted, Rows, fit_rows, missing, with_bias
from hefting.ingest.rivals.explanation import (
    Explanation,
    at_offset,
    fit_as_given,
    over_offsets,
)

CODE = "object-changing"
KNOTS = 3
"""Number of knots of mass and first moment."""
LARGEST_LEFT = 0.8
"""Largest share of what noise does not explain that a change may leave at the clock offset
of the recording as given, for other clock offsets to be tried."""
SMALLEST_MASS_CHANGE = 0.02
"""Smallest relative change of the mass that is reported: gains of sensors drift by less."""
FEWEST_POSES = 4
"""Fewest static poses on each side of a change: fewer may be outliers."""
SMALLEST_MOVE = 0.002
"""[m] Smallest movement of the COM that is reported."""


def explain(case: Case) -> Explanation | None:
    """The likeliest change; None where a bias that drifts alike is likelier."""
    if not case.path.moves:
        return _at_a_pose(case)
    hats = HatFunctions.over(case.time, KNOTS).values
    given, offset = fit_as_given(case)
    quick = at_offset(case, lambda motion: _rows(case, motion, hats), offset)
    if missing(case, quick) > LARGEST_LEFT * missing(case, given):
        return None
    fitted, offset = over_offsets(case, lambda motion: _rows(case, motion, hats))
    drifting = at_offset(case, lambda motion: _with_drift(case, motion, hats), offset)
    if drifting.likelihood[0] >= fitted.likelihood.max():
        return None
    return _explanation(fitted, KNOTS)


def _at_a_pose(case: Case) -> Explanation | None:
    """The likeliest change between two of the static poses, whose rows are in order."""
    pose = np.arange(len(case.time))
    firsts = pose[FEWEST_POSES : 1 - FEWEST_POSES, None]
    after = pose >= firsts
    parts = np.stack((~after, after), axis=2).astype(float)
    fitted = fit_rows(case, _rows(case, case.motion, parts))
    drifting = fit_rows(case, _with_drift(case, case.motion, parts))
    if drifting.likelihood.max() >= fitted.likelihood.max():
        return None
    first = np.searchsorted(
        case.recording["wrench"].time, case.time[firsts[fitted.best, 0]]
    )
    return _explanation(fitted, 2, f" from row {first + 1} on")


def _explanation(fitted: Fitted, n: int, at: str = "") -> Explanation | None:
    """The change between n successive bodies: of the mass or of the COM, whichever changes
    the wrench more; None if it is too small. `at` says where a sudden change is."""
    inertia, rest = np.split(fitted.solution[fitted.best], [6])
    bodies = rest[: 4 * n].reshape(n, 4)
    if bodies[:, 0].min() <= 0.0 <= bodies[:, 0].max():
        return None
    mass, com = np.abs(bodies[:, 0]), bodies[:, 1:] / bodies[:, :1]
    mass_change = np.ptp(mass)
    moved = float(np.linalg.norm(com - com[0], axis=1).max())
    force_scale, torque_scale = fitted.scale[fitted.best]
    if mass_change / force_scale > mass.max() * moved / torque_scale:
        if mass_change < SMALLEST_MASS_CHANGE * mass.max():
            return None
        fix, what = "close it", _mass_change(mass, at)
    else:
        if moved < SMALLEST_MOVE:
            return None
        fix = "grip it tighter"
        what = f"the object seems to move by {1e3 * moved:.0f} mm in the gripper"
        what += at or ", little by little"
    return Explanation(
        CODE,
        what,
        f"{fix} and record again, or give a part in which it does not change with "
        "`start` and `duration`",
        fitted,
        4 * (n - 1) + bool(at),
        argument="start",
        parameters=np.concatenate((bodies[-1], inertia)),
        is_change=True,
    )


def _mass_change(mass: Array, at: str) -> str:
    """A clause on masses (n,) [kg] that are held one after the other."""
    start = f"the object seems to be {mass[0]:.3g} kg at the start of the recording"
    if at:
        return f"{start} and {mass[-1]:.3g} kg {at.strip()}"
    return (
        f"{start}, {mass[1]:.3g} kg in its middle and {mass[-1]:.3g} kg at its end, as one "
        "that leaks or is filled, or by a sensor whose gain drifts"
    )


def _rows(case: Case, motion: Motion, functions: Array) -> Rows:
    """Rows of a constant inertia, of a mass and first moment for each of n functions of
    time (..., K, n), whose sum is one, and of a bias."""
    features, n = case.features(motion), functions.shape[-1]
    known = functions[..., None] * features[..., None, :]
    O, K = known.shape[:2]
    maps = np.zeros((n, FEATURES, 6, 6 + 4 * n))
    maps[..., :6] = REGRESSOR_BY_FEATURE[:, :, 4:]
    for i in range(n):
        maps[i, :, :, 6 + 4 * i : 10 + 4 * i] = REGRESSOR_BY_FEATURE[:, :, :4]
    used = np.broadcast_to(motion.known, (O, K))
    known, maps = known.reshape(O, K, -1), maps.reshape(-1, 6, 6 + 4 * n)
    return with_bias(case, known, maps, used)


def _with_drift(case: Case, motion: Motion, functions: Array) -> Rows:
    """Rows of one constant body, and of a bias composed of the same functions."""
    O = max(functions[..., 0, 0].size, len(motion.known))
    features = case.features(motion)
    known = np.broadcast_to(features, (O, *features.shape[1:]))
    used = np.broadcast_to(motion.known, known.shape[:2])
    return with_bias(case, known, REGRESSOR_BY_FEATURE, used, functions=functions)
