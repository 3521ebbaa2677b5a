"""Rivals: the mistakes by which joint positions and torques do not fit the URDF's arm,
each tried on a run.

An arm whose links may have any inertias, the last with what it holds, still explains
the torques of another order or sign of joints, or of another gravity, far worse than
those of its own. So each is put right in turn, and what remains is compared.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from hefting.core.spatial import Array, Indices
from hefting.torques.dynamics import JointDynamics
from hefting.torques.equations import OWN, Rows
from hefting.torques.noise import fit
from hefting.torques.runs import drifting, no_samples
from hefting.torques.samples import TorqueSamples

SAMPLES = 400
"""Samples that a rival is tried on, of all runs together."""
FEWEST_ROWS = 5
"""Rows for each unknown from which on what remains tells something."""
LEAST_GAIN = 0.5
"""Sum over joints of the logarithm by which the residuals shrink, by the share of the
rows, from which on a rival is believed. Of 99 right recordings, simulated and real, it
was at most 0.04; of 36 with a mistake, two of them of 0.01 kg m about the last joint,
at least 1.2."""
KINDS = (
    ("position", "velocity", "acceleration", "torque"),
    ("torque",),
    ("position", "velocity", "acceleration"),
)
"""What of a joint may be wrong together."""
NEAR = np.array([(j, j + by) for j in range(20) for by in (1, 2)])
"""Joints that are exchanged: neighbours, and those next to them, as shoulder and
elbow in the order of the alphabet."""
WORDS = ("", "torques of ", "positions of ")


@dataclass(frozen=True, eq=False)
class Rival:
    """A mistake, and the run without it."""

    words: str
    dynamics: JointDynamics
    runs: tuple[TorqueSamples, ...]

    @property
    def residuals(self) -> tuple[float, Array]:
        """Logarithm of the residuals' standard deviation, summed over joints, by the
        share of the rows, infinite where there are too few; and (n,) of each [N m], nan
        where there are too few.
        """
        scales = no_samples(self.dynamics)
        for samples in self.runs:
            scales = scales.fold(Rows.of(self.dynamics, samples, False))
        counts = scales.counts.sum(axis=0)
        unknown = len(self.dynamics.base) + len(OWN) * self.dynamics.joints
        if counts.sum() < FEWEST_ROWS * unknown:
            return np.inf, np.ones(self.dynamics.joints)
        left = fit(scales, drifting).std
        left[counts < FEWEST_ROWS * len(OWN)] = np.nan
        # weights of their own would change with the joints that are exchanged
        return float(np.nansum(np.log(left)) * counts.mean()) / scales.samples, left


def better_rival(
    dynamics: JointDynamics, runs: Sequence[TorqueSamples]
) -> tuple[str, float] | None:
    """The mistake without which the torques are explained best, and by how much smaller
    the residuals of some joint then are; None where none explains them far better."""
    step = max(1, sum(len(run.time) for run in runs) // SAMPLES)
    own = Rival("", dynamics, tuple(run[::step] for run in runs))
    spread, before = own.residuals
    if not np.isfinite(spread):
        return None
    found = [(*rival.residuals, rival.words) for rival in _rivals(own, before)]
    least, left, words = min(found, key=lambda each: each[0])
    if not spread - least > LEAST_GAIN:
        return None
    return words, float(np.nanmax(before / left))


def _rivals(own: Rival, left: Array) -> Iterator[Rival]:
    told = np.flatnonzero(np.isfinite(left))
    n, names = own.dynamics.joints, own.dynamics.names
    same = np.arange(n)
    for fields, what in zip(KINDS, WORDS, strict=True):
        for j in range(n):
            sign = np.where(same == j, -1.0, 1.0)
            words = f"with the {what or 'joint '}{names[j]} of the other sign"
            yield _changed(own, words, fields, same, sign)
        for i, j in NEAR[np.isin(NEAR, told).all(axis=1)].tolist():
            order = same.copy()
            order[[i, j]] = j, i
            words = f"with the {what or 'joints '}{names[i]} and {names[j]} exchanged"
            yield _changed(own, words, fields, order, np.ones(n))
    gravity = own.dynamics.gravity
    for axis, g in zip("xyz", np.linalg.norm(gravity) * np.eye(3), strict=True):
        if abs(g @ gravity) < 0.5 * (g @ g):
            words = f"with gravity along the {axis} axis of the base"
            yield replace(own, words=words, dynamics=own.dynamics.under(g))


def _changed(
    own: Rival, words: str, fields: Sequence[str], order: Indices, sign: Array
) -> Rival:
    """With the joints of some fields in another order, and of other signs."""
    runs = (
        replace(run, **{key: getattr(run, key)[:, order] * sign for key in fields})
        for run in own.runs
    )
    return replace(own, words=words, runs=tuple(runs))
