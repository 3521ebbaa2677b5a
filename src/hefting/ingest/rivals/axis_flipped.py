"""Axes of force or torque with the wrong sign, swapped, turned, or of a left-handed
system; and torque in the place of force."""

from collections.abc import Iterator

import numpy as np

from hefting.core.spatial import Array
from hefting.ingest.rivals.axes_turned import (
    CROSS_TALK,
    QUARTER_TURNS,
    nearest_rotations,
)
from hefting.ingest.rivals.case import Case
from hefting.ingest.rivals.evidence import Rows, fit_free_channels, is_hopeless
from hefting.ingest.rivals.explanation import (
    FIRST_ITERATIONS,
    Explanation,
    Undone,
    as_columns,
    fit_as_given,
    newton_euler,
    of_each_wrench,
    over_offsets,
)
from hefting.ingest.rivals.placement import (
    angle_and_axis,
    find_placement,
    turn_text,
    turned_by,
)

CODE = "axis-flipped"
APART = "force and torque seem to be in different axes"
RARITY_OF_APART = 8.0
"""Rarity of force and torque in different axes, of which there are many."""
RARITY_OF_SWAP = 15.0
"""Rarity of two swapped axes. With the other sign convention that is half a turn of the
sensor about the line between them."""
ORDERS = 4
"""Number of signed orders of the torque's axes that are tried with that of the force's."""


def explain(case: Case) -> Explanation | None:
    """The likeliest change of axes, at the clock offset that conditioning found or none."""
    offsets = case.likely_offsets
    rows = newton_euler(case, case.motion_late(offsets))
    changes = _changes()
    apart = _different_axes(case, rows, [matrix for _, matrix, _ in changes])
    changes += [(APART, matrix, RARITY_OF_APART) for matrix in apart]
    matrices = np.array([matrix for _, matrix, _ in changes])
    wrenches = np.einsum("mij,kj->mki", matrices, case.wrench)
    quick = of_each_wrench(case, rows, wrenches, FIRST_ITERATIONS)
    best = quick.best // len(offsets)
    wrench = wrenches[best][None]
    fitted, _ = over_offsets(case, lambda motion: newton_euler(case, motion, wrench))
    what, matrix, rarity = changes[best]
    return Explanation(
        CODE,
        f"{what} in the wrench",
        _fix(matrix),
        fitted,
        0,
        rarity=rarity,
        argument="column_map",
        is_grave=rarity == RARITY_OF_APART,
    )


TURNED_APART = "axes-turned-apart"
TURN_STEPS = 4
"""Gauss-Newton steps of the turn and the clock offset."""


def explain_turned_apart(case: Case) -> Explanation | None:
    """The likeliest turn of the force's axes, or of the torque's, against the other's."""
    offsets = case.likely_offsets
    rows = newton_euler(case, case.motion_late(offsets))
    turns = _turns_apart(*_levers(case, rows))
    wrenches = np.array([turned_by(case, R, only) for only, R in turns])
    quick = of_each_wrench(case, rows, wrenches, FIRST_ITERATIONS)
    if is_hopeless(case, quick, fit_as_given(case)[0]):
        return None
    best, at = divmod(quick.best, len(offsets))
    only, R = turns[best]
    found = find_placement(
        case,
        R,
        float(offsets[at]),
        turns=True,
        moves=False,
        steps=TURN_STEPS,
        only=only,
    )
    angle, axis = angle_and_axis(found.R)
    known = float(np.sqrt(axis @ found.covariance @ axis + 0.5 * CROSS_TALK**2))
    names = ("force", "torque")
    return Explanation(
        TURNED_APART,
        f"the {names[only]}'s axes seem turned by {turn_text(found.R, known)} against the {names[1 - only]}'s",
        "log both in the same axes",
        found.fitted,
        3,
        rarity=RARITY_OF_APART,
        effect=angle / max(known, 1e-12),
        is_grave=only == 1,
    )


def _turns_apart(force: Array, torque: Array) -> list[tuple[int, Array]]:
    """What turns (0 the force, 1 the torque) and by which rotation (3, 3), for matrices
    as in `_levers`: the force's becomes nearest to a multiple of the identity; or the
    torque's to an antisymmetric one, which has two solutions, one for each sign of the
    arm."""
    U, _, V = np.linalg.svd(torque)
    along = np.linalg.det(U) * np.linalg.det(V) * np.outer(V[2], U[:, 2])
    across = np.outer(V[1], U[:, 0]) - np.outer(V[0], U[:, 1])
    upright = force.T * np.sign(np.linalg.det(force))
    return [
        (0, nearest_rotations(upright.reshape(1, 9)).reshape(3, 3)),
        (1, along + across),
        (1, along - across),
    ]


