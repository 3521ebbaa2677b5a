"""WhitenedState: what is known of the ten parameters as equations of unit noise,
whatever sensor they came from.

Offsets, frictions and whatever else was unknown are eliminated, and the noise was found
beforehand: A phi = b + e, e of unit variance, holds all that is left. Equations of
several sensors simply stand below one another.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import NoReturn, Self

import numpy as np
from numpy.typing import ArrayLike

from hefting.core.errors import InputError
from hefting.core.measurements import Measurements
from hefting.core.moments import triangular
from hefting.core.spatial import Array, frozen

_MASS_LAST = np.array((*range(1, 10), 0, 10))


@dataclass(frozen=True, eq=False)
class WhitenedState:
    """Equations of the ten parameters, of unit noise.

    It is a state of the estimators that take the parameters' equations alone (`Bayes`,
    `GEO`, `LMI`, `OLS`, `PMD`), with ``bias="none"``.
    """

    factor: Array
    """(11, 11) triangular [A | b]"""
    samples: int
    """Samples it was made from."""
    duration: float
    """Time between the first and the last of them [s]."""
    noise: float = 1.0
    """Standard deviation [N or N m] of a typical equation before it was divided by it:
    methods that weigh residuals against something else see them times it."""

    def __post_init__(self):
        factor = frozen(self.factor)
        if factor.shape != (11, 11) or not np.isfinite(factor).all():
            raise InputError(
                f"equations of ten parameters are a finite factor (11, 11), not "
                f"{factor.shape}"
            )
        object.__setattr__(self, "factor", factor)

    @classmethod
    def of_information(
        cls,
        precision: ArrayLike,
        shift: ArrayLike,
        samples: int,
        duration: float,
        noise: float = 1.0,
    ) -> Self:
        """Of a Gaussian likelihood exp(-½ phi' precision phi + shift' phi), with
        precision (10, 10) and shift (10,).

        Combinations of parameters without information have equations of zeros.
        """
        P = np.asarray(precision, dtype=float)
        scale = np.sqrt(np.maximum(P.diagonal(), 0.0))
        scale[scale <= 1e-13 * scale.max(initial=0.0)] = np.inf
        values, vectors = np.linalg.eigh(P / np.outer(scale, scale))
        kept = values > 1e-12 * values[-1]
        unit = vectors[:, kept] / np.sqrt(values[kept])
        right = unit.T @ (np.asarray(shift, dtype=float) / scale)
        finite = np.where(np.isfinite(scale), scale, 0.0)
        left = (vectors[:, kept] * np.sqrt(values[kept])).T * finite
        rows = np.column_stack((left, right))
        return cls(triangular(rows), samples, duration, noise)

    def stacked(self, other: WhitenedState) -> Self:
        """Of the equations of both: of one object, in one frame, by independent
        sensors."""
        return type(self)(
            triangular(np.vstack((self.factor, other.factor))),
            self.samples + other.samples,
            max(self.duration, other.duration),
            self.noise,
        )

    @property
    def is_empty(self) -> bool:
        """Whether no sample was seen."""
        return self.samples == 0

    @cached_property
    def mass_last(self) -> Array:
        """(10, 11) the same equations; in the last of them the mass stands alone."""
        return triangular(self.factor[:, _MASS_LAST])[:10, np.argsort(_MASS_LAST)]

    def fold(self, measurements: Measurements, weight: Array | float = 1.0) -> NoReturn:
        """Raises `InputError`: the samples are gone, and their noise was found."""
        raise InputError(
            "the noise of these equations was found already",
            fix="fold samples into the moments they came from",
        )
