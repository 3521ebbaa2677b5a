"""Moments: the sums over any number of samples that estimators need, as a 22 x 22
triangular factor.

Every estimator works on sums over samples of quadratic forms in the features x of
`hefting.core.regressor`. The sums depend on the K x 22 matrix X of all features only
through X'X = R'R, so the rows of the triangular factor R serve as 22 *virtual samples*:
regressors, noise weights and bias columns built from them give the same sums. R is
updated by orthogonal transformations without forming X'X, which keeps full precision
(Golub & Van Loan, *Matrix Computations*, sec. 6.5).
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Self

import numpy as np

from hefting.core.errors import InputError
from hefting.core.lapack import lapack
from hefting.core.measurements import Measurements
from hefting.core.regressor import (
    FEATURES,
    ONE,
    WRENCH,
    features,
    full_rows,
    reduced_rows,
)
from hefting.core.spatial import Array

BLOCK = 2048
"""Number of rows folded at once, to bound the memory."""
REFLECTORS = 8
"""Number of Householder reflectors that LAPACK applies together; more cost more than
they save for so few columns."""


def triangular(rows: Array, *, overwrite: bool = False) -> Array:
    """Upper triangular R (n, n) with R'R = rows' rows, for `rows` (k, n), which
    `overwrite` allows to be overwritten."""
    k, n = rows.shape
    if k < n:
        rows = np.vstack((rows, np.zeros((n - k, n))))
    factor = lapack.dgeqrf(rows, overwrite_a=overwrite)[0][:n]
    return factor * _UPPER[n] if n in _UPPER else np.triu(factor)


def folded(factor: Array, rows: Array) -> Array:
    """Triangular factor (n, n) with `rows` (k, n) added."""
    if len(rows) <= BLOCK:  # as single samples are, without the time of a slice
        return lapack.dtpqrt(0, REFLECTORS, factor, rows)[0]
    for first in range(0, len(rows), BLOCK):
        factor = folded(factor, rows[first : first + BLOCK])
    return factor


_UPPER = {n: np.triu(np.ones((n, n))) for n in (5, 11, 17, FEATURES)}


def _equations(regressors: Array) -> Array:
    unit = np.zeros((FEATURES, 6, 7))
    unit[ONE, :, :6] = np.eye(6)
    unit[WRENCH, :, 6] = np.eye(6)
    columns = np.concatenate((unit[:, :, :6], regressors, unit[:, :, 6:]), axis=2)
    return np.ascontiguousarray(columns.transpose(2, 1, 0))


FULL_EQUATIONS = _equations(full_rows(np.eye(FEATURES)))
"""(17, 6, 22): columns [bias | full regressor | wrench] of the six equations, linear in
a sample's features."""
REDUCED_EQUATIONS = _equations(reduced_rows(np.eye(FEATURES))[:, :, :4])
"""(11, 6, 22): the same with the reduced regressor, without its six zero columns."""


@dataclass(frozen=True, eq=False)
class Moments:
    """Triangular factor of the features of samples, with their number and time span.

    Immutable: `fold` and `merge` return new values. Folding costs the same however many
    samples went before.

    Examples
    --------
    >>> moments = hefting.Moments.of(measurements[:500])
    >>> moments.merge(hefting.Moments.of(measurements[500:]), one_bias=True).samples
    1000
    """

    factor: Array
    """(22, 22) upper triangular; its rows are the virtual samples."""
    samples: int = 0
    """Number of samples."""
    start: float = np.inf
    """Time of the first sample [s]."""
    end: float = -np.inf
    """Time of the last sample [s]."""

    @classmethod
    def empty(cls) -> Self:
        """Without samples."""
        return cls(np.zeros((FEATURES, FEATURES)))

    @classmethod
    def of(cls, measurements: Measurements) -> Self:
        """Moments of `measurements` alone."""
        return cls.empty().fold(measurements)

    def fold(self, measurements: Measurements, scale: Array | None = None) -> Self:
        """With the samples of `measurements` added, their equations multiplied by
        `scale` (K,) if given."""
        return self.fold_features(features(measurements), measurements.time, scale)

    def fold_features(self, x: Array, time: Array, scale: Array | None = None) -> Self:
        """With samples of features `x` (K, 22) at `time` (K,) added."""
        if len(time) == 0:
            return self
        if scale is not None:
            x = x * scale[:, None]
        if len(x) == 1:
            first = last = float(time[0])
        else:
            first, last = float(np.minimum.reduce(time)), float(np.maximum.reduce(time))
        start, end = min(self.start, first), max(self.end, last)
        factor = folded(self.factor, x)
        return type(self)(factor, self.samples + len(time), start, end)

    def merge(self, other: Moments, *, one_bias: bool = False) -> Self:
        """Moments of both sets of samples together, in whichever order and on whichever
        machine they were folded.

        Parameters
        ----------
        other : moments of other samples of the same object, in the same sensor frame.
        one_bias : that the wrench of both has the same constant bias, or none, as in
            parts of one recording.

        Raises `InputError` where that is not said and both may have a bias of their
        own: a bias found in the merged samples would be that of neither.
        """
        if not one_bias and self.may_hold_bias and other.may_hold_bias:
            raise InputError(
                "each of the moments may hold a wrench bias of its own",
                fix="merge `without_bias()` of each, or say one_bias=True of parts of "
                "one recording",
            )
        factor = triangular(np.vstack((self.factor, other.factor)))
        start, end = min(self.start, other.start), max(self.end, other.end)
        return type(self)(factor, self.samples + other.samples, start, end)

    def scaled(self, weight: float) -> Self:
        """With every weight multiplied by `weight`."""
        factor = weight**0.5 * self.factor
        return type(self)(factor, self.samples, self.start, self.end)

    def without_bias(self) -> Self:
        """The moments with the constant bias eliminated, which may be merged with those
        of other recordings.

        The column of ones is that of the bias in each of the six equations, so to take
        it out of the features takes the best bias out of any of their equations.
        """
        factor = np.zeros((FEATURES, FEATURES))
        columns = np.column_stack((self.ones, self.factor[:, :ONE]))
        factor[:ONE, :ONE] = triangular(columns)[1:, 1:]
        return type(self)(factor, self.samples, self.start, self.end)

    @property
    def may_hold_bias(self) -> bool:
        """Whether there are samples from which the bias was not eliminated."""
        return bool(self.ones.any())

    def factor_of(self, equations: Array) -> Array:
        """Triangular factor (c, c) of all samples' `equations` (c, 6, 22), such as
        columns of `FULL_EQUATIONS`."""
        rows = equations.reshape(-1, FEATURES).dot(self.factor.T)
        return triangular(rows.reshape(len(equations), -1).T, overwrite=True)

    @property
    def duration(self) -> float:
        """Time between the first and the last sample [s]."""
        return max(0.0, self.end - self.start)

    @cached_property
    def full(self) -> Array:
        """Full regressors (22, 6, 10) of the virtual samples."""
        return full_rows(self.factor)

    @cached_property
    def reduced(self) -> Array:
        """Reduced regressors (22, 6, 10) of the virtual samples."""
        return reduced_rows(self.factor)

    @property
    def wrench(self) -> Array:
        """Wrenches (22, 6) of the virtual samples."""
        return self.factor[:, WRENCH]

    @property
    def ones(self) -> Array:
        """(22,) the feature 1 of each virtual sample: the scale of its bias column."""
        return self.factor[:, ONE]
