"""Profile of a clock offset: how well every possible offset explains the inliers, and
whether that supports the one found.

The gain of an offset is the decrease of the weighted sum of squared residuals, over
their spectrum at low frequencies: twice a log likelihood ratio, in which correlated
residuals count as the few independent ones that they amount to. A late wrench that the
model explains gains thousands. One that the model does not explain, as of a sensor
mounted turned or in contact, gains some tens at offsets at which the motion resembles
itself.
"""

from typing import Literal

import numpy as np

from hefting.core.spatial import Array, immutable
from hefting.ingest.offset import (
    COARSE_OFFSET_STEP,
    FIRST_SCAN_RANGE,
    LARGEST_OFFSET_SHARE,
    NEIGHBOURHOOD_OF_OFFSET,
    SCANNED_BLOCKS,
    Design,
)
from hefting.ingest.robust_fit import MOST_BLOCKS_OF_FIRST_FIT, RobustFit
from hefting.ingest.robust_rows import normal_equations, solve_each

SMALLEST_JUDGED_OFFSET = 0.01
"""[s] Smaller offsets are not judged: they do little harm."""
OFFSET_OF_UNIT_GAIN = 0.005
"""[s] The gain that an offset must have is the square of the offset over this. Offsets
of 17 ms in recordings of 18 s with an optical sensor gain 64 and 91, simulated ones of
50 ms of an object of 0.3 kg 2,000 and more; those invented for sensors turned by 15° to
60° are 19 to 200 ms and gain 13 to 75."""
LARGEST_REQUIRED_GAIN = 300.0
"""Gain from which on an offset of any size is accepted. Offsets of 0.2 to 0.3 s in
those recordings gain 500 to 980; in 270 simulated mistakes without an offset, those
found beyond 40 ms that leave less than half gain at most 73, and 153 for play."""
LARGE_OFFSET = 0.1
"""[s] Larger offsets must also explain half of the squared residuals."""
LARGEST_SHARE_LEFT = 0.5
"""Largest share of the squared residuals at zero offset a large offset may leave."""
CLEAR_GAIN_SHARE = 0.2
"""Share of its gain by which the best offset must exceed the best one outside its
neighbourhood, with a worse one between them."""

Doubt = Literal["several", "edge", "gain", "share"]


@immutable
class OffsetProfile:
    """Weighted squared residuals at O clock offsets."""

    offsets: Array
    """(O,) [s]"""
    square: Array
    """(O,) sum of squared residuals over the scales, and over their spectrum at low
    frequencies; infinite where the motion is known at less than half of the samples"""
    offset: float
    """[s] the offset that was found"""
    at_zero: float
    """the sum for more samples, at zero offset"""
    at_offset: float
    """the same at the offset found"""

    @property
    def best(self) -> float:
        """The smallest square within `NEIGHBOURHOOD_OF_OFFSET` of the offset found."""
        near = np.abs(self.offsets - self.offset) <= NEIGHBOURHOOD_OF_OFFSET
        return float(self.square[near].min())

    @property
    def gain(self) -> float:
        """Decrease of the sum from zero to the offset found."""
        return self.at_zero - self.at_offset

    @property
    def share_left(self) -> float:
        """Share of the squared residuals at zero that remains at the offset found."""
        return self.at_offset / max(self.at_zero, 1e-300)

    @property
    def rival(self) -> tuple[float, float]:
        """The best other peak [s], and the gain of the offset found over it; infinite
        if there is none."""
        inner = np.arange(1, len(self.offsets) - 1)
        square = self.square
        peak = (square[inner] <= square[inner - 1]) & (
            square[inner] <= square[inner + 1]
        )
        far = np.abs(self.offsets[inner] - self.offset) > NEIGHBOURHOOD_OF_OFFSET
        others = inner[peak & far & np.isfinite(square[inner])]
        if not len(others):
            return 0.0, np.inf
        other = others[np.argmin(square[others])]
        return float(self.offsets[other]), float(square[other]) - self.best

    @property
    def at_edge(self) -> bool:
        """Whether the offset found is at an end of the range that was tried."""
        return bool(
            abs(self.offset) > np.abs(self.offsets).max() - 0.5 * COARSE_OFFSET_STEP
        )

    @property
    def has_rival(self) -> bool:
        """Whether another offset explains the wrench nearly as well."""
        return bool(self.rival[1] < CLEAR_GAIN_SHARE * self.gain)

    @property
    def is_lag(self) -> bool:
        """Whether the wrench is late in spite of a rival: that is as late or later, and
        no offset gains far too little. In the rise of a single move the lag is only
        partly distinguished from the object's weight."""
        other, apart = self.rival
        enough = min(self.gain, self.gain - apart) > LARGEST_REQUIRED_GAIN
        return bool(0.0 < self.offset < other) and enough

    @property
    def required_gain(self) -> float:
        """Gain that an offset of this size must have to be accepted."""
        return min((self.offset / OFFSET_OF_UNIT_GAIN) ** 2, LARGEST_REQUIRED_GAIN)

    def doubt(self) -> Doubt | None:
        """Reason not to accept the offset found; None to accept it."""
        if self.at_edge:
            return "edge"
        if self.has_rival and not self.is_lag:
            return "several"
        if self.gain < self.required_gain:
            return "gain"
        if abs(self.offset) > LARGE_OFFSET and self.share_left > LARGEST_SHARE_LEFT:
            return "share"
        return None


