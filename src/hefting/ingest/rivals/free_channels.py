"""What the motion explains of the wrench at most.

Wrong axes, signs, units, gains, a lever, a payload, another gravity or unit of time leave
each channel of the wrench a linear function of the motion: of accelerations, products of
velocities and the sensor's axes. Any such functions, each channel its own, explain at
least as much as all of these mistakes, and are fitted in the time of one.
"""

import numpy as np

from hefting.core.spatial import Array
from hefting.ingest.rivals.case import FINE_OFFSETS, Case, Motion
from hefting.ingest.rivals.evidence import ITERATIONS, SMALLEST_FLOOR
from hefting.ingest.robust_rows import RobustRows, fit_channels

FINEST_OFFSETS = 0.2 * FINE_OFFSETS
"""[s] Clock offsets about the best of the fine ones: mistakes are refined beside it."""
FIRST_ITERATIONS = 3
"""Reweightings by which offsets are compared."""


def explained_by_motion(case: Case) -> RobustRows:
    """The fit of free channels at the clock offsets about the likeliest one."""
    if not case.path.moves:
        return _fit(case, case.motion, ITERATIONS)
    offset = case.offsets[_fit(case, case.motion, FIRST_ITERATIONS).best]
    for step in (FINE_OFFSETS, FINEST_OFFSETS):
        near = offset + step
        motion = case.motion_at(case.time - near[:, None])
        fitted = _fit(case, motion, ITERATIONS)
        offset = near[fitted.best]
    return fitted


def _fit(case: Case, motion: Motion, iterations: int) -> RobustRows:
    known: list[Array] = [
        motion.features(case.modelled_gravity),
        motion.axes.reshape(*motion.known.shape, 9),
    ]
    shared = (case.bias_functions, case.wrench)
    known += [np.broadcast_to(x, (len(motion.known), *x.shape)) for x in shared]
    return fit_channels(
        np.concatenate(known, axis=2),
        motion.known.astype(float),
        np.maximum(case.floor, SMALLEST_FLOOR),
        iterations,
    )
