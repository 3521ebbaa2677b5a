"""Covariance of the ten parameters of a body, infinite where open: its check and its
decomposition."""

from typing import NamedTuple, Self

import numpy as np

from hefting.core.errors import InputError
from hefting.core.spatial import Array, Mask

NEGATIVE = 1e-6
"""Largest negative eigenvalue that is rounding, relative to the largest one, for
standard deviations scaled to 1."""
NOTHING = 1e-12
"""Eigenvalue, relative to the largest one, below which there is no variance."""


class Covariance(NamedTuple):
    """A covariance (10, 10) as ``D V diag(values) V' D``, with the standard deviations
    on the diagonal of D, zero for open parameters."""

    size: Array
    """(10,) standard deviations, 1 for none"""
    values: Array
    """(10,) eigenvalues, not negative, smallest first"""
    vectors: Array
    """(10, 10) eigenvectors by columns"""
    open: Mask
    """(10,) parameters that are not determined at all"""

    @classmethod
    def of(cls, covariance: Array) -> Self:
        """From a covariance (10, 10) with infinite diagonal entries for open
        parameters. Raises `InputError` for what is no covariance."""
        open_ = np.isinf(covariance.diagonal())
        known = np.where(open_ | open_[:, None], 0.0, covariance)
        if not np.isfinite(known).all() or (covariance.diagonal() < 0.0).any():
            what = "the estimate's covariance has a negative or missing variance"
            raise InputError(what, fix="identify it again")
        size = np.where(known.diagonal() > 0.0, np.sqrt(known.diagonal()), 1.0)
        scaled = known / size / size[:, None]
        values, vectors = np.linalg.eigh(0.5 * (scaled + scaled.T))
        if (
            values[0] < -NEGATIVE * max(values[-1], 1.0)
            or np.abs(scaled - scaled.T).max() > NEGATIVE
        ):
            what = "the estimate's covariance is not one: not symmetric or not positive"
            raise InputError(what, fix="identify it again")
        vectors[known.diagonal() == 0.0] = 0.0  # they are zero up to rounding
        return cls(size, np.maximum(values, 0.0), vectors, open_)

    @property
    def root(self) -> Array:
        """(10, 10) with ``root @ root.T`` the covariance."""
        return self.size[:, None] * self.vectors * np.sqrt(self.values)

    @property
    def information(self) -> Array:
        """(10, 10) inverse of the covariance; zero in directions without variance."""
        some = self.values > NOTHING * self.values[-1]
        ways = self.vectors[:, some] / self.size[:, None]
        return (ways / self.values[some]) @ ways.T
