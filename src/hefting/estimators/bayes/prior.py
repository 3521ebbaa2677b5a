"""Prior of the Bayesian estimator: what a shape says of the ten parameters before any
wrench was measured.

The object is thought of as some 4,000 voxels; a_f (10,) are the parameters of 1 kg in
voxel f, v_f its share of the volume, mu = sum v_f a_f those of the homogeneous body.
The density is 1 + e(p), with e a Gaussian process. About the homogeneous centre of
mass, for 1 kg, phi then has the mean mu and, the mass apart, the covariance

    Q = sigma² (Q1 + `WITHIN_CELL_VARIANCE` Qw) + delta² Qd

- Q1 = M (C - C 1 1' C / 1' C 1) M': between cells, C_ij = v_i v_j exp(-d_ij² / 2 l²), l =
  `CORRELATION_LENGTH` times the diagonal of the bounding box; M (10, cells) are the means of a_f in each cell.
- Qw: within cells, the covariance of a_f, scaled to the inertia of Q1.
- Qd: a shell or a core. With r_f the rank of the voxel's depth, 0 at the surface and 1 in the middle, the density
  has random shares of the Legendre polynomials P1 and, with `CURVED_SHELL_VARIANCE` of the variance, P2:
  Qd = d1 d1' + `CURVED_SHELL_VARIANCE` d2 d2',
  d1 = sqrt(3) sum v_f a_f P1(2 r_f - 1),  d2 = sqrt(5) sum v_f a_f P2(2 r_f - 1).

The block of the inertia, given the centre of mass, is scaled by k². What sigma, delta
and k are is not known: the prior is a mixture of Gaussians over all of them.
"""

from dataclasses import dataclass, replace
from itertools import product
from typing import Self

import numpy as np

from hefting.core.spatial import Array
from hefting.estimators.bayes.distortion import Distortions, Move, affine
from hefting.estimators.bayes.voxels import Voxels
from hefting.shapes import Shape

DENSITY_STD_WEIGHTS = {0.1: 0.25, 0.3: 0.25, 0.7: 0.25, 1.4: 0.25}
"""sigma, the relative standard deviation of the density, and the prior probability of
each value."""
SHELL_STD_WEIGHTS = {0.0: 0.5, 1.0: 0.5}
"""delta, the relative difference in density between core and shell, and the prior
probability of each value."""
INERTIA_SCALE_WEIGHTS = {0.2: 0.3, 0.6: 0.4, 2.0: 0.3}
"""k, the factor of the inertia's standard deviation given the COM, and the prior
probability of each value."""
WITHIN_CELL_VARIANCE = 0.2
"""Variance of the density within cells, relative to that between them."""
CURVED_SHELL_VARIANCE = 0.3
"""Variance of the second Legendre polynomial of the depth rank, relative to that of the
first."""
TENSOR_MULTIPLICITY = np.array((1.0, 2.0, 2.0, 1.0, 2.0, 1.0))
"""(6,) number of times each entry xx, xy, xz, yy, yz, zz occurs in the symmetric
tensor."""
CORRELATION_LENGTH = 0.25
"""Correlation length of the density, as a share of the diagonal of the bounding box."""
LARGEST_DISTORTION = 3.0
"""Largest distortion of a shape along each mode, in prior standard deviations."""


@dataclass(frozen=True, eq=False)
class Prior:
    """Mixture of Gaussians for the parameters of a body of 1 kg, about the sensor's
    origin.

    Where the shape is uncertain, what its distortions do is linear only about one of
    them, and `about` another gives the same prior linear there.
    """

    mean: Array
    """(10,) of the homogeneous body; of its line, where a distortion is the place to be
    linear about"""
    spread: Array
    """(j, 10, 10) F: phi = s (mean + F z), z standard normal, for a body of about s kg;
    F[:, 0] is the mass's"""
    log_weight: Array
    """(j,) of the members of the mixture"""
    cells: Array
    """(10, n) parameters of 1 kg at each of the shape's points, spread over its cell"""
    shares: Array
    """(n,) of the homogeneous body's mass at each point"""
    voxels: Array
    """(10, n k) the same of smaller pieces: k to each point, one after the other"""
    voxel_shares: Array
    """(n k,)"""
    distortions: Distortions
    """in which ways the shape may be wrong; none for one that is certain"""

    @classmethod
    def of(
        cls,
        shape: Shape,
        pose_std: tuple[float, float] = (0.0, 0.0),
        shape_std: float = 0.0,
    ) -> Self:
        """Of a shape in the sensor frame; for its deviations see `Distortions.of`."""
        voxels = Voxels.of(shape)
        Q1, Qw, Qd = covariances(voxels, float(np.linalg.norm(shape.extents)) or 1.0)
        size = np.sqrt(max(float(np.trace(vector_second(voxels.mean))), 1e-12))
        units = np.repeat((size, size**2), (3, 6))
        pairs = list(product(DENSITY_STD_WEIGHTS.items(), SHELL_STD_WEIGHTS.items()))
        Q = np.stack(
            [
                s**2 * (Q1 + WITHIN_CELL_VARIANCE * Qw) + d**2 * Qd
                for (s, _), (d, _) in pairs
            ]
        )[:, 1:, 1:]
        members = _stiffened(
            Q / np.outer(units, units), np.array(list(INERTIA_SCALE_WEIGHTS))
        )
        weights = np.outer(
            [p * q for (_, p), (_, q) in pairs], list(INERTIA_SCALE_WEIGHTS.values())
        ).ravel()
        values, vectors = np.linalg.eigh(members)
        L = (
            vectors
            * np.sqrt(np.maximum(values, 0.0))[:, None, :]
            * units[None, :, None]
        )
        spread = np.zeros((len(members), 10, 10))
        spread[:, :, 0] = 3.0 * voxels.mean
        spread[:, 1:, 1:] = L
        T = affine(np.eye(3), shape.homogeneous.center_of_mass)
        return cls(
            shape.homogeneous.vector / shape.homogeneous.mass,
            T @ spread,
            np.log(weights / weights.sum()),
            T @ voxels.points,
            voxels.shares,
            T @ voxels.parameters,
            voxels.volumes,
            Distortions.of(shape, pose_std, shape_std),
        )

    def about(self, scores: Array) -> "Placed":
        """With the distortions, linear about the one of so many standard deviations
        (d,)."""
        if not len(scores):
            return Placed(self, None, scores, np.zeros((len(self.spread), 0, 9)))
        move = self.distortions.by(scores)
        effects = self.distortions.effects(self.mean, scores)
        M = move.parameters
        mean = M @ self.mean - effects @ scores
        both = np.concatenate(
            (
                M[1:, 1:] @ self.spread[:, 1:, 1:],
                np.tile(effects[1:], (len(self.spread), 1, 1)),
            ),
            2,
        )
        L = np.asarray(np.linalg.qr(both.transpose(0, 2, 1), mode="r")).transpose(
            0, 2, 1
        )
        spread = np.zeros_like(self.spread)
        spread[:, :, 0] = 3.0 * mean
        spread[:, 1:, 1:] = L
        prior = replace(
            self, mean=mean, spread=spread, cells=M @ self.cells, voxels=M @ self.voxels
        )
        return Placed(prior, move, scores, _attribution(L, effects[1:]))


