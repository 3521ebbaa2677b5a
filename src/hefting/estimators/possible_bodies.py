"""Possible bodies: what a method takes an object to be before any wrench was measured,
as a mixture of Gaussians.

A member of the mixture is a body of 1 kg with the parameters phi = mean + F z, z
standard normal. Its first column is the mass's, next to free; the others are

- about a body of pseudo-inertia G G': phi(G (1 + sqrt(2 / nu) X) G'), X a symmetric
  matrix of ten standard normal coordinates (`hefting.core.inertia`). This is
  the Gaussian of the mean and covariance of a Wishart distribution of nu degrees of
  freedom, whose logarithm is that of GEO's entropic prior for gamma = nu - 5;
- of densities in a shape: the prior of Bayes;
- of homogeneous parts: each part's mass by itself.

How far bodies stray is not known: members have several nu, sizes or deviations.
"""

from typing import Self

import numpy as np

from hefting.core.inertia import IDENTITY, PARAMETERS_OF, InertialParameters, congruence
from hefting.core.spatial import Array, immutable
from hefting.estimators.bayes.prior import MASS_STD, Prior, parallel_axis_slopes
from hefting.shapes import Shape

NEAR_BODY_FREEDOMS = {1000.0: 0.3, 200.0: 0.3, 50.0: 0.2, 12.0: 0.1, 3.0: 0.1}
"""nu of bodies near a homogeneous one of known shape, and their prior probabilities."""
IN_BOX_FREEDOMS = {12.0: 0.25, 4.0: 0.25, 1.0: 0.25, 0.3: 0.25}
"""nu of bodies somewhere in a box, and their prior probabilities."""
RADII = 0.01 * 2.0 ** np.arange(6)
"""(6,) radii of gyration [m] of an unknown object, equally likely: 10 mm to 0.32 m."""
ANY_BODY_FREEDOM = 1.0
"""nu of bodies of each of these radii."""
COM_STD = 0.3
"""[m] Standard deviation along each axis of the COM of an unknown object about that of
least squares."""
PART_STDS = (0.3, 1.0, 3.0)
"""Standard deviations of a part's density over the mean density, equally probable."""
WITHIN_PART_STDS = (0.003, 0.02, 0.1)
"""Standard deviations along each axis of the density within a part over the part's,
equally probable. The points show a part's border only to their spacing."""
THIN = 1e-9
"""Standard deviation of a part's points along an axis, relative to the largest
coordinate, up to which they lie in a plane."""
WRONG_SHAPE = 0.01
"""Prior probability that the object is none of the method's possible bodies, but any
body."""


