"""Densities: how the density of a real thing may vary inside a known shape, and what
that does to the ten parameters.

About the homogeneous centre of mass, for 1 kg, a member of the mixture gives phi, the
mass apart, the covariance

    Q = sigma² (Q_l + `WITHIN_CELL_VARIANCE` Qw) + delta² Qd

- Q_l = M (C - C 1 1' C / 1' C 1) M': between cells, C_ij = v_i v_j exp(-d_ij² / 2 l²),
  l a share of the diagonal of the bounding box; M (10, cells) are the means of a_f in
  each.
- Qw: within cells, the covariance of a_f, scaled to the inertia of Q_l at a quarter.
- Qd: a shell or a core. With r_f the rank of the voxel's depth, 0 at the surface and 1
  in the middle, the density has random shares of the Legendre polynomials P1 and, with
  `CURVED_SHELL_VARIANCE` of the variance, P2:
  Qd = d1 d1' + `CURVED_SHELL_VARIANCE` d2 d2',
  d1 = sqrt(3) sum v_f a_f P1(2 r_f - 1),  d2 = sqrt(5) sum v_f a_f P2(2 r_f - 1).

The block of the inertia, given the centre of mass, is scaled by (kappa / sigma)²: a
thing may have its centre of mass in its middle and yet be far from uniform, as a
dumbbell is.
"""

import numpy as np

from hefting.core.spatial import Array
from hefting.estimators.bayes.voxels import Voxels

MEMBERS = np.array(
    (
        (0.03, 0.12, 1, 0.02, 1, 0.006),
        (0.03, 0.25, 0, 0.7, 0, 0.009),
        (0.03, 0.25, 0, 0.7, 1, 0.031),
        (0.03, 0.25, 0, 1, 0, 0.019),
        (0.03, 0.5, 0, 0.02, 0, 0.133),
        (0.03, 0.5, 0, 0.02, 1, 0.038),
        (0.03, 0.5, 0, 0.7, 0, 0.066),
        (0.03, 0.5, 0, 1, 0, 0.022),
        (0.03, 0.5, 0.3, 0.1, 0, 0.017),
        (0.03, 0.5, 0.3, 0.2, 0, 0.036),
        (0.03, 0.5, 1, 0.02, 1, 0.008),
        (0.03, 0.5, 1.7, 0.05, 0, 0.019),
        (0.1, 0.5, 0.3, 0.2, 0, 0.005),
        (0.1, 0.5, 1, 0.05, 0, 0.007),
        (0.1, 0.5, 1.7, 0.02, 0, 0.006),
        (0.1, 0.5, 1.7, 0.05, 0, 0.007),
        (0.2, 0.25, 0, 0.2, 0, 0.012),
        (0.2, 0.25, 1, 0.1, 0, 0.007),
        (0.4, 0.5, 1.7, 0.1, 0, 0.004),
        (0.7, 0.25, 0, 0.05, 0, 0.007),
        (0.7, 0.25, 0, 0.1, 0, 0.014),
        (0.7, 0.25, 0, 0.2, 0, 0.010),
        (0.7, 0.25, 0, 0.4, 0, 0.066),
        (0.7, 0.25, 0.3, 0.4, 0, 0.029),
        (0.7, 0.25, 1, 0.4, 0, 0.005),
        (0.7, 0.25, 1, 0.7, 0, 0.029),
        (0.7, 0.5, 1, 0.4, 0, 0.035),
        (1, 0.25, 0.3, 1, 0, 0.066),
        (1, 0.25, 0.3, 1, 1, 0.030),
        (1, 0.25, 1, 0.7, 0, 0.008),
        (1, 0.25, 1.7, 1.5, 0, 0.006),
        (1, 0.5, 1, 0.7, 1, 0.013),
        (1.4, 0.12, 0, 1.5, 0, 0.044),
        (1.4, 0.12, 0.3, 1, 0, 0.028),
        (1.4, 0.12, 0.3, 1.5, 0, 0.010),
        (1.4, 0.25, 0, 2.5, 0, 0.011),
        (1.4, 0.25, 0.3, 1.5, 1, 0.009),
        (1.4, 0.25, 1, 1, 0, 0.079),
        (1.4, 0.25, 1, 1, 1, 0.017),
        (2, 0.12, 0, 2.5, 1, 0.032),
        (20, 0.5, 0, 20, 1, 0.001),
    )
)
"""(j, 6) members of the mixture: sigma, relative standard deviation of the density; l,
its correlation length over the diagonal of the bounding box; delta, relative difference
in density between core and shell; kappa, sigma of the inertia given the COM; whether
the member allows for a typical error of the pose; prior probability.

Found by expectation maximisation over 1,500 candidates, of which those of least weight
were left out one after the other: the likelihood of 360 bodies of twelve classes
(`benchmarks.bodies`, seeds 60000 and up), once in their place, with four fifths of the
weight, and once 5 mm and 5 degrees beside it, seen with three levels of noise.
Dumbbells count six times, inserts five, lumps and uniform bodies four, shells and
hammers twice, the others once or less: what is rare or looks uniform and is not would
else be missed. The last, of sigma 20, is for shapes that are not the object's at
all."""
OFF_CENTRE_GROWTH = 0.6
"""The second moment about the homogeneous centre of mass is thought to be larger by
this times c c', c being the way to the real one: what is heavy at one end is no
nearer to the middle. Of bodies as above it is 0.4 to 0.7, of hammers 0.67."""
LENGTHS = tuple(sorted(set(MEMBERS[:, 1].tolist())))
"""Correlation lengths of the members, as shares of the diagonal."""
REFERENCE_LENGTH = 0.25
"""Correlation length whose inertia sets that of the variation within cells."""
WITHIN_CELL_VARIANCE = 0.2
"""Variance of the density within cells, relative to that between them."""
CURVED_SHELL_VARIANCE = 0.3
"""Variance of the second Legendre polynomial of the depth rank, relative to that of the
first."""
TENSOR_MULTIPLICITY = np.array((1.0, 2.0, 2.0, 1.0, 2.0, 1.0))
"""(6,) number of times each entry xx, xy, xz, yy, yz, zz occurs in the tensor."""


