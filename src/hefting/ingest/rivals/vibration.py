"""Vibration: a wrench that vibrates at one frequency, or in a band, as on a compliant
arm."""

from dataclasses import dataclass
from typing import Self

import numpy as np

from hefting.core.spatial import Array, interpolated
from hefting.ingest.blocks import Blocks
from hefting.ingest.model import REGRESSOR_BY_FEATURE
from hefting.ingest.rivals.case import Case
from hefting.ingest.rivals.explanation import fit_as_given

LOWEST_FREQUENCY = 3.0
"""[Hz] Below it arms with an object move, and liquids in it swing."""
BAND = 0.1
"""Half width of a vibration's band relative to its frequency."""
LEAST_SHARE = 0.5
"""Least share of the residual variance in that band: of white noise it is at most a
fifth."""
WIDEST = 4.0
"""Largest ratio of the frequencies that bound nine tenths of what is above the
motion's: for 5 to 15 Hz it is 3, for white noise above 10."""
MOST_BLOCKS = 6_000
"""Largest number of blocks of the wrench that are used, the first ones: a minute."""
FEWEST_BLOCKS = 64
"""Least number of blocks."""


@dataclass(frozen=True)
class Vibration:
    """A vibration in the residuals of a body's wrench."""

    frequency: float
    """[Hz] median of the band"""
    force: float
    """[N] amplitude, over all axes"""
    share: float
    """of the residual variance"""

    def beside(self, unexplained: float) -> float:
        """The part of an unexplained residual that is no vibration."""
        return unexplained * (1.0 - self.share) ** 0.5

    @classmethod
    def of(cls, case: Case) -> Self | None:
        """From the recording as given, with each channel detrended; None for too few
        samples, or if most of the residual is elsewhere."""
        time, residual = _residual(case)
        if len(time) < FEWEST_BLOCKS:
            return None
        line = np.column_stack((np.ones_like(time), time - time.mean()))
        residual = residual - line @ np.linalg.lstsq(line, residual, rcond=None)[0]
        even = np.linspace(time[0], time[-1], len(time))
        values = interpolated(even, time, residual)
        frequency = np.fft.rfftfreq(len(even), float(even[1] - even[0]))
        window = np.hanning(len(even))
        power = np.square(np.abs(np.fft.rfft(values * window[:, None], axis=0)))
        power *= 2.0 / (len(even) * np.square(window).sum())
        scale = np.maximum(
            np.square(values).mean(axis=0).reshape(2, 3).sum(axis=1), 1e-300
        )
        weighted = (power.reshape(-1, 2, 3).sum(axis=2) / scale).sum(axis=1)
        fast = frequency > LOWEST_FREQUENCY
        if not fast.any() or not weighted[fast].any():
            return None
        peak = float(frequency[np.argmax(np.where(fast, weighted, 0.0))])
        near = np.abs(frequency - peak) < BAND * peak
        share = float(weighted[near].sum() / weighted.sum())
        if share < LEAST_SHARE:
            below = np.cumsum(weighted[fast])
            parts = np.array((0.05, 0.5, 0.95)) * below[-1]
            low, peak, high = np.interp(parts, below, frequency[fast])
            if high > WIDEST * low:
                return None
            near, share = fast, float(below[-1] / weighted.sum())
        return cls(float(peak), float(np.sqrt(2.0 * power[near, :3].sum())), share)


def _residual(case: Case) -> tuple[Array, Array]:
    """Times (B,) [s] and residuals (B, 6) of the blocks' wrench."""
    wrench = case.recording["wrench"]
    blocks = Blocks.of(wrench.time, wrench.values)
    time, values = blocks.time[:MOST_BLOCKS], blocks.wrench[:MOST_BLOCKS]
    fitted, offset = fit_as_given(case)
    motion = case.motion_at(time[None] - offset)
    known = motion.known[0]
    body = REGRESSOR_BY_FEATURE @ fitted.solution[fitted.best][:10]
    left = values - case.features(motion)[0] @ body
    return time[known], left[known]
