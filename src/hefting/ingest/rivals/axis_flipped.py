"""Axes of force or torque with the wrong sign, swapped, or of a left-handed system; and
torque in the place of force."""

from collections.abc import Iterator

import numpy as np

from hefting.core.spatial import Array
from hefting.ingest.rivals.axes_turned import QUARTER_TURNS
from hefting.ingest.rivals.case import Case
from hefting.ingest.rivals.evidence import Rows, fit_free_channels
from hefting.ingest.rivals.explanation import (
    FIRST_ITERATIONS,
    Explanation,
    Undone,
    as_columns,
    newton_euler,
    of_each_wrench,
    over_offsets,
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

    An object of mass m with its COM at c has the force m s and the torque m [c]x s for a
    specific force s. Free channels give both matrices, (3, 3). The force's order is the
    one that brings the first nearest to the identity, and the torque's orders are those
    that bring the second nearest to an antisymmetric matrix.
    """
    free = fit_free_channels(case, rows.known, rows.used)
    force, torque = np.split(free.solution[free.best].reshape(-1, 6)[:3].T, 2)
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
