"""Axes of force or torque with the wrong sign, swapped, or of a left-handed system; and
torque in the place of force."""

import numpy as np

from hefting.core.spatial import WRENCH, Array
from hefting.ingest.rivals.case import Case
from hefting.ingest.rivals.explanation import (
    FIRST_ITERATIONS,
    Explanation,
    newton_euler,
    of_each_wrench,
    over_offsets,
)

CODE = "axis-flipped"
RARITY_OF_SWAP = 15.0
"""Rarity of two axes that are swapped: with the other sign convention it is half a turn
of the sensor about the line between them."""


def explain(case: Case) -> Explanation | None:
    """The likeliest of all."""
    changes = _changes()
    matrices = np.array(list(changes.values()))
    wrenches = np.einsum("mij,kj->mki", matrices, case.wrench)
    offsets = case.likely_offsets
    rows = newton_euler(case, case.motion_late(offsets))
    quick = of_each_wrench(case, rows, wrenches, FIRST_ITERATIONS)
    best = quick.best // len(offsets)
    wrench = wrenches[best][None]
    fitted, _ = over_offsets(case, lambda motion: newton_euler(case, motion, wrench))
    what, matrix = list(changes)[best], matrices[best]
    names = [
        ("-" if row.sum() < 0.0 else "") + WRENCH[np.abs(row).argmax()]
        for row in matrix
    ]
    columns = ", ".join(f'"{name}"' for name in names)
    return Explanation(
        CODE,
        f"{what} in the wrench",
        "correct it where the log is written, or give the wrench's columns as "
        f"[{columns}] in a column map",
        fitted,
        0,
        rarity=RARITY_OF_SWAP if "axes" in what else 0.0,
        argument="column_map",
    )


def _changes() -> dict[str, Array]:
    """Matrices (6, 6) that undo a mistake, by what it is. An axis of both force and
    torque that is mirrored is none: with the other sign convention, which is free, it is
    half a turn of the sensor about that axis."""
    found: dict[str, Array] = {}
    names = ("x", "y", "z")
    for part, quantity in ((0, "force"), (3, "torque")):
        for i, axis in enumerate(names):
            signs = np.ones(6)
            signs[part + i] = -1.0
            found[f"{quantity} {axis} seems to have the wrong sign"] = np.diag(signs)
            signs = np.ones(6)
            signs[part : part + 3] = -1.0
            signs[part + i] = 1.0
            others = " and ".join(name for name in names if name != axis)
            found[f"{quantity} {others} seem to have the wrong sign"] = np.diag(signs)
    signs = np.repeat((1.0, -1.0), 3)
    found["the torque seems to have the sign opposite to the force's"] = np.diag(signs)
    for i, axis in enumerate(names):
        mirror = np.ones(3)
        mirror[i] = -1.0
        # a torque is a pseudovector: mirrored, the two other components change sign
        left = np.diag(np.concatenate((mirror, -mirror)))
        found[
            f"axes of a left-handed system, {axis} mirrored, seem to be in the poses or"
        ] = left
        j, k = (i + 1) % 3, (i + 2) % 3
        order = np.eye(3)
        order[[j, k]] = order[[k, j]]
        swap = np.array(np.kron(np.eye(2), order), dtype=float)
        found[f"axes {names[j]} and {names[k]} seem to be swapped"] = swap
    exchanged = np.roll(np.eye(6), 3, axis=0)
    found["force and torque seem to be swapped"] = exchanged
    return found