def profile_of(found: RobustFit) -> OffsetProfile | None:
    """Profile of a fit's clock offset, with its weights, scales and number of bias
    knots; None for an offset too small to be judged."""
    problem, fit = found.problem, found.fit
    if abs(fit.offset) < SMALLEST_JUDGED_OFFSET:
        return None
    duration = float(problem.time[-1] - problem.time[0])
    half_range = min(
        max(FIRST_SCAN_RANGE, 2.0 * abs(fit.offset)), LARGEST_OFFSET_SHARE * duration
    )
    steps = max(int(half_range / COARSE_OFFSET_STEP), 1)
    grid = COARSE_OFFSET_STEP * np.arange(-steps, steps + 1, dtype=float)
    offsets = np.sort(np.append(grid, fit.offset))
    scanned = SCANNED_BLOCKS + 50 * (fit.hats.n - 1)
    two = np.array((0.0, fit.offset))
    at_zero, at_offset = _squares(found, MOST_BLOCKS_OF_FIRST_FIT, two)
    return OffsetProfile(
        offsets, _squares(found, scanned, offsets), fit.offset, at_zero, at_offset
    )


def _squares(found: RobustFit, most: int, offsets: Array) -> Array:
    """(O,) sums of squared residuals of least squares at each of the offsets (O,), over
    their spectrum at low frequencies; from at most `most` blocks, scaled to all."""
    fit, stride = found.fit, -(-len(found.problem.time) // most)
    problem, weights = found.problem.every(most), fit.weights[::stride]
    design = Design.of(problem, fit.gravity, fit.hats.n, offsets, gravity_only=False)
    used = design.used * weights
    scale = np.broadcast_to(fit.scale, (len(offsets), 2))
    known, maps = design.known, design.maps
    solution = solve_each(*normal_equations(known, maps, used, scale))
    predicted = known[:, :, :-6] @ np.einsum("zcp,op->ozc", maps, solution)
    residual = (problem.wrench - predicted) / np.repeat(fit.scale, 3)
    share = used.sum(axis=1) / max(float(weights.sum()), 1e-300)
    square = np.einsum("ok,okc->o", used, residual**2) / np.maximum(share, 1e-12)
    square *= stride / max(found.uncertainty.slow, 1e-3)
    return np.where(share < 0.5, np.inf, square)