@immutable
class PossibleBodies:
    """Mixture of Gaussians for the parameters of a body of 1 kg, in sensor axes about
    the sensor's origin."""

    means: Array
    """(j, 10)"""
    spread: Array
    """(j, 10, k) F"""
    log_weight: Array
    """(j,)"""

    @classmethod
    def any(cls, center: Array) -> Self:
        """Any size, with the COM anywhere about `center` (3,) [m]."""
        members = [
            _about(ball_factor(center, float(r)), ANY_BODY_FREEDOM) for r in RADII
        ]
        shift = COM_STD * _com_derivative(center)
        return cls(
            np.array([mean for mean, _ in members]),
            np.array([np.column_stack((F, shift)) for _, F in members]),
            np.full(len(members), -np.log(len(members))),
        )

    @classmethod
    def near(cls, body: InertialParameters) -> Self:
        """Near a homogeneous body of positive definite pseudo-inertia, such as
        `hefting.estimators.geo.thickened`."""
        return cls._of_freedoms(body, NEAR_BODY_FREEDOMS)

    @classmethod
    def in_box(cls, body: InertialParameters) -> Self:
        """Somewhere in a box, of which `body` is the homogeneous filling."""
        return cls._of_freedoms(body, IN_BOX_FREEDOMS)

    @classmethod
    def in_shape(cls, shape: Shape) -> Self:
        """Any density in a shape, with the shape's own deviation."""
        prior = Prior.of(shape, shape_std=shape.shape_std)
        prior = prior.about(np.zeros(len(prior.distortions.shifts))).prior
        means = np.tile(prior.mean, (len(prior.spread), 1))
        return cls(means, prior.spread, prior.log_weight)

    @classmethod
    def of_parts(cls, shape: Shape, shares: Array) -> Self:
        """Nearly homogeneous parts; `shares` (n, parts) are the shares of each part's
        mass at the shape's points."""
        volume = (shares > 0.0).T @ shape.shares
        volume = volume / volume.sum()
        shares = shares * volume
        columns, gradients = shape.cell_matrix @ shares, _gradients(shape, shares)
        mean = shape.homogeneous.vector / shape.homogeneous.mass
        # points are the solid only nearly; together the parts are the whole
        columns += np.outer(mean - columns.sum(axis=1), volume)
        members = [
            _compact(
                np.column_stack((MASS_STD * mean, std * columns, within * gradients))
            )
            for std in PART_STDS
            for within in WITHIN_PART_STDS
        ]
        return cls(
            np.tile(mean, (len(members), 1)),
            np.array(members),
            np.full(len(members), -np.log(len(members))),
        )

    @classmethod
    def _of_freedoms(
        cls, body: InertialParameters, freedoms: dict[float, float]
    ) -> Self:
        G = body_factor(body)
        members = [_about(G, nu) for nu in freedoms]
        return cls(
            np.array([mean for mean, _ in members]),
            np.array([F for _, F in members]),
            np.log(np.array(list(freedoms.values()))),
        )

    def or_any(self, center: Array) -> "PossibleBodies":
        """These, or any other body with the probability `WRONG_SHAPE`."""
        other = PossibleBodies.any(center)
        width = max(self.spread.shape[2], other.spread.shape[2])
        return PossibleBodies(
            np.concatenate((self.means, other.means)),
            np.concatenate([_padded(each.spread, width) for each in (self, other)]),
            np.concatenate(
                (
                    self.log_weight + np.log(1.0 - WRONG_SHAPE),
                    other.log_weight + np.log(WRONG_SHAPE),
                )
            ),
        )


def _gradients(shape: Shape, shares: Array) -> Array:
    """(10, 3 parts) change of the parameters by a linear variation of the density along
    each axis within each part, of one standard deviation of the part's."""
    columns: list[Array] = []
    thin = THIN * float(np.abs(shape.positions).max())
    for share in shares.T:
        mass = float(share.sum()) or 1.0
        off = shape.positions - share @ shape.positions / mass
        size = np.sqrt(share @ (off * off) / mass)
        # across a plane in which all points of a part lie there is nothing but rounding
        along = np.divide(off, size, out=np.zeros_like(off), where=size > thin)
        columns.append(shape.cell_matrix @ (share[:, None] * along))
    return np.column_stack(columns)


def _compact(F: Array) -> Array:
    """(10, 10) factor with the same F F' as F (10, k)."""
    R = np.asarray(np.linalg.qr(F.T, mode="r"))
    found = np.zeros((10, 10))
    found[:, : len(R)] = R.T
    return found


def _padded(spread: Array, width: int) -> Array:
    """F (j, 10, width), with columns of zeros."""
    return np.pad(spread, ((0, 0), (0, 0), (0, width - spread.shape[2])))


def _about(G: Array, nu: float) -> tuple[Array, Array]:
    """Mean (10,) and F (10, 11) of bodies of 1 kg about that of pseudo-inertia G G'."""
    T = PARAMETERS_OF @ congruence(G)
    mean = T @ IDENTITY
    return mean, np.column_stack((MASS_STD * mean, (2.0 / nu) ** 0.5 * T))


def ball_factor(center: Array, radius: float) -> Array:
    """G (4, 4) of 1 kg with this radius of gyration along each axis about `center`."""
    G = np.diag((radius, radius, radius, 1.0))
    G[:3, 3] = center
    return G


def body_factor(body: InertialParameters) -> Array:
    """G (4, 4) with G G' the pseudo-inertia of 1 kg of the body."""
    c = body.center_of_mass
    P = body.pseudo_inertia[:3, :3] / body.mass - np.outer(c, c)
    G = np.eye(4)
    G[:3, :3], G[:3, 3] = np.linalg.cholesky(P), c
    return G


def _com_derivative(c: Array) -> Array:
    """(10, 3) derivative of the parameters of 1 kg by its COM, inertia fixed."""
    derivative = np.zeros((10, 3))
    derivative[1:4] = np.eye(3)
    derivative[4:] = parallel_axis_slopes(c)
    return derivative
