"""Rivals: the mistakes by which joint positions and torques do not fit the URDF's arm,
each tried on a run.

An arm whose links may have any inertias, the last with what it holds, still explains
the torques of another order or sign of joints, or of another gravity, far worse than
those of its own. So each is put right in turn, and what remains is compared.
"""

from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import Self

import numpy as np

from hefting.core.immutable import immutable
from hefting.core.spatial import Array, Indices, Mask
from hefting.torques.dynamics import JointDynamics
from hefting.torques.equations import OWN, Load, Rows, TorqueScales
from hefting.torques.noise import fit
from hefting.torques.runs import drifting, no_samples
from hefting.torques.samples import TorqueSamples

SAMPLES = 400
"""Samples that a rival is tried on, of all runs together."""
FEWEST_ROWS = 5
"""Rows for each unknown from which on what remains tells something."""
LEAST_GAIN = np.array((0.5, 0.25))
"""Sum over joints of the logarithm by which the residuals shrink, and what of the torques
is left over what offset and friction alone leave, by the share of the rows, from which
on a rival is believed. Of 99 right recordings, simulated and real, the first was at most
0.04; of 36 with a mistake, two of them of 0.01 kg m about the last joint, at least 1.2.
The second is for joints that move one at a time, of which an exchange passes for 1.3 by
the first: of 40 such the lesser share of both was 0.9."""
POSITIONS = ("position", "velocity", "acceleration")
KINDS = ((*POSITIONS, "torque"), ("torque",), POSITIONS)
"""What of a joint may be wrong together."""
NEAR = np.array([(j, j + by) for j in range(20) for by in (1, 2)])
"""Joints that are exchanged: neighbours, and those next to them, as shoulder and
elbow in the order of the alphabet."""
WORDS = ("", "torques of ", "positions of ")


@immutable
class Rival:
    """A mistake, and the equations of all runs without it."""

    words: str
    dynamics: JointDynamics
    values: Array
    """(K, n, c) as of `Rows`"""
    used: Mask
    """(K, n) which of them count"""

    @classmethod
    def of(
        cls, words: str, dynamics: JointDynamics, runs: Sequence[TorqueSamples]
    ) -> Self:
        """Of runs that are put right."""
        load = Load.published(dynamics)
        rows = [Rows.of(dynamics, own, False).under(dynamics, load) for own in runs]
        used = np.concatenate([each.used for each in rows])
        values = np.concatenate([each.values for each in rows])
        return cls(words, dynamics, values, used)

    @property
    def residuals(self) -> tuple[Array, Array]:
        """(2,) logarithm of the residuals' standard deviation, and of that over what
        offset and friction alone leave, summed over joints, by the share of the rows,
        infinite where there are too few; and (n,) of each [N m], nan where there are
        too few.
        """
        counts = self.used.sum(axis=0)
        unknown = len(self.dynamics.base) + len(OWN) * self.dynamics.joints
        if counts.sum() < FEWEST_ROWS * unknown:
            return np.full(2, np.inf), np.ones(self.dynamics.joints)
        # time scales, which the noise's colour needs, would change no residual
        none = no_samples(self.dynamics).levels[0]
        folded = none.fold_rows(self.values * self.used[..., None])
        moments = replace(folded, counts=counts.astype(float))
        found = fit(TorqueScales((moments,)), drifting)
        few = counts < FEWEST_ROWS * len(OWN)
        left = np.where(few, np.nan, found.std)
        # the torque of a joint that stands while another moves is explained by anything
        alone = np.linalg.norm(found.moments.without_nuisances[..., -1], axis=1)
        part = np.sqrt(counts) / np.where(few, np.nan, alone)
        # weights of their own would change with the joints that are exchanged
        spread = np.nansum(np.log((left, part)), axis=1) * counts.mean()
        return spread / len(self.used), left


def better_rival(
    dynamics: JointDynamics, runs: Sequence[TorqueSamples]
) -> tuple[Rival, float] | None:
    """The mistake without which the torques are explained best, and by how much smaller
    the residuals of some joint then are; None where none explains them far better."""
    step = max(1, sum(len(run.time) for run in runs) // SAMPLES)
    runs = [run[::step] for run in runs]
    own = Rival.of("", dynamics, runs)
    spread, before = own.residuals
    if not np.isfinite(spread).all():
        return None
    found = [(*rival.residuals, rival) for rival in _rivals(own, runs, before)]
    gains = [float(((spread - each[0]) / LEAST_GAIN).min()) for each in found]
    _, left, best = found[int(np.argmax(gains))]
    if not max(gains) > 1.0:
        return None
    return best, float(np.nanmax(before / left))


def _rivals(own: Rival, runs: Sequence[TorqueSamples], left: Array) -> Iterator[Rival]:
    told = np.flatnonzero(np.isfinite(left))
    dynamics = own.dynamics
    n, names = dynamics.joints, dynamics.names
    same = np.arange(n)
    for fields, what in zip(KINDS, WORDS, strict=True):
        for j in range(n):
            sign = np.where(same == j, -1.0, 1.0)
            words = f"with the {what or 'joint '}{names[j]} of the other sign"
            yield _changed(own, runs, words, fields, same, sign)
        for i, j in NEAR[np.isin(NEAR, told).all(axis=1)].tolist():
            order = same.copy()
            order[[i, j]] = j, i
            words = f"with the {what or 'joints '}{names[i]} and {names[j]} exchanged"
            yield _changed(own, runs, words, fields, order, np.ones(n))
    gravity = dynamics.gravity
    for axis, g in zip("xyz", np.linalg.norm(gravity) * np.eye(3), strict=True):
        if abs(g @ gravity) < 0.5 * (g @ g):
            words = f"with gravity along the {axis} axis of the base"
            g = g * _way(dynamics.under(g), runs)
            yield Rival.of(words, dynamics.under(g), runs)


def _way(dynamics: JointDynamics, runs: Sequence[TorqueSamples]) -> float:
    """One, or minus one where the URDF's arm needs torques of the other sign: links of
    any inertias fit either."""
    both = 0.0
    for run in runs:
        W = dynamics.regressor(run.position, run.velocity, run.acceleration)
        both += float((W @ dynamics.arm * run.torque).sum())
    return 1.0 if both >= 0.0 else -1.0


def _changed(
    own: Rival,
    runs: Sequence[TorqueSamples],
    words: str,
    fields: Sequence[str],
    order: Indices,
    sign: Array,
) -> Rival:
    """With the joints of some fields in another order, and of other signs."""
    if fields == ("torque",):  # the regressors, which take long, stay
        values = own.values.copy()
        values[..., -1] = values[:, order, -1] * sign
        return replace(own, words=words, values=values)
    changed = [
        replace(run, **{key: getattr(run, key)[:, order] * sign for key in fields})
        for run in runs
    ]
    return Rival.of(words, own.dynamics, changed)
