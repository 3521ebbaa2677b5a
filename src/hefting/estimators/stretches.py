"""Stretches: the samples in four to eight consecutive parts, so that they can be
compared with each other."""

from dataclasses import dataclass, field
from itertools import pairwise
from typing import Self

import numpy as np

from hefting.core.moments import triangular
from hefting.core.regressor import FEATURES
from hefting.core.spatial import Array
from hefting.estimators.timescales import folded

MOST_STRETCHES = 8
"""Number of stretches at which neighbours are joined in pairs."""
FIRST_STRETCH_LENGTH = 64
"""Number of samples in a stretch, before any are joined."""


def _empty_factor() -> Array:
    return np.zeros((FEATURES, FEATURES))


@dataclass(frozen=True, eq=False)
class Stretches:
    """Triangular factors of consecutive stretches of one length, and of the one that is
    being filled. Immutable."""

    factors: tuple[Array, ...] = ()
    """(22, 22) each, of the complete ones"""
    counts: tuple[int, ...] = ()
    """samples in each"""
    length: int = FIRST_STRETCH_LENGTH
    """samples of a complete one"""
    open_factor: Array = field(default_factory=_empty_factor)
    """(22, 22) of the one being filled"""
    open_count: int = 0
    """samples in it"""

    def fold(self, rows: Array) -> Self:
        """With the features `rows` (k, 22) of the samples that follow."""
        stretches, first = self, 0
        while first < len(rows):
            taken = min(stretches.length - stretches.open_count, len(rows) - first)
            factor = folded(stretches.open_factor, rows[first : first + taken])
            stretches = stretches._with_open(factor, stretches.open_count + taken)
            first += taken
        return stretches

    def merge(self, other: "Stretches") -> Self:
        """With those of other samples; what either was filling is complete, however
        short."""
        parts = [
            *zip(self.factors, self.counts, strict=True),
            (self.open_factor, self.open_count),
        ]
        parts += [
            *zip(other.factors, other.counts, strict=True),
            (other.open_factor, other.open_count),
        ]
        parts = [part for part in parts if part[1]]
        # the two neighbours that are shortest together
        while len(parts) >= MOST_STRETCHES:
            sizes = [first[1] + second[1] for first, second in pairwise(parts)]
            at = int(np.argmin(sizes))
            parts[at : at + 2] = [_join(parts[at], parts[at + 1])]
        length = max(self.length, other.length)
        return type(self)(
            tuple(part[0] for part in parts), tuple(part[1] for part in parts), length
        )

    def scaled(self, weight: float) -> Self:
        """Of the same samples, each of so many times its weight."""
        scale = weight**0.5
        return type(self)(
            tuple(scale * factor for factor in self.factors),
            self.counts,
            self.length,
            scale * self.open_factor,
            self.open_count,
        )

    @property
    def parts(self) -> list[tuple[Array, int]]:
        """Factor and samples of each; what is being filled belongs to the last one
        until it is half a stretch."""
        parts = list(zip(self.factors, self.counts, strict=True))
        rest = (self.open_factor, self.open_count)
        if self.open_count >= 0.5 * self.length:
            return [*parts, rest]
        return (
            [*parts[:-1], _join(parts[-1], rest)]
            if parts and self.open_count
            else parts
        )

    def _with_open(self, factor: Array, count: int) -> Self:
        if count < self.length:
            return type(self)(self.factors, self.counts, self.length, factor, count)
        parts = [*zip(self.factors, self.counts, strict=True), (factor, count)]
        length = self.length
        if len(parts) >= MOST_STRETCHES:
            parts = [
                _join(parts[i], parts[i + 1]) for i in range(0, len(parts) - 1, 2)
            ] + parts[len(parts) // 2 * 2 :]
            length *= 2
        return type(self)(
            tuple(part[0] for part in parts), tuple(part[1] for part in parts), length
        )


def _join(first: tuple[Array, int], second: tuple[Array, int]) -> tuple[Array, int]:
    return triangular(np.concatenate((first[0], second[0]))), first[1] + second[1]
