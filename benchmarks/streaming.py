"""A live stream: every sample is folded in and the problem solved anew."""

import numpy as np

from benchmarks.problem import shape, wielded
from benchmarks.report import Row, Section
from benchmarks.timing import collected, timed
from hefting import PMD
from hefting.measurements import Measurements


def one_sample_at_a_time(samples: int, known: int = 150) -> Section:
    """After `known` samples, so many single ones; each solution starts from the one before."""
    z = wielded(known + samples)
    motion = (z.gravity, z.linear_acceleration, z.angular_velocity, z.angular_acceleration)
    arrays = (z.time, *motion, z.force, z.torque)
    pmd = PMD(shape(56))
    state = pmd.update(pmd.start(), z[:known])
    estimate = pmd.estimate(state)

    def step(k: int):
        row = slice(k, k + 1)
        sample = Measurements(*(array[row] for array in arrays))
        after = pmd.update(state, sample)
        return after, pmd.estimate(after, start=estimate)

    records = []
    for k in range(known, known + samples):
        wall, cpu, (state, estimate) = timed(step, k)
        records.append((wall, cpu, estimate.certificate.iterations))
    steps = collected(records)
    return Section(
        f"PMD, {pmd.shape.n} points, {samples:,} samples streamed",
        (
            Row("Measurements, update and estimate", steps, steps.median, "s", at_most=250e-6),
            Row("99th percentile", figure=float(np.percentile(steps.wall, 99)), unit="s", at_most=1e-3),
            Row("99th percentile, CPU", figure=float(np.percentile(steps.cpu, 99)), unit="s"),
            Row("linear systems solved, mean", figure=float(np.mean(steps.results))),
        ),
    )
