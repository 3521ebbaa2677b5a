"""What folding joint torques costs as they come, beside the regressor of a sample."""

from time import perf_counter

import numpy as np

from benchmarks.torques_simulated import dynamics_of
from hefting.core.spatial import Array, Mask
from hefting.torques.equations import LEVELS, OWN, Rows, TorqueScales

SAMPLES = 4000
TOGETHER = 2**LEVELS
"""Rows that are folded at once: whole blocks of the longest time scale."""


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
    def empty(cls, joints: int, own: int, arm: int = 0) -> "LiveTorques":
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


def costs() -> dict[str, float]:
    """Median, 99th percentile and mean of folding one sample of a Panda with 43 base
    parameters [µs], and the size of the state in the beginning and in the end
    [bytes]."""
    dynamics = dynamics_of("panda")
    n, columns = dynamics.joints, len(OWN) + len(dynamics.base) + 11
    rng = np.random.default_rng(0)
    rows = rng.standard_normal((64, n, columns))
    live, took = LiveTorques.empty(n, len(OWN), len(dynamics.base)), []
    used = np.ones(n, dtype=bool)
    for k in range(SAMPLES):
        begin = perf_counter()
        live.add(rows[k % 64], 0.01 * k, used)
        took.append(perf_counter() - begin)
        if k == SAMPLES // 10:
            early = live.size
    micro = 1e6 * np.array(took)
    return {
        "median [us]": float(np.median(micro)),
        "99th [us]": float(np.quantile(micro, 0.99)),
        "mean [us]": float(micro.mean()),
        "early [bytes]": float(early),
        "late [bytes]": float(live.size),
    }
