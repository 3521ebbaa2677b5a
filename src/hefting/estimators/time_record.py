"""Time record: moments of a state's samples by time scale and by stretch, for
estimators that model coloured noise."""

from dataclasses import field, replace
from functools import cached_property
from itertools import pairwise
from typing import Self

import numpy as np

from hefting.core.measurements import MotionNoise
from hefting.core.moments import folded, triangular
from hefting.core.regressor import FEATURES
from hefting.core.spatial import Array, immutable
from hefting.estimators.raw_motion import NO_ROUGHNESS, roughness, white_noise_of
from hefting.estimators.timescales import TimeScales

BUFFERED_SAMPLES = 64
"""Number of samples that are transformed together, which costs a few array operations.
It is a power of two, so that blocks are aligned however the samples arrive."""

MOST_STRETCHES = 8
"""Number of stretches at which neighbours are joined in pairs."""
FIRST_STRETCH_LENGTH = 64
"""Number of samples in a stretch, before any are joined."""


@immutable
class Stretches:
    """Triangular factors of consecutive stretches of one length, and of the one being
    filled. Immutable."""

    factors: tuple[Array, ...] = ()
    """(22, 22) of each complete stretch"""
    counts: tuple[int, ...] = ()
    """samples in each"""
    length: int = FIRST_STRETCH_LENGTH
    """samples of a complete one"""
    open_factor: Array = field(default_factory=np.zeros((FEATURES, FEATURES)).copy)
    """(22, 22) of the one being filled"""
    open_count: int = 0
    """samples in it"""

    def fold(self, rows: Array) -> Self:
        """With samples of features `rows` (k, 22) appended."""
        stretches, first = self, 0
        while first < len(rows):
            taken = min(stretches.length - stretches.open_count, len(rows) - first)
            factor = folded(stretches.open_factor, rows[first : first + taken])
            stretches = stretches._with_open(factor, stretches.open_count + taken)
            first += taken
        return stretches

    def merge(self, other: "Stretches") -> Self:
        """With the stretches of other samples; both that were being filled are
        complete, however short."""
        parts = [part for part in (*self._each, *other._each) if part[1]]
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
        """With every weight multiplied by `weight`."""
        scale = weight**0.5
        return type(self)(
            tuple(scale * factor for factor in self.factors),
            self.counts,
            self.length,
            scale * self.open_factor,
            self.open_count,
        )

    @property
    def _each(self) -> list[tuple[Array, int]]:
        """Factor and number of samples of each, the one being filled last."""
        whole = zip(self.factors, self.counts, strict=True)
        return [*whole, (self.open_factor, self.open_count)]

    @property
    def parts(self) -> list[tuple[Array, int]]:
        """Factor and number of samples of each; the one being filled belongs to the
        last one until it is half a stretch."""
        *parts, rest = self._each
        if self.open_count >= 0.5 * self.length:
            return [*parts, rest]
        if parts and self.open_count:
            return [*parts[:-1], _join(parts[-1], rest)]
        return parts

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


@immutable
class TimeRecord:
    """Features by time scale and by stretch, and the errors of the motion. Immutable;
    amortised cost is constant."""

    scales: TimeScales = field(default_factory=TimeScales)
    stretches: Stretches = field(default_factory=Stretches)
    buffer: tuple[Array, ...] = ()
    """(k, 22) features of the latest samples, fewer than `BUFFERED_SAMPLES` in all, not
    yet in the other two"""
    buffered: int = 0
    motion: tuple[float, ...] = (0.0,) * 5
    """sums over samples, by weight: 1 for all; and, of those whose motion's noise is
    known: 1, squared errors of linear [m²/s⁴] and of angular [rad²/s⁴] acceleration,
    the time for which those errors last [s]"""
    rough: Array = field(default_factory=NO_ROUGHNESS.copy)
    """(6, 7) `hefting.estimators.raw_motion.roughness` of samples that came while
    nothing was said of their motion's noise"""

    def fold(self, x: Array, weights: Array | None, noise: MotionNoise | None) -> Self:
        """With samples of features `x` (K, 22), `weights` (K,) and noise of motion."""
        motion = self._motion_with(
            float(len(x)) if weights is None else float(weights.sum()), noise
        )
        count = self.buffered + len(x)
        if count < BUFFERED_SAMPLES:
            return replace(
                self, buffer=(*self.buffer, x), buffered=count, motion=motion
            )
        rows = np.ascontiguousarray(
            np.concatenate((*self.buffer, x)) if self.buffer else x
        )
        whole = count - count % BUFFERED_SAMPLES
        rest = (rows[whole:].copy(),) if whole < count else ()
        scales = self.scales.fold(rows[:whole])
        stretches = self.stretches.fold(rows[:whole])
        rough = self.rough
        if not motion[1]:
            blocks = rows[:whole].reshape(-1, BUFFERED_SAMPLES, rows.shape[1])
            rough = rough + roughness(blocks)
        return type(self)(scales, stretches, rest, count - whole, motion, rough)

    def merge(self, later: "TimeRecord") -> "TimeRecord":
        """With the record of `later` samples, which further samples continue."""
        motion = tuple(
            mine + theirs
            for mine, theirs in zip(self.motion, later.motion, strict=True)
        )
        if not self.buffered and not self.scales.counts:
            return replace(later, motion=motion)
        if not later.buffered and not later.scales.counts:
            return replace(self, motion=motion)
        scales, stretches = self.complete
        return type(self)(
            scales.merge(later.scales),
            stretches.merge(later.stretches),
            later.buffer,
            later.buffered,
            motion,
            self.rough_whole + later.rough,
        )

    def scaled(self, weight: float) -> "TimeRecord":
        """With every weight multiplied by `weight`."""
        return type(self)(
            self.scales.scaled(weight),
            self.stretches.scaled(weight),
            tuple(weight**0.5 * rows for rows in self.buffer),
            self.buffered,
            tuple(weight * each for each in self.motion),
            self.rough,
        )

    @cached_property
    def complete(self) -> tuple[TimeScales, Stretches]:
        """Scales and stretches, with the buffered samples included."""
        if not self.buffered:
            return self.scales, self.stretches
        rows = np.ascontiguousarray(np.concatenate(self.buffer))
        return self.scales.fold(rows), self.stretches.fold(rows)

    @property
    def rough_whole(self) -> Array:
        """`rough` with the buffered samples included."""
        if not self.buffered or self.motion[1]:
            return self.rough
        return self.rough + roughness(np.concatenate(self.buffer)[None])

    @property
    def motion_noise(self) -> MotionNoise | None:
        """Root mean square over samples that state the motion's noise; None: none."""
        n, known, linear, angular, memory = self.motion
        if not known:
            return None
        return MotionNoise((linear / n) ** 0.5, (angular / n) ** 0.5, memory / known)

    @property
    def found_motion_noise(self) -> MotionNoise | None:
        """White noise of the accelerations that the samples show; None if it is stated,
        or none is found."""
        return None if self.motion[1] else white_noise_of(self.rough_whole)

    def _motion_with(
        self, weight: float, noise: MotionNoise | None
    ) -> tuple[float, ...]:
        """`motion` with samples of a total `weight` whose motion has this noise."""
        known = (0.0,) * 4
        if noise is not None:
            known = 1.0, noise.linear**2, noise.angular**2, noise.memory
        new = zip(self.motion, (1.0, *known), strict=True)
        return tuple(before + weight * each for before, each in new)
