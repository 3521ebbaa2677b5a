"""The sensor's axes are turned against the logged ones, as where it is mounted at an
angle to the logged flange; or the world's are, too, as with a marker attached at any
angle in a motion capture with y up, or poses by joints with wrong zeros.

With w the wrench as recorded and R the rotation from sensor to logged axes, R w is
linear in R, and least squares of the parameters leaves

    |w|² - vec(R)' Q vec(R),    Q = B' N^-1 B,

with N the normal matrix, which no rotation changes as force and torque are weighted the
same along all axes, and B vec(R) the right-hand side. Q is positive semidefinite, so R
<- (the rotation nearest to Q vec(R)) never decreases vec(R)' Q vec(R).
"""

from functools import partial
from weakref import WeakKeyDictionary

import numpy as np

from hefting.core.spatial import Array, angle_between
from hefting.ingest.rivals import base
from hefting.ingest.rivals.base import SENSOR_ERROR, gravity_to_give
from hefting.ingest.rivals.case import Case
from hefting.ingest.rivals.evidence import Rows
from hefting.ingest.rivals.explanation import Explanation, as_columns, newton_euler
from hefting.ingest.rivals.placement import (
    Placement,
    advice,
    angle_and_axis,
    find_placement,
    turn_text,
    turned_and_moved,
)
from hefting.ingest.rivals.pose_forms import SIGNED_PERMUTATIONS
from hefting.ingest.robust_rows import normal_equations, scaled_to_ones

CODE = "axes-turned"
STEPS = 25
"""Steps of the ascent from the best starts."""
FIRST_STEPS = 5
"""Steps from each start, after which the best ones are known."""
KEPT_STARTS = 6
"""Number of starts from which the ascent continues. In 327 of 330 recordings with
mistakes of all kinds the rotation is that from all starts; in the others another
mistake explains more."""
REFINEMENTS = 4
"""Gauss-Newton steps of rotation and clock offset."""
CHANCE = 3.0
"""Standard deviations from half a turn within which a turn may be one."""
CROSS_TALK = 0.005
"""Standard deviation of a sensor's cross-talk, as on data sheets. Its antisymmetric
part is a rotation, of this over the root of two radians about each axis."""
QUARTER_TURNS = SIGNED_PERMUTATIONS[np.linalg.det(SIGNED_PERMUTATIONS) > 0.0]
"""The 24 rotations of a cube, from which the best one is looked for."""
_ROTATIONS: WeakKeyDictionary[Case, Placement] = WeakKeyDictionary()


def explain(case: Case) -> Explanation | None:
    """The likeliest rotation, with its standard deviation."""
    found = rotation_of(case)
    covariance = found.covariance + 0.5 * CROSS_TALK**2 * np.eye(3)
    angle, axis = angle_and_axis(found.R)
    known = float(np.sqrt(axis @ covariance @ axis))
    return Explanation(
        CODE,
        f"the sensor's axes seem turned by {turn_text(found.R, known)} of the logged ones",
        advice(case, found.R, np.zeros(3), covariance) + _or_mirrored(found, known),
        found.fitted,
        3,
        argument="sensor_pose_in_log",
        parameters=found.parameters,
        effect=angle / max(known, 1e-12),
        alternative=lambda: turned_and_moved(case, CODE, found.R, found.offset),
    )


def _or_mirrored(found: Placement, std: float) -> str:
    """Alternatives to half a turn about an axis, or about a line between two, whose
    angle is known to `std` [rad]: the opposite sign of the wrench, with an axis
    mirrored or two swapped."""
    turn = np.rint(found.R)
    if np.trace(turn) != -1.0 or np.abs(found.R - turn).max() > CHANCE * std:
        return ""
    acts = "sensor" if found.parameters[0] > 0.0 else "object"
    columns = as_columns(np.array(np.kron(np.eye(2), -turn), dtype=float))
    return f" or, if the wrench acts on the {acts}, its columns as {columns} in a column map"


def rotation_of(case: Case) -> Placement:
    """The best rotation from all starts, cached."""
    if case not in _ROTATIONS:
        R, offset, _ = rotation_at(case, case.offsets)
        _ROTATIONS[case] = find_placement(
            case, R, offset, turns=True, moves=False, steps=REFINEMENTS
        )
    return _ROTATIONS[case]


def rotation_at(case: Case, offsets: Array) -> tuple[Array, float, float]:
    """The rotation (3, 3) of best least squares at any of the clock offsets (O,) [s],
    that offset, and minus its squared residuals."""
    rows = newton_euler(case, case.motion_late(offsets))
    scale = np.maximum(np.std(case.wrench, axis=0).reshape(2, 3).mean(axis=1), 1e-9)
    scales = np.broadcast_to(scale, (len(offsets), 2))
    R, value = _ascend(case, rows, rows.used, scales, QUARTER_TURNS)
    index = int(np.argmax(value))
    return R[index], float(offsets[index]), float(value[index])