def member_covariances(voxels: Voxels, diagonal: float, units: Array) -> Array:
    """(j, 9, 9) Q of each of `MEMBERS` for 1 kg about the homogeneous COM, without the
    mass, over products of `units` (9,); `diagonal` [m] is that of the bounding box."""
    between = {
        length: between_cells(voxels, length * diagonal)
        for length in {*LENGTHS, REFERENCE_LENGTH}
    }
    centred = voxels.parameters[1:] - voxels.mean[1:, None]
    Qw = (centred * voxels.volumes) @ centred.T
    within = float(Qw.diagonal()[3:] @ TENSOR_MULTIPLICITY)
    if within:
        reference = between[REFERENCE_LENGTH].diagonal()[3:] @ TENSOR_MULTIPLICITY
        Qw = Qw * (float(reference) / within)
    r = 2.0 * voxels.depth_rank - 1.0
    polynomials = np.stack(
        (3.0**0.5 * r, (5.0 * CURVED_SHELL_VARIANCE) ** 0.5 * (1.5 * r * r - 0.5))
    )
    d = voxels.parameters[1:] @ (voxels.volumes * polynomials).T
    Ql = np.stack([between[length] for length in LENGTHS])
    sigma, _, delta, kappa = MEMBERS[:, :4].T[:, :, None, None]
    index = [LENGTHS.index(length) for length in MEMBERS[:, 1].tolist()]
    Q = sigma**2 * (Ql[index] + WITHIN_CELL_VARIANCE * Qw) + delta**2 * (d @ d.T)
    return _stiffened(Q / np.outer(units, units), (kappa / sigma) ** 2)


def between_cells(voxels: Voxels, reach: float) -> Array:
    """Q_l (9, 9) for 1 kg about the homogeneous COM, without the mass; `reach` [m] is
    the correlation length."""
    v, M, x = voxels.cell_shares, voxels.cells[1:], voxels.cell_positions
    square = ((x[:, None] - x[None]) ** 2).sum(axis=2)
    C = np.outer(v, v) * np.exp(-0.5 * square / reach**2)
    row = C.sum(axis=1)
    Mr = M @ row
    return M @ C @ M.T - np.outer(Mr, Mr) / row.sum()


def _stiffened(Q: Array, factor: Array) -> Array:
    """Q (j, 9, 9) with the covariance of the inertia, given the centre of mass, times
    `factor` (j, 1, 1)."""
    values, vectors = np.linalg.eigh(Q[:, :3, :3])
    inverse = 1.0 / np.where(values > 1e-9 * values[:, -1:], values, np.inf)
    half = Q[:, 3:, :3] @ (vectors * np.sqrt(inverse)[:, None, :])
    explained = half @ half.transpose(0, 2, 1)
    Q[:, 3:, 3:] = explained + factor * (Q[:, 3:, 3:] - explained)
    return Q
