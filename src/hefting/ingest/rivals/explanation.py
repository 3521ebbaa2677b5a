"""Explanation: one way to understand a recording, fitted to it."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from hefting.core.messages import Message, warning
from hefting.core.spatial import Array
from hefting.ingest.model import REGRESSOR_BY_FEATURE
from hefting.ingest.rivals.case import FINE_OFFSETS, Case, Motion
from hefting.ingest.rivals.evidence import Fitted, Rows, fit_rows, with_bias

OFFSET_STEP = 2e-3
"""[s] Half of the step of the numerical derivative by the clock offset."""
Build = Callable[[Motion], Rows]
"""Rows of the model for the motion at O clock offsets."""


@dataclass(frozen=True, eq=False)
class Explanation:
    """One way to understand a recording: as it was given, or with a mistake in it."""

    code: str
    """code of the message that names it; ``"as-given"`` for no mistake"""
    what: str
    """what would be wrong, as a clause: "the sensor's axes are turned by 30°" """
    fix: str
    """what to do about it, as an imperative"""
    fitted: Fitted
    unknowns: int
    """unknowns besides those of a recording as given"""
    rarity: float = 0.0
    """negative log of how common the mistake is, over that of the most common ones"""
    argument: str | None = None
    """argument of the library with which the user can act on it"""
    parameters: Array | None = None
    """(10,) of the object in the recorded wrench's sign, if it is so; None where they
    are those of `fitted`"""
    effect: float | None = None
    """size of the mistake over its standard deviation, where that was found"""

    @property
    def vector(self) -> Array:
        """(10,) parameters of the object, in the recorded wrench's sign."""
        if self.parameters is not None:
            return self.parameters
        return self.fitted.solution[self.fitted.best][:10]

    @property
    def likelihood(self) -> float:
        """Log-likelihood of one sample on average, up to a constant."""
        return float(self.fitted.likelihood[self.fitted.best])

    @property
    def scale(self) -> Array:
        """(2,) size of what it leaves of force [N] and torque [N m]."""
        return self.fitted.scale[self.fitted.best]

    def message(self) -> Message:
        """The warning that names it."""
        return warning(self.code, f"{self.what}: {self.fix}", self.argument)


def over_offsets(case: Case, build: Build) -> tuple[Fitted, float]:
    """The fit at the likeliest clock offset near the coarse ones, and that offset
    [s]."""
    coarse = fit_rows(case, build(case.motion))
    best = case.offsets[coarse.best]
    if not case.path.moves:
        return coarse, 0.0
    near = best + FINE_OFFSETS
    fine = fit_rows(case, build(case.motion_at(case.time - near[:, None])))
    return fine, float(near[fine.best])


def newton_euler(case: Case, motion: Motion, wrench: Array | None = None) -> Rows:
    """Rows of the model of a body as given: ten parameters and a bias."""
    return with_bias(
        case,
        motion.features(case.gravity),
        REGRESSOR_BY_FEATURE,
        motion.known,
        wrench,
    )


def as_given(case: Case) -> Explanation:
    """The recording without a mistake."""
    fitted, _ = over_offsets(case, lambda motion: newton_euler(case, motion))
    return Explanation(code="as-given", what="", fix="", fitted=fitted, unknowns=0)


def turned_wrench(case: Case, matrices: Array) -> Array:
    """(M, K, 6) wrench multiplied by each matrix (M, 6, 6)."""
    return np.einsum("mij,kj->mki", matrices, case.wrench)


def likeliest_matrix(
    case: Case, matrices: Array, offset: float
) -> tuple[int, Fitted, float]:
    """Which of the matrices (M, 6, 6) that keep the wrench's length explains it best,
    its fit, and its clock offset [s].

    All are tried at the clock offset given and at none, the best at all offsets.
    """
    times = case.time - np.unique((0.0, offset))[:, None]
    motion = case.motion_at(times)
    likelihoods = []
    wrenches = turned_wrench(case, matrices)
    for i in range(len(times)):
        one = Motion(
            motion.a[i : i + 1],
            motion.rest[i : i + 1],
            motion.axes[i : i + 1],
            motion.known[i : i + 1],
        )
        rows = newton_euler(case, one)
        M = len(matrices)
        known = np.broadcast_to(rows.known, (M, *rows.known.shape[1:]))
        used = np.broadcast_to(rows.used, (M, rows.used.shape[1]))
        fitted = fit_rows(case, Rows(known, rows.maps, used, wrenches))
        likelihoods.append(fitted.likelihood)
    best = int(np.argmax(np.max(likelihoods, axis=0)))
    wrench = wrenches[best][None]
    found, there = over_offsets(case, lambda m: newton_euler(case, m, wrench))
    return best, found, there


def offset_columns(
    case: Case, motion_at: Build, offset: float, solution: Array
) -> Array:
    """(K, 6, 1) derivative of the wrench by the clock offset, at the offset given [s]
    and a solution (p,)."""
    around = np.array((-1.0, 1.0)) * OFFSET_STEP
    motion = case.motion_at(case.time - offset - around[:, None])
    rows = motion_at(motion)
    wrench = rows.known @ np.einsum("zcp,p->zc", rows.maps, solution)
    return ((wrench[1] - wrench[0]) / (2.0 * OFFSET_STEP))[:, :, None]


def at_offset(case: Case, build: Build, offset: float) -> Fitted:
    """The fit at one clock offset [s]."""
    return fit_rows(case, build(case.motion_at(case.time[None] - offset)))