@dataclass(frozen=True, eq=False)
class Placed:
    """A prior for a shape that may be distorted, linear about one distortion; or for a
    certain one."""

    prior: Prior
    """with cells and voxels where that distortion puts them"""
    move: Move | None
    """what it does; None for a certain shape"""
    scores: Array
    """(d,) its standard deviations"""
    attribution: Array
    """(j, d, 9) to how many deviations of each a difference from `mean`, the mass
    apart, comes"""

    def most_likely(self, weights: Array, means: Array) -> Array:
        """(d,) posterior mean of the distortion, given each member's weight (j,) and
        mean (j, 10)."""
        off = means[:, 1:] / means[:, :1] - self.prior.mean[1:]
        return np.clip(
            weights @ (self.attribution @ off[:, :, None])[:, :, 0],
            -LARGEST_DISTORTION,
            LARGEST_DISTORTION,
        )


def _attribution(L: Array, effects: Array) -> Array:
    """(j, d, 9): mean of z (d,) given x (9,), whose covariance is L L' (j, 9, 9), of
    which effects z is a part."""
    scale = np.linalg.norm(L, axis=2, keepdims=True)
    scale = np.where(scale > 0.0, scale, 1.0)
    inverse = np.linalg.pinv(L / scale, rcond=1e-9)
    return (
        (inverse @ (effects / scale)).transpose(0, 2, 1)
        @ inverse
        / scale.transpose(0, 2, 1)
    )


def vector_second(vector: Array) -> Array:
    """Second moment (3, 3) of the body of parameters (10,) about the origin."""
    xx, xy, xz, yy, yz, zz = vector[4:]
    J = np.array(((xx, xy, xz), (xy, yy, yz), (xz, yz, zz)))
    return 0.5 * np.trace(J) * np.eye(3) - J


def covariances(voxels: Voxels, diagonal: float) -> tuple[Array, Array, Array]:
    """Q1, Qw and Qd (10, 10) for 1 kg; `diagonal` [m] is that of the bounding box."""
    v, M, x = voxels.cell_shares, voxels.cells, voxels.cell_positions
    square = ((x[:, None] - x[None]) ** 2).sum(axis=2)
    C = np.outer(v, v) * np.exp(-0.5 * square / (CORRELATION_LENGTH * diagonal) ** 2)
    row = C.sum(axis=1)
    Mr = M @ row
    Q1 = M @ C @ M.T - np.outer(Mr, Mr) / row.sum()
    centred = voxels.parameters - voxels.mean[:, None]
    Qw = (centred * voxels.volumes) @ centred.T
    r = 2.0 * voxels.depth_rank - 1.0
    polynomials = np.stack(
        (3.0**0.5 * r, (5.0 * CURVED_SHELL_VARIANCE) ** 0.5 * (1.5 * r * r - 0.5))
    )
    d = voxels.parameters @ (voxels.volumes * polynomials).T
    within = float(Qw.diagonal()[4:] @ TENSOR_MULTIPLICITY)
    return (
        Q1,
        Qw
        * (float(Q1.diagonal()[4:] @ TENSOR_MULTIPLICITY) / within if within else 0.0),
        d @ d.T,
    )


def _stiffened(Q: Array, k: Array) -> Array:
    """Q (j, 9, 9) with the inertia's covariance, the centre of mass given, scaled by
    each k²: (j len(k), 9, 9)."""
    values, vectors = np.linalg.eigh(Q[:, :3, :3])
    inverse = 1.0 / np.where(values > 1e-9 * values[:, -1:], values, np.inf)
    half = Q[:, 3:, :3] @ (vectors * np.sqrt(inverse)[:, None, :])
    explained = half @ half.transpose(0, 2, 1)
    members = np.repeat(Q[:, None], len(k), axis=1)
    members[:, :, 3:, 3:] = (
        explained[:, None] + (k**2)[:, None, None] * (Q[:, 3:, 3:] - explained)[:, None]
    )
    return members.reshape(-1, 9, 9)
