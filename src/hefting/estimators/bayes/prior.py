"""Prior of the Bayesian estimator: what a shape says of the ten parameters before any
wrench was measured.

The object is thought of as some 4,000 voxels; a_f (10,) are the parameters of 1 kg in
voxel f, v_f its share of the volume, mu = sum v_f a_f those of the homogeneous body.
About the homogeneous centre of mass, for 1 kg, phi has the mean mu and, the mass apart,
a covariance that depends on how the density may vary (`densities`) and on how the shape
or its place may be wrong (`distortion`). Neither is known: the prior is a mixture of
Gaussians.
"""

from dataclasses import replace
from functools import cached_property, lru_cache
from typing import Self

import numpy as np

from hefting.core.spatial import STEINER, Array, immutable
from hefting.estimators.bayes import bounds
from hefting.estimators.bayes.densities import (
    MEMBERS,
    OFF_CENTRE_GROWTH,
    member_covariances,
)
from hefting.estimators.bayes.distortion import Distortions, Move, affine
from hefting.estimators.bayes.voxels import Voxels
from hefting.shapes import Shape

MASS_STD = 3.0
"""Standard deviation of the mass over the prior's mass, which leaves it nearly free."""
LARGEST_DISTORTION = 3.0
"""Largest distortion of a shape along each mode, in prior standard deviations."""
NEGLIGIBLE_MEMBER = 1e-3
"""Posterior weight below which a member does not affect where a shape is."""
SMALLEST_SHARE = 1e-12
"""Least variance of a combination of parameters, relative to that of each; smaller ones
are rounding errors."""
PRIORS_KEPT = 8
"""Number of priors that are cached for later recordings of the same shape; with 4,000
voxels each takes 0.4 MB."""


