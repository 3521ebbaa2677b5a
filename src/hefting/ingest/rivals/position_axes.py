"""Positions in other axes than the orientations: columns swapped or with the wrong
sign, or another frame of the world."""

import itertools
from dataclasses import replace

import numpy as np

from hefting.core.spatial import Array
from hefting.ingest.rivals.case import Case, Motion
from hefting.ingest.rivals.evidence import fit_rows, is_hopeless
from hefting.ingest.rivals.explanation import Explanation, newton_euler, over_offsets

CODE = "position-axes"
THIRD = 3
"""Step between the samples on which axes are first compared."""
FIRST_ITERATIONS = 2
"""Number of reweightings of that comparison."""
SMALL_ADVANTAGE = 5.0
"""Log likelihood ratio of all samples by which other axes must exceed simpler ones."""
SIGNED_PERMUTATIONS = np.array(
    [
        np.array(signs)[:, None] * np.array(order)
        for order in itertools.permutations(np.eye(3))
        for signs in itertools.product((1.0, -1.0), repeat=3)
    ]
)
"""(48, 3, 3) ways to name and to direct three axes, the identity first."""
OTHER_AXES = SIGNED_PERMUTATIONS[1:]


def explain(case: Case) -> Explanation | None:
    """The likeliest axes."""
    if not case.recording.has("position") or case.path.kind != "smooth":
        return None
    thin = case.every(THIRD)
    motion = thin.motion_as_found
    rows = newton_euler(thin, _in_axes(motion, OTHER_AXES))
    quick = fit_rows(thin, rows, FIRST_ITERATIONS)
    given = fit_rows(thin, newton_euler(thin, motion), FIRST_ITERATIONS)
    if quick.likelihood.max() <= given.likelihood[0] or is_hopeless(thin, quick, given):
        return None
    # where positions hardly vary along an axis its sign is open: the fewest changes
    best = quick.likelihood > quick.likelihood.max() - SMALL_ADVANTAGE / len(case.time)
    kept = np.trace(OTHER_AXES, axis1=1, axis2=2)
    axes = OTHER_AXES[int(np.argmax(np.where(best, kept, -np.inf)))]
    fitted, _ = over_offsets(
        case, lambda motion: newton_euler(case, _in_axes(motion, axes[None]))
    )
    logged = ", ".join(
        f"{'-' if row.sum() < 0.0 else ''}{'xyz'[int(np.argmax(np.abs(row)))]}"
        for row in axes
    )
    return Explanation(
        CODE,
        f"the positions seem to be in other axes than the orientations: ({logged}) of "
        "those logged in place of (x, y, z)",
        "give both in the same axes of the world, with positions as they are measured",
        fitted,
        0,
        rarity=float(np.log(len(OTHER_AXES))),
        is_grave=True,
    )


def _in_axes(motion: Motion, axes: Array) -> Motion:
    """The motion with positions in each of other axes of the world (A, 3, 3), at one
    clock offset or at one for each."""
    in_world = np.swapaxes(motion.axes, -1, -2) @ motion.a[..., None]
    a = (motion.axes @ (axes[:, None] @ in_world))[..., 0]
    count = len(a)
    return replace(
        motion,
        a=a,
        rest=np.broadcast_to(motion.rest, (count, *motion.rest.shape[1:])),
        axes=np.broadcast_to(motion.axes, (count, *motion.axes.shape[1:])),
        known=np.broadcast_to(motion.known, (count, *motion.known.shape[1:])),
    )
