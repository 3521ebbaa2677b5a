"""A live stream: every sample is folded in and the problem solved anew.

The targets of 250 µs and 1 ms were set where Pinocchio's regressor with `lstsq` takes
2.4 ms over 1,000 samples. As machines differ by more than that margin, the same work is
timed here between the steps: in its terms a step may take 0.25 / 2.4, the slowest
percent 1 / 2.4.
"""

import numpy as np

from benchmarks.least_squares import with_pinocchio
from benchmarks.problem import shape, wielded
from benchmarks.report import Row, Section
from benchmarks.timing import collected, timed
from hefting import PMD
from hefting.core.measurements import Measurements


def one_sample_at_a_time(samples: int, known: int = 150) -> Section:
    """After `known` samples, so many single ones; each solution starts from the one
    before."""
    z = wielded(known + samples)
    motion = (
        z.gravity,
        z.linear_acceleration,
        z.angular_velocity,
        z.angular_acceleration,
    )
    arrays = (z.time, *motion, z.force, z.torque)
    pmd = PMD(shape(56), intervals=False)
    state = pmd.update(pmd.start(), z[:known])
    estimate = pmd.estimate(state)

    def step(k: int):
        row = slice(k, k + 1)
        sample = Measurements(*(array[row] for array in arrays))
        after = pmd.update(state, sample)
        return after, pmd.estimate(after, start=estimate)

    long = wielded(1000)
    yardstick = (
        long.time,
        long.gravity,
        long.linear_acceleration,
        long.angular_velocity,
        long.angular_acceleration,
    )
    yardstick += (long.force, long.torque)
    records, pinocchio = [], []
    for k in range(known, known + samples):
        if (k - known) % max(samples // 15, 1) == 0:
            pinocchio.append(timed(with_pinocchio, yardstick))
        wall, cpu, (state, estimate) = timed(step, k)
        records.append((wall, cpu, estimate.certificate.iterations))
    steps, theirs = collected(records), collected(pinocchio)
    slowest = float(np.percentile(steps.wall, 99))
    return Section(
        f"PMD, {pmd.shape.n} points, {samples:,} samples streamed",
        (
            Row(
                "Measurements, update and estimate",
                steps,
                steps.median,
                "s",
                at_most=250e-6,
            ),
            Row("99th percentile", figure=slowest, unit="s", at_most=1e-3),
            Row(
                "99th percentile, CPU",
                figure=float(np.percentile(steps.cpu, 99)),
                unit="s",
            ),
            Row("Pinocchio and lstsq over 1,000 samples", theirs),
            Row(
                "  over a step's median",
                figure=theirs.median / steps.median,
                unit="x",
                at_least=2.4 / 0.25,
            ),
            Row(
                "  over its 99th percentile, CPU",
                figure=theirs.median_cpu / float(np.percentile(steps.cpu, 99)),
                unit="x",
                at_least=2.4 / 1.0,
            ),
            Row("linear systems solved, mean", figure=float(np.mean(steps.results))),
        ),
    )