@immutable
class Prior:
    """Mixture of Gaussians for the parameters of a body of 1 kg, about the sensor's
    origin.

    The effect of an uncertain shape's distortions is linearised about one of them;
    `about` linearises the same prior about another.
    """

    mean: Array
    """(10,) of the homogeneous body; where the prior is linear about another COM, of
    the tangent there"""
    spread: Array
    """(j, 10, 10) F: phi = s (mean + F z), z standard normal, for a body of about s kg;
    F[:, 0] is the mass's"""
    log_weight: Array
    """(j,) of the members of the mixture"""
    cells: Array
    """(10, n) parameters of 1 kg at each of the shape's points, spread over its cell"""
    shares: Array
    """(n,) of the homogeneous body's mass at each point"""
    stated_voxels: Array
    """(10, n k) the same for k smaller pieces of each point's cell in turn, as the
    shape states them"""
    voxel_shares: Array
    """(n k,)"""
    distortions: Distortions
    """modes in which the shape may be wrong; none for a certain shape"""
    slips: Distortions
    """small errors of a pose whose accuracy is not given, which `spread` includes"""
    growth: float
    """`OFF_CENTRE_GROWTH`: of the second moment with the squared distance of the COM
    from that of `mean`"""
    offsets: Array | None = None
    """(j, 10) of the members' means from `mean`; None if they have the same mean"""
    placement: Array | None = None
    """(10, 10) map of the stated voxels to where they are; None for the identity"""

    @classmethod
    def of(
        cls,
        shape: Shape,
        pose_std: tuple[float, float] | None = None,
        shape_std: float = 0.0,
    ) -> Self:
        """From a shape in the sensor frame; for its deviations see `Distortions.of`.
        With `pose_std` None some members have the exact pose, and some allow for a
        typical error."""
        voxels, com = Voxels.of(shape), shape.homogeneous.center_of_mass
        mean = shape.homogeneous.vector / shape.homogeneous.mass
        size = np.sqrt(max(float(np.trace(vector_second(voxels.mean))), 1e-12))
        units = np.repeat((size, size**2), (3, 6))
        diagonal = float(np.linalg.norm(shape.extents)) or 1.0
        Q = member_covariances(voxels, diagonal, units)
        T = affine(np.eye(3), com)
        unsaid = pose_std is None and shape_std == 0.0
        slips = Distortions.typical(shape) if unsaid else Distortions.none(shape)
        if unsaid:
            back = affine(np.eye(3), -com)
            moved = (back @ slips.covariance(mean) @ back.T)[1:, 1:]
            Q = Q + MEMBERS[:, 4, None, None] * (moved / np.outer(units, units))
        values, vectors = np.linalg.eigh(Q)
        L = vectors * np.sqrt(np.maximum(values, 0.0))[:, None, :]
        spread = np.zeros((len(Q), 10, 10))
        spread[:, :, 0] = MASS_STD * voxels.mean
        spread[:, 1:, 1:] = L * units[None, :, None]
        return cls(
            mean,
            T @ spread,
            np.log(MEMBERS[:, 5] / MEMBERS[:, 5].sum()),
            T @ voxels.points,
            voxels.shares,
            T @ voxels.parameters,
            voxels.volumes,
            Distortions.of(shape, pose_std, shape_std),
            slips,
            OFF_CENTRE_GROWTH,
        )

    @classmethod
    def of_bounds(cls, shape: Shape) -> Self:
        """From a box in the sensor frame that contains the object, or the neighbourhood
        of the sensor (`Shape.known`)."""
        table, least_gamma = bounds.BOUNDS_MEMBERS, bounds.EVEN_COM
        if shape.known == "reach":
            table, least_gamma = bounds.REACH_MEMBERS, 0.0
        means, factors = bounds.bounded_members(
            table, np.asarray(shape.extents), least_gamma
        )
        com = shape.homogeneous.center_of_mass
        T, turned = affine(np.eye(3), com), affine(shape.pose[:3, :3], com)
        voxels, none = Voxels.of(shape), Distortions.none(shape)
        weights = table[:, 5] / table[:, 5].sum()
        spread = np.zeros((len(table), 10, 10))
        spread[:, :, 0] = MASS_STD * means
        spread[:, 1:, 1:] = factors
        mean = weights @ means
        return cls(
            turned @ mean,
            turned @ spread,
            np.log(weights),
            T @ voxels.points,
            voxels.shares,
            T @ voxels.parameters,
            voxels.volumes,
            none,
            none,
            bounds.OFF_CENTRE_GROWTH,
            (means - mean) @ turned.T,
        )

    def mean_as_stated(self, weights: Array, means: Array) -> Array:
        """(10,) posterior mean from the members' weights (j,) and means (j, 10); only
        of the members with an exact pose if these are likelier than not."""
        if len(self.slips.shifts):
            exact = weights * (1.0 - MEMBERS[:, 4])
            if (total := float(exact.sum())) > 0.5:
                return exact @ means / total
        return weights @ means

    def likely_slips(self, weights: Array, means: Array) -> Array:
        """(d,) posterior mean of the errors of a pose whose accuracy is not given, in
        standard deviations, from the members' weights (j,) and means (j, 10)."""
        effects = self.slips.effects(self.mean, np.zeros(len(self.slips.shifts)))
        return _most_likely(self, effects, weights * MEMBERS[:, 4], means)

    @property
    def undistorted(self) -> "Prior":
        """Placed without distortion, linear about none."""
        return self.about(np.zeros(len(self.distortions.shifts))).prior

    def about(self, scores: Array, com: Array | None = None) -> "Placed":
        """Placed with the distortion `scores` (d,), linear about it and about a centre
        of mass `com` (3,) [m], by default the homogeneous one."""
        if not len(scores):
            mean, spread = self._bent(com)
            return Placed(
                replace(self, mean=mean, spread=spread), None, scores, np.zeros((10, 0))
            )
        move = self.distortions.by(scores)
        effects = self.distortions.effects(self.mean, scores)
        M = move.parameters
        bent, spread = self._bent(None if com is None else move.back(com))
        mean = M @ bent - effects @ scores
        both = np.concatenate(
            (
                M[1:, 1:] @ spread[:, 1:, 1:],
                np.tile(effects[1:], (len(self.spread), 1, 1)),
            ),
            2,
        )
        L = np.asarray(np.linalg.qr(both.transpose(0, 2, 1), mode="r")).transpose(
            0, 2, 1
        )
        spread = np.zeros_like(self.spread)
        spread[:, :, 0] = MASS_STD * mean
        spread[:, 1:, 1:] = L
        prior = replace(self.placed_by(M), mean=mean, spread=spread)
        return Placed(prior, move, scores, effects)

    def placed_by(self, M: Array) -> "Prior":
        """The prior with cells and voxels moved by the linear map M (10, 10)."""
        placement = M if self.placement is None else M @ self.placement
        return replace(self, cells=M @ self.cells, placement=placement)

    @cached_property
    def voxels(self) -> Array:
        """(10, n k) parameters of 1 kg in each voxel, where it is; when needed."""
        if self.placement is None:
            return self.stated_voxels
        return self.placement @ self.stated_voxels

    @cached_property
    def _to_and_from_com(self) -> tuple[Array, Array]:
        """(10, 6) parameters by the inertia about the homogeneous COM, and (3, 10)
        first moment about it by the parameters."""
        away = affine(np.eye(3), self.mean[1:4])
        back = affine(np.eye(3), -self.mean[1:4])
        return away[:, 4:], back[1:4]

    def _bent(self, com: Array | None) -> tuple[Array, Array]:
        """`mean` and `spread` for a second moment that grows with the squared distance
        of the COM from the homogeneous one, linear about `com` (3,) [m]."""
        if com is None:
            return self.mean, self.spread
        c = com - self.mean[1:4]
        slopes = parallel_axis_slopes(c)
        mean = self.mean.copy()
        mean[4:] -= self.growth * 0.5 * (slopes @ c)
        away, back = self._to_and_from_com
        spread = (np.eye(10) + self.growth * (away @ slopes @ back)) @ self.spread
        own = mean if self.offsets is None else mean + self.offsets
        spread[:, :, 0] = MASS_STD * own
        return mean, spread


