"""TorqueMoments: the sums over any number of samples of joint torques that estimators
need, in a triangular factor for each joint.

The torque of joint j is linear in what is unknown,

    tau_j = u_j' nu_j + w_j' beta + y_j' phi + e_j

with nuisances nu_j of its own (offset, friction, reflected inertia), parameters beta of
the arm that all joints share, and the ten parameters phi of the payload. One factor R_j
of the columns [u_j | w_j | y_j | tau_j] holds all that the samples tell of it. Its rows
below those of the nuisances are the equations without these. Those of all joints, over
the standard deviations of their noise, stand below one another, and the arm is taken
out in the same way. What is left is an 11 x 11 factor, as a wrench leaves.
"""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import suppress
from dataclasses import replace
from functools import cached_property
from typing import Self

import numpy as np
from numpy.typing import ArrayLike

from hefting.core.errors import InputError
from hefting.core.lapack import lapack
from hefting.core.moments import folded, triangular
from hefting.core.spatial import Array, immutable

PAYLOAD = 10
"""Number of columns of the payload's parameters, the last before the torque's."""
WELL_CONDITIONED = 1e-7
"""Reciprocal condition number of scaled columns above which no unknown is open."""
OPEN = 1e-9
"""Singular value of scaled columns, relative to 1, below which a direction is open."""
VANISHING = 1e-8
"""Length of a column over the longest, below which it is rounding."""


@immutable
class TorqueMoments:
    """Triangular factor of each joint's equations for samples of joint torques.

    Immutable: `fold_rows` and `merge` return new values. Folding costs the same however many
    samples went before.
    """

    factors: Array
    """(n, c, c) upper triangular, of the columns [own | arm | payload 10 | torque]."""
    own: int
    """Number of nuisances of each joint."""
    counts: Array
    """(n,) Number of samples that count in each joint."""
    samples: int = 0
    """Number of samples, counted by a joint or not."""
    start: float = np.inf
    """Time of the first sample [s]."""
    end: float = -np.inf
    """Time of the last sample [s]."""

    @classmethod
    def empty(cls, joints: int, own: int, arm: int = 0) -> Self:
        """Without samples, for numbers of joints, nuisances of each, and parameters of
        the arm."""
        c = own + arm + PAYLOAD + 1
        return cls(np.zeros((joints, c, c)), own, np.zeros(joints))

    def __post_init__(self):
        factors, counts = np.asarray(self.factors), np.asarray(self.counts)
        c = self.own + PAYLOAD + 1
        if (
            factors.ndim != 3
            or factors.shape[1] != factors.shape[2]
            or factors.shape[1] < c
            or counts.shape != factors.shape[:1]
        ):
            raise InputError(
                f"factors of shape {factors.shape} are not those of {len(counts)} "
                f"joints with {self.own} nuisances each"
            )

    @property
    def joints(self) -> int:
        """Number of joints n."""
        return len(self.factors)

    @property
    def arm(self) -> int:
        """Number of unknown parameters of the arm."""
        return self.factors.shape[1] - self.own - PAYLOAD - 1

    @property
    def duration(self) -> float:
        """Time between the first and the last sample [s]."""
        return max(0.0, self.end - self.start)

    def fold_rows(self, rows: Array) -> Self:
        """With rows (K, n, c) that are no samples, such as averages or differences;
        numbers and times stay."""
        factors = np.empty_like(self.factors)
        for j, factor in enumerate(self.factors):
            factors[j] = folded(np.asfortranarray(factor), rows[:, j])
        return replace(self, factors=factors)

    def merge(self, other: TorqueMoments) -> Self:
        """Of the samples of both, in whichever order and on whichever machine they were
        folded: of one robot, and of one payload or none.

        Raises `InputError` where their columns are not the same.
        """
        if self.factors.shape != other.factors.shape or self.own != other.own:
            raise InputError(
                f"moments of {self.joints} joints, {self.own} nuisances and {self.arm} "
                f"parameters of the arm do not merge with those of {other.joints}, "
                f"{other.own} and {other.arm}"
            )
        both = np.concatenate((self.factors, other.factors), axis=1)
        return replace(
            self,
            factors=np.array([triangular(rows) for rows in both]),
            counts=self.counts + other.counts,
            samples=self.samples + other.samples,
            start=min(self.start, other.start),
            end=max(self.end, other.end),
        )

    def weighed(self, std: ArrayLike) -> Self:
        """With the equations of each joint divided by the standard deviation of its
        noise, `std` (n,) [N m]."""
        factors = self.factors / _positive(std, self.joints)[:, None, None]
        return replace(self, factors=factors)

    @cached_property
    def without_nuisances(self) -> Array:
        """(n, c, c - own) equations [arm | payload | torque] of each joint with its
        nuisances eliminated."""
        left = np.zeros((self.joints, *self.factors.shape[1:]))[:, :, self.own :]
        for j, factor in enumerate(self.factors):
            rows = eliminated(factor, self.own)
            left[j, : len(rows)] = rows
        return left

    def shared(self, std: ArrayLike = 1.0) -> Array:
        """(m, m) factor [arm | payload | torque] of all joints, their noise `std` (n,)
        [N m]; m = arm + 11."""
        std = _positive(std, self.joints)
        rows = self.without_nuisances / std[:, None, None]
        return triangular(rows.reshape(-1, rows.shape[2]))


