"""The grip gives way under the load, as a suction cup or soft fingers do.

The centre of mass is c - C s, with the compliance C (3, 3) and the specific force s of
the sensor in its axes, which is gravity's where it moves slowly. The force is that of
the rigid body, the torque has m s x C s besides: of C it does not tell a part that is
the same along all axes.
"""

import itertools

import numpy as np

from hefting.core.spatial import Array
from hefting.ingest.model import FEATURES, REGRESSOR_BY_FEATURE
from hefting.ingest.rivals.case import Case, Motion
from hefting.ingest.rivals.evidence import Rows, is_hopeless, with_bias
from hefting.ingest.rivals.explanation import Explanation, at_offset, fit_as_given

CODE = "grip-elastic"
SMALLEST_MOVE = 0.001
"""[m] Movement of the COM that is told."""
PAIRS = tuple(itertools.combinations_with_replacement(range(3), 2))
LEVI_CIVITA = np.cross(np.eye(3)[:, None], np.eye(3))
"""(3, 3, 3) by two axes, their cross product."""


def explain(case: Case) -> Explanation | None:
    """The likeliest compliance, at the clock offset of the recording as given."""
    if not case.path.moves:
        return None
    given, offset = fit_as_given(case)
    fitted = at_offset(case, lambda motion: _rows(case, motion), offset)
    if is_hopeless(case, fitted, given):
        return None
    body, rest = np.split(fitted.solution[0], [10])
    C = _with_isotropic(rest[:9].reshape(3, 3) / body[0])
    s = fitted.rows.known[0, :, :3]
    place = -s @ C.T
    mean = place.mean(axis=0)
    moved = float(np.linalg.norm(place - mean, axis=1).max())
    if not SMALLEST_MOVE < moved < 1.0:
        return None
    body[1:4] += body[0] * mean
    return Explanation(
        CODE,
        f"the object seems to give way in the grip, as in a suction cup or soft fingers: "
        f"its centre of mass is up to {1e3 * moved:.2g} mm from its mean place",
        "grip it stiffer and record again, or count on its moving so",
        fitted,
        8,
        parameters=body,
    )


def yielding_columns(features: Array) -> Array:
    """(..., 6, 9) derivatives of the wrench by mass times compliance, row by row, from
    features (..., 12)."""
    return np.tensordot(_products(features), YIELDING, 1)


def _rows(case: Case, motion: Motion) -> Rows:
    """Rows of a body, of its mass times the compliance, and of a bias."""
    features = motion.features(case.modelled_gravity)
    known = np.concatenate((features, _products(features)), axis=2)
    maps = np.zeros((FEATURES + len(PAIRS), 6, 19))
    maps[:FEATURES, :, :10] = REGRESSOR_BY_FEATURE
    maps[FEATURES:, :, 10:] = YIELDING
    return with_bias(case, known, maps, motion.known)


def _products(features: Array) -> Array:
    """(..., 6) products of the components of the specific force."""
    return np.stack([features[..., i] * features[..., j] for i, j in PAIRS], axis=-1)


def _yielding() -> Array:
    maps = np.zeros((len(PAIRS), 6, 9))
    for row, column, axis in itertools.product(range(3), repeat=3):
        pair = PAIRS.index((min(axis, column), max(axis, column)))
        maps[pair, 3:, 3 * row + column] += LEVI_CIVITA[axis, row]
    return maps


YIELDING = _yielding()
"""(6, 6, 9) columns of the compliance, row by row, per unit of each product."""


def _with_isotropic(C: Array) -> Array:
    """The compliance (3, 3) with the least part that is the same along all axes for
    which nothing moves against its load."""
    return C - np.linalg.eigvalsh(C + C.T)[0] / 2.0 * np.eye(3)
