"""Stall: since when the wrench of a live stream repeats its last value."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from hefting.core.recording import Stream
from hefting.ingest.stalled_wrench import FEWEST_REPEATED, stalled
from hefting.online.series import Series

ROUNDING = 1e-12
"""Share of its values by which averages of the same value differ."""


@dataclass(frozen=True)
class Stall:
    """The last time that the wrench stood still."""

    since: float = np.inf
    """[s] First repeated value; infinite where it never stood still."""
    until: float = np.inf
    """[s] First other value; infinite while it stands still."""

    @property
    def lasts(self) -> bool:
        """Whether the wrench stands still now."""
        return np.isfinite(self.since) and np.isinf(self.until)

    def after(self, wrench: Series | None) -> Stall:
        """With what came since."""
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
