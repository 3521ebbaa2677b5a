"""LiveTorques: equations of joint torques folded as they come, at a cost and in a
memory that do not grow."""

from __future__ import annotations

import numpy as np

from hefting.core.spatial import Array, Mask
from hefting.torques.equations import Rows
from hefting.torques.scales import LEVELS, TorqueScales

TOGETHER = 2**LEVELS
"""Rows that are folded at once: whole blocks of the longest time scale."""


class LiveTorques:
    """Moments of rows that come one by one: they wait until `TOGETHER` are there."""

    def __init__(self, scales: TorqueScales):
        n, c = scales.levels[0].factors.shape[:2]
        self._folded = scales
        self._values = np.empty((TOGETHER, n, c))
        self._used = np.empty((TOGETHER, n), dtype=bool)
        self._time = np.empty(TOGETHER)
        self._waiting = 0

    @classmethod
    def empty(cls, joints: int, own: int, arm: int = 0) -> LiveTorques:
        """No samples yet; for the arguments see `TorqueMoments.empty`."""
        return cls(TorqueScales.empty(joints, own, arm))

    def add(self, row: Array, time: float, used: Mask) -> None:
        """One sample more: equations (n, c) at `time` [s], of which joints `used` (n,)
        count."""
        k = self._waiting
        self._values[k], self._time[k], self._used[k] = row, time, used
        self._waiting += 1
        if self._waiting == TOGETHER:
            self._folded = self._folded.fold(self._rows)
            self._waiting = 0

    @property
    def scales(self) -> TorqueScales:
        """Moments of all samples so far."""
        return self._folded.fold(self._rows) if self._waiting else self._folded

    @property
    def size(self) -> int:
        """Memory [bytes]."""
        own = self._values.nbytes + self._used.nbytes + self._time.nbytes
        return own + sum(
            m.factors.nbytes + m.counts.nbytes for m in self._folded.levels
        )

    @property
    def _rows(self) -> Rows:
        part = slice(self._waiting)
        return Rows(self._values[part], self._time[part], self._used[part])
