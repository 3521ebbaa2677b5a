"""Rivals: mistakes by which joint positions and torques do not fit the URDF's arm, each
corrected in turn.

Even with any inertias of the links, the last with the payload, an arm explains torques
far worse if joints are in another order, of another sign, or gravity is another. So the
residuals with each correction are compared with those of the runs as recorded.
"""

from collections.abc import Iterator, Sequence
from dataclasses import replace
from itertools import product
from typing import Self

import numpy as np

from hefting.core.spatial import Array, Indices, Mask, immutable
from hefting.torques.dynamics import JointDynamics
from hefting.torques.equations import OWN, Load, Rows, TorqueScales
from hefting.torques.noise import fit
from hefting.torques.runs import drifting, no_samples
from hefting.torques.samples import TorqueSamples

SAMPLES = 400
"""Number of samples, of all runs together, on which rivals are compared."""
FEWEST_ROWS = 5
"""Fewest rows for each unknown, and of a joint for each of its nuisances, from which
residuals are compared."""
LEAST_GAIN = np.array((0.5, 0.25))
"""Least decreases of the two logarithms of `Rival.residuals` for which a rival is
believed. The first decreased by at most 0.04 in 99 correct recordings, by at least 1.2
in 36 with a mistake; by 1.3 in correct ones of joints that move one at a time, but not
both."""
POSITIONS = ("position", "velocity", "acceleration")
"""Fields of `TorqueSamples` that a mistake affects together."""
NEAR = np.array([(j, j + by) for j in range(20) for by in (1, 2)])
"""Pairs of joints that are exchanged: neighbours and second neighbours, as shoulder and
elbow in alphabetical order."""
ZEROS = (-90, 90, 180)
"""[degree] Angles between zeros by Denavit-Hartenberg and those of a URDF."""


@immutable
class Rival:
    """A correction of a mistake, and the equations of all runs with it."""

    words: str
    """of the correction, in messages"""
    dynamics: JointDynamics
    values: Array
    """(K, n, c) as `Rows.values`"""
    used: Mask
    """(K, n) whether a row counts"""

    @classmethod
    def of(
        cls, words: str, dynamics: JointDynamics, runs: Sequence[TorqueSamples]
    ) -> Self:
        """Rival with equations of corrected runs; the payload is in the last link."""
        load = Load.published(dynamics)
        rows = [Rows.of(dynamics, run, False).under(dynamics, load) for run in runs]
        used = np.concatenate([each.used for each in rows])
        values = np.concatenate([each.values for each in rows])
        return cls(words, dynamics, values, used)

    @property
    def residuals(self) -> tuple[Array, Array]:
        """Two logarithms (2,), and the standard deviation (n,) of the residuals of each
        joint [N m], nan for joints with too few rows.

        The logarithms are of these, and of them over the torque that offset and friction
        alone do not explain; summed over joints, times the share of rows that count.
        They are infinite if there are too few rows in all.
        """
        counts = self.used.sum(axis=0)
        unknowns = len(self.dynamics.base) + len(OWN) * self.dynamics.joints
        if counts.sum() < FEWEST_ROWS * unknowns:
            return np.full(2, np.inf), np.ones(self.dynamics.joints)
        # time scales matter for the noise's colour only, not for residuals
        none = no_samples(self.dynamics).levels[0]
        folded = none.fold_rows(self.values * self.used[..., None])
        moments = replace(folded, counts=counts.astype(float))
        fitted = fit(TorqueScales((moments,)), drifting)
        few = counts < FEWEST_ROWS * len(OWN)
        std = np.where(few, np.nan, fitted.std)
        # any model explains the torque of a joint that rests while another moves;
        # the torque left by the nuisances is in units of `fitted.std`
        unexplained = np.linalg.norm(fitted.moments.without_nuisances[..., -1], axis=1)
        relative = np.sqrt(counts) / np.where(few, np.nan, unexplained)
        # weights for each joint would change with the joints that are exchanged
        spread = np.nansum(np.log((std, relative)), axis=1) * counts.mean()
        return spread / len(self.used), std


