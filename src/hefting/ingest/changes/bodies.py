"""Bodies: one joint fit of several bodies, each in intervals of its own, beside one bias
that drifts smoothly.

The normal equations are composed of those of the intervals, so that another assignment
of bodies to intervals costs one small solution.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from hefting.core.spatial import Array
from hefting.ingest.changes.cells import Cells
from hefting.ingest.changes.partition import (
    LARGEST_BIAS,
    LARGEST_PARAMETERS,
    Interval,
)

PARAMETERS = len(LARGEST_PARAMETERS)
DRIFT_FUNCTIONS = 4
"""Polynomials of time of which the drift of the bias is composed, while changes are
looked for: up to third degree."""


def drift_functions(time: Array, number: int) -> Array:
    """(M, number) Legendre polynomials over the times (M,) [s]."""
    span = max(float(time[-1] - time[0]), 1e-12)
    return np.polynomial.legendre.legvander(
        2.0 * (time - time[0]) / span - 1.0, number - 1
    )


@dataclass(frozen=True, eq=False)
class JointFit:
    """Bodies and bias by least squares in `intervals` (L of them)."""

    bodies: Array
    """(n, 10) parameters, with the sign of the recorded wrench"""
    covariance: Array
    """(n, 10, 10) theirs, for white residuals of the size of the cells' scale"""
    squares: Array
    """(L, 2) sum of the squared residuals of force and torque in each interval, in units
    of the cells' scale"""
    equations: Array
    """(L,) of the force, and as many of the torque, less those that the unknowns take"""

    combinations: tuple[Array | None, ...]
    """(L) of each interval with a body the combination of the columns of
    `JointModel.rows` that is the residual"""

    @property
    def variance(self) -> Array:
        """(2,) of the residuals of force and torque."""
        return self.squares.sum(axis=0) / max(float(self.equations.sum()), 1.0)

    @property
    def variances(self) -> Array:
        """(L, 2) of the residuals in each interval."""
        return self.squares / np.maximum(self.equations, 1.0)[:, None]


class JointModel:
    """Normal equations of intervals of cells, for any assignment of bodies to them."""

    def __init__(
        self,
        cells: Cells,
        intervals: list[Interval],
        drift: int = DRIFT_FUNCTIONS,
    ) -> None:
        self.cells, self.intervals, self.drift = cells, intervals, drift
        T = drift_functions(cells.time, drift)
        unit = 1.0 / np.repeat(cells.scale, 3)
        bias = np.einsum("mn,cd,c->mcdn", T, np.eye(6), unit)
        self.rows = np.concatenate(
            (
                cells.regressor,
                bias.reshape(len(T), 6, 6 * drift),
                cells.whitened[:, :, None],
            ),
            axis=2,
        )
        self.ridge_of_bias = np.repeat(LARGEST_BIAS**-2.0, drift)
        grams = []
        for begin, end in intervals:
            rows = self.rows[begin:end].reshape(end - begin, 2, 3, -1)
            flat = np.swapaxes(rows, 0, 1).reshape(2, -1, rows.shape[-1])
            grams.append(np.swapaxes(flat, 1, 2) @ flat)
        self.grams = np.array(grams)

    @cached_property
    def lengths(self) -> Array:
        """(L,) cells of the intervals."""
        return np.array([end - begin for begin, end in self.intervals], dtype=float)

    def fit(self, labels: list[int]) -> JointFit:
        """The fit with body `labels[i]` in interval i; -1 is for none: the interval is
        left out."""
        names = sorted({label for label in labels if label >= 0})
        n, p, q = len(names), PARAMETERS, 6 * self.drift
        size = n * p + q
        normal, right = np.zeros((size, size)), np.zeros(size)
        places = []
        for gram, label in zip(self.grams, labels, strict=True):
            first = names.index(label) * p if label >= 0 else 0
            at = np.concatenate((np.arange(first, first + p), np.arange(n * p, size)))
            places.append(at)
            if label >= 0:
                both = gram.sum(axis=0)
                normal[np.ix_(at, at)] += both[:-1, :-1]
                right[at] += both[:-1, -1]
        ridge = np.concatenate((np.tile(LARGEST_PARAMETERS**-2.0, n), self.ridge_of_bias))
        inverse = np.linalg.inv(normal + np.diag(ridge))
        solution = inverse @ right
        squares = np.zeros((len(labels), 2))
        combinations: list[Array | None] = [None] * len(labels)
        spent = np.zeros(len(labels))
        for i, (gram, at, label) in enumerate(
            zip(self.grams, places, labels, strict=True)
        ):
            if label < 0:
                continue
            combinations[i] = x = np.append(-solution[at], 1.0)
            squares[i] = np.maximum(np.einsum("i,gij,j->g", x, gram, x), 0.0)
            spent[i] = np.sum(inverse[np.ix_(at, at)] * gram.sum(axis=0)[:-1, :-1])
        used = np.array([label >= 0 for label in labels])
        equations = np.where(used, 3.0 * self.lengths - 0.5 * spent, 0.0)
        blocks = [slice(i * p, i * p + p) for i in range(n)]
        return JointFit(
            solution[: n * p].reshape(n, p),
            np.array([inverse[b, b] for b in blocks]),
            squares,
            equations,
            tuple(combinations),
        )

    def residuals(self, fit: JointFit) -> Array:
        """(K, 6) residuals of the cells of the intervals with a body, in order, in units
        of the cells' scale."""
        parts = [
            self.rows[begin:end] @ x
            for (begin, end), x in zip(self.intervals, fit.combinations, strict=True)
            if x is not None
        ]
        return np.concatenate(parts)
