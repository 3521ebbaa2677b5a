"""Weighted least squares by the normal equations of `hefting.ingest.model`, with
undetermined directions left out."""

import numpy as np

from hefting.core.immutable import immutable
from hefting.core.lapack import lapack
from hefting.core.spatial import Array, Mask
from hefting.ingest.drift import HatFunctions
from hefting.ingest.model import Model

UNDETERMINED_EIGENVALUE = 1e-11
"""Eigenvalues of the scaled normal matrix below this share of the largest one count as
zero."""
SAFE_PIVOT_RATIO = 1e-6
"""Squared ratio of the smallest to the largest Cholesky pivot above which the normal
matrix is inverted directly.

Above it no eigenvalue comes near `UNDETERMINED_EIGENVALUE`, unless many of some hundred
unknowns lose rank together.
"""


@immutable
class Solution:
    """Solution of weighted normal equations."""

    core: Array
    """(core,) parameters, then changes of offset and tilt: see
    `hefting.ingest.model.Layout`"""
    bias: Array
    """(n, 6) at the knots [N, N m]"""
    inverse: Array
    """(core + 6 n, core + 6 n) of the normal matrix; zero where undetermined"""
    undetermined: Mask
    """(core + 6 n,) unknowns that the data leave undetermined"""


def solve(
    model: Model, phi: Array, weights: Array, scale: Array, hats: HatFunctions
) -> Solution:
    """Weighted least squares of the model that is linear about parameters phi.

    Parameters
    ----------
    model : with the known rows of B blocks.
    phi : (10,) parameters about which the columns of offset and tilt are evaluated.
    weights : (B,) of the blocks' squared residuals.
    scale : (2,) standard deviations of force [N] and torque [N m] residuals.
    hats : the functions of time of which the bias is composed.
    """
    maps, known = model.maps(phi), model.known
    inverse_variance = np.repeat(scale, 3) ** -2.0
    weighted = known * weights[:, None]
    gram = weighted.T @ known
    p, n = maps.shape[2], hats.n
    N, b = np.empty((p + 6 * n, p + 6 * n)), np.empty(p + 6 * n)

    by_channel = maps.transpose(1, 0, 2)  # (6, z, p)
    gram_columns = gram @ by_channel
    blocks = by_channel.transpose(0, 2, 1) @ gram_columns
    N[:p, :p] = (blocks * inverse_variance[:, None, None]).sum(axis=0)
    wrench = np.arange(len(gram) - 6, len(gram))
    b[:p] = (gram_columns[np.arange(6), wrench] * inverse_variance[:, None]).sum(axis=0)

    projected = hats.project(weighted)  # (n, z)
    cross = projected @ by_channel * inverse_variance[:, None, None]
    N[p:, :p] = cross.transpose(1, 0, 2).reshape(6 * n, p)
    N[:p, p:] = N[p:, :p].T
    b[p:] = (projected[:, -6:] * inverse_variance).ravel()

    bias_gram = np.einsum("ij,cd->icjd", hats.gram(weights), np.diag(inverse_variance))
    N[p:, p:] = bias_gram.reshape(6 * n, 6 * n)
    inverse, undetermined = invert(N)
    solution = inverse @ b
    return Solution(solution[:p], solution[p:].reshape(n, 6), inverse, undetermined)


def invert(N: Array) -> tuple[Array, Mask]:
    """Inverse of a positive semidefinite matrix (q, q) in its determined directions,
    and a mask (q,) of the others.

    The unknowns are scaled to a unit diagonal first. An unknown with a component in a
    direction that is left out counts as undetermined.
    """
    length = np.sqrt(np.maximum(N.diagonal(), 0.0))
    usable = length > 1e-150
    length = np.where(usable, length, 1.0)
    scaled = N / length / length[:, None]
    factor, failed = lapack.dpotrf(scaled, lower=1)
    pivots = factor.diagonal()
    if (
        not failed
        and usable.all()
        and (pivots.min() / pivots.max()) ** 2 > SAFE_PIVOT_RATIO
    ):
        lower = lapack.dpotri(factor, lower=1)[0]  # zero above the diagonal
        inverse = lower + lower.T
        np.fill_diagonal(inverse, lower.diagonal())
        return inverse / length / length[:, None], np.zeros(len(N), dtype=bool)
    return _invert_semidefinite(scaled, length, usable)


def _invert_semidefinite(
    scaled: Array, length: Array, usable: Mask
) -> tuple[Array, Mask]:
    """The same as `invert`, by eigenvalues of the scaled matrix (q, q)."""
    values, vectors = np.linalg.eigh(scaled)
    determined = np.zeros(len(values), dtype=bool)
    if values[-1] > 0.0:
        determined = values > UNDETERMINED_EIGENVALUE * values[-1]
    kept = vectors[:, determined] / np.sqrt(values[determined])
    inverse = (kept @ kept.T) / length / length[:, None]
    undetermined = (
        np.asarray((vectors[:, ~determined] ** 2).sum(axis=1) > 1e-4) | ~usable
    )
    inverse[~usable] = 0.0
    inverse[:, ~usable] = 0.0
    return inverse, undetermined
