"""One stream of live samples, checked, averaged if it is fast, and bounded; and stalls
of the wrench."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass, replace

import numpy as np

from hefting.core.magnitudes import SMALLEST_INTERVAL, in_order
from hefting.core.recording import Stream
from hefting.core.spatial import Array
from hefting.ingest.unmeasured import FEWEST_REPEATED, stalled

BIN = 0.005
"""[s] Duration of averages of a fast stream. On recordings of a Panda at 1 kHz the COM
is then within 0.25 standard deviations of that by all samples; with 10 ms within 0.75.
"""
FAST = 250.0
"""[Hz] Rate above which streams are averaged."""
SAMPLES_OF_RATE = 50
"""Number of samples from which the rate is found."""
ROUNDING = 1e-12
"""Relative difference of averages of equal values."""


class Series:
    """The recent samples of one stream in order of time.

    Samples are kept as they are until their rate is known. Those of a fast stream are
    then averaged over bins of `BIN`, each of which is complete once a later one begins.
    """

    def __init__(self, name: str, skipped: Counter[str]):
        self.name = name
        self.time: Array = np.empty(0)
        """(N,) [s]"""
        self.values: Array = np.empty((0, 0))
        """(N, d)"""
        self._skipped = skipped
        self._fast: bool | None = None
        self._open_time: Array = np.empty(0)
        self._open_values: Array = np.empty((0, 0))

    def __len__(self) -> int:
        return len(self.time)

    @property
    def latest(self) -> float:
        """[s] Time of the newest sample; minus infinity for none."""
        latest = -np.inf
        for time in (self.time, self._open_time):
            latest = max(latest, float(time[-1])) if len(time) else latest
        return latest

    def add(self, time: Array, values: Array) -> None:
        """Add possible samples (n,), (n, d) of one clock; late and repeated ones of a
        fast stream are counted."""
        if not len(time):
            return
        if self._fast:
            late = time - self.latest < SMALLEST_INTERVAL
            self._count("late", int(late.sum()))
            self._add_fast(time[~late], values[~late])
            return
        self._insert(time, values)
        if self._fast is None and len(self.time) >= SAMPLES_OF_RATE:
            self._judge_rate()

    def cut(self, before: float) -> None:
        """Forget samples before `before` [s]."""
        first = int(np.searchsorted(self.time, before))
        if first:
            self.time, self.values = self.time[first:].copy(), self.values[first:]
            self.values = self.values.copy()
        kept = self._open_time >= before
        self._open_time, self._open_values = (
            self._open_time[kept],
            self._open_values[kept],
        )

    def stream(self, begin: float, end: float) -> Stream | None:
        """The samples from `begin` to before `end` [s]; None for none."""
        first, last = np.searchsorted(self.time, (begin, end))
        if last <= first:
            return None
        return Stream(self.time[first:last], self.values[first:last])

    def _insert(self, time: Array, values: Array) -> None:
        if len(self.time) and self.values.shape[1] != values.shape[1]:
            self._count("of another width", len(time))
            return
        last = self.time[-1:]
        self.time = np.concatenate((self.time, time))
        whole = (self.values, values) if self.values.size else (values,)
        self.values = np.concatenate(whole)
        if (np.diff(time, prepend=last) < SMALLEST_INTERVAL).any():
            self.time, self.values = self._ordered(self.time, self.values)

    def _ordered(self, time: Array, values: Array) -> tuple[Array, Array]:
        kept = in_order(time)
        self._count("repeated", len(time) - len(kept))
        return time[kept], values[kept]

    def _judge_rate(self) -> None:
        self._fast = bool(np.median(np.diff(self.time)) < 1.0 / FAST)
        if not self._fast:
            return
        time, values = self.time, self.values
        self.time, self.values = np.empty(0), np.empty((0, values.shape[1]))
        self._open_values = self.values
        self._add_fast(time, values)

    def _add_fast(self, time: Array, values: Array) -> None:
        if not len(time):
            return
        if values.shape[1] != self._open_values.shape[1]:
            self._count("of another width", len(time))
            return
        time = np.concatenate((self._open_time, time))
        values = np.concatenate((self._open_values, values))
        times, values = self._ordered(time, values)
        bins = np.floor(times / BIN)
        done = int(np.searchsorted(bins, bins[-1]))
        self._open_time, self._open_values = times[done:], values[done:]
        if done:
            self._close_bins(times[:done], values[:done], bins[:done])

    def _close_bins(self, time: Array, values: Array, bins: Array) -> None:
        starts = np.flatnonzero(np.append(True, np.diff(bins) > 0.0))
        counts = np.diff(np.append(starts, len(time)))
        if self.name == "orientation":  # q and -q are equal
            first = np.repeat(values[starts], counts, axis=0)
            side = np.einsum("ki,ki->k", values, first)
            values = np.where(side[:, None] < 0.0, -values, values)
        mean = np.add.reduceat(values, starts) / counts[:, None]
        if self.name == "orientation":
            mean /= np.linalg.norm(mean, axis=1)[:, None]
        # relative to the first, so that large stamps keep their digits
        at = time[0] + np.add.reduceat(time - time[0], starts) / counts
        self.time = np.concatenate((self.time, at))
        self.values = np.concatenate((self.values, mean))

    def _count(self, reason: str, number: int) -> None:
        if number:
            self._skipped[reason] += number


@dataclass(frozen=True)
class Stall:
    """The last stall of the wrench."""

    since: float = np.inf
    """[s] First repeated value; infinite without a stall."""
    until: float = np.inf
    """[s] First other value; infinite during a stall."""

    @property
    def lasts(self) -> bool:
        """Whether the wrench is stalled now."""
        return np.isfinite(self.since) and np.isinf(self.until)

    def after(self, wrench: Series | None) -> Stall:
        """The stall after new samples."""
        if wrench is None or len(wrench) <= FEWEST_REPEATED:
            return self
        last = wrench.values[-FEWEST_REPEATED:]
        change = np.abs(last - last[-1]) > ROUNDING * np.abs(last).max()
        if change.any():
            if not self.lasts:
                return self
            first = 1 + int(np.flatnonzero(change.any(axis=1))[-1])
            return replace(self, until=float(wrench.time[first - FEWEST_REPEATED]))
        repeats = stalled(wrench.values)
        if self.lasts or not repeats[-1]:
            return self
        varies = np.flatnonzero(~repeats)
        first = int(varies[-1]) + 1 if len(varies) else 0
        return Stall(float(wrench.time[first]))

    def without(self, wrench: Stream) -> Stream:
        """The wrench without the repeated values."""
        kept = (wrench.time < self.since) | (wrench.time >= self.until)
        return wrench if kept.all() else wrench[kept]
