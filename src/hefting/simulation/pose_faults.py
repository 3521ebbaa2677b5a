"""Faults of a pose stream: glitches, stalls, and values of a driver that has not begun
or has ended."""

import numpy as np
from scipy.spatial.transform import Rotation

from hefting.core.spatial import Array, Mask
from hefting.simulation.faults import Faults

STALLS = 3
"""Number of stalls in a recording that has any."""


def with_pose_faults(
    time: Array,
    position: Array,
    orientation: Array,
    faults: Faults,
    rng: np.random.Generator,
) -> tuple[Array, Array]:
    """Poses with the faults of their stream, the same for the same generator.

    Parameters
    ----------
    time : (K,) [s].
    position, orientation : (K, 3) [m] and quaternions (K, 4).
    faults : of which those of the pose stream are applied.
    rng : generator of what is random.
    """
    since = time - time[0]
    position, orientation = position.copy(), orientation.copy()
    for mask in _bouts(since, faults, rng):
        place, turn = rng.normal(size=(2, 3))
        position[mask] += faults.pose_glitch_size[0] * place
        turned = Rotation.from_quat(orientation[mask]) * Rotation.from_rotvec(
            faults.pose_glitch_size[1] * turn
        )
        orientation[mask] = turned.as_quat()
    slot = since[-1] / STALLS
    for stall in range(STALLS if faults.pose_stalls else 0):
        lasts = faults.pose_stalls * slot
        begin = stall * slot + rng.uniform(0.1 * (slot - lasts), slot - lasts)
        held = np.flatnonzero((since >= begin) & (since < begin + lasts))
        if len(held):
            position[held], orientation[held] = position[held[0]], orientation[held[0]]
    silent = (since < faults.pose_startup) | (since > since[-1] - faults.pose_shutdown)
    position[silent], orientation[silent] = 0.0, (0.0, 0.0, 0.0, 1.0)
    return position, orientation


def _bouts(since: Array, faults: Faults, rng: np.random.Generator) -> list[Mask]:
    """Masks (K,) of the glitches, each of at least one sample."""
    if not faults.pose_glitches or len(since) < 2:
        return []
    samples = max(round(faults.pose_glitch_duration * (len(since) - 1) / since[-1]), 1)
    begins = np.flatnonzero(rng.random(len(since)) < faults.pose_glitches / samples)
    rows = np.arange(len(since))
    return [(rows >= begin) & (rows < begin + samples) for begin in begins]
