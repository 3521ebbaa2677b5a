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
"""Half of the width of a vibration's band, as a share of its frequency."""
LEAST_SHARE = 0.5
"""Of the variance that is left, in that band: of white noise it is a fifth at most."""
WIDEST = 4.0
"""Largest over smallest frequency of a band that holds nine tenths of what is above the
motion's: of 5 to 15 Hz it is 3, of white noise above 10."""
MOST_BLOCKS = 6_000
"""Blocks of the wrench, the first ones, that are looked at: a minute."""
FEWEST_BLOCKS = 64


@dataclass(frozen=True)
class Vibration:
    """The vibration in what a body leaves of the wrench."""

    frequency: float
    """[Hz]; the median of a band's"""
    force: float
    """[N] amplitude, over all axes"""
    share: float
    """of the variance that is left"""

    def beside(self, unexplained: float) -> float:
        """What of an unexplained residual is no vibration."""
        return unexplained * (1.0 - self.share) ** 0.5

    @classmethod
    def of(cls, case: Case) -> Self | None:
        """Of the recording as given, each channel about the line that fits it; None
        where there are too few samples, or most of what is left is elsewhere."""
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
