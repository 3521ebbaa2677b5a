"""TorqueScales: moments of joint torques at each time scale, from which the noise and
its colour are found after the samples are gone.

Rows that follow one another are turned into their Haar coefficients: differences of
neighbours, then of averages of two, of four ..., and what is left in the end. The
transform is orthonormal, so that the factors of all scales together are those of the
rows; and where the noise is coloured, its coefficients at different scales are nearly
independent, each scale with a variance of its own (Wornell 1993). So weights by scale
are generalised least squares, and intervals allow for the colour.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Self

import numpy as np

from hefting.core.errors import InputError
from hefting.core.spatial import Array, Mask
from hefting.core.torque_moments import TorqueMoments, merged
from hefting.torques.equations import Rows

LEVELS = 7
"""Of differences; the last is of 2^6 and 2^6 rows, 0.64 s and 0.64 s at 100 Hz."""
HALF = 0.5**0.5


@dataclass(frozen=True, eq=False)
class TorqueScales:
    """Of the Haar coefficients of all rows: `LEVELS` of differences, from the shortest,
    and of what is left."""

    levels: tuple[TorqueMoments, ...]

    @classmethod
    def empty(cls, joints: int, own: int, arm: int = 0) -> Self:
        """Arguments as of `TorqueMoments.empty`."""
        none = TorqueMoments.empty(joints, own, arm)
        return cls((none,) * (LEVELS + 1))

    def fold(self, rows: Rows) -> Self:
        """With rows that follow one another in time, none before or after them."""
        values = rows.values * rows.used[:, :, None]
        left, share = _padded(values), _padded(rows.used.astype(float))
        levels = list(self.levels)
        for level in range(LEVELS):
            pairs = left.reshape(-1, 2, *left.shape[1:])
            each = share.reshape(-1, 2, share.shape[1])
            difference = HALF * (pairs[:, 0] - pairs[:, 1])
            left, share = HALF * (pairs[:, 0] + pairs[:, 1]), 0.5 * each.sum(axis=1)
            # white noise has the variance `share` in each coefficient
            levels[level] = _added(levels[level], difference, share)
        levels[-1] = _added(levels[-1], left, share)
        levels[-1] = replace(
            levels[-1],
            samples=levels[-1].samples + len(rows.time),
            start=min(levels[-1].start, float(rows.time.min(initial=np.inf))),
            end=max(levels[-1].end, float(rows.time.max(initial=-np.inf))),
        )
        return type(self)(tuple(levels))

    def merge(self, other: TorqueScales) -> Self:
        """As `TorqueMoments.merge`."""
        if len(self.levels) != len(other.levels):
            raise InputError("moments of different time scales do not merge")
        pairs = zip(self.levels, other.levels, strict=True)
        return type(self)(tuple(a.merge(b) for a, b in pairs))

    @cached_property
    def whole(self) -> TorqueMoments:
        """Of all rows, as of white noise."""
        return merged(self.levels)

    @property
    def counts(self) -> Array:
        """(LEVELS + 1, n) coefficients that count."""
        return np.array([each.counts for each in self.levels])

    @property
    def samples(self) -> int:
        """Rows folded in."""
        return self.levels[-1].samples


def _added(moments: TorqueMoments, rows: Array, share: Array) -> TorqueMoments:
    return replace(moments.fold_rows(rows), counts=moments.counts + share.sum(axis=0))


def _padded(values: Array) -> Array:
    """To a whole number of the longest blocks."""
    more = -len(values) % 2**LEVELS
    return np.concatenate((values, np.zeros((more, *values.shape[1:]))))


TOGETHER = 2**LEVELS
"""Whole blocks of the longest time scale."""


class LiveTorques:
    """Moments of rows that come one by one, at a cost and in a memory that do not grow:
    they wait until `TOGETHER` are there."""

    def __init__(self, scales: TorqueScales):
        n, c = scales.levels[0].factors.shape[:2]
        self._folded = scales
        self._values = np.empty((TOGETHER, n, c))
        self._used = np.empty((TOGETHER, n), dtype=bool)
        self._time = np.empty(TOGETHER)
        self._waiting = 0

    @classmethod
    def empty(cls, joints: int, own: int, arm: int = 0) -> LiveTorques:
        """Arguments as of `TorqueMoments.empty`."""
        return cls(TorqueScales.empty(joints, own, arm))

    def add(self, row: Array, time: float, used: Mask) -> None:
        """Equations (n, c) at `time` [s], of which joints `used` (n,) count."""
        k = self._waiting
        self._values[k], self._time[k], self._used[k] = row, time, used
        self._waiting += 1
        if self._waiting == TOGETHER:
            self._folded = self._folded.fold(self._rows)
            self._waiting = 0

    @property
    def scales(self) -> TorqueScales:
        """Of all samples so far."""
        return self._folded.fold(self._rows) if self._waiting else self._folded

    @property
    def size(self) -> int:
        """[bytes]"""
        own = self._values.nbytes + self._used.nbytes + self._time.nbytes
        return own + sum(
            m.factors.nbytes + m.counts.nbytes for m in self._folded.levels
        )

    @property
    def _rows(self) -> Rows:
        part = slice(self._waiting)
        return Rows(self._values[part], self._time[part], self._used[part])