@lru_cache(maxsize=PRIORS_KEPT)
def prior_of(
    shape: Shape, pose_std: tuple[float, float] | None, shape_std: float | None
) -> Prior:
    """`Prior.of` a shape or, without `shape_std`, `Prior.of_bounds`; cached, so that
    nothing may be changed in place."""
    if shape_std is None:
        return Prior.of_bounds(shape)
    return Prior.of(shape, pose_std, shape_std)


@immutable
class Placed:
    """A prior linearised about one distortion of its shape."""

    prior: Prior
    """with cells and voxels moved by the distortion"""
    move: Move | None
    """the distortion as a map; None for a certain shape"""
    scores: Array
    """(d,) the distortion in standard deviations"""
    effects: Array
    """(10, d) change of the parameters of 1 kg by a standard deviation of each mode"""

    def most_likely(self, weights: Array, means: Array) -> Array:
        """(d,) posterior mean of the distortion by the members' weights and means."""
        if not len(self.scores):
            return self.scores
        return _most_likely(self.prior, self.effects, weights, means)


def _most_likely(prior: Prior, effects: Array, weights: Array, means: Array) -> Array:
    """(d,) posterior mean of distortions with effects X (10, d) from the members'
    weights (j,), of any sum, and means (j, 10): X'Q^-1 times the difference from the
    prior's mean, without the mass, for a member of covariance Q."""
    kept = weights > NEGLIGIBLE_MEMBER
    L, X = prior.spread[kept, 1:, 1:], effects[1:]
    off = means[kept, 1:] / means[kept, :1] - prior.mean[1:]
    scale = np.linalg.norm(L, axis=2)
    scale = np.where(scale > 0.0, scale, 1.0)
    L = L / scale[:, :, None]
    Q = L @ L.transpose(0, 2, 1) + SMALLEST_SHARE * np.eye(9)
    y = np.linalg.solve(Q, (off / scale)[:, :, None])[:, :, 0] / scale
    return np.clip((weights[kept] @ y) @ X, -LARGEST_DISTORTION, LARGEST_DISTORTION)


def parallel_axis_slopes(c: Array) -> Array:
    """(6, 3) derivative by c (3,) of |c|² 1 - c c', as xx, xy, xz, yy, yz, zz."""
    return 2.0 * STEINER @ c


def vector_second(vector: Array) -> Array:
    """Second moment (3, 3) of the body of parameters (10,) about the origin."""
    xx, xy, xz, yy, yz, zz = vector[4:]
    J = np.array(((xx, xy, xz), (xy, yy, yz), (xz, yz, zz)))
    return 0.5 * np.trace(J) * np.eye(3) - J
