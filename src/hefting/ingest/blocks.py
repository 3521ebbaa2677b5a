"""Blocks: the wrench averaged over 10 ms, which is short beside an arm's motion.

An arm with an object moves at no more than 10 to 15 Hz, so the average over 10 ms,
weighted by its number of samples, is as informative as the samples. The motion is
averaged too, to second order: the mean of x(t) over times of mean t' and variance s² is
x(t') + s² x''(t') / 2.
"""

from dataclasses import replace
from functools import cached_property
from typing import Self

import numpy as np

from hefting.core.recording import Recording, Stream, block_starts
from hefting.core.spatial import Array, Indices, Mask, immutable, in_sensor_axes
from hefting.ingest.conditioned import Conditioned
from hefting.motion import Measured, measure
from hefting.motion.measure import Source

BLOCKS_AT_A_TIME = 10_000
"""Number of blocks processed together, to bound the memory."""


@immutable
class Blocks:
    """Averages of K samples over B blocks; of a slow sensor each sample is a block."""

    time: Array
    """(B,) [s] mean of the samples' times"""
    variance: Array
    """(B,) [s²] of the samples' times"""
    count: Array
    """(B,) number of samples averaged; 0 if none was kept: the block then holds the
    average of all its samples"""
    wrench: Array
    """(B, 6) mean [N, N m]"""
    starts: Indices | None = None
    """(B,) first sample of each block; None where each sample is a block"""

    def __len__(self) -> int:
        return len(self.time)

    @cached_property
    def mean_count(self) -> float:
        """Mean number of samples in the blocks that have any."""
        used = self.count > 0.0
        return float(self.count[used].mean()) if used.any() else 1.0

    @classmethod
    def of(
        cls, time: Array, wrench: Array, kept: Mask | None = None, smooth: bool = True
    ) -> Self:
        """From samples at `time` (K,) of `wrench` (K, 6), or only those `kept` (K,);
        each sample is a block unless the motion is `smooth`."""
        starts = block_starts(time) if smooth else None
        if starts is None:
            count = np.ones(len(time)) if kept is None else kept.astype(float)
            return cls(time, np.zeros(len(time)), count, wrench)
        weight = np.ones(len(time)) if kept is None else kept.astype(float)
        count = np.add.reduceat(weight, starts)
        # a block without inliers has the average of all of its samples
        if (count == 0.0).any():
            none = np.repeat(count == 0.0, np.diff(np.append(starts, len(time))))
            weight = np.where(none, 1.0, weight)
        total = np.add.reduceat(weight, starts)
        since = time - time[0]
        mean = np.add.reduceat(weight * since, starts) / total
        variance = np.maximum(
            np.add.reduceat(weight * since * since, starts) / total - mean**2, 0.0
        )
        weighted = wrench if kept is None else wrench * weight[:, None]
        average = np.add.reduceat(weighted, starts, axis=0) / total[:, None]
        return cls(mean + time[0], variance, count, average, starts)

    def with_medians(self, wrench: Array) -> Self:
        """With the median of each block of samples (K, 6) in place of its average."""
        return replace(self, wrench=medians(wrench, self.starts))

    def step_of(self, most: int) -> int:
        """Step between evenly chosen blocks, at most `most` of them."""
        return max(-(-len(self) // most), 1)

    def every(self, most: int) -> Self:
        """At most `most` of the blocks, evenly chosen."""
        step = self.step_of(most)
        if step == 1:
            return self
        return type(self)(
            self.time[::step],
            self.variance[::step],
            self.count[::step],
            self.wrench[::step],
        )


def medians(wrench: Array, starts: Indices | None, nth: int = 1) -> Array:
    """(B, 6) median of each block of samples (K, 6); of every n-th block only."""
    if starts is None:
        return wrench[::nth]
    sizes = np.diff(np.append(starts, len(wrench)))
    if nth > 1:
        chosen = np.arange(len(starts)) % nth == 0
        wrench, sizes = wrench[np.repeat(chosen, sizes)], sizes[chosen]
        starts = np.cumsum(sizes) - sizes
    # a layout with the samples of a block side by side is sorted in half the time
    table = np.full((len(starts), wrench.shape[1], int(sizes.max())), np.inf)
    block = np.repeat(np.arange(len(starts)), sizes)
    table[block, :, np.arange(len(wrench)) - starts[block]] = wrench
    table.sort(axis=2)
    rows = np.arange(len(starts))
    return 0.5 * (table[rows, :, (sizes - 1) // 2] + table[rows, :, sizes // 2])


def within_blocks(
    blocks: Blocks, time: Array, wrench: Array, kept: Mask | None = None
) -> Array:
    """(6, 6) covariance of the samples of the wrench (K, 6) at `time` (K,) about the
    means of their blocks, without changes between blocks. `kept` (K,) are the averaged
    samples; by default all."""
    if blocks.starts is None:
        return np.zeros((6, 6))
    ends = np.append(blocks.starts, len(wrench))
    rate = (
        np.gradient(blocks.wrench, blocks.time, axis=0)
        if len(blocks) > 1
        else np.zeros((1, 6))
    )
    total, count = np.zeros((6, 6)), 0
    for begins in range(0, len(blocks), BLOCKS_AT_A_TIME):
        part = slice(begins, begins + BLOCKS_AT_A_TIME)
        sizes = np.diff(ends)[part]
        samples = slice(ends[begins], ends[min(begins + BLOCKS_AT_A_TIME, len(blocks))])
        since = time[samples] - np.repeat(blocks.time[part], sizes)
        apart = wrench[samples] - np.repeat(blocks.wrench[part], sizes, axis=0)
        apart -= np.repeat(rate[part], sizes, axis=0) * since[:, None]
        if kept is not None:
            apart = apart[kept[samples]]
        total, count = total + apart.T @ apart, count + len(apart)
    return total / max(count, 1)


def measured_blocks(
    recording: Recording, found: Conditioned, motion: Source, *, drift: bool = True
) -> tuple[Measured, Array, Array]:
    """Corrected motion and wrench, averaged over blocks where the sensor is fast.

    Parameters
    ----------
    recording : as recorded.
    found : its conditioning.
    motion : where the motion comes from.
    drift : whether to remove the drift of the bias.

    Returns
    -------
    The measurements, the number of samples averaged in each row (K,), and the
    covariance (6, 6) of the wrench within the averages.
    """
    corrected = found.corrected(recording, drift)
    wrench = corrected["wrench"]
    smooth = (
        not recording.static
        and motion in ("auto", "smooth")
        and found.curves is not None
    )
    smooth = smooth and (
        recording.has("position") or not recording.has("accelerometer")
    )
    # by the recorded times, as shifted ones may round to another block
    recorded = recording["wrench"].time[found.kept]
    blocks = Blocks.of(recorded, wrench.values, smooth=smooth)
    if blocks.starts is None:
        measured = measure(corrected, found.gravity, motion, found.curves)
        return measured, np.ones(len(measured.measurements)), np.zeros((6, 6))
    blocks = replace(blocks, time=blocks.time - found.offset)
    averaged = Stream(blocks.time, blocks.wrench, np.arange(1, len(blocks) + 1))
    averaged_log = replace(corrected, streams={**corrected.streams, "wrench": averaged})
    measured = measure(
        averaged_log, found.gravity, motion, found.curves, counts=blocks.count
    )
    assert measured.rows is not None
    rows = measured.rows - 1
    measured = _averaged_motion(measured, found, blocks.variance[rows])
    return (
        measured,
        blocks.count[rows],
        within_blocks(blocks, wrench.time, wrench.values),
    )


def _averaged_motion(
    measured: Measured, found: Conditioned, variance: Array
) -> Measured:
    """The motion averaged over samples whose times have the `variance` (K,) [s²]: the
    mean of the motion one standard deviation earlier and later, which is exact to third
    order."""
    motion, z, curves = measured.motion, measured.measurements, found.curves
    if motion is None or curves is None:
        return measured
    apart = np.sqrt(variance)
    inside = (z.time - apart >= curves.poses.first) & (
        z.time + apart <= curves.poses.last
    )
    apart = np.where(inside, apart, 0.0)
    sides = [
        curves.poses.at(z.time + side * apart, spread=False) for side in (-1.0, 1.0)
    ]
    usable = (sides[0].known & sides[1].known & inside)[:, None]

    def mean(before: Array, after: Array, now: Array) -> Array:
        return np.where(usable, 0.5 * (before + after), now)

    before, after = sides
    gravity = [in_sensor_axes(side.orientation, found.gravity) for side in sides]
    changes = {"gravity": mean(gravity[0], gravity[1], z.gravity)}
    if measured.source != "orientation":
        changes |= {
            name: mean(getattr(before, name), getattr(after, name), getattr(z, name))
            for name in (
                "linear_acceleration",
                "angular_velocity",
                "angular_acceleration",
            )
        }
    return replace(measured, measurements=replace(z, **changes))


def residual_size(residual: Array, counts: Array, within: Array) -> Array:
    """(2,) root mean square of force and torque, of one axis and one sample of the log,
    from the residuals (K, 6) of averages over `counts` (K,) samples and the covariance
    `within` (6, 6) of samples about these."""
    square = counts @ residual**2 / max(float(counts.sum()), 1e-300) + within.diagonal()
    return np.sqrt(square.reshape(2, 3).mean(axis=1))