def undone(case: Case) -> Iterator[Undone]:
    """Each of `_changes`, except two axes of force or torque with the wrong sign: with the
    other sign convention that is the third axis and all of the other quantity."""
    for what, matrix, rarity in _changes():
        if np.trace(matrix) == 2.0 and not rarity:
            continue
        other = case.with_wrench(matrix)
        yield Undone(
            CODE,
            f"{what} in the wrench",
            _fix(matrix),
            other,
            argument="column_map",
            rarity=rarity,
            is_linear=True,
        )


def _fix(matrix: Array) -> str:
    fix = "correct it where the log is written, or give the wrench's columns as "
    return f"{fix}{as_columns(matrix)} in a column map"


def _different_axes(case: Case, rows: Rows, taken: list[Array]) -> list[Array]:
    """Signed permutations (6, 6) of the wrench that undo one order of the force's axes
    and another of the torque's, except those in `taken`.

    The force's order is the one that brings its matrix (`_levers`) nearest to the
    identity, and the torque's orders are those that bring its own nearest to an
    antisymmetric one.
    """
    force, torque = _levers(case, rows)
    likeness = np.abs((QUARTER_TURNS @ force).trace(0, 1, 2))
    first = QUARTER_TURNS[likeness.argmax()]
    lever = QUARTER_TURNS @ torque
    symmetric_part = np.square(lever + np.swapaxes(lever, 1, 2)).sum(axis=(1, 2))
    found: list[Array] = []
    for second in QUARTER_TURNS[symmetric_part.argsort()[:ORDERS]]:
        for sign in (1.0, -1.0):
            undo = np.zeros((6, 6))
            undo[:3, :3], undo[3:, 3:] = first, sign * second
            undo *= 1.0 if undo.sum() >= 0.0 else -1.0
            is_turn = sign > 0.0 and np.array_equal(first, second)
            # of signed permutations, 6 for the same one and -6 for its opposite
            if not is_turn and np.abs(np.tensordot(taken, undo)).max() < 6.0:
                found.append(undo)
    return found


def _levers(case: Case, rows: Rows) -> tuple[Array, Array]:
    """Matrices (3, 3) of force and torque by the specific force s, which free channels
    give: an object of mass m with its COM at c has the force m s and the torque
    m [c]x s."""
    free = fit_free_channels(case, rows.known, rows.used)
    force, torque = np.split(free.solution[free.best].reshape(-1, 6)[:3].T, 2)
    return force, torque


def _changes() -> list[tuple[str, Array, float]]:
    """Mistakes as clauses, the matrices (6, 6) that undo them, and their rarities.

    An axis that is mirrored for force and torque alike is no mistake here: with the other
    sign convention, which is free, it is half a turn of the sensor about that axis.
    """
    found: list[tuple[str, Array, float]] = []
    names = ("x", "y", "z")
    for part, quantity in ((0, "force"), (3, "torque")):
        for i, axis in enumerate(names):
            signs = np.ones(6)
            signs[part + i] = -1.0
            what = f"{quantity} {axis} seems to have the wrong sign"
            found.append((what, np.diag(signs), 0.0))
            signs = np.ones(6)
            signs[part : part + 3] = -1.0
            signs[part + i] = 1.0
            others = " and ".join(name for name in names if name != axis)
            what = f"{quantity} {others} seem to have the wrong sign"
            found.append((what, np.diag(signs), 0.0))
    signs = np.repeat((1.0, -1.0), 3)
    what = "the torque seems to have the sign opposite to the force's"
    found.append((what, np.diag(signs), 0.0))
    for i, axis in enumerate(names):
        mirror = np.ones(3)
        mirror[i] = -1.0
        # a mirror reverses the two other components of a torque, a pseudovector
        left = np.diag(np.concatenate((mirror, -mirror)))
        what = (
            f"axes of a left-handed system, {axis} mirrored, seem to be in the poses "
        )
        what += "(then correct these) or"
        found.append((what, left, RARITY_OF_SWAP))
        j, k = (i + 1) % 3, (i + 2) % 3
        order = np.eye(3)
        order[[j, k]] = order[[k, j]]
        swap = np.array(np.kron(np.eye(2), order), dtype=float)
        what = f"axes {names[j]} and {names[k]} seem to be swapped"
        found.append((what, swap, RARITY_OF_SWAP))
    exchanged = np.roll(np.eye(6), 3, axis=0)
    found.append(("force and torque seem to be swapped", exchanged, 0.0))
    return found