def _ascend(
    case: Case, rows: Rows, weights: Array, scale: Array, starts: Array
) -> tuple[Array, Array]:
    """For each of the O alternatives the best rotation (O, 3, 3) from any of the starts
    (S, 3, 3), and vec(R)' Q vec(R) less the wrench's square (O,)."""
    Q, square = _quadratic(case, rows, weights, scale)
    v = np.broadcast_to(starts.reshape(-1, 9), (len(Q), len(starts), 9))
    for _ in range(FIRST_STEPS):
        v = nearest_rotations(v @ Q)
    worst_first = np.argsort(np.sum(v @ Q * v, axis=2), axis=1)
    v = np.take_along_axis(v, worst_first[:, -KEPT_STARTS:, None], axis=1)
    for _ in range(STEPS - FIRST_STEPS):
        v = nearest_rotations(v @ Q)
    value = np.sum(v @ Q * v, axis=2)
    best = np.argmax(value, axis=1)
    each = np.arange(len(Q))
    # per sample, so that offsets with fewer known samples do not win by that
    count = np.maximum(weights.sum(axis=1), 1.0)
    return v[each, best].reshape(-1, 3, 3), (value[each, best] - square) / count


def nearest_rotations(vectors: Array) -> Array:
    """The rotations nearest to matrices, both (..., 9) by rows."""
    U, _, V = np.linalg.svd(vectors.reshape(*vectors.shape[:-1], 3, 3))
    U[..., 2] *= np.linalg.det(U @ V)[..., None]
    return (U @ V).reshape(vectors.shape)


def _quadratic(
    case: Case, rows: Rows, weights: Array, scale: Array
) -> tuple[Array, Array]:
    """Q (O, 9, 9) for the rotation's rows one after the other, and the weighted square
    of the wrench (O,)."""
    known, maps = rows.known, rows.maps
    O, K, _ = known.shape
    p = maps.shape[2]
    wrench = np.broadcast_to(case.wrench, (O, K, 6))
    both = np.concatenate((known, wrench), axis=2)
    normal, _ = normal_equations(both, maps, weights, scale)
    # sums of known rows times each channel of the wrench: (O, z, 6)
    cross = np.swapaxes(known * weights[:, :, None], 1, 2) @ wrench
    inverse_variance = np.repeat(scale**-2.0, 3, axis=1)
    B = np.zeros((O, p, 3, 3))  # of the rotation's entry (i, j)
    for i in range(3):
        for part in (0, 3):
            along = maps[:, part + i, :]  # (z, p)
            sums = np.einsum("zp,ozj->opj", along, cross[:, :, part : part + 3])
            B[:, :, i, :] += inverse_variance[:, part, None, None] * sums
    B = B.reshape(O, p, 9)
    scaled, length = scaled_to_ones(normal)
    B = B / length[:, :, None]
    Q = np.swapaxes(B, 1, 2) @ np.linalg.solve(scaled, B)
    square = np.einsum("ok,okc,oc->o", weights, wrench**2, inverse_variance)
    return 0.5 * (Q + np.swapaxes(Q, 1, 2)), square


CLEAR_TURN = 3.0
"""Standard deviations from which on a turn is larger than a sensor's errors."""
TILT_STEPS = 8
"""Gauss-Newton steps of turn, gravity's direction and clock offset."""


def explain_with_tilt(case: Case) -> Explanation | None:
    """The likeliest turn, with gravity's direction near the one given."""
    if not _is_modelled(case):
        return None
    turned = rotation_of(case)
    return _turned_and_tilted(case, turned.R, turned.offset, case.gravity)


def explain_with_axis(case: Case) -> Explanation | None:
    """The likeliest turn, with gravity near an axis of the world."""
    if not _is_modelled(case):
        return None
    size = float(np.linalg.norm(case.gravity))
    directions = [size * s * e for e in np.eye(3) for s in (1.0, -1.0)]

    def explained(gravity: Array) -> float:
        return rotation_at(case.with_gravity(gravity), case.likely_offsets)[2]

    gravity = max(directions, key=explained)
    R, offset, _ = rotation_at(case.with_gravity(gravity), case.offsets)
    return _turned_and_tilted(case, R, offset, gravity)


def _is_modelled(case: Case) -> bool:
    """Whether all accelerations are modelled; neglected ones look like a tilt."""
    return not (case.path.gravity_measured or case.path.kind == "orientation")


def _turned_and_tilted(
    case: Case, R: Array, offset: float, gravity: Array
) -> Explanation:
    """From a turn (3, 3), a clock offset [s] and gravity (3,)."""
    found = find_placement(
        case,
        R,
        offset,
        turns=True,
        moves=False,
        tilts=True,
        steps=TILT_STEPS,
        gravity=gravity,
    )
    gravity, C = found.gravity, found.covariance
    angle, axis = angle_and_axis(found.R)
    known = float(np.sqrt(axis @ C[:3, :3] @ axis + 0.5 * CROSS_TALK**2))
    tilt = angle_between(case.gravity, gravity)
    std = float(np.hypot(np.sqrt(C[3:, 3:].trace() / 2.0), SENSOR_ERROR))
    turns, tilts = angle / max(known, 1e-12), tilt / std
    # where one is within a sensor's errors it is the other alone
    alone = explain if turns > CLEAR_TURN else base.explain
    x, y, z = gravity
    return Explanation(
        CODE,
        f"the sensor's axes seem turned by {turn_text(found.R, known)} of the logged "
        f"ones, and gravity to point along ({x:.2f}, {y:.2f}, {z:.2f}) m/s², "
        f"{np.degrees(tilt):.1f}° ± {np.degrees(std):.1g}° from where it is given",
        f"{advice(case, found.R, np.zeros(3), C[:3, :3])} and "
        f"{gravity_to_give(gravity, tilt)}; of poses by joints check their zeros",
        found.fitted,
        5,
        argument="sensor_pose_in_log",
        parameters=found.parameters,
        effect=min(turns, tilts),
        alternative=partial(alone, case),
    )
