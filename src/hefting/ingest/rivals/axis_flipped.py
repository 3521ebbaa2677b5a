"""Axes of force or torque with the wrong sign, swapped, or of a left-handed system; and
torque in the place of force."""

import numpy as np

from hefting.core.spatial import Array
from hefting.ingest.rivals.case import Case
from hefting.ingest.rivals.explanation import (
    Explanation,
    newton_euler,
    of_each_wrench,
    over_offsets,
)

CODE = "axis-flipped"
RARITY_OF_BOTH = 15.0
"""Rarity of an axis of both force and torque that is mirrored, or of two that are
swapped: with the other sign convention it is half a turn of the sensor, which is far
more common."""


def explain(case: Case) -> Explanation | None:
    """The likeliest of all."""
    changes = _changes()
    matrices = np.array(list(changes.values()))
    wrenches = np.einsum("mij,kj->mki", matrices, case.wrench)
    offsets = case.likely_offsets
    rows = newton_euler(case, case.motion_late(offsets))
    best = of_each_wrench(case, rows, wrenches).best // len(offsets)
    wrench = wrenches[best][None]
    fitted, _ = over_offsets(case, lambda motion: newton_euler(case, motion, wrench))
    what = list(changes)[best]
    of_both = np.linalg.det(matrices[best, :3, :3]) < 0.0 and np.array_equal(
        matrices[best, :3, :3], matrices[best, 3:, 3:]
    )
    return Explanation(
        CODE,
        f"{what} in the wrench",
        "correct it where the log is written, or in a column map",
        fitted,
        0,
        rarity=RARITY_OF_BOTH if of_both else 0.0,
    )


def _changes() -> dict[str, Array]:
    """Matrices (6, 6) that undo a mistake, by what it is."""
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
        both = np.diag(np.concatenate((mirror, mirror)))
        found[f"force {axis} and torque {axis} seem to have the wrong sign"] = both
        # a torque is a pseudovector: mirrored, the two other components change sign
        left = np.diag(np.concatenate((mirror, -mirror)))
        found[f"axes of a left-handed system, {axis} mirrored, seem to be"] = left
        j, k = (i + 1) % 3, (i + 2) % 3
        order = np.eye(3)
        order[[j, k]] = order[[k, j]]
        swap = np.array(np.kron(np.eye(2), order), dtype=float)
        found[f"axes {names[j]} and {names[k]} seem to be swapped"] = swap
    exchanged = np.roll(np.eye(6), 3, axis=0)
    found["force and torque seem to be swapped"] = exchanged
    return found