def merged(several: Sequence[TorqueMoments]) -> TorqueMoments:
    """With the samples of all, see `TorqueMoments.merge`."""
    found = several[0]
    for other in several[1:]:
        found = found.merge(other)
    return found


def payload_factor(shared: Array) -> Array:
    """(11, 11) factor [payload | torque] of a factor [others | payload | torque] with
    the others eliminated."""
    rows = eliminated(shared, shared.shape[1] - PAYLOAD - 1)
    return triangular(rows)


def eliminated(R: Array, first: int) -> Array:
    """Rows that are left of an upper triangular factor R (c, c) when the unknowns of
    its `first` columns take their best values, whatever the others: (c - first or more,
    c - first).

    They are the rows below the first ones; and, where the samples leave some of these
    unknowns open, the combinations of the first rows in which none of them stands.
    """
    rest = R[first:, first:]
    if not first:
        return rest
    N = R[:first, :first]
    N, _ = scaled(N)
    if float(lapack.dtrcon(N)[0]) > WELL_CONDITIONED:
        return rest
    U, S, _ = np.linalg.svd(N)
    extra = U[:, OPEN > S].T @ R[:first, first:]
    return np.vstack((rest, extra))


def scaled(N: Array) -> tuple[Array, Array]:
    """Columns of N (..., r, c) scaled to unit length, and their lengths (..., 1, c);
    vanishing ones stay zero with length 1."""
    lengths = np.sqrt((N * N).sum(axis=-2, keepdims=True))
    vanish = lengths <= VANISHING * lengths.max(axis=-1, keepdims=True, initial=0.0)
    lengths = np.where(vanish, 1.0, lengths)
    return np.where(vanish, 0.0, N / lengths), lengths


def _positive(std: ArrayLike, joints: int) -> Array:
    values = np.broadcast_to(np.asarray(std, dtype=float), (joints,))
    if not (np.isfinite(values).all() and (values > 0.0).all()):
        raise InputError("the noise of every joint must be positive and finite")
    return values


def pseudo_inverse_half(A: Array) -> Array:
    """X (..., c, k) with X X' = (A'A)^+ for A (..., r, c) with columns scaled to unit
    length; zero columns for combinations that A leaves open."""
    N, lengths = scaled(A)
    with suppress(np.linalg.LinAlgError):  # a fifth of the time of singular values
        X = np.linalg.inv(np.linalg.qr(N, mode="r"))
        if np.linalg.norm(X) < 1.0 / WELL_CONDITIONED:
            return X / np.swapaxes(lengths, -1, -2)
    _, S, V = np.linalg.svd(N, full_matrices=False)
    inverse = np.divide(1.0, S, out=np.zeros_like(S), where=S > OPEN)
    return np.swapaxes(V * inverse[..., None] / lengths, -1, -2)