def better_rival(
    dynamics: JointDynamics, runs: Sequence[TorqueSamples]
) -> tuple[Rival, float] | None:
    """The rival that explains the torques best, and the largest factor by which it
    reduces the residuals of a joint; None if no rival explains them far better."""
    step = max(1, sum(len(run.time) for run in runs) // SAMPLES)
    runs = [run[::step] for run in runs]
    recorded = Rival.of("", dynamics, runs)
    spread, std = recorded.residuals
    if not np.isfinite(spread).all():
        return None
    enough = np.flatnonzero(np.isfinite(std))
    tried = [(*rival.residuals, rival) for rival in _rivals(recorded, runs, enough)]
    gains = [float(((spread - each[0]) / LEAST_GAIN).min()) for each in tried]
    _, best_std, best = tried[int(np.argmax(gains))]
    if not max(gains) > 1.0:
        return None
    return best, float(np.nanmax(std / best_std))


def _rivals(
    recorded: Rival, runs: Sequence[TorqueSamples], enough: Indices
) -> Iterator[Rival]:
    """All rivals of the runs as recorded: signs of each joint, exchanges of two joints
    with `enough` rows, other zeros of a joint, and gravity along other axes."""
    dynamics = recorded.dynamics
    n, names = dynamics.joints, dynamics.names
    same = np.arange(n)
    changes = [
        ("joint ", f"{names[j]} of the other sign", same, 1.0 - 2.0 * (same == j))
        for j in range(n)
    ]
    for i, j in NEAR[np.isin(NEAR, enough).all(axis=1)].tolist():
        order = same.copy()
        order[[i, j]] = j, i
        what = f"{names[i]} and {names[j]} exchanged"
        changes.append(("joints ", what, order, np.ones(n)))
    moved = []
    for _, what, order, sign in changes:
        changed = [
            replace(run, **{x: getattr(run, x)[:, order] * sign for x in POSITIONS})
            for run in runs
        ]
        moved.append(Rival.of(f"with the positions of {what}", dynamics, changed))
    # the regressors, which take long, are the same whatever the torques are
    for rival, (joints, what, order, sign) in zip(moved, changes, strict=True):
        yield _with_torques(rival, joints + what, order, sign)
    for _, what, order, sign in changes:
        yield _with_torques(recorded, f"torques of {what}", order, sign)
    yield from moved
    # zeros of the first and last joint show in no torque
    turning = [j for j in same[1:-1] if dynamics.robot.limits[j]]
    for j, angle in product(turning, ZEROS):
        by = np.radians(angle) * (same == j)
        turned = [replace(run, position=run.position + by) for run in runs]
        words = f"with {angle}° added to the angles of {names[j]}"
        yield Rival.of(words, dynamics, turned)
    gravity = dynamics.gravity
    for axis, g in zip("xyz", np.linalg.norm(gravity) * np.eye(3), strict=True):
        if abs(g @ gravity) < 0.5 * (g @ g):
            words = f"with gravity along the {axis} axis of the base"
            g = g * _gravity_sign(dynamics.under(g), runs)
            yield Rival.of(words, dynamics.under(g), runs)


def _gravity_sign(dynamics: JointDynamics, runs: Sequence[TorqueSamples]) -> float:
    """The sign of the correlation between the torques of the URDF's arm and those that
    were recorded: arms with any inertias fit gravity of either sign."""
    product = 0.0
    for run in runs:
        W = dynamics.regressor(run.position, run.velocity, run.acceleration)
        product += float((W @ dynamics.arm * run.torque).sum())
    return 1.0 if product >= 0.0 else -1.0


def _with_torques(rival: Rival, what: str, order: Indices, sign: Array) -> Rival:
    """`rival` with its torques in another order (n,), times `sign` (n,)."""
    values = rival.values.copy()
    values[..., -1] = values[:, order, -1] * sign
    return replace(rival, words=f"with the {what}", values=values)
